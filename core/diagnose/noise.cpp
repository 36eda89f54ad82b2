#include "core/diagnose/noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/diagnose/dictionary.hpp"
#include "core/diagnose/selection.hpp"
#include "core/diagnose/structure.hpp"
#include "core/linear/decompositions.hpp"
#include "core/statistics/limits.hpp"
#include "core/statistics/tail.hpp"

namespace trammel {

namespace {

constexpr std::array<double, 4> kMedianChi2 = {1, 0.454936, 1.386294, 2.36597};
/// Variance of chi^2(k) / k over that of its median as an estimate of scale, n large: the share of
/// the degrees of freedom that a median of distances has.
constexpr std::array<double, 4> kOfMedian = {1, 0.37, 0.48, 0.53};
constexpr double kTenSigmasSquared = 100;

/// d_i = r_loo' (I + A_loo)^-1 r_loo, chi^2 of its coordinates for a good reading: its residual
/// from a fit without it, over the covariance of that. From the weighted fit (U orthonormal,
/// reading i weighted w): H = w^2 A, r_loo = (I - H)^-1 r, so d = r' (I - H)^-1 (I + (1 - w^2)
/// A)^-1 r.
Eigen::VectorXd distances(const Eigen::MatrixXd& U, const Eigen::VectorXd& r,
                          const Eigen::VectorXd& weight) {
  Eigen::VectorXd d(weight.size());
  for (Eigen::Index i = 0; i < d.size(); ++i) {
    const Eigen::Matrix3d H = rows_product(U.middleRows<3>(3 * i), U.middleRows<3>(3 * i));
    const double w2 = weight[i] * weight[i];
    const Eigen::Matrix3d C =
        (Eigen::Matrix3d::Identity() - H) * (Eigen::Matrix3d::Identity() + (1 - w2) / w2 * H);
    const Eigen::Vector3d ri = r.segment<3>(3 * i);
    d[i] = ri.dot(solve_square(C, ri));
  }
  return d;
}

double median(Eigen::VectorXd v) {
  const auto half = v.data() + v.size() / 2;
  std::nth_element(v.data(), half, v.data() + v.size());
  return *half;
}

Eigen::MatrixXd all_columns(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  Eigen::MatrixXd columns(space.rows(), space.Q.cols() + signals.cols());
  columns << space.Q, signals;
  for (Eigen::Index j = space.Q.cols(); j < columns.cols(); ++j) columns.col(j).normalize();
  return columns;
}

struct RobustFit {
  Eigen::VectorXd distance;  // d_i over the robust scale
  Eigen::VectorXd residual;
  double degrees = 0;  // of freedom that its scale stands on
};

/// Base and catalogue by iterated reweighting: a reading d sigmas off weighs min(1, 3 / d) squared
/// … so that a gross one ends with next to nothing.
RobustFit robust_fit(const ResidualSpace& space, const Eigen::MatrixXd& columns) {
  const auto n = static_cast<Eigen::Index>(space.readings.size());
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(n);
  RobustFit fit;
  for (int iteration = 0; iteration < 12; ++iteration) {
    Eigen::MatrixXd weighted = columns;
    Eigen::VectorXd r = space.residual;
    for (Eigen::Index i = 0; i < n; ++i) {
      weighted.middleRows<3>(3 * i) *= weight[i];
      r.segment<3>(3 * i) *= weight[i];
    }
    const Eigen::MatrixXd U = orthonormal(weighted);
    r = without(U, r);
    for (Eigen::Index i = 0; i < n; ++i) r.segment<3>(3 * i) /= weight[i];
    fit.distance = distances(U, r, weight);
    fit.distance /=
        median(fit.distance) / kMedianChi2[static_cast<std::size_t>(space.coordinates())];
    fit.residual = r;
    fit.degrees = kOfMedian[static_cast<std::size_t>(space.coordinates())] *
                  static_cast<double>(space.coordinates() * n - U.cols());
    for (Eigen::Index i = 0; i < n; ++i)
      weight[i] = std::min(1.0, 3.0 / std::sqrt(fit.distance[i]));
  }
  return fit;
}

/// Excess kurtosis of the readings within the threshold, in its errors sqrt(24 / n); 0 for too few.
double tail_weight(const ResidualSpace& space, const RobustFit& fit, double threshold) {
  Kurtosis near;
  for (Eigen::Index i = 0; i < fit.distance.size(); ++i) {
    if (fit.distance[i] > threshold) continue;
    for (int k = 0; k < 3; ++k) {
      if (space.is_measured(k)) near.add(fit.residual[3 * i + k]);
    }
  }
  return near.in_errors();
}

/// Heavier tails than a normal distribution's: beyond four errors of the kurtosis; beyond two where
/// far readings are there to ask for them, none of which is farther than ten sigmas.
bool heavier_than_normal(const ResidualSpace& space, const RobustFit& fit, double threshold) {
  const double farthest = fit.distance.maxCoeff();
  const bool moderate = farthest > threshold && farthest < kTenSigmasSquared;
  return tail_weight(space, fit, threshold) > (moderate ? 2 : 4);
}

/// Squared scales beyond which one of n normal readings lies in a share kFalseOutlier of campaigns;
/// on few readings the scale is uncertain itself.
double far_for(const ResidualSpace& space, const RobustFit& fit) {
  const double p = kFalseOutlier / static_cast<double>(space.readings.size());
  const int k = space.coordinates();
  if (fit.degrees < 1) return INFINITY;
  return k * variance_ratio_limit(p, k, fit.degrees);
}

/// Readings that follow one another: most of those flagged stand next to another one. Single bad
/// readings do so by chance only (k^2 / n pairs of k among n).
bool in_a_row(const std::vector<std::size_t>& places) {
  std::size_t pairs = 0;
  for (std::size_t i = 0; i + 1 < places.size(); ++i) pairs += places[i + 1] == places[i] + 1;
  return pairs >= 2 && 2 * pairs >= places.size();
}

}  // namespace

NoiseRatio noise_ratio(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  const Eigen::MatrixXd U = orthonormal(all_columns(space, signals));
  const Eigen::VectorXd r = without(U, space.residual);
  const Eigen::VectorXd left = Eigen::VectorXd::Ones(space.rows()) - U.rowwise().squaredNorm();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), dof = Eigen::Vector3d::Zero();
  double xy = 0, xy_dof = 0;
  for (Eigen::Index i = 0; i < space.rows(); ++i) {
    if (!space.is_measured(i)) continue;
    sum[i % 3] += r[i] * r[i];
    dof[i % 3] += left[i];
    if (i % 3 == 2) continue;
    xy += r[i] * r[i];
    xy_dof += left[i];
  }
  const auto ratio = [](double squares, double degrees) {
    return degrees > 0 ? std::sqrt(squares / degrees) : 1;
  };
  return {.xy = ratio(xy, xy_dof),
          .phi = ratio(sum[2], dof[2]),
          .xy_dof = xy_dof,
          .phi_dof = dof[2],
          .x = ratio(sum[0], dof[0]),
          .y = ratio(sum[1], dof[1]),
          .x_dof = dof[0],
          .y_dof = dof[1]};
}

