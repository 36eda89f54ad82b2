#pragma once
// How far chance alone goes: limits of test statistics for a stated false-alarm rate. Quantiles of
// Boost.Math, to its own accuracy (some 1e-15 relative); compared with published tables in
// limits_test.cpp. Precondition of all: 0 < p < 1, degrees > 0.

#include <limits>

namespace trammel {

/// z with P(|N(0, 1)| > z) = p.
double normal_limit(double p);

/// t with P(|t| > t) = p for Student's t of `degrees` of freedom.
double student_limit(double p, double degrees);

/// x with P(chi^2(degrees) > x) = p.
double chi2_limit(double p, double degrees);

/// F with P(s_1^2 / s_2^2 > F) = p for two variances of one normal noise, estimated with `degrees`
/// and `other_degrees` of freedom (infinite: the second is known).
double variance_ratio_limit(double p, double degrees,
                            double other_degrees = std::numeric_limits<double>::infinity());

}  // namespace trammel
