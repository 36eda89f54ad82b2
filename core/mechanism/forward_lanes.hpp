#pragma once
// The iteration of forward.hpp for several poses side by side.

#include <array>
#include <cmath>
#include <cstddef>

#include "core/linear/lanes.hpp"
#include "core/mechanism/chain_lanes.hpp"

namespace trammel {

/// Chain i at n poses (ChainsAtPose), and its row of J_F2 (6).
template <int n>
struct ChainInLanes {
  Real<n> l, u, across, arm_u, arm_n;
  std::array<Real<n>, 3> row;
};

template <int n>
struct PosesInLanes {
  std::array<Real<n>, 3> l, X;  // X: where to look first, then the poses
  Whole<n> found;               // all bits, or none
  std::array<ChainInLanes<n>, 3> at;
  std::array<std::array<Real<n>, 3>, 3> inverse;  // columns of J_F2^-1
};

template <int n>
ChainInLanes<n> chain_in_lanes(const RailFrames& frames, std::size_t i,
                               const std::array<Real<n>, 3>& X, const SineCosine<n>& turn) {
  const Rail<double> f = rail(frames, i);
  const auto at = chain_equation(f, X[0], X[1], turn.sine, turn.cosine);
  const Real<n> u = at.reach / f.S_mm, across = at.across / f.S_mm;
  return {at.l,
          u,
          across,
          at.arm_u,
          at.arm_n,
          {u * f.ca - across * f.sa, u * f.sa + across * f.ca, across * at.arm_u - u * at.arm_n}};
}

template <int n>
Real<n> largest_of(const std::array<Real<n>, 3>& of) {
  std::array<Real<n>, 3> size;
  for (std::size_t i = 0; i < 3; ++i) size[i] = of[i] < 0.0 ? -of[i] : of[i];
  const Real<n> two = size[0] > size[1] ? size[0] : size[1];
  return two > size[2] ? two : size[2];
}

/// Columns of the inverse of J_F2, by its cofactors.
template <int n>
std::array<std::array<Real<n>, 3>, 3> inverse_columns(const std::array<ChainInLanes<n>, 3>& at) {
  std::array<std::array<Real<n>, 3>, 3> columns;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto &a = at[(i + 1) % 3].row, &b = at[(i + 2) % 3].row;
    columns[i] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  }
  const auto& row = at[0].row;
  const Real<n> scale =
      1.0 / (row[0] * columns[0][0] + row[1] * columns[0][1] + row[2] * columns[0][2]);
  for (auto& column : columns) {
    for (Real<n>& entry : column) entry *= scale;
  }
  return columns;
}

/// Newton's steps as in forward(), each pose until it is found; what it takes a shorter step to
/// find, or is not there, is left unfound.
template <int n>
void find_poses(const RailFrames& frames, PosesInLanes<n>& poses) {
  constexpr double kFound = 1e-12;     // of the displacement, and mm: as forward() stops
  constexpr double kRounding = 1e-11;  // mm: what a step that no longer improves may leave
  constexpr int kMostSteps = 12;
  const Real<n> size = largest_of<n>(poses.l), one = Real<n>{} + 1.0;
  const Real<n> tolerance = kFound * (size > one ? size : one);
  Real<n> previous = Real<n>{} + INFINITY;
  poses.found = Whole<n>{};
  for (int step = 0; step < kMostSteps; ++step) {
    const SineCosine<n> turn = sine_cosine_of<n>(poses.X[2]);
    std::array<Real<n>, 3> missing;
    for (std::size_t i = 0; i < 3; ++i) {
      poses.at[i] = chain_in_lanes<n>(frames, i, poses.X, turn);
      missing[i] = poses.l[i] - poses.at[i].l;
    }
    poses.inverse = inverse_columns<n>(poses.at);
    const Real<n> gap = largest_of<n>(missing);
    const Real<n> near = poses.X[2] < 0.0 ? -poses.X[2] : poses.X[2];
    poses.found |= ((gap <= tolerance) | ((gap <= kRounding) & (gap >= previous))) &
                   (near <= kLargestAngle) & (missing[0] == missing[0]) &
                   (missing[1] == missing[1]) & (missing[2] == missing[2]);
    bool all = true;
    for (int j = 0; j < n; ++j) all = all && poses.found[j] != 0;
    if (all) return;
    previous = gap;
    for (std::size_t r = 0; r < 3; ++r) {
      Real<n> move = {};
      for (std::size_t i = 0; i < 3; ++i) {
        move += poses.inverse[i][r] * (poses.at[i].u * missing[i]);
      }
      poses.X[r] = poses.found ? poses.X[r] : poses.X[r] + move;
    }
  }
}

}  // namespace trammel
