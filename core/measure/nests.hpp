#pragma once
// Tracker points of the platform's nests -> the planar pose, how well it is known, and whether to
// believe it. Frames: T tracker, B base (O_A-XY, Z out of the plane of motion), P platform (O_C).

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/mechanism/pose.hpp"

namespace trammel {

/// The centre of a reflector in a nest, by the nest's name.
struct NestPoint {
  std::string nest;
  Eigen::Vector3d at_mm = Eigen::Vector3d::Zero();
};

/// All that turns tracker points into poses.
struct NestFrame {
  std::vector<NestPoint> body;  // where the nests sit in P; z: their height over one another
  Eigen::Isometry3d T_B_T = Eigen::Isometry3d::Identity();  // p_B = T_B_T p_T; base_frame.hpp
  double u_nest_mm = 0;        // standard uncertainty of a coordinate in `body`
  double false_alarm = 0.001;  // a body as stated is called not rigid in that share of poses
};

enum class NestStatus {
  ok,
  phi_not_observed,  // one nest, or nests in one place: where it is, not how it is turned
  no_nests,          // nothing was measured
  mirrored,          // the triangle is turned over: two names swapped, or the frame seen from below
  not_rigid,         // sides differ from the body's beyond chance: a point or `body` is wrong
};
/// "ok", "phi not observed", …
const char* name_of(NestStatus status);

/// Figures of quality; none of them depends on where the base frame was put, but the height.
struct NestQuality {
  double height_mm = 0;        // mean over the nests of z_B less the nest's height in `body`
  double out_of_plane_mm = 0;  // largest |z_B - height in `body` - height_mm|: the platform tilts
  double rms_mm = 0;           // in-plane residual, sqrt(sum |r|^2 / (2 n - 3))
  double side_mm = 0;          // largest difference of a side from the body's, measured - body
  double side_limit_mm = 0;    // what chance leaves |side_mm| below, false_alarm aside
  std::string side = {};       // "P1-P2": that side
  double scale = 1;            // size seen / size of the body: 0.001 or 25.4 is a unit
};

struct [[nodiscard]] NestPose {
  NestStatus status = NestStatus::no_nests;
  /// ok, not_rigid: of the platform. phi_not_observed: x and y of the body's point `at_body_mm`.
  Pose pose = {};
  Eigen::Vector2d at_body_mm = Eigen::Vector2d::Zero();  // the platform's origin, but for one nest
  /// Of x, y, phi [mm, mm, rad]; ok only. phi_not_observed: of x and y, the rest 0.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  NestQuality quality = {};
  int n_nests = 0;
  [[nodiscard]] bool ok() const { return status == NestStatus::ok; }
};

/// The pose in which the body's nests lie nearest to the measured ones, in the plane of B.
///
///   m_i = T_B_T p_i,   minimises sum |m_i - t - R(phi) b_i|^2 over x and y              (Kabsch)
///   phi: u^2 = s^2 / sum r_i^2,  r_i = |b_i - b|,  b the nests' centroid, s^2 = sigma^2 + u_nest^2
///   t:   Cov = (s^2 / n) I + u_phi^2 v v',   Cov(t, phi) = -u_phi^2 v,   v = R'(phi) b
/// so x and y of an origin away from the nests' centroid are known the worse the farther it is.
/// `sigma_mm` is one standard deviation of one coordinate of one point. u_nest is common to all
/// poses of a body: it widens each pose, and does not average out.
/// Sides are checked in space: |p_i - p_j| - |b_i - b_j| against
/// normal_limit(false_alarm / sides) sqrt(2) s.
///
/// @throws InputError  a nest that the body does not have, or twice; a number that is not finite;
///                     sigma_mm <= 0
/// Proof: exact in random frames; covariance against 10,000 draws; 33 urad of an equilateral
/// triangle of 150 mm at 5 um (nests_test.cpp).
NestPose pose_of_nests(const std::vector<NestPoint>& measured, const NestFrame& frame,
                       double sigma_mm);

}  // namespace trammel
