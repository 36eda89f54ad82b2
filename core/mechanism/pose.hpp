#pragma once

#include <Eigen/Core>

namespace trammel {

/// The platform centre O_C and orientation in the base frame O_A-XY.
struct Pose {
  double x_mm = 0;
  double y_mm = 0;
  double phi_rad = 0;

  [[nodiscard]] Eigen::Vector3d vector() const { return {x_mm, y_mm, phi_rad}; }
  static Pose from(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
  bool operator==(const Pose&) const = default;
};

/// Joint displacements l_1..l_3 [mm], as in the paper.
using Displacements = Eigen::Vector3d;

}  // namespace trammel
