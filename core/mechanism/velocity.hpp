#pragma once
// Joint velocity and acceleration, the velocity Jacobian, and how far a pose is from singular.

#include <Eigen/Core>

#include "core/mechanism/displacements.hpp"
#include "core/mechanism/geometry.hpp"
#include "core/mechanism/inverse.hpp"

namespace trammel {

/// Rates of one chain: (l', theta') or (l'', theta''), shape (3) each, mm/s and rad/s (or /s^2).
struct JointRates {
  Eigen::Vector3d l = {};
  Eigen::Vector3d theta = {};
};

/// Joint rates under the platform rates `X_dot` = (x', y', phi'); at a pose solved by `inverse`.
///
///   cos(alpha) l' - S sin(theta) theta' = x' - r sin(beta + phi) phi'
///   sin(alpha) l' + S cos(theta) theta' = y' + r cos(beta + phi) phi'                       (5, 6)
/// Source: Zhang et al. 2024. Proof: finite differences of the inverse kinematics
/// (velocity_test.cpp).
JointRates joint_velocity(const Geometry& geometry, const Pose& pose, const InverseResult& at,
                          const Eigen::Vector3d& X_dot);

/// Joint accelerations under X' and X''.
///
///   cos(alpha) l'' - S sin(theta) theta'' = x'' - r cos(g) phi'^2 - r sin(g) phi'' + S cos(theta)
///   theta'^2 sin(alpha) l'' + S cos(theta) theta'' = y'' - r sin(g) phi'^2 + r cos(g) phi'' + S
///   sin(theta) theta'^2
/// with g = beta + phi (7, 8; the sign of the last terms corrected). Proof: second differences.
JointRates joint_acceleration(const Geometry& geometry, const Pose& pose, const InverseResult& at,
                              const Eigen::Vector3d& X_dot, const Eigen::Vector3d& X_ddot);

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
