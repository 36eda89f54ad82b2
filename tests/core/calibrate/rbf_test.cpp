#include "core/calibrate/rbf.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/error.hpp"
#include "core/plane/kmeans.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"
#include "tests/support/csv.hpp"

using namespace trammel;

namespace {

RbfNetwork golden_network() {
  const auto t = tests::read_table("core/calibrate/golden/rbf_network.csv");
  const auto b = tests::read_table("core/calibrate/golden/rbf_bias.csv");
  const auto n = static_cast<Eigen::Index>(t.rows.size());
  RbfNetwork network;
  network.cx_mm.resize(n);
  network.cy_mm.resize(n);
  network.sigma_mm.resize(n);
  network.weights_mm.resize(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto row = static_cast<std::size_t>(k);
    network.cx_mm[k] = t.number(row, "cx_mm");
    network.cy_mm[k] = t.number(row, "cy_mm");
    network.sigma_mm[k] = t.number(row, "sigma_mm");
    network.weights_mm.row(k) << t.number(row, "w1_mm"), t.number(row, "w2_mm"),
        t.number(row, "w3_mm");
  }
  network.bias_mm = {b.number(0, "b1_mm"), b.number(0, "b2_mm"), b.number(0, "b3_mm")};
  return network;
}

/// A smooth field of joint errors, of the size the paper sees.
Eigen::Vector3d field(double x, double y) {
  return {0.1 + 2e-3 * x, 1e-3 * y + 1e-5 * x * x, 0.05 * std::sin(x / 60) * std::cos(y / 50)};
}

std::vector<JointSample> field_samples(int n, std::uint64_t seed, double noise = 0) {
  Random random(seed);
  std::vector<JointSample> samples;
  for (int k = 0; k < n; ++k) {
    const double x = random.uniform(-100, 100), y = random.uniform(-100, 100);
    const Eigen::Vector3d r(random.normal(), random.normal(), random.normal());
    samples.push_back({x, y, field(x, y) + noise * r});
  }
  return samples;
}

}  // namespace

