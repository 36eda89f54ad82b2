#include "core/mechanism/inverse.hpp"

#include <cmath>

namespace trammel {

InverseResult inverse(const Geometry& geometry, const Pose& pose) {
  InverseResult result;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double ca = std::cos(c.alpha_rad), sa = std::sin(c.alpha_rad);
    const double gamma = c.beta_rad + pose.phi_rad;
    const double Qx = pose.x_mm + c.r_mm * std::cos(gamma) + c.R_mm * ca + c.h_mm * sa;
    const double Qy = pose.y_mm + c.r_mm * std::sin(gamma) + c.R_mm * sa - c.h_mm * ca;
    const double along = Qx * ca + Qy * sa;
    const double across = -Qx * sa + Qy * ca;
    const double discriminant = (c.S_mm - across) * (c.S_mm + across);
    if (!(discriminant >= 0)) {
      result.chain = i;
      return result;
    }
    const double reach = std::sqrt(discriminant);
    result.l_mm[i] = along - reach - c.l_zero_mm;  // (4)
    // B_i C_i = reach u + across n
    result.theta_rad[i] = std::atan2(reach * sa + across * ca, reach * ca - across * sa);
  }
  result.status = InverseResult::Status::ok;
  return result;
}

std::vector<InverseResult> inverse(const Geometry& geometry, std::span<const Pose> poses) {
  std::vector<InverseResult> results;
  results.reserve(poses.size());
  for (const Pose& pose : poses) results.push_back(inverse(geometry, pose));
  return results;
}

}  // namespace trammel
