#include "core/mechanism/inverse.hpp"

#include <cmath>

#include "core/mechanism/rail_directions.hpp"

namespace trammel {

RailDirections rail_directions(const Geometry& geometry) {
  RailDirections rails{};
  for (std::size_t i = 0; i < kChains; ++i) {
    rails.cosine[i] = std::cos(geometry.chains[i].alpha_rad);
    rails.sine[i] = std::sin(geometry.chains[i].alpha_rad);
  }
  return rails;
}

InverseResult inverse(const Geometry& geometry, const Pose& pose) {
  return inverse(geometry, rail_directions(geometry), pose);
}

InverseResult inverse(const Geometry& geometry, const RailDirections& rails, const Pose& pose) {
  InverseResult result;
  for (int i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[static_cast<std::size_t>(i)];
    const double ca = rails.cosine[static_cast<std::size_t>(i)];
    const double sa = rails.sine[static_cast<std::size_t>(i)];
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
  const RailDirections rails = rail_directions(geometry);
  for (const Pose& pose : poses) results.push_back(inverse(geometry, rails, pose));
  return results;
}

}  // namespace trammel
