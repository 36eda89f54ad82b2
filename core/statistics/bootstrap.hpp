#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace trammel {

/// 95 % interval of a figure, by resampling.
struct Interval {
  double low = 0;
  double high = 0;
};

/// Interval of the improvement 100 (1 - mean after / mean before), %, by resampling the points in
/// pairs (percentile method, `replicates` draws from `seed`): a point that was bad before stays
/// with what it became. Nothing for fewer than five points or a mean before of zero. Throws
/// InputError when the lengths differ. Proof: coverage on drawn data, and
/// resamples one by one (bootstrap_test.cpp).
std::optional<Interval> improvement_interval_pct(std::span<const double> before,
                                                 std::span<const double> after,
                                                 std::uint64_t seed = 1, int replicates = 2000);

/// Interval of mean(a) - mean(b) over the same points, by the same resampling: a method against
/// another. Nothing for fewer than five points.
std::optional<Interval> paired_difference(std::span<const double> a, std::span<const double> b,
                                          std::uint64_t seed = 1, int replicates = 2000);

}  // namespace trammel
