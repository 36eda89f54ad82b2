#pragma once
// Nests on a platform and a tracker that sees them from anywhere.

#include <cmath>
#include <string>
#include <vector>

#include "core/measure/nests.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"

namespace trammel::tests {

/// P1, P2, P3 in a triangle of equal sides about `centre`.
inline std::vector<NestPoint> triangle(double side_mm,
                                       const Eigen::Vector3d& centre_mm = {0, 0, 0}) {
  std::vector<NestPoint> nests;
  const double r_mm = side_mm / std::sqrt(3.0);
  for (int k = 0; k < 3; ++k) {
    const double at = rad_from_deg(90 + 120.0 * k);
    nests.push_back({"P" + std::to_string(k + 1),
                     centre_mm + Eigen::Vector3d(r_mm * std::cos(at), r_mm * std::sin(at), 0)});
  }
  return nests;
}

/// Any rotation, and a tracker some metres away.
inline Eigen::Isometry3d random_frame(Random& random) {
  Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::AngleAxisd(random.uniform(-kPi, kPi), axis.normalized()).toRotationMatrix();
  for (Eigen::Index k = 0; k < 3; ++k) T.translation()[k] = random.uniform(-4000, 4000);
  return T;
}

/// Points of T as seen by the tracker when the platform stands at `pose`, `height_mm` over the
/// plane of B.
inline std::vector<NestPoint> seen_at(const Pose& pose, const NestFrame& frame,
                                      double height_mm = 0) {
  Eigen::Isometry3d T_B_P = Eigen::Isometry3d::Identity();
  T_B_P.linear() = Eigen::AngleAxisd(pose.phi_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_B_P.translation() << pose.x_mm, pose.y_mm, height_mm;
  std::vector<NestPoint> points;
  for (const NestPoint& nest : frame.body) {
    points.push_back({nest.nest, frame.T_B_T.inverse() * (T_B_P * nest.at_mm)});
  }
  return points;
}

inline Eigen::Vector3d noise_mm(Random& random, double sigma_mm) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return sigma_mm * Eigen::Vector3d(x, y, z);
}

}  // namespace trammel::tests
