#include "core/assess/summary.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

std::vector<double> sorted(std::span<const double> values) {
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
  std::vector<double> copy(values.begin(), values.end());
  std::sort(copy.begin(), copy.end());
  return copy;
}

double quantile_of_sorted(const std::vector<double>& v, double q) {
  TRAMMEL_ASSERT(q >= 0 && q <= 1);
  const double h = q * static_cast<double>(v.size() - 1);
  const auto low = static_cast<std::size_t>(h);
  if (low + 1 >= v.size()) return v.back();
  return v[low] + (h - static_cast<double>(low)) * (v[low + 1] - v[low]);
}

}  // namespace

Summary summarise(std::span<const double> values) {
  const std::vector<double> v = sorted(values);
  double sum = 0;
  for (const double value : values) sum += value;
  return {.n = v.size(),
          .mean = sum / static_cast<double>(v.size()),
          .max = v.back(),
          .min = v.front(),
          .p95 = quantile_of_sorted(v, 0.95)};
}

double quantile(std::span<const double> values, double q) {
  return quantile_of_sorted(sorted(values), q);
}

std::optional<double> improvement_pct(const Summary& before, const Summary& after) {
  if (before.mean == 0) return std::nullopt;
  return 100.0 * (1.0 - after.mean / before.mean);
}

double noise_floor_mean_mm(double sigma_xy_mm) { return sigma_xy_mm * std::sqrt(kPi / 2.0); }

}  // namespace trammel
