#pragma once

#include <optional>
#include <span>

namespace trammel {

/// 95 % interval of a figure.
struct Interval {
  double low = 0;
  double high = 0;
};

inline constexpr std::size_t kFewestForInterval = 5;

/// Interval of the improvement 100 (1 - mean after / mean before), %, over points in pairs:
/// Student's t of the log ratio,
///   L = log(a / b),  s_L^2 = sum (a_k / a - b_k / b)^2 / (n (n - 1)) + u_rel^2,
///   100 (1 - exp(L +- t(n - 1) s_L)),   a, b: means
/// `u_relative`: standard uncertainty of the ratio beside the choice of points. Covers .94 at n = 5
/// and .95 from n = 10 on, where resampling covers .81 and .89 (interval_test.cpp). Nothing for
/// fewer than five points or where a mean is not positive. Throws InputError when the lengths
/// differ.
std::optional<Interval> improvement_interval_pct(std::span<const double> before,
                                                 std::span<const double> after,
                                                 double u_relative = 0);

/// Interval of mean(a) - mean(b) over the same points, by Student's t: a method against another.
/// Nothing for fewer than five points.
std::optional<Interval> paired_difference(std::span<const double> a, std::span<const double> b);

}  // namespace trammel
