#include <algorithm>
#include <cmath>

#include "core/simulate/virtual_robot.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel::simulate {

namespace {

constexpr double kForgotten = 1e-9;  // weight below which an earlier reading no longer counts

Eigen::Vector3d white(std::uint64_t seed, std::uint64_t reading) {
  Random random = Random::stream(seed, "tracker noise", reading);
  Eigen::Vector3d e;
  for (double& value : e) value = random.normal();
  return e;
}

/// e_n = rho e_(n-1) + sqrt(1 - rho^2) white_n, unrolled: e_0 = white_0, so the variance is 1.
Eigen::Vector3d correlated(double rho, std::uint64_t seed, std::uint64_t reading) {
  if (rho == 0) return white(seed, reading);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double weight = 1;
  for (std::uint64_t n = reading; weight > kForgotten; --n, weight *= rho) {
    sum += weight * (n == 0 ? 1.0 : std::sqrt(1 - rho * rho)) * white(seed, n);
    if (n == 0) break;
  }
  return sum;
}

}  // namespace

Pose reading_noise(const TrackerTruth& tracker, std::uint64_t seed, std::uint64_t reading) {
  const Eigen::Vector3d e = correlated(tracker.correlation, seed, reading);
  Pose noise{tracker.sigma_xy_mm * e[0], tracker.sigma_xy_mm * e[1], tracker.sigma_phi_rad * e[2]};
  Random random = Random::stream(seed, "tracker outlier", reading);
  const bool by_chance = random.uniform() < tracker.outlier_share;
  const double bearing = random.uniform(0, 2 * kPi);
  if (by_chance || std::find(tracker.outliers.begin(), tracker.outliers.end(), reading) !=
                       tracker.outliers.end()) {
    noise.x_mm += tracker.outlier_mm * std::cos(bearing);
    noise.y_mm += tracker.outlier_mm * std::sin(bearing);
  }
  return noise;
}

}  // namespace trammel::simulate
