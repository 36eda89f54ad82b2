#pragma once
// Middle and spread that wild values do not move.

#include <vector>

namespace trammel {

/// Median: the middle value, the mean of the two middle ones of an even number. Not empty.
double median(std::vector<double> values);

inline constexpr double kThreeQuartersOfNormal = 1.1503;  // |N(0, 1)| stays below it in 75 %

/// Standard deviation about zero, from a quantile of the sizes:
///   quantile(|v|, share) / of_normal,   of_normal: the same quantile of |N(0, 1)|
/// so that a share of 1 - `share` of wild values decides nothing. Not empty.
/// Proof: tests/core/measure/screen_test.cpp, point_outliers_test.cpp.
double robust_sigma(std::vector<double> values, double share = 0.75,
                    double of_normal = kThreeQuartersOfNormal);

/// robust_sigma about the median. Not empty.
double robust_scatter(std::vector<double> values);

}  // namespace trammel
