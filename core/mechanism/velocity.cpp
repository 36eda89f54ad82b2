#include "core/mechanism/velocity.hpp"

#include <cmath>

#include "core/linear/decompositions.hpp"

namespace trammel {

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
