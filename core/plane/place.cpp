#include "core/plane/place.hpp"

#include <cmath>
#include <map>
#include <utility>

namespace trammel {

namespace {

constexpr double kSamePlaceMm = 1e-9;  // rounding

}  // namespace

std::vector<std::size_t> group_places(std::span<const Place> places) {
  std::map<std::pair<long long, long long>, std::size_t> known;
  std::vector<std::size_t> groups;
  groups.reserve(places.size());
  for (const Place p : places) {
    const std::pair rounded{std::llround(p.x_mm / kSamePlaceMm),
                            std::llround(p.y_mm / kSamePlaceMm)};
    groups.push_back(known.try_emplace(rounded, known.size()).first->second);
  }
  return groups;
}

std::vector<Place> distinct_places(std::span<const Place> places) {
  const std::vector<std::size_t> groups = group_places(places);
  std::vector<Place> distinct;
  for (std::size_t k = 0; k < places.size(); ++k) {
    if (groups[k] == distinct.size()) distinct.push_back(places[k]);
  }
  return distinct;
}

}  // namespace trammel
