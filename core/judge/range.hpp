#pragma once
// Where a fit may be asked without extrapolating.

#include <span>
#include <string>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/plane/hull.hpp"
#include "core/units.hpp"

namespace trammel {

/// Of the readings that were fitted: the convex hull of their places, and their orientations.
struct FittedRange {
  std::vector<Place> hull;
  double phi_low = 0, phi_high = 0;

  [[nodiscard]] bool holds_place(const Pose& p) const;
  [[nodiscard]] bool holds_phi(const Pose& p) const;  // within kPhiSlackRad
  /// "" within the range, else "outside the convex hull of the fitted points" …
  [[nodiscard]] std::string why_outside(const Pose& p) const;
};
inline constexpr double kPhiSlackRad = rad_from_deg(0.05);  // a tracker's sigma of phi, generously

/// Precondition: some readings. Proof: assess_test.cpp.
FittedRange fitted_range(std::span<const Reading> fitted);

}  // namespace trammel
