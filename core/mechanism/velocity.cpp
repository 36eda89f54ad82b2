#include "core/mechanism/velocity.hpp"

#include <cmath>

#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

/// Solves [cos a, -S sin t; sin a, S cos t] (l, theta)' = b: the determinant is S cos(a - t).
void solve_chain(const Chain& c, double theta, double bx, double by, double& l, double& t) {
  const double ca = std::cos(c.alpha_rad), sa = std::sin(c.alpha_rad);
  const double ct = std::cos(theta), st = std::sin(theta);
  const double cosine = ca * ct + sa * st;
  l = (ct * bx + st * by) / cosine;
  t = (-sa * bx + ca * by) / (c.S_mm * cosine);
}

}  // namespace

JointRates joint_velocity(const Geometry& geometry, const Pose& pose, const InverseResult& at,
                          const Eigen::Vector3d& X_dot) {
  JointRates rates;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double g = c.beta_rad + pose.phi_rad;
    const double bx = X_dot[0] - c.r_mm * std::sin(g) * X_dot[2];
    const double by = X_dot[1] + c.r_mm * std::cos(g) * X_dot[2];
    solve_chain(c, at.theta_rad[i], bx, by, rates.l[i], rates.theta[i]);  // (6)
  }
  return rates;
}

JointRates joint_acceleration(const Geometry& geometry, const Pose& pose, const InverseResult& at,
                              const Eigen::Vector3d& X_dot, const Eigen::Vector3d& X_ddot) {
  const JointRates velocity = joint_velocity(geometry, pose, at, X_dot);
  JointRates rates;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double g = c.beta_rad + pose.phi_rad;
    const double phi2 = X_dot[2] * X_dot[2];
    const double theta2 = velocity.theta[i] * velocity.theta[i];
    const double ct = std::cos(at.theta_rad[i]), st = std::sin(at.theta_rad[i]);
    const double bx =
        X_ddot[0] - c.r_mm * (std::cos(g) * phi2 + std::sin(g) * X_ddot[2]) + c.S_mm * ct * theta2;
    const double by =
        X_ddot[1] - c.r_mm * (std::sin(g) * phi2 - std::cos(g) * X_ddot[2]) + c.S_mm * st * theta2;
    solve_chain(c, at.theta_rad[i], bx, by, rates.l[i], rates.theta[i]);  // (8)
  }
  return rates;
}

VelocityEquation velocity_equation(const Geometry& geometry, const Pose& pose,
                                   const InverseResult& at) {
  VelocityEquation equation;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double theta = at.theta_rad[i];
    equation.J_F1_diagonal[i] = std::cos(c.alpha_rad - theta);
    equation.J_F2.row(i) << std::cos(theta), std::sin(theta),
        -c.r_mm * std::sin(c.beta_rad + pose.phi_rad - theta);
  }
  return equation;
}

VelocityEquation velocity_equation(const RailFrames& frames, const ChainsAtPose& at) {
  VelocityEquation equation;
  equation.J_F1_diagonal = at.link_u;
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double u = at.link_u[row], n = at.link_n[row], ca = frames.ca[i], sa = frames.sa[i];
    equation.J_F2.row(row) << u * ca - n * sa, u * sa + n * ca,
        n * at.arm_u_mm[row] - u * at.arm_n_mm[row];
  }
  return equation;
}

Eigen::Matrix3d velocity_jacobian(const VelocityEquation& equation) {
  return inverse(equation.J_F2) * equation.J_F1_diagonal.asDiagonal();
}

Singularity singularity(const Geometry& geometry, const VelocityEquation& equation) {
  double r_mm = 0;
  for (const Chain& c : geometry.chains) r_mm += c.r_mm / kChains;
  Eigen::Matrix3d scaled = equation.J_F2;
  scaled.col(2) /= r_mm;
  return {equation.J_F1_diagonal.cwiseAbs().minCoeff(),
          smallest_singular_value(scaled) / std::sqrt(3.0)};
}

}  // namespace trammel
