#include "core/plane/hull.hpp"

#include <algorithm>
#include <cmath>

namespace trammel {

namespace {

double cross(Place o, Place a, Place b) {
  return (a.x_mm - o.x_mm) * (b.y_mm - o.y_mm) - (a.y_mm - o.y_mm) * (b.x_mm - o.x_mm);
}

double distance_to_segment(Place a, Place b, Place p) {
  const double dx = b.x_mm - a.x_mm, dy = b.y_mm - a.y_mm;
  const double length2 = dx * dx + dy * dy;
  const double along =
      length2 > 0 ? ((p.x_mm - a.x_mm) * dx + (p.y_mm - a.y_mm) * dy) / length2 : 0;
  const double t = std::clamp(along, 0.0, 1.0);
  return std::hypot(p.x_mm - a.x_mm - t * dx, p.y_mm - a.y_mm - t * dy);
}

}  // namespace

std::vector<Place> convex_hull(std::span<const Place> places) {
  std::vector<Place> sorted(places.begin(), places.end());
  std::sort(sorted.begin(), sorted.end(), [](Place a, Place b) {
    return a.x_mm < b.x_mm || (a.x_mm == b.x_mm && a.y_mm < b.y_mm);
  });
  sorted.erase(std::unique(sorted.begin(), sorted.end(),
                           [](Place a, Place b) { return a.x_mm == b.x_mm && a.y_mm == b.y_mm; }),
               sorted.end());
  if (sorted.size() < 3) return sorted;
  std::vector<Place> hull;  // Andrew's monotone chain: lower, then upper
  for (int side = 0; side < 2; ++side) {
    const std::size_t base = hull.size();
    for (const Place p : sorted) {
      while (hull.size() >= base + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(sorted.begin(), sorted.end());
  }
  return hull;
}

bool inside(std::span<const Place> hull, Place at, double slack_mm) {
  if (hull.empty()) return false;
  bool within = hull.size() > 2;
  double nearest = INFINITY;
  for (std::size_t k = 0; k < hull.size(); ++k) {
    const Place a = hull[k], b = hull[(k + 1) % hull.size()];
    within = within && cross(a, b, at) >= 0;
    nearest = std::min(nearest, distance_to_segment(a, b, at));
  }
  return within || nearest <= slack_mm;
}

}  // namespace trammel
