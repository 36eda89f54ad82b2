#include "core/mechanism/displacements.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/lanes.hpp"

namespace trammel {

namespace {

/// A rail's frame, or those of all rails in lanes.
template <class T>
struct Rail {
  T ca, sa, k1, k2, R_mm, S_mm, h_mm, l_zero_mm;
};

Rail<double> rail(const RailFrames& f, std::size_t i) {
  return {f.ca[i], f.sa[i], f.k1[i], f.k2[i], f.R_mm[i], f.S_mm[i], f.h_mm[i], f.l_zero_mm[i]};
}

/// Rails i and i + 1.
Rail<Real<2>> two_rails(const RailFrames& f, std::size_t i) {
  const auto of = [i](const std::array<double, 4>& all) { return Real<2>{all[i], all[i + 1]}; };
  return {of(f.ca),   of(f.sa),   of(f.k1),   of(f.k2),
          of(f.R_mm), of(f.S_mm), of(f.h_mm), of(f.l_zero_mm)};
}

template <class T>
struct Reach {
  T l_mm, root;  // root is not a number where the pose is out of reach
};

/// (4) of one rail and poses in lanes, or of one pose and rails in lanes.
template <class F, class X>
auto displacement(const Rail<F>& f, const X& x, const X& y, const X& sine, const X& cosine) {
  const auto along = x * f.ca + y * f.sa + (f.k1 * cosine - f.k2 * sine) + f.R_mm;
  const auto across = y * f.ca - x * f.sa + (f.k2 * cosine + f.k1 * sine) - f.h_mm;
  const auto square = (f.S_mm - across) * (f.S_mm + across);
  const auto root = each(square, [](double s) { return std::sqrt(s); });
  return Reach<std::remove_const_t<decltype(root)>>{along - root - f.l_zero_mm, root};
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
      const auto reach = displacement(f, x[b], y[b], sine[b], cosine[b]);
      l[b][i] = reach.l_mm;
      reached += reach.root;
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
    const double ca = frames.ca[i], sa = frames.sa[i], S = frames.S_mm[i];
    const double arm_u = frames.k1[i] * cosine - frames.k2[i] * sine;
    const double arm_n = frames.k2[i] * cosine + frames.k1[i] * sine;
    const double along = X[0] * ca + X[1] * sa + arm_u + frames.R_mm[i];
    const double across = X[1] * ca - X[0] * sa + arm_n - frames.h_mm[i];
    const double square = (S - across) * (S + across);
    if (!(square >= 0)) {
      at.missed = static_cast<int>(i);
      return at;
    }
    const double reach = std::sqrt(square);
    at.l_mm[row] = along - reach - frames.l_zero_mm[i];
    at.link_u[row] = reach / S;
    at.link_n[row] = across / S;
    at.arm_u_mm[row] = arm_u;
    at.arm_n_mm[row] = arm_n;
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
  const auto first = displacement(two_rails(frames, 0), x, y, turn.sine, turn.cosine);
  const auto last = displacement(two_rails(frames, 2), x, y, turn.sine, turn.cosine);
  const double reached = first.root[0] + first.root[1] + last.root[0];
  if (!(reached == reached)) return {};
  return Displacements(first.l_mm[0], first.l_mm[1], last.l_mm[0]);
}

}  // namespace trammel
