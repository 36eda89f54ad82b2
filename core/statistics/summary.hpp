#pragma once
// A list of deviations in a few honest numbers.

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

namespace trammel {

/// mean, extremes and the 95 % point of n numbers, in the numbers' own unit.
struct Summary {
  std::size_t n = 0;
  double mean = 0;
  double max = 0;
  double min = 0;
  double p95 = 0;
};

/// Summary of `values`. p95 interpolates linearly between order statistics: with the values sorted
/// as v_0 … v_(n-1) and h = 0.95 (n - 1), p95 = v_floor(h) + (h - floor(h)) (v_floor(h)+1 -
/// v_floor(h)). Throws InputError when there are none or one is not finite. Proof:
/// summary_test.cpp.
Summary summarise(std::span<const double> values);

/// The quantile q in [0, 1] by the same rule. `values` need not be sorted.
double quantile(std::span<const double> values, double q);
/// Two of them, low <= high.
std::pair<double, double> quantiles(std::span<const double> values, double low, double high);

/// 100 (1 - mean after / mean before), in %; nothing when the mean before is zero.
std::optional<double> improvement_pct(const Summary& before, const Summary& after);

/// What a perfect robot reads: the mean length of a plane vector of two independent errors of one
/// sigma each, sigma sqrt(pi / 2) (the mean of a Rayleigh distribution).
double noise_floor_mean_mm(double sigma_xy_mm);

}  // namespace trammel
