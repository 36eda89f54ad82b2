#include "core/statistics/robust.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/statistics/summary.hpp"

namespace trammel {

double median(std::vector<double> values) {
  TRAMMEL_ASSERT(!values.empty());
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return (*std::max_element(values.begin(), middle) + *middle) / 2;
}

double robust_sigma(std::vector<double> values, double share, double of_normal) {
  for (double& v : values) v = std::abs(v);
  return quantile(values, share) / of_normal;
}

double robust_scatter(std::vector<double> values) {
  const double middle = median(values);
  for (double& v : values) v -= middle;
  return robust_sigma(std::move(values));
}

}  // namespace trammel
