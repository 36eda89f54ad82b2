#include "core/measure/point_outliers.hpp"

#include <algorithm>

#include "core/statistics/robust.hpp"

namespace trammel {

Screened screen(std::span<const Eigen::Vector3d> points_mm, const OutlierRule& rule) {
  Screened screened;
  if (points_mm.empty()) return screened;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const auto& p : points_mm) values.push_back(p[c]);
    screened.median_mm[c] = median(std::move(values));
  }
  std::vector<double> r_mm;
  for (const auto& p : points_mm) r_mm.push_back((p - screened.median_mm).norm());
  screened.mad_mm = median(r_mm);
  if (static_cast<int>(points_mm.size()) < rule.least_n) return screened;
  screened.limit_mm = std::max(rule.times * screened.mad_mm, rule.least_mm);
  for (std::size_t k = 0; k < r_mm.size(); ++k) {
    if (r_mm[k] > *screened.limit_mm) screened.outliers.push_back(k);
  }
  return screened;
}

}  // namespace trammel
