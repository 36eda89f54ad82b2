#include "core/mechanism/error_model.hpp"

#include "core/linear/decompositions.hpp"
#include "core/mechanism/velocity.hpp"

namespace trammel {

ErrorJacobian error_jacobian(const RailFrames& frames, const ChainsAtPose& at) {
  const Eigen::Matrix3d J_1_inverse = inverse(velocity_equation(frames, at).J_F2);
  ErrorJacobian J;
  for (int i = 0; i < kChains; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double cosine = at.link_u[i], sine = -at.link_n[i];  // of alpha - theta
    const double arm_along = cosine * at.arm_u_mm[i] - sine * at.arm_n_mm[i];
    const double arm_across = cosine * at.arm_n_mm[i] + sine * at.arm_u_mm[i];
    const double l_mm = at.l_mm[i] + frames.l_zero_mm[k];
    Eigen::Matrix<double, 1, 6> J_2;  // (18); the other chains' are zero
    J_2 << (frames.R_mm[k] - l_mm) * sine - frames.h_mm[k] * cosine, arm_across,
        -arm_along / frames.r_mm[k], 1, cosine, -cosine;
    J.block<3, 6>(0, 6 * i).noalias() = J_1_inverse.col(i) * J_2;  // (19)
    J.col(kPaperParameters + i) = -sine * J_1_inverse.col(i);
  }
  return J;
}

}  // namespace trammel
