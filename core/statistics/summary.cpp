#include "core/statistics/summary.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

void require_finite(std::span<const double> values) {
  if (values.empty()) {
    throw InputError({.what = "there is nothing to summarise",
                      .got = "0 values",
                      .expected = "at least one measured point"});
  }
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (!std::isfinite(values[k])) {
      throw InputError({.what = "a deviation is not a finite number",
                        .where = {.point = std::to_string(k + 1)},
                        .got = std::to_string(values[k]),
                        .expected = "a finite number"});
    }
  }
}

/// The first n values of v in the order of `less` and some more, in no order; of a long v few more.
template <class Less>
std::vector<double> at_least_first(std::span<const double> v, std::size_t n, const Less& less) {
  constexpr std::size_t kSample = 64, kMargin = 4;
  std::vector<double> some(v.begin(), v.end());
  const std::size_t place = kSample * n / v.size() + kMargin;
  if (v.size() < 8 * kSample || place >= kSample / 2) return some;
  std::vector<double> sample;
  for (std::size_t k = 0; k < kSample; ++k) sample.push_back(v[k * v.size() / kSample]);
  std::ranges::nth_element(sample, sample.begin() + static_cast<std::ptrdiff_t>(place), less);
  std::size_t kept = 0;
  for (const double value : v) {  // without a branch, that would be guessed
    some[kept] = value;
    kept += static_cast<std::size_t>(less(value, sample[place]));
  }
  if (kept < n) return {v.begin(), v.end()};
  some.resize(kept);
  return some;
}

/// The k-th value of v and the next one, counted from 0 in the order of `less`.
template <class Less>
std::pair<double, double> two_in_order(std::span<const double> v, std::size_t k, const Less& less) {
  std::vector<double> some = at_least_first(v, k + 2, less);
  const auto at = some.begin() + static_cast<std::ptrdiff_t>(k);
  std::ranges::nth_element(some, at, less);
  return {*at, *std::ranges::min_element(at + 1, some.end(), less)};
}

double quantile_among(std::span<const double> v, double q) {
  const double h = q * static_cast<double>(v.size() - 1);
  const auto place = static_cast<std::size_t>(h);
  if (place + 1 == v.size()) return *std::ranges::max_element(v);
  const bool low = 2 * place < v.size();
  const auto [one, next] = low ? two_in_order(v, place, std::less<>())
                               : two_in_order(v, v.size() - 2 - place, std::greater<>());
  const double below = low ? one : next, above = low ? next : one;
  return below + (h - std::floor(h)) * (above - below);
}

}  // namespace

Summary summarise(std::span<const double> values) {
  const double p95 = quantile(values, 0.95);
  double sum = 0;
  for (const double value : values) sum += value;
  const auto [min, max] = std::ranges::minmax(values);
  return {.n = values.size(),
          .mean = sum / static_cast<double>(values.size()),
          .max = max,
          .min = min,
          .p95 = p95};
}

double quantile(std::span<const double> values, double q) {
  TRAMMEL_ASSERT(q >= 0 && q <= 1);
  require_finite(values);
  return quantile_among(values, q);
}

std::pair<double, double> quantiles(std::span<const double> values, double low, double high) {
  TRAMMEL_ASSERT(low >= 0 && low <= high && high <= 1);
  require_finite(values);
  return {quantile_among(values, low), quantile_among(values, high)};
}

std::optional<double> improvement_pct(const Summary& before, const Summary& after) {
  if (before.mean == 0) return std::nullopt;
  return 100.0 * (1.0 - after.mean / before.mean);
}

double noise_floor_mean_mm(double sigma_xy_mm) { return sigma_xy_mm * std::sqrt(kPi / 2.0); }

}  // namespace trammel
