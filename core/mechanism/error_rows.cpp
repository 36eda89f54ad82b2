#include "core/mechanism/error_rows.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/error.hpp"
#include "core/lanes.hpp"

namespace trammel {

namespace {

constexpr double kFound = 1e-12;     // of the displacement, and mm: as forward() stops
constexpr double kRounding = 1e-11;  // mm: what a step that no longer improves may leave
constexpr int kMostSteps = 12;

/// Chain i at n poses (ChainsAtPose), and its row of J_F2 (6).
template <int n>
struct Lane {
  Real<n> l, u, across, arm_u, arm_n;
  std::array<Real<n>, 3> row;
};

template <int n>
void chain_at(const RailFrames& f, std::size_t i, const std::array<Real<n>, 3>& X,
              const SineCosine<n>& turn, Lane<n>& at) {
  const double ca = f.ca[i], sa = f.sa[i], S = f.S_mm[i];
  at.arm_u = f.k1[i] * turn.cosine - f.k2[i] * turn.sine;
  at.arm_n = f.k2[i] * turn.cosine + f.k1[i] * turn.sine;
  const Real<n> along = X[0] * ca + X[1] * sa + at.arm_u + f.R_mm[i];
  const Real<n> off = X[1] * ca - X[0] * sa + at.arm_n - f.h_mm[i];
  const Real<n> reach = each((S - off) * (S + off), [](double s) { return std::sqrt(s); });
  at.l = along - reach - f.l_zero_mm[i];
  at.u = reach / S;
  at.across = off / S;
  at.row = {at.u * ca - at.across * sa, at.u * sa + at.across * ca,
            at.across * at.arm_u - at.u * at.arm_n};
}

template <int n>
Real<n> largest(const std::array<Real<n>, 3>& of) {
  std::array<Real<n>, 3> size;
  for (std::size_t i = 0; i < 3; ++i) size[i] = of[i] < 0.0 ? -of[i] : of[i];
  const Real<n> two = size[0] > size[1] ? size[0] : size[1];
  return two > size[2] ? two : size[2];
}

/// Column i of the inverse of J_F2, by its cofactors.
template <int n>
std::array<std::array<Real<n>, 3>, 3> inverse_columns(const std::array<Lane<n>, 3>& at) {
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

template <int n>
struct Block {
  std::array<Real<n>, 3> l, X;  // X: where to look first, then the poses
  Whole<n> found;               // all bits, or none
  std::array<Lane<n>, 3> at;
  std::array<std::array<Real<n>, 3>, 3> inverse;  // columns of J_F2^-1
};

/// Newton's steps as in forward(), each pose until it is found.
template <int n>
void find(const RailFrames& frames, Block<n>& block) {
  const Real<n> size = largest<n>(block.l), one = Real<n>{} + 1.0;
  const Real<n> tolerance = kFound * (size > one ? size : one);
  Real<n> previous = Real<n>{} + INFINITY;
  block.found = Whole<n>{};
  for (int step = 0; step < kMostSteps; ++step) {
    const SineCosine<n> turn = sine_cosine_of<n>(block.X[2]);
    std::array<Real<n>, 3> missing;
    for (std::size_t i = 0; i < 3; ++i) {
      chain_at<n>(frames, i, block.X, turn, block.at[i]);
      missing[i] = block.l[i] - block.at[i].l;
    }
    block.inverse = inverse_columns<n>(block.at);
    const Real<n> gap = largest<n>(missing);
    const Real<n> near = block.X[2] < 0.0 ? -block.X[2] : block.X[2];
    block.found |= ((gap <= tolerance) | ((gap <= kRounding) & (gap >= previous))) &
                   (near <= kLargestAngle) & (missing[0] == missing[0]) &
                   (missing[1] == missing[1]) & (missing[2] == missing[2]);
    bool all = true;
    for (int j = 0; j < n; ++j) all = all && block.found[j] != 0;
    if (all) return;
    previous = gap;
    for (std::size_t r = 0; r < 3; ++r) {
      Real<n> move = {};
      for (std::size_t i = 0; i < 3; ++i)
        move += block.inverse[i][r] * (block.at[i].u * missing[i]);
      block.X[r] = block.found ? block.X[r] : block.X[r] + move;
    }
  }
}

/// Columns of (18) and (19) for chain i: the six of the paper, then the rail's offset.
template <int n>
std::array<Real<n>, 7> errors_of(const RailFrames& frames, std::size_t i, const Lane<n>& at) {
  const Real<n> cosine = at.u, sine = -at.across, one = Real<n>{} + 1.0;
  const Real<n> arm_along = cosine * at.arm_u - sine * at.arm_n;
  const Real<n> arm_across = cosine * at.arm_n + sine * at.arm_u;
  const Real<n> l = at.l + frames.l_zero_mm[i];
  return {(frames.R_mm[i] - l) * sine - frames.h_mm[i] * cosine,
          arm_across,
          -arm_along / frames.r_mm[i],
          one,
          cosine,
          -cosine,
          -sine};
}

/// n poses one after the other, and their rows of J column by column.
template <int n>
struct Found {
  static constexpr auto kPoses = static_cast<std::size_t>(n);
  std::array<Displacements, kPoses> l_mm;
  std::array<Pose, kPoses> poses;  // in: where to look first
  std::array<bool, kPoses> found;
  std::array<std::array<double, 3 * kPoses>, kGeometryParameters> J;
};

template <int n>
void solve(const RailFrames& frames, Found<n>& poses) {
  Block<n> block;
  block.l = columns_of<n>(poses.l_mm.data());
  block.X = columns_of<n>(poses.poses.data());
  find<n>(frames, block);
  store_columns<n>(block.X, poses.poses.data());
  for (int j = 0; j < n; ++j) poses.found[static_cast<std::size_t>(j)] = block.found[j] != 0;
  for (std::size_t i = 0; i < kChains; ++i) {
    const std::array<Real<n>, 7> errors = errors_of<n>(frames, i, block.at[i]);
    const std::array<Real<n>, 3>& column = block.inverse[i];
    for (std::size_t e = 0; e < errors.size(); ++e) {
      const std::array<Real<n>, 3> rows = {column[0] * errors[e], column[1] * errors[e],
                                           column[2] * errors[e]};
      store_columns<n>(rows, poses.J[e < 6 ? 6 * i + e : kPaperParameters + i].data());
    }
  }
}

}  // namespace

std::vector<std::size_t> error_rows(const RailFrames& frames, std::span<const Displacements> l_mm,
                                    std::span<Pose> poses, Eigen::MatrixXd& J, CpuLevel level) {
  static_assert(sizeof(Pose) == 3 * sizeof(double) && sizeof(Displacements) == sizeof(Pose));
  TRAMMEL_ASSERT(poses.size() == l_mm.size());
  J.resize(static_cast<Eigen::Index>(3 * poses.size()), kGeometryParameters);
  std::vector<std::size_t> missed;
  at_level(level, [&]<int n>() {
    Found<n> block;
    constexpr std::size_t kPoses = Found<n>::kPoses;
    for (std::size_t first = 0; first < poses.size(); first += kPoses) {
      const std::size_t count = std::min(kPoses, poses.size() - first);
      for (std::size_t j = 0; j < kPoses; ++j) {  // the last block is filled up with copies
        block.l_mm[j] = l_mm[first + std::min(j, count - 1)];
        block.poses[j] = poses[first + std::min(j, count - 1)];
      }
      solve<n>(frames, block);
      for (std::size_t j = 0; j < count; ++j) {
        poses[first + j] = block.poses[j];
        if (!block.found[j]) missed.push_back(first + j);
      }
      for (std::size_t k = 0; k < block.J.size(); ++k) {
        double* to = J.col(static_cast<Eigen::Index>(k)).data() + 3 * first;
        std::copy_n(block.J[k].begin(), 3 * count, to);
      }
    }
  });
  return missed;
}

}  // namespace trammel
