#pragma once

#include <string>

namespace trammel {

/// Times the floor that still count as being there: as near as readings of this noise can tell.
inline constexpr double kAtFloor = 1.3;

/// "at the floor: 0.0130 mm where a perfect robot reads 0.0125", or "12.3 um unexplained beyond the
/// floor of 0.0125 mm": sqrt(mean^2 - floor^2). Precondition: floor_mm > 0.
std::string floor_verdict(double mean_mm, double floor_mm);

}  // namespace trammel
