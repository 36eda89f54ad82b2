#pragma once

#include <span>
#include <vector>

#include "core/plane/place.hpp"

namespace trammel {

/// The corners of the smallest upright rectangle around places, of which there is one at least.
struct Extent {
  Place low, high;
};
Extent extent(std::span<const Place> places);

/// The upright square from low to high in x and y, as a convex hull.
std::vector<Place> square_hull(double low_mm, double high_mm);

}  // namespace trammel
