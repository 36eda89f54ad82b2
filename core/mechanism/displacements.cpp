#include "core/mechanism/displacements.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/lanes.hpp"

namespace trammel {

namespace {

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

constexpr int kPoses = 64;  // a pass: stays in the first cache

/// Sine and cosine by polynomials; by the library where an angle is too large for them.
template <int n>
SineCosine<n> turn_of(const Real<n>& phi) {
  SineCosine<n> turn = sine_cosine_of<n>(phi);
  bool small = true;
  for (int j = 0; j < n; ++j) small &= std::abs(phi[j]) <= kLargestAngle;
  for (int j = 0; j < n && !small; ++j) {
    if (std::abs(phi[j]) <= kLargestAngle) continue;
    turn.sine[j] = std::sin(phi[j]);
    turn.cosine[j] = std::cos(phi[j]);
  }
  return turn;
}

/// `blocks` times n poses, pass by pass: the short passes keep the processor's pipes full. Adds to
/// `reached`, which is not a number once a pose was out of reach.
template <int n, std::size_t blocks>
void displacements_of(const RailFrames& frames, const Pose* poses, Displacements* l_mm,
                      Real<n>& reached) {
  std::array<Real<n>, blocks> x, y, sine, cosine, l;
  for (std::size_t b = 0; b < blocks; ++b) {
    Real<n> phi;
    for (std::size_t j = 0; j < n; ++j) {
      const Pose& pose = poses[n * b + j];
      x[b][j] = pose.x_mm;
      y[b][j] = pose.y_mm;
      phi[j] = pose.phi_rad;
    }
    const SineCosine<n> turn = turn_of<n>(phi);
    sine[b] = turn.sine;
    cosine[b] = turn.cosine;
  }
  for (int i = 0; i < kChains; ++i) {
    const RailFrame& f = frames[static_cast<std::size_t>(i)];
    for (std::size_t b = 0; b < blocks; ++b) {
      const Real<n> along =
          x[b] * f.ca + y[b] * f.sa + (f.k1 * cosine[b] - f.k2 * sine[b]) + f.R_mm;
      const Real<n> across =
          y[b] * f.ca - x[b] * f.sa + (f.k2 * cosine[b] + f.k1 * sine[b]) - f.h_mm;
      const Real<n> square = (f.S_mm - across) * (f.S_mm + across);
      const Real<n> root = each(square, [](double s) { return std::sqrt(s); });
      l[b] = along - root - f.l_zero_mm;  // (4)
      reached += root;
    }
    for (std::size_t b = 0; b < blocks; ++b) {
      for (std::size_t j = 0; j < n; ++j) l_mm[n * b + j][i] = l[b][j];
    }
  }
}

}  // namespace

RailFrames rail_frames(const Geometry& geometry) {
  RailFrames frames{};
  std::transform(geometry.chains.begin(), geometry.chains.end(), frames.begin(), rail_frame);
  return frames;
}

std::size_t inverse_displacements(const RailFrames& frames, std::span<const Pose> poses,
                                  std::span<Displacements> l_mm, CpuLevel level) {
  TRAMMEL_ASSERT(poses.size() == l_mm.size());
  double all = 0;
  at_level(level, [&]<int n>() {
    constexpr std::size_t kBlocks = kPoses / n;
    Real<n> reached = {};
    in_blocks<kPoses>(poses, l_mm, [&](const Pose* from, Displacements* to) {
      displacements_of<n, kBlocks>(frames, from, to, reached);
    });
    for (int j = 0; j < n; ++j) all += reached[j];
  });
  if (all == all) return poses.size();
  const auto missed = [](const Displacements& l) { return l.hasNaN(); };
  return static_cast<std::size_t>(std::ranges::find_if(l_mm, missed) - l_mm.begin());
}

std::optional<Displacements> inverse_displacements(const RailFrames& frames, const Pose& pose) {
  const std::array<Pose, 2> poses = {pose, pose};
  std::array<Displacements, 2> l_mm;
  Real<2> reached = {};
  displacements_of<2, 1>(frames, poses.data(), l_mm.data(), reached);
  if (!(reached[0] == reached[0])) return {};
  return l_mm[0];
}

}  // namespace trammel
