#include "core/mechanism/error_model.hpp"

#include <Eigen/LU>
#include <cmath>

namespace trammel {

ErrorJacobian error_jacobian(const Geometry& geometry, const Pose& pose, const InverseResult& at) {
  ErrorJacobian J_2 = ErrorJacobian::Zero();
  Eigen::Matrix3d J_F2;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double theta = at.theta_rad[i];
    const double arm = c.beta_rad + pose.phi_rad - theta;
    const double l = at.l_mm[i] + c.l_zero_mm;
    const double cosine = std::cos(c.alpha_rad - theta), sine = std::sin(c.alpha_rad - theta);
    const double arm_cosine = std::cos(arm), arm_across = c.r_mm * std::sin(arm);
    J_2.block<1, 6>(i, 6 * i) << (c.R_mm - l) * sine - c.h_mm * cosine, arm_across, -arm_cosine, 1,
        cosine, -cosine;  // (18)
    J_2(i, kPaperParameters + i) = -sine;
    J_F2.row(i) << std::cos(theta), std::sin(theta), -arm_across;  // (6)
  }
  return J_F2.inverse() * J_2;  // (19)
}

}  // namespace trammel
