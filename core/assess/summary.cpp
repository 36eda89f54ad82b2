#include "core/assess/summary.hpp"

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

/// The quantile of v, and v in another order. Near an end few are sorted.
double quantile_among(std::vector<double>& v, double q) {
  constexpr std::ptrdiff_t kFew = 8;  // of the values, the share
  const double h = q * static_cast<double>(v.size() - 1);
  const auto place = static_cast<std::ptrdiff_t>(h), n = std::ssize(v);
  if (place + 1 == n) return *std::ranges::max_element(v);
  const auto at = v.begin() + place;
  if (kFew * (place + 2) <= n) {
    std::partial_sort(v.begin(), at + 2, v.end());
  } else if (kFew * (n - place) <= n) {
    std::partial_sort(v.rbegin(), v.rbegin() + (n - place), v.rend(), std::greater<>());
  } else {
    std::nth_element(v.begin(), at, v.end());
    std::iter_swap(at + 1, std::min_element(at + 1, v.end()));
  }
  return *at + (h - std::floor(h)) * (at[1] - *at);
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

double quantile(std::span<const double> values, double q) { return quantiles(values, q, q).second; }

std::pair<double, double> quantiles(std::span<const double> values, double low, double high) {
  TRAMMEL_ASSERT(low >= 0 && low <= high && high <= 1);
  require_finite(values);
  std::vector<double> v(values.begin(), values.end());
  const double lower = quantile_among(v, low);
  return {lower, quantile_among(v, high)};
}

std::optional<double> improvement_pct(const Summary& before, const Summary& after) {
  if (before.mean == 0) return std::nullopt;
  return 100.0 * (1.0 - after.mean / before.mean);
}

double noise_floor_mean_mm(double sigma_xy_mm) { return sigma_xy_mm * std::sqrt(kPi / 2.0); }

}  // namespace trammel
