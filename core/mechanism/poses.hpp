#pragma once
// Forward kinematics for tables of displacements, several poses side by side.

#include <span>
#include <vector>

#include "core/linear/cpu_level.hpp"
#include "core/mechanism/displacements.hpp"
#include "core/mechanism/pose.hpp"

namespace trammel {

/// Poses of the platform at displacements `l_mm` of one robot: forward() of forward.hpp. `poses`
/// holds where to look first and then what was found.
///
/// @return  which forward() does not find either, in order, with `poses` undefined there
/// Within 1e-9 mm and rad of forward(); the same bits for a pose wherever it stands in the batch,
/// and on every level of CPU (forward_test.cpp).
[[nodiscard]] std::vector<std::size_t> poses_at(const RailFrames& rails,
                                                std::span<const Displacements> l_mm,
                                                std::span<Pose> poses,
                                                CpuLevel level = cpu_level());

}  // namespace trammel
