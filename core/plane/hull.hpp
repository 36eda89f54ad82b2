#pragma once

#include <span>
#include <vector>

#include "core/plane/place.hpp"

namespace trammel {

/// The convex hull of places, counter-clockwise, without points on its edges: where a map may be
/// asked without extrapolating. One or two points for places in one spot or on one line.
std::vector<Place> convex_hull(std::span<const Place> places);

/// Whether `at` lies in the hull or within `slack_mm` of it.
bool inside(std::span<const Place> hull, Place at, double slack_mm = 1e-6);

}  // namespace trammel
