#pragma once
// Where the tracker sees the base: registration by base nests or by the plane of motion, zeroing,
// and the check that nothing has moved since. Frames as in nests.hpp.

#include <span>

#include "core/measure/nests.hpp"
#include "core/plane/rigid.hpp"

namespace trammel {

struct BaseFrame {
  Eigen::Isometry3d T_B_T = Eigen::Isometry3d::Identity();
  int n_nests = 0;
  double rms_mm = 0;       // sqrt(sum |r|^2 / (3 n - 6)) of what the fit leaves
  double max_mm = 0;       // largest |r|
  std::string worst = {};  // the nest it belongs to
};

/// Registers the tracker by three or more nests of the base whose places in B are known: the rigid
/// move (never a reflection, no scale) with the least sum of squared distances (Umeyama 1991; for
/// nests in one plane it is their plane and axes).
/// @throws InputError  fewer than three nests in common, or all near one line: no plane; a nest
///                     twice; a number that is not finite
/// Proof: exact in random frames, residual against the noise put in (base_frame_test.cpp).
BaseFrame frame_of_base(const std::vector<NestPoint>& measured, const std::vector<NestPoint>& base);

/// The plane in which the platform moves, from points of its nests at many poses: the points of
/// each nest about their own mean, since nests may sit at different heights.
Plane motion_plane(std::span<const NestPoint> measured);

/// A frame for tracker points before zeroing: Z along the plane's normal, to the side where `up`
/// points (a direction in T); X along the tracker's X, or its Y where X stands on the plane; the
/// origin in the plane's centre.
/// @throws InputError  the plane is not observed, or `up` lies in it
Eigen::Isometry3d frame_on_plane(const Plane& plane, const Eigen::Vector3d& up);

/// Zeroing (Zhang et al., Sec. 3.3, step 2): moves and turns the base frame in its plane, and lifts
/// it, until the platform that stands at `home` reads `home`. `at_home` was measured with `T_B_T`.
/// One nest at O_C sets the origin alone: the directions of the axes stay as they were.
/// @throws InputError  no pose was measured, or one nest off the platform's origin
/// Proof: the home pose reads home, other poses move along rigidly (base_frame_test.cpp).
Eigen::Isometry3d zeroed(const Eigen::Isometry3d& T_B_T, const NestPose& at_home, const Pose& home);

struct BaseDrift {
  int n_nests = 0;
  double largest_mm = 0;  // how far the nest that moved most has moved
  std::string nest = {};  // that one
  double limit_mm = 0;    // what chance leaves largest_mm below, false_alarm aside
  bool moved = false;     // largest_mm > limit_mm
  Pose shift = {};        // the same as one move in the plane of B; phi 0 with a single nest
};

/// Have the base nests moved between two measurements of them? Each coordinate of a difference has
/// the variance 2 sigma^2; with n nests
///   limit = sigma sqrt(2 chi2_3(false_alarm / n)),   chi2_3(p) = chi2_limit(p, 3)
/// so a base that stands still is called moved in no more than the share `false_alarm` of checks
/// (one in a thousand: with a check every 20 points, once in 20,000 points).
/// @throws InputError  no nest was measured both times; a nest twice; not a number
/// Proof: 20,000 checks of a base at rest, and one that moved (base_frame_test.cpp).
BaseDrift base_drift(const std::vector<NestPoint>& before, const std::vector<NestPoint>& now,
                     const Eigen::Isometry3d& T_B_T, double sigma_mm, double false_alarm = 0.001);

}  // namespace trammel
