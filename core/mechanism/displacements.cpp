#include "core/mechanism/displacements.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/mechanism/chain_lanes.hpp"

namespace trammel {

namespace {

/// Rails i and i + 1.
Rail<Real<2>> two_rails(const RailFrames& f, std::size_t i) {
  const auto of = [i](const std::array<double, 4>& all) { return Real<2>{all[i], all[i + 1]}; };
  return {of(f.ca),   of(f.sa),   of(f.k1),   of(f.k2),
          of(f.R_mm), of(f.S_mm), of(f.h_mm), of(f.l_zero_mm)};
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
  static_assert(sizeof(Pose) == 3 * sizeof(double) && sizeof(Displacements) == sizeof(Pose));
  std::array<Real<n>, blocks> x, y, sine, cosine;
  std::array<std::array<Real<n>, 3>, blocks> l;
  for (std::size_t b = 0; b < blocks; ++b) {
    const std::array<Real<n>, 3> pose = columns_of<n>(poses + n * b);
    const SineCosine<n> turn = turn_of<n>(pose[2]);
    x[b] = pose[0];
    y[b] = pose[1];
    sine[b] = turn.sine;
    cosine[b] = turn.cosine;
  }
  for (std::size_t i = 0; i < kChains; ++i) {
    const Rail<double> f = rail(frames, i);
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto at = chain_equation(f, x[b], y[b], sine[b], cosine[b]);
      l[b][i] = at.l;
      reached += at.reach;
    }
  }
  for (std::size_t b = 0; b < blocks; ++b) store_columns<n>(l[b], l_mm + n * b);
}

}  // namespace

RailFrames rail_frames(const Geometry& geometry) {
  RailFrames f{};
  for (std::size_t i = 0; i < kChains; ++i) {
    const Chain& c = geometry.chains[i];
    const double turn = c.beta_rad - c.alpha_rad;
    f.ca[i] = std::cos(c.alpha_rad);
    f.sa[i] = std::sin(c.alpha_rad);
    f.k1[i] = c.r_mm * std::cos(turn);
    f.k2[i] = c.r_mm * std::sin(turn);
    f.r_mm[i] = c.r_mm;
    f.R_mm[i] = c.R_mm;
    f.S_mm[i] = c.S_mm;
    f.h_mm[i] = c.h_mm;
    f.l_zero_mm[i] = c.l_zero_mm;
  }
  return f;
}

ChainsAtPose chains_at(const RailFrames& frames, const Eigen::Vector3d& X) {
  ChainsAtPose at;
  const double sine = std::sin(X[2]), cosine = std::cos(X[2]);
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const ChainEquation<double> chain = chain_equation(rail(frames, i), X[0], X[1], sine, cosine);
    if (!(chain.square >= 0)) {
      at.missed = static_cast<int>(i);
      return at;
    }
    at.l_mm[row] = chain.l;
    at.link_u[row] = chain.reach / frames.S_mm[i];
    at.link_n[row] = chain.across / frames.S_mm[i];
    at.arm_u_mm[row] = chain.arm_u;
    at.arm_n_mm[row] = chain.arm_n;
  }
  return at;
}

Eigen::Vector3d link_angles_rad(const RailFrames& frames, const ChainsAtPose& at) {
  Eigen::Vector3d theta;
  for (std::size_t i = 0; i < kChains; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double u = at.link_u[row], n = at.link_n[row], ca = frames.ca[i], sa = frames.sa[i];
    theta[row] = std::atan2(u * sa + n * ca, u * ca - n * sa);
  }
  return theta;
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
  const SineCosine<2> turn = turn_of<2>(Real<2>{pose.phi_rad, pose.phi_rad});
  const Real<2> x = {pose.x_mm, pose.x_mm}, y = {pose.y_mm, pose.y_mm};
  const auto first = chain_equation(two_rails(frames, 0), x, y, turn.sine, turn.cosine);
  const auto last = chain_equation(two_rails(frames, 2), x, y, turn.sine, turn.cosine);
  const double reached = first.reach[0] + first.reach[1] + last.reach[0];
  if (!(reached == reached)) return {};
  return Displacements(first.l[0], first.l[1], last.l[0]);
}

}  // namespace trammel
