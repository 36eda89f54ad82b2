#include "core/plane/extent.hpp"

#include <algorithm>

#include "core/plane/hull.hpp"

namespace trammel {

Extent extent(std::span<const Place> places) {
  Extent all{places.front(), places.front()};
  for (const Place p : places) {
    all.low = {std::min(all.low.x_mm, p.x_mm), std::min(all.low.y_mm, p.y_mm)};
    all.high = {std::max(all.high.x_mm, p.x_mm), std::max(all.high.y_mm, p.y_mm)};
  }
  return all;
}

std::vector<Place> square_hull(double low_mm, double high_mm) {
  return convex_hull(std::vector<Place>{
      {low_mm, low_mm}, {high_mm, low_mm}, {high_mm, high_mm}, {low_mm, high_mm}});
}

}  // namespace trammel
