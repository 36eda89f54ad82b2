#pragma once
// The velocity Jacobian of the 3-PRR, and how far a pose is from singular.

#include <Eigen/Core>

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/mechanism/inverse.hpp"

namespace trammel {

/// J_F1 l' = J_F2 X' (11, 12). J_F1 = diag(cos(alpha_i - theta_i)), row i of J_F2 =
/// [cos theta_i, sin theta_i, -r_i sin(beta_i + phi - theta_i)].
struct VelocityEquation {
  Eigen::Vector3d J_F1_diagonal = {};
  Eigen::Matrix3d J_F2 = {};
};
VelocityEquation velocity_equation(const Geometry& geometry, const Pose& pose,
                                   const InverseResult& at);
VelocityEquation velocity_equation(const RailFrames& frames, const ChainsAtPose& at);

/// J_V = J_F2^-1 J_F1 (13): platform rates (mm/s, rad/s) per joint rates (mm/s), shape (3, 3).
/// Precondition: singularity(...) is not zero.
Eigen::Matrix3d velocity_jacobian(const VelocityEquation& equation);

/// Distance from the two kinds of singularity, 1 at best and 0 at the singular pose.
struct Singularity {
  double serial = 0;  // min |cos(alpha_i - theta_i)|: rail and link at right angles, motion is lost
  double parallel = 0;  // smallest singular value of J_F2 with phi scaled by r (times 1/sqrt(3)):
                        // the links meet in a point or are parallel, stiffness is lost
  [[nodiscard]] double margin() const { return serial < parallel ? serial : parallel; }
};
Singularity singularity(const Geometry& geometry, const VelocityEquation& equation);

}  // namespace trammel
