#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace trammel {

/// A place in the plane, mm.
struct Place {
  double x_mm = 0;
  double y_mm = 0;
};

/// Which distinct place each of `places` is, numbered by first appearance. Places are one where
/// they round to the same picometre (1e-9 mm): a coordinate that went through text is itself again.
std::vector<std::size_t> group_places(std::span<const Place> places);

/// The distinct places, in the order of their first appearance.
std::vector<Place> distinct_places(std::span<const Place> places);

}  // namespace trammel
