#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/plane/place.hpp"

namespace trammel {

/// Block of each place, 0 … n_blocks - 1, for spatially blocked cross-validation: neighbours fall
/// into one block, so that a held-out point has none of its neighbours in training (a random fold
/// has, and flatters interpolators). Blocks by k-means of the distinct places; repeats stay
/// together. Fewer blocks when there are fewer places. Precondition: n_blocks >= 2, some places.
std::vector<int> spatial_blocks(std::span<const Place> places, int n_blocks,
                                std::uint64_t seed = 1);

}  // namespace trammel
