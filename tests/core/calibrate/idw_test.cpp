#include "core/calibrate/idw.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/cpu_levels.hpp"
#include "tests/support/csv.hpp"

using namespace trammel;

namespace {

std::vector<JointSample> samples_of(const tests::Table& t) {
  std::vector<JointSample> samples;
  for (std::size_t k = 0; k < t.rows.size(); ++k) {
    samples.push_back({t.number(k, "x_mm"),
                       t.number(k, "y_mm"),
                       {t.number(k, "e1_mm"), t.number(k, "e2_mm"), t.number(k, "e3_mm")}});
  }
  return samples;
}

std::vector<JointSample> random_samples(int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<JointSample> samples;
  for (int k = 0; k < n; ++k) {
    samples.push_back({random.uniform(-100, 100),
                       random.uniform(-100, 100),
                       {random.normal(), random.normal(), random.normal()}});
  }
  return samples;
}

/// Eq. 22 as it is written.
Eigen::Vector3d direct(const std::vector<JointSample>& samples, Place at, double power) {
  double sum = 0;
  Eigen::Vector3d total = Eigen::Vector3d::Zero();
  for (const JointSample& s : samples) {
    const double w = 1 / std::pow(std::hypot(at.x_mm - s.x_mm, at.y_mm - s.y_mm), power);
    sum += w;
    total += w * s.error_mm;
  }
  return total / sum;
}

}  // namespace