bool other_size(double ratio, double dof, double noise_dof) {
  if (!(dof >= 1)) return false;
  if (noise_dof >= 1) {
    constexpr double p = kOtherSize / 2;
    return ratio * ratio > variance_ratio_limit(p, dof, noise_dof) ||
           ratio * ratio * variance_ratio_limit(p, noise_dof, dof) < 1;
  }
  const double larger = chi2_tail(dof * ratio * ratio, dof);
  return std::min(larger, 1 - larger) < kOtherSize / 2;
}

std::optional<Tails> heavy_tails(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  const RobustFit fit = robust_fit(space, all_columns(space, signals));
  const double normal = far_for(space, fit);
  if (!heavier_than_normal(space, fit, normal)) return std::nullopt;
  const int coordinates = space.coordinates();
  const double student = std::pow(
      student3_reach(coordinates * static_cast<double>(space.readings.size()), kFalseOutlier), 2);
  const Eigen::Vector3d sigma = space.sigma.each;
  const double winsor = kWinsor[static_cast<std::size_t>(coordinates)];
  Tails tails{.far = {}, .gross = {}, .sigmas = {}, .readings = space.readings};
  for (std::size_t i = 0; i < tails.readings.size(); ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    const double d = fit.distance[at];
    if (d > normal) {
      tails.far.push_back(i);
      tails.sigmas.push_back(std::sqrt(d));
    }
    if (d > student) tails.gross.push_back(i);
    if (d <= winsor * winsor) continue;
    const double excess = 1 - winsor / std::sqrt(d);
    const Eigen::Vector3d r = fit.residual.segment<3>(3 * at);
    tails.readings[i].measured =
        Pose::from(tails.readings[i].measured->vector() - excess * sigma.cwiseProduct(r));
  }
  return tails;
}

std::vector<std::size_t> bad_readings(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  const RobustFit fit = robust_fit(space, all_columns(space, signals));
  const auto n = static_cast<double>(space.readings.size());
  double threshold = far_for(space, fit);
  if (heavier_than_normal(space, fit, threshold)) threshold = kTenSigmasSquared;
  std::vector<std::size_t> bad;
  for (Eigen::Index i = 0; i < fit.distance.size(); ++i) {
    if (fit.distance[i] > threshold) bad.push_back(static_cast<std::size_t>(i));
  }
  if (static_cast<double>(bad.size()) > kMostBad * n || in_a_row(bad)) bad.clear();
  return bad;
}

double noise_correlation(const std::function<ResidualSpace(double rho)>& space_with, bool known) {
  constexpr double kTooSmall = 0.02;  // a correlation below this changes nothing
  const auto z_at = [&](double rho, bool without_time) {
    const ResidualSpace space = space_with(rho);
    std::vector<Shape> removed = without_time ? time_courses(space) : std::vector<Shape>{};
    removed.push_back({"catalogue", "all", make_library(space).signals});
    return successive_agreement(space, removed);
  };
  const double z = z_at(0, false);
  const double sign = z < 0 ? -1 : 1;
  if (!known && (std::abs(z) < kCorrelated || sign * z_at(0, true) < kNotACourse)) return 0;
  double low = 0, high = 0.95;  // of |rho|: sign * z falls as it rises
  while (high - low > kTooSmall) {
    const double middle = 0.5 * (low + high);
    (sign * z_at(sign * middle, !known) > 0 ? low : high) = middle;
  }
  return sign * 0.5 * (low + high);
}

}  // namespace trammel
