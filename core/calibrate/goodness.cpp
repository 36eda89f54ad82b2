#include "core/calibrate/goodness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/statistics/limits.hpp"

namespace trammel {

Goodness goodness(double chi2, int dof, int noise_degrees) {
  Goodness g{.dof = dof};
  if (dof <= 0) return g;
  const bool known = noise_degrees == 0;
  g.ratio = std::sqrt(chi2 / dof);
  const double other = known ? std::numeric_limits<double>::infinity() : noise_degrees;
  g.limit = std::sqrt(variance_ratio_limit(kFalseMisfit, dof, other));
  g.least = std::sqrt(variance_ratio_limit(1 - kFalseMisfit, dof, other));
  g.explained = g.ratio <= g.limit;
  g.too_good = g.ratio < g.least;
  g.scale = known ? std::max(1.0, g.ratio) : g.ratio;
  return g;
}

}  // namespace trammel
