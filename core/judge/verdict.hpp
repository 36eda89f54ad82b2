#pragma once

#include <string>

namespace trammel {

/// Times the floor that still count as being there: as near as readings of this noise can tell.
inline constexpr double kAtFloor = 1.3;

/// Of the floor: what lies below was fitted to the noise itself, no robot reads so little.
inline constexpr double kBelowFloor = 0.7;

/// "at the floor: 0.0130 mm where a perfect robot reads 0.0125", "12.3 um unexplained beyond the
/// floor of 0.0125 mm": sqrt(mean^2 - floor^2), or "0.0000 mm is below the floor of 0.0125 mm that
/// a perfect robot reads: the fit follows the noise of these readings, and they cannot judge it".
/// Precondition: floor_mm > 0. Proof: summary_test.cpp.
std::string floor_verdict(double mean_mm, double floor_mm);

}  // namespace trammel
