#pragma once
// How far chance alone goes: limits of test statistics for a stated false-alarm rate.

#include <limits>

namespace trammel {

/// z with P(|N(0, 1)| > z) = p, by bisection. Precondition: 0 < p < 1.
double normal_limit(double p);

/// t with P(|t| > t) = p for Student's t, by the first two terms in 1 / degrees (to 1 % from 20
/// degrees of freedom on).
double student_limit(double p, double degrees);

/// x with P(chi^2(3) > x) = p: the squared length of three independent standard normals.
///   P(chi^2(3) > x) = erfc(sqrt(x / 2)) + sqrt(2 x / pi) exp(-x / 2)
double chi2_of_three_limit(double p);

/// F with P(s_1^2 / s_2^2 > F) = p for two variances of one normal noise, estimated with `degrees`
/// and `other_degrees` of freedom (infinite: the second is known). Paulson's cube-root formula
/// (1942), Wilson and Hilferty's when the second is known: within 2 % from 3 degrees on, for p down
/// to 0.001. Infinity where so few degrees leave no limit. Proof: limits_test.cpp.
double variance_ratio_limit(double p, double degrees,
                            double other_degrees = std::numeric_limits<double>::infinity());

}  // namespace trammel
