#include "core/calibrate/gp.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

Eigen::Vector3d waves(double x, double y) {
  return {0.1 * std::sin(x / 50), 0.05 * std::cos(y / 60), 1e-3 * (x - y)};
}

std::vector<JointSample> noisy(int n, double noise_mm, std::uint64_t seed) {
  Random random(seed);
  std::vector<JointSample> samples;
  for (int k = 0; k < n; ++k) {
    const double x = random.uniform(-100, 100), y = random.uniform(-100, 100);
    const Eigen::Vector3d r(random.normal(), random.normal(), random.normal());
    samples.push_back({x, y, waves(x, y) + noise_mm * r});
  }
  return samples;
}

}  // namespace

TEST_CASE("the process finds the noise and predicts below it where nothing was measured",
          "[calibrate]") {
  constexpr double kNoise = 0.010;
  const GpMap map = fit_gp(noisy(120, kNoise, 91));
  for (const GpJoint& joint : map.joints) CHECK_THAT(joint.noise_mm, WithinRel(kNoise, 0.5));
  Random random(92);
  double sum = 0;
  for (int k = 0; k < 200; ++k) {
    const Place at{random.uniform(-90, 90), random.uniform(-90, 90)};
    sum += (predict(map, at) - waves(at.x_mm, at.y_mm)).squaredNorm() / 600;
  }
  CHECK(std::sqrt(sum) < 0.6 * kNoise);
}

TEST_CASE("twice the stated uncertainty covers the error in about 95 of 100 places",
          "[calibrate]") {
  int covered = 0, all = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const GpMap map = fit_gp(noisy(80, 0.010, seed));
    Random random(100 + seed);
    std::vector<Place> at;
    for (int k = 0; k < 50; ++k) at.push_back({random.uniform(-90, 90), random.uniform(-90, 90)});
    const auto u = uncertainty_mm(map, at);
    for (std::size_t k = 0; k < at.size(); ++k) {
      const Eigen::Vector3d miss = predict(map, at[k]) - waves(at[k].x_mm, at[k].y_mm);
      for (int i = 0; i < 3; ++i) {
        covered += std::abs(miss[i]) <= 2 * u[k][i] ? 1 : 0;
        ++all;
      }
    }
  }
  // The field is no draw of the process and neighbours err together: a wide band.
  CHECK(covered > 0.88 * all);
  CHECK(covered < all);
}

TEST_CASE("far from all samples the uncertainty is the signal's own size", "[calibrate]") {
  const GpMap map = fit_gp(noisy(60, 0.010, 93));
  const Place far{1e5, 1e5};
  const auto u = uncertainty_mm(map, {&far, 1});
  for (int i = 0; i < 3; ++i) {
    const GpJoint& joint = map.joints[static_cast<std::size_t>(i)];
    CHECK_THAT(u[0][i], WithinRel(joint.signal_mm, 1e-9));
    CHECK_THAT(predict(map, far)[i], WithinAbs(joint.mean_mm, 1e-12));
  }
}

TEST_CASE("a constant column is predicted as the constant, not as NaN", "[calibrate]") {
  auto samples = noisy(20, 0, 94);
  for (JointSample& s : samples) s.error_mm[1] = 0.25;
  CHECK_THAT(predict(fit_gp(samples), Place{3, 4})[1], WithinAbs(0.25, 1e-9));
  CHECK_THROWS_WITH(fit_gp(std::vector<JointSample>(9, samples[0])), Contains("1 place"));
}
