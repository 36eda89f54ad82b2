#pragma once

#include <cstddef>
#include <string>

namespace trammel {

/// Level of each side of the test against a perfect robot.
inline constexpr double kFalseFloor = 0.01;

/// Between which bounds the mean of n errors of position of a perfect robot lies, but for
/// kFalseFloor on each side: lengths of plane vectors of one sigma per coordinate.
///   mean = sigma sqrt(pi / 2),  variance = sigma^2 (2 - pi / 2) / n
/// with the skewness 0.631 / sqrt(n) by Cornish and Fisher. Where sigma itself comes from repeats
/// of m degrees of freedom, 2 m coordinates, the bound c of mean / sigma is Fieller's (1954):
///   (c - sqrt(pi / 2))^2 = z^2 ((2 - pi / 2) / n + c^2 / (4 m))
/// Proof: counted on drawn errors (verdict_test.cpp).
struct PerfectMean {
  double mean_mm = 0;  // mean length of a perfect reading
  double low_mm = 0, high_mm = 0;
};
/// Of one coordinate, an axis, the lengths are those of |N(0, sigma)|: mean sqrt(2 / pi), variance
/// 1 - 2 / pi, skewness 0.995.
PerfectMean perfect_mean(std::size_t n, double sigma_xy_mm, int noise_degrees, int coordinates = 2);

/// A mean of n errors of position beside that of a perfect robot: "at the floor: 0.0130 mm …",
/// "12.3 um unexplained beyond …": sqrt(mean^2 - floor^2), or that it is below what any robot
/// reads. Precondition: n > 0, sigma_xy_mm > 0. Proof: verdict_test.cpp.
std::string floor_verdict(double mean_mm, std::size_t n, double sigma_xy_mm, int noise_degrees,
                          int coordinates = 2);

}  // namespace trammel
