#include "core/judge/range.hpp"

#include <algorithm>

#include "core/error.hpp"

namespace trammel {

bool FittedRange::holds_place(const Pose& p) const { return inside(hull, {p.x_mm, p.y_mm}); }

bool FittedRange::holds_phi(const Pose& p) const {
  return p.phi_rad >= phi_low - kPhiSlackRad && p.phi_rad <= phi_high + kPhiSlackRad;
}

std::string FittedRange::why_outside(const Pose& p) const {
  if (!holds_place(p)) return "outside the convex hull of the fitted points";
  return holds_phi(p) ? "" : "turned beyond the fitted orientations";
}

FittedRange fitted_range(std::span<const Reading> fitted) {
  TRAMMEL_ASSERT(!fitted.empty());
  std::vector<Place> places;
  FittedRange range{{}, fitted.front().target.phi_rad, fitted.front().target.phi_rad};
  for (const Reading& r : fitted) {
    places.push_back({r.target.x_mm, r.target.y_mm});
    range.phi_low = std::min(range.phi_low, r.target.phi_rad);
    range.phi_high = std::max(range.phi_high, r.target.phi_rad);
  }
  range.hull = convex_hull(places);
  return range;
}

}  // namespace trammel
