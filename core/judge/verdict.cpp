#include "core/judge/verdict.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/judge/floor.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel {

PerfectMean perfect_mean(std::size_t n, double sigma_xy_mm, int noise_degrees, int coordinates) {
  constexpr int kFewestDegrees = 3;  // below it an estimated sigma bounds nothing
  const double count = static_cast<double>(n);
  const bool one = coordinates == 1;
  const double mean = perfect_mean_mm(coordinates, 1);
  const double skewness = one ? std::sqrt(2.0) * (4 - kPi) / std::pow(kPi - 2, 1.5)       // 0.995
                              : 2 * std::sqrt(kPi) * (kPi - 3) / std::pow(4 - kPi, 1.5);  // 0.631
  const double v = (one ? 1 - 2 / kPi : 2 - kPi / 2) / count;
  const double v_sigma =
      noise_degrees > 0 ? 0.5 / coordinates / std::max(kFewestDegrees, noise_degrees) : 0.0;
  const double z = normal_limit(2 * kFalseFloor);
  const double bend = skewness / std::sqrt(count) * (z * z - 1) / 6 * std::sqrt(v);
  // (c - mean)^2 = z^2 (v + c^2 v_sigma)
  const double a = 1 - z * z * v_sigma;
  const double root = std::sqrt(mean * mean - a * (mean * mean - z * z * v));
  return {.mean_mm = sigma_xy_mm * mean,
          .low_mm = sigma_xy_mm * std::max(0.0, (mean - root) / a + bend),
          .high_mm = sigma_xy_mm * ((mean + root) / a + bend)};
}

std::string floor_verdict(double mean_mm, std::size_t n, double sigma_xy_mm, int noise_degrees,
                          int coordinates) {
  const PerfectMean perfect = perfect_mean(n, sigma_xy_mm, noise_degrees, coordinates);
  char expected[120], text[320];
  std::snprintf(expected, sizeof expected,
                "%.4f mm (%.4f to %.4f for n = %zu, but for 1 in 100 on each side)",
                perfect.mean_mm, perfect.low_mm, perfect.high_mm, n);
  if (mean_mm < perfect.low_mm) {
    std::snprintf(text, sizeof text,
                  "below the floor: %.4f mm, where a perfect robot reads %s: a fit follows the "
                  "noise of these readings, or sigma is not what was stated",
                  mean_mm, expected);
  } else if (mean_mm <= perfect.high_mm) {
    std::snprintf(text, sizeof text, "at the floor: %.4f mm, where a perfect robot reads %s",
                  mean_mm, expected);
  } else {
    std::snprintf(text, sizeof text,
                  "%.1f um unexplained beyond the floor%s: a perfect robot reads %s",
                  1000 * std::sqrt(mean_mm * mean_mm - perfect.mean_mm * perfect.mean_mm),
                  noise_degrees == 0 ? ", or noisier readings than stated" : "", expected);
  }
  return text;
}

}  // namespace trammel
