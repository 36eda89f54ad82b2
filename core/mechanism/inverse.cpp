#include "core/mechanism/inverse.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace trammel {

namespace {

constexpr std::size_t kLanes = 8;  // poses side by side: the compiler vectorises over them

/// A chain seen from its rail: C_i - h n = (x ca + y sa + k1 cos phi - k2 sin phi) u + …
struct RailFrame {
  double ca, sa, k1, k2, R_mm, S_mm, h_mm, l_zero_mm;
};

RailFrame rail_frame(const Chain& c) {
  const double turn = c.beta_rad - c.alpha_rad;
  return {std::cos(c.alpha_rad),
          std::sin(c.alpha_rad),
          c.r_mm * std::cos(turn),
          c.r_mm * std::sin(turn),
          c.R_mm,
          c.S_mm,
          c.h_mm,
          c.l_zero_mm};
}

struct Block {
  std::array<double, kLanes> x, y, cosine, sine;
};

/// One chain of a block of poses; NaN (the root of a negative) where it does not reach.
std::array<double, kLanes> displacements(const RailFrame& f, const Block& at) {
  std::array<double, kLanes> l;
  for (std::size_t j = 0; j < kLanes; ++j) {
    const double along =
        at.x[j] * f.ca + at.y[j] * f.sa + (f.k1 * at.cosine[j] - f.k2 * at.sine[j]) + f.R_mm;
    const double across =
        at.y[j] * f.ca - at.x[j] * f.sa + (f.k2 * at.cosine[j] + f.k1 * at.sine[j]) - f.h_mm;
    l[j] = (f.S_mm - across) * (f.S_mm + across);
    l[j] = along - std::sqrt(l[j]) - f.l_zero_mm;  // (4)
  }
  return l;
}

}  // namespace

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

std::size_t inverse_displacements(const Geometry& geometry, std::span<const Pose> poses,
                                  std::span<Displacements> l_mm) {
  TRAMMEL_ASSERT(poses.size() == l_mm.size());
  std::array<RailFrame, kChains> frames{};
  std::transform(geometry.chains.begin(), geometry.chains.end(), frames.begin(), rail_frame);
  std::size_t first_unreached = poses.size();
  Block at{};
  for (std::size_t first = 0; first < poses.size(); first += kLanes) {
    const std::size_t n = std::min(kLanes, poses.size() - first);
    for (std::size_t j = 0; j < n; ++j) {
      const Pose& pose = poses[first + j];
      at.x[j] = pose.x_mm;
      at.y[j] = pose.y_mm;
      at.cosine[j] = std::cos(pose.phi_rad);
      at.sine[j] = std::sin(pose.phi_rad);
    }
    for (int i = 0; i < kChains; ++i) {
      const auto l = displacements(frames[static_cast<std::size_t>(i)], at);
      for (std::size_t j = 0; j < n; ++j) {
        l_mm[first + j][i] = l[j];
        if (!(l[j] == l[j])) first_unreached = std::min(first_unreached, first + j);
      }
    }
  }
  return first_unreached;
}

}  // namespace trammel
