#pragma once
// What the base leaves of a campaign.

#include "core/diagnose/residual_space.hpp"
#include "core/measure/reading.hpp"

namespace trammel::tests {

/// The residual space of the fitted set, after the base alone.
inline ResidualSpace space_of(const Campaign& campaign) {
  std::vector<Reading> readings;
  for (const Reading& r : campaign.readings) {
    if (r.set == ReadingSet::identify) readings.push_back(r);
  }
  const GeometryFit fit =
      fit_geometry(nominal_model(mechanism_of(campaign.machine)), readings, *campaign.tracker);
  return residual_space(fit, readings, *campaign.tracker);
}

}  // namespace trammel::tests