TEST_CASE("the network's outputs are the golden numbers, one by one and in blocks", "[calibrate]") {
  const RbfNetwork network = golden_network();
  const auto t = tests::read_table("core/calibrate/golden/rbf_outputs.csv");
  std::vector<Place> at;
  for (std::size_t k = 0; k < t.rows.size(); ++k) {
    at.push_back({t.number(k, "x_mm"), t.number(k, "y_mm")});
  }
  std::vector<Eigen::Vector3d> errors(at.size());
  predict(network, at, errors);
  for (std::size_t k = 0; k < at.size(); ++k) {
    const Eigen::Vector3d golden(t.number(k, "e1_mm"), t.number(k, "e2_mm"), t.number(k, "e3_mm"));
    CHECK((errors[k] - golden).cwiseAbs().maxCoeff() < 1e-12);
    CHECK((predict(network, at[k]) - golden).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("a trained network predicts a smooth field where it was never measured", "[calibrate]") {
  const RbfTraining training = train_rbf(field_samples(80, 21));
  CHECK(training.network.cx_mm.size() == 50);
  CHECK_FALSE(training.trials.empty());
  double worst = 0;
  Random random(22);
  for (int k = 0; k < 200; ++k) {
    const double x = random.uniform(-80, 80), y = random.uniform(-80, 80);
    worst = std::max(worst, (predict(training.network, Place{x, y}) - field(x, y)).norm());
  }
  CHECK(worst < 0.01);  // the field spans 0.4 mm
}

TEST_CASE("the leave-one-out residuals are those of leaving out, centres held", "[calibrate]") {
  // As many neurons as samples would move the centres with the sample left out: with one neuron per
  // cluster and the clusters held by doubled samples the shortcut can be checked by brute force.
  const auto samples = field_samples(12, 23, 0.01);
  const RbfOptions options{.neurons = 1, .sigma_mm = 150};
  const RbfTraining all = train_rbf(samples, {.neurons = 1});
  const SpreadTrial* trial = nullptr;
  for (const SpreadTrial& t : all.trials) {
    if (std::abs(t.sigma_mm - 160) < 1e-9) trial = &t;
  }
  REQUIRE(trial != nullptr);
  const double cx = all.network.cx_mm[0], cy = all.network.cy_mm[0];
  double sum = 0;
  for (std::size_t out = 0; out < samples.size(); ++out) {
    Eigen::MatrixXd A(11, 2);
    Eigen::MatrixX3d b(11, 3);
    Eigen::Index row = 0;
    const auto phi = [&](const JointSample& s) {
      return std::exp(-(std::pow(s.x_mm - cx, 2) + std::pow(s.y_mm - cy, 2)) / (160.0 * 160.0));
    };
    for (std::size_t k = 0; k < samples.size(); ++k) {
      if (k == out) continue;
      A.row(row) << phi(samples[k]), 1;
      b.row(row++) = samples[k].error_mm.transpose();
    }
    const Eigen::MatrixX3d w = (A.transpose() * A).inverse() * A.transpose() * b;
    const Eigen::RowVector3d miss =
        samples[out].error_mm.transpose() - Eigen::RowVector2d(phi(samples[out]), 1) * w;
    sum += miss.squaredNorm();
  }
  CHECK_THAT(trial->loo_rms_mm, WithinRel(std::sqrt(sum / 36), 1e-6));
  CHECK(train_rbf(samples, options).trials.empty());
}

TEST_CASE("the same seed gives the same bits, another seed other centres", "[calibrate]") {
  const auto samples = field_samples(80, 24, 0.01);
  const RbfTraining a = train_rbf(samples), b = train_rbf(samples);
  CHECK((a.network.weights_mm.array() == b.network.weights_mm.array()).all());
  CHECK(a.sigma_mm == b.sigma_mm);
  const RbfTraining c = train_rbf(samples, {.seed = 2});
  CHECK_FALSE((a.network.cx_mm == c.network.cx_mm).all());
}

TEST_CASE("k-means finds separated clusters from any seed", "[calibrate]") {
  Random random(25);
  const std::vector<Place> middles = {{0, 0}, {100, 0}, {0, 100}};
  std::vector<Place> points;
  for (int k = 0; k < 60; ++k) {
    const Place m = middles[static_cast<std::size_t>(k % 3)];
    points.push_back({m.x_mm + random.normal(), m.y_mm + random.normal()});
  }
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const KMeans result = kmeans(points, 3, seed);
    for (const Place& m : middles) {
      double nearest = 1e9;
      for (const Place& c : result.centres) {
        nearest = std::min(nearest, std::hypot(c.x_mm - m.x_mm, c.y_mm - m.y_mm));
      }
      CHECK(nearest < 1.0);
    }
  }
}

TEST_CASE("more neurons than places become as many as places", "[calibrate]") {
  const RbfTraining training = train_rbf(field_samples(20, 26));
  CHECK(training.network.cx_mm.size() == 20);
}

TEST_CASE("training refuses one place, no neurons and a bad spread in words", "[calibrate]") {
  CHECK_THROWS_WITH(train_rbf(std::vector<JointSample>(9, JointSample{1, 2, {0, 0, 0}})),
                    Contains("1 place"));
  CHECK_THROWS_WITH(train_rbf(field_samples(9, 1), {.neurons = 0}), Contains("neurons"));
  CHECK_THROWS_WITH(train_rbf(field_samples(9, 1), {.sigma_mm = -1}), Contains("sigma_mm"));
}

TEST_CASE("the network gives the same bits on every level of CPU, alone and in a batch",
          "[calibrate]") {
  const RbfNetwork network = golden_network();
  Random random(42);
  std::vector<Place> at;
  for (int k = 0; k < 1003; ++k) at.push_back({random.uniform(-99, 99), random.uniform(-99, 99)});
  at[3] = {1e6, -1e6};  // beyond every neuron
  std::vector<Eigen::Vector3d> baseline(at.size()), errors(at.size());
  predict(network, at, baseline, CpuLevel::x86_64);
  CHECK(baseline[3] == network.bias_mm);
  for (const CpuLevel level : tests::levels_here()) {
    predict(network, at, errors, level);
    CHECK(errors == baseline);
  }
  CHECK(predict(network, at[500]) == baseline[500]);
}
