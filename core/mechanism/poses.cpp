#include "core/mechanism/poses.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/mechanism/forward.hpp"
#include "core/mechanism/forward_lanes.hpp"

namespace trammel {

std::vector<std::size_t> poses_at(const RailFrames& rails, std::span<const Displacements> l_mm,
                                  std::span<Pose> poses, CpuLevel level) {
  static_assert(sizeof(Pose) == 3 * sizeof(double) && sizeof(Displacements) == sizeof(Pose));
  TRAMMEL_ASSERT(poses.size() == l_mm.size());
  std::vector<Pose> starts(poses.begin(), poses.end());
  std::vector<std::size_t> missed;
  at_level(level, [&]<int n>() {
    constexpr auto kPoses = static_cast<std::size_t>(n);
    for (std::size_t first = 0; first < poses.size(); first += kPoses) {
      const std::size_t count = std::min(kPoses, poses.size() - first);
      std::array<Displacements, kPoses> l;
      std::array<Pose, kPoses> at;
      for (std::size_t j = 0; j < kPoses; ++j) {  // the last block is filled up with copies
        l[j] = l_mm[first + std::min(j, count - 1)];
        at[j] = poses[first + std::min(j, count - 1)];
      }
      PosesInLanes<n> block;
      block.l = columns_of<n>(l.data());
      block.X = columns_of<n>(at.data());
      find_poses<n>(rails, block);
      store_columns<n>(block.X, at.data());
      for (std::size_t j = 0; j < count; ++j) {
        poses[first + j] = at[j];
        if (block.found[static_cast<int>(j)] == 0) missed.push_back(first + j);
      }
    }
  });
  std::erase_if(missed, [&](std::size_t k) {
    const ForwardResult at = forward(rails, l_mm[k], starts[k]);
    poses[k] = at.pose;
    return at.ok();
  });
  return missed;
}

}  // namespace trammel
