#include "core/mechanism/error_model.hpp"

#include <Eigen/LU>
#include <cmath>

#include "core/mechanism/velocity.hpp"

namespace trammel {

ErrorJacobian error_jacobian(const Geometry& geometry, const Pose& pose, const InverseResult& at) {
  ErrorJacobian J_2 = ErrorJacobian::Zero();
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double theta = at.theta_rad[i];
    const double gamma = c.beta_rad + pose.phi_rad;
    const double l = at.l_mm[i] + c.l_zero_mm;
    const double cosine = std::cos(c.alpha_rad - theta), sine = std::sin(c.alpha_rad - theta);
    J_2.block<1, 6>(i, 6 * i) << (c.R_mm - l) * sine - c.h_mm * cosine,
        c.r_mm * std::sin(gamma - theta), -std::cos(gamma - theta), 1, cosine, -cosine;  // (18)
    J_2(i, kPaperParameters + i) = -sine;
  }
  return velocity_equation(geometry, pose, at).J_F2.inverse() * J_2;  // (19)
}

}  // namespace trammel
