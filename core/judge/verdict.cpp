#include "core/judge/verdict.hpp"

#include <cmath>
#include <cstdio>

namespace trammel {

std::string floor_verdict(double mean_mm, double floor_mm) {
  char text[200];
  if (mean_mm < kBelowFloor * floor_mm) {
    std::snprintf(
        text, sizeof text,
        "%.4f mm is below the floor of %.4f mm that a perfect robot reads: the fit follows "
        "the noise of these readings, and they cannot judge it",
        mean_mm, floor_mm);
  } else if (mean_mm <= kAtFloor * floor_mm) {
    std::snprintf(text, sizeof text, "at the floor: %.4f mm where a perfect robot reads %.4f",
                  mean_mm, floor_mm);
  } else {
    std::snprintf(text, sizeof text, "%.1f um unexplained beyond the floor of %.4f mm",
                  1000 * std::sqrt(mean_mm * mean_mm - floor_mm * floor_mm), floor_mm);
  }
  return text;
}

}  // namespace trammel
