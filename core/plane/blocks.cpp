#include "core/plane/blocks.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "core/plane/kmeans.hpp"

namespace trammel {

std::vector<int> spatial_blocks(std::span<const Place> places, int n_blocks, std::uint64_t seed) {
  TRAMMEL_ASSERT(n_blocks >= 2 && !places.empty());
  const std::vector<Place> distinct = distinct_places(places);
  const int k = std::min(n_blocks, static_cast<int>(distinct.size()));
  const std::vector<Place> centres = kmeans(distinct, k, seed).centres;
  std::vector<int> blocks;
  for (const Place p : places) {
    const auto d2 = [p](Place c) {
      return (p.x_mm - c.x_mm) * (p.x_mm - c.x_mm) + (p.y_mm - c.y_mm) * (p.y_mm - c.y_mm);
    };
    const auto nearest = std::min_element(centres.begin(), centres.end(),
                                          [&](Place a, Place b) { return d2(a) < d2(b); });
    blocks.push_back(static_cast<int>(nearest - centres.begin()));
  }
  return blocks;
}

}  // namespace trammel
