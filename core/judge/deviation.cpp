#include "core/judge/deviation.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"

namespace trammel {

double position_error_mm(const Pose& measured, const Pose& wanted) {
  return std::hypot(measured.x_mm - wanted.x_mm, measured.y_mm - wanted.y_mm);
}

Eigen::Vector3d pose_difference(const Pose& measured, const Pose& wanted) {
  Eigen::Vector3d d = measured.vector() - wanted.vector();
  if (std::abs(d[2]) > kPi) d[2] = std::remainder(d[2], 2 * kPi);
  return d;
}

double attitude_error_rad(const Pose& measured, const Pose& wanted) {
  return std::abs(pose_difference(measured, wanted)[2]);
}

FitScores fit_scores(std::span<const double> predicted, std::span<const double> measured) {
  if (predicted.size() != measured.size() || measured.empty()) {
    throw InputError({.what = "predictions and measurements do not pair",
                      .got = std::to_string(predicted.size()) + " predictions",
                      .expected = std::to_string(measured.size()) + ", and at least one"});
  }
  const auto n = static_cast<double>(measured.size());
  double mean_p = 0, mean_m = 0;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    mean_p += predicted[k] / n;
    mean_m += measured[k] / n;
  }
  FitScores scores;
  double S_pp = 0, S_mm = 0, S_pm = 0;
  for (std::size_t k = 0; k < measured.size(); ++k) {
    const double miss = measured[k] - predicted[k];
    const double p = predicted[k] - mean_p, m = measured[k] - mean_m;
    scores.mae += std::abs(miss) / n;
    scores.mse += miss * miss / n;
    S_pp += p * p;
    S_mm += m * m;
    S_pm += p * m;
  }
  // A column is constant when what is left of it is rounding.
  const auto constant = [n](double S, double mean) { return S <= 1e-28 * n * mean * mean; };
  if (!constant(S_mm, mean_m)) {
    scores.r2 = 1 - scores.mse * n / S_mm;
    if (!constant(S_pp, mean_p)) scores.r2_pearson = S_pm * S_pm / (S_pp * S_mm);
  }
  return scores;
}

}  // namespace trammel
