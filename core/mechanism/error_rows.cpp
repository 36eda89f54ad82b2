#include "core/mechanism/error_rows.hpp"

#include <algorithm>
#include <array>

#include "core/error.hpp"
#include "core/mechanism/forward_lanes.hpp"

namespace trammel {

namespace {

/// Columns of (18) and (19) for chain i: the six of the paper, then the rail's offset.
template <int n>
std::array<Real<n>, 7> errors_of(const RailFrames& frames, std::size_t i,
                                 const ChainInLanes<n>& at) {
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
  PosesInLanes<n> block;
  block.l = columns_of<n>(poses.l_mm.data());
  block.X = columns_of<n>(poses.poses.data());
  find_poses<n>(frames, block);
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
