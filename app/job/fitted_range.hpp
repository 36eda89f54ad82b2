#pragma once
// Where the readings lie that a fit has seen: beyond, a correction extrapolates.

#include <span>
#include <string>
#include <vector>

#include "core/measure/reading.hpp"
#include "core/plane/place.hpp"
#include "store/job.hpp"

namespace trammel::job {

struct FittedRange {
  std::vector<Place> hull;  // of the fitted targets
  double phi_low_rad = 0, phi_high_rad = 0;

  [[nodiscard]] bool holds_place(const Pose& p) const;
  [[nodiscard]] bool holds_phi(const Pose& p) const;
};

/// Of readings, one at least. Proof: assess_test.cpp, session_test.cpp.
FittedRange fitted_range(const std::vector<Reading>& fitted);
/// Of what a job fitted.
FittedRange fitted_range(store::Connection& connection, const store::Job& job);

/// "3 of 80 `points` lie outside …", one sentence for place and one for orientation; none when all
/// lie within.
std::vector<std::string> extrapolation_words(const FittedRange& range,
                                             std::span<const Pose> targets,
                                             const std::string& points);

}  // namespace trammel::job
