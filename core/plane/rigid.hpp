#pragma once
// Planes through points, and rigid moves of one set of points onto another.

#include <Eigen/Core>
#include <span>

namespace trammel {

/// The plane that passes points with the least sum of squared distances.
struct Plane {
  bool observed =
      false;  // false: fewer than three points, or narrower than kNarrow of their length
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit; its largest component is positive
  double rms_mm = 0;  // sqrt(sum d^2 / (n - 3)) of the distances d; 0 for three points
  double max_mm = 0;  // largest |d|
  double width_mm =
      0;  // sqrt of the sum of squares across: the normal tilts by sigma / width [rad]
};

inline constexpr double kNarrow = 1e-3;  // points narrower than this share of their length: a line

/// Fits by SVD of the points about their mean: the normal is the last right singular vector.
/// Proof: exact on random planes, tilt against sigma / width (rigid_test.cpp).
Plane fit_plane(std::span<const Eigen::Vector3d> points_mm);

/// seen_i = shift + R(turn) body_i in the plane.
struct PlanarFit {
  double turn_rad = 0;  // in (-pi, pi]; 0 where it is not observed
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d body_centre_mm = Eigen::Vector2d::Zero();  // centroid of the body's points
  Eigen::Vector2d seen_centre_mm = Eigen::Vector2d::Zero();
  double spread_mm2 = 0;       // sum of squared distances r_i^2 of the body's points from there
  double rms_mm = 0;           // sqrt(sum |residual|^2 / (2 n - 3)), 0 for one point
  double mirrored_rms_mm = 0;  // the same had the body been turned over: for telling swapped nests
  double scale = 1;  // size seen / size of the body, which the fit does not use; 1 for one point
};

/// Least squares over turn and shift, never a reflection (Kabsch 1976; in the plane, with b and m
/// about their centroids, turn = atan2(sum b x m, sum b . m)). Precondition: as many of each, at
/// least one. Proof: exact in random frames, also mirrored and collinear (rigid_test.cpp).
PlanarFit fit_planar(std::span<const Eigen::Vector2d> body_mm,
                     std::span<const Eigen::Vector2d> seen_mm);

}  // namespace trammel