TEST_CASE("IDW gives the golden numbers, also where the query is a sample", "[calibrate]") {
  const IdwMap map =
      fit_idw(samples_of(tests::read_table("core/calibrate/golden/idw_samples.csv")));
  for (const JointSample& q :
       samples_of(tests::read_table("core/calibrate/golden/idw_queries.csv"))) {
    const Eigen::Vector3d e = predict(map, Place{q.x_mm, q.y_mm});
    CHECK((e - q.error_mm).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("any power equals Eq. 22 as written, whole, odd and broken powers alike", "[calibrate]") {
  const auto samples = random_samples(30, 3);
  const auto queries = random_samples(20, 4);
  for (const double power : {1.0, 2.0, 3.0, 4.0, 2.5, 0.7, 20.0}) {
    const IdwMap map = fit_idw(samples, {.power = power, .neighbours = 0});
    for (const JointSample& q : queries) {
      const Place at{q.x_mm, q.y_mm};
      CHECK((predict(map, at) - direct(samples, at, power)).norm() < 1e-12);
    }
  }
}

TEST_CASE("a query on a sample returns the sample bit for bit, near it almost", "[calibrate]") {
  const auto samples = random_samples(25, 5);
  for (const int neighbours : {0, 1, 8}) {
    const IdwMap map = fit_idw(samples, {.power = 2, .neighbours = neighbours});
    for (const JointSample& s : samples) {
      CHECK(predict(map, Place{s.x_mm, s.y_mm}) == s.error_mm);
      CHECK((predict(map, Place{s.x_mm + 1e-9, s.y_mm}) - s.error_mm).norm() < 1e-9);
    }
  }
}

TEST_CASE("the nearest k samples alone count when k neighbours are asked for", "[calibrate]") {
  const auto samples = random_samples(40, 6);
  const Place at{3, -7};
  auto sorted = samples;
  std::sort(sorted.begin(), sorted.end(), [at](const JointSample& a, const JointSample& b) {
    return std::hypot(a.x_mm - at.x_mm, a.y_mm - at.y_mm) <
           std::hypot(b.x_mm - at.x_mm, b.y_mm - at.y_mm);
  });
  sorted.resize(8);
  const IdwMap map = fit_idw(samples, {.power = 2, .neighbours = 8});
  CHECK((predict(map, at) - direct(sorted, at, 2)).norm() < 1e-13);
}

TEST_CASE("many queries at once are bit-identical to one at a time", "[calibrate]") {
  const IdwMap map = fit_idw(random_samples(80, 8));
  std::vector<Place> at;
  for (const JointSample& q : random_samples(37, 9)) at.push_back({q.x_mm, q.y_mm});
  at[5] = {map.x_mm[3], map.y_mm[3]};
  std::vector<Eigen::Vector3d> errors(at.size());
  predict(map, at, errors);
  for (std::size_t k = 0; k < at.size(); ++k) CHECK(errors[k] == predict(map, at[k]));
}

TEST_CASE("repeats in one place count as their mean", "[calibrate]") {
  auto samples = random_samples(5, 10);
  samples.push_back(samples[0]);
  samples.back().error_mm += Eigen::Vector3d(2, 4, 6);
  const IdwMap map = fit_idw(samples);
  CHECK(map.x_mm.size() == 5);
  const Eigen::Vector3d mean = samples[0].error_mm + Eigen::Vector3d(1, 2, 3);
  CHECK((predict(map, Place{samples[0].x_mm, samples[0].y_mm}) - mean).norm() < 1e-14);
}

TEST_CASE("tuned IDW is no worse than any of its grid, by leaving out", "[calibrate]") {
  Random random(12);
  std::vector<JointSample> samples;
  for (int k = 0; k < 50; ++k) {
    const double x = random.uniform(-100, 100), y = random.uniform(-100, 100);
    samples.push_back({x, y, {1e-3 * x, 1e-3 * y, 1e-5 * x * y}});
  }
  const auto loo = [&](const IdwOptions& options) {
    double sum = 0;
    for (std::size_t out = 0; out < samples.size(); ++out) {
      auto others = samples;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(out));
      const Place at{samples[out].x_mm, samples[out].y_mm};
      sum += (predict(fit_idw(others, options), at) - samples[out].error_mm).squaredNorm();
    }
    return sum;
  };
  const double best = loo(tune_idw(samples));
  for (const int neighbours : {4, 8, 24, 0}) {
    for (const double power : {1.0, 2.0, 4.0}) {
      CHECK(best <= loo({.power = power, .neighbours = neighbours}));
    }
  }
  CHECK(best < loo({}));
  CHECK_THROWS_AS(tune_idw(random_samples(4, 1)), InputError);
}

TEST_CASE("IDW refuses no samples, a bad power and too many neighbours in words", "[calibrate]") {
  CHECK_THROWS_AS(fit_idw({}), InputError);
  const auto samples = random_samples(4, 1);
  CHECK_THROWS_WITH(fit_idw(samples, {.power = 0, .neighbours = 0}), Contains("power"));
  CHECK_THROWS_WITH(fit_idw(samples, {.power = 2, .neighbours = 5}), Contains("neighbours"));
  auto bad = samples;
  bad[2].error_mm[1] = std::nan("");
  CHECK_THROWS_WITH(fit_idw(bad), Contains("sample 3"));
}

TEST_CASE("IDW gives the same bits on every level of CPU, and near and on samples", "[calibrate]") {
  Random random(41);
  std::vector<JointSample> samples;
  for (int k = 0; k < 79; ++k) {  // a rest of three beside the fours
    const Eigen::Vector3d e(random.normal(), random.normal(), random.normal());
    samples.push_back({random.uniform(-100, 100), random.uniform(-100, 100), e});
  }
  std::vector<Place> at;
  for (int k = 0; k < 1003; ++k) at.push_back({random.uniform(-99, 99), random.uniform(-99, 99)});
  for (std::size_t k = 0; k < 79; k += 7) {
    at[11 * k] = {samples[k].x_mm, samples[k].y_mm};
    at[11 * k + 1] = {samples[k].x_mm + 1e-9, samples[k].y_mm};
  }
  for (const double power : {1.0, 2.0, 3.0, 6.0, 16.0}) {
    const IdwMap map = fit_idw(samples, {.power = power});
    std::vector<Eigen::Vector3d> baseline(at.size()), errors(at.size());
    predict(map, at, baseline, CpuLevel::x86_64);
    for (const CpuLevel level : tests::levels_here()) {
      predict(map, at, errors, level);
      CHECK(errors == baseline);
    }
    for (std::size_t k = 0; k < 79; k += 7) {
      CHECK(baseline[11 * k] == samples[k].error_mm);
      if (power > 1) CHECK((baseline[11 * k + 1] - samples[k].error_mm).norm() < 1e-6);
    }
    CHECK(predict(map, at[500]) == baseline[500]);
  }
}
