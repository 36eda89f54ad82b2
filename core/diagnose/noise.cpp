#include "core/diagnose/noise.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace trammel {

namespace {

constexpr double kMedianChi2Of3 = 2.36597;
constexpr double kTenSigmasSquared = 100;

using GroupKey = std::tuple<int, long, long, long, int, int, int>;

GroupKey group_of(const Reading& r) {
  const auto rounded = [](double v) { return std::lround(v * 1e6); };  // nm, urad
  const auto dir = [&](int i) {
    const double d = r.conditions.cmd_mm[i] - r.conditions.from_mm[i];
    return d > 1e-6 ? 1 : d < -1e-6 ? -1 : 0;
  };
  return {r.conditions.epoch,
          rounded(r.target.x_mm),
          rounded(r.target.y_mm),
          rounded(r.target.phi_rad),
          dir(0),
          dir(1),
          dir(2)};
}

/// Distances d_i of the readings from a fit with projector I - U U', weights one a reading.
Eigen::VectorXd distances(const ResidualSpace& space, const Eigen::MatrixXd& U,
                          const Eigen::VectorXd& r) {
  const auto n = static_cast<Eigen::Index>(space.readings.size());
  Eigen::VectorXd d(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto rows = U.middleRows<3>(3 * i);
    const Eigen::Matrix3d left = Eigen::Matrix3d::Identity() - rows * rows.transpose();
    const Eigen::Vector3d ri = r.segment<3>(3 * i);
    d[i] = ri.dot(left.fullPivLu().solve(ri));
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
    r -= U * (U.transpose() * r);
    const Eigen::VectorXd d = distances(space, U, r);
    // back to the reading's own scale: the weights were in r
    fit.distance = d.cwiseQuotient(weight.cwiseAbs2());
    fit.distance /= median(fit.distance) / kMedianChi2Of3;
    fit.residual = r.cwiseQuotient(weight.replicate(1, 3).transpose().reshaped());
    for (Eigen::Index i = 0; i < n; ++i)
      weight[i] = std::min(1.0, 3.0 / std::sqrt(fit.distance[i]));
  }
  return fit;
}

/// Heavier tails than a normal distribution's: kurtosis of the good readings beyond four of its
/// errors.
bool heavy_tails(const RobustFit& fit, double threshold) {
  double m2 = 0, m4 = 0, count = 0;
  for (Eigen::Index i = 0; i < fit.distance.size(); ++i) {
    if (fit.distance[i] > threshold) continue;
    for (int k = 0; k < 3; ++k) {
      const double r = fit.residual[3 * i + k];
      m2 += r * r;
      m4 += r * r * r * r;
      count += 1;
    }
  }
  if (count < 30 || m2 <= 0) return false;
  const double kurtosis = m4 * count / (m2 * m2) - 3;
  return kurtosis > 4 * std::sqrt(24 / count);
}

}  // namespace

RepeatNoise repeat_noise(std::span<const Reading> readings) {
  std::map<GroupKey, std::vector<Eigen::Vector3d>> groups;
  for (const Reading& r : readings) {
    if (r.measured) groups[group_of(r)].push_back(r.measured->vector());
  }
  RepeatNoise noise;
  double xy = 0, phi = 0;
  for (const auto& [key, poses] : groups) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& p : poses) mean += p / static_cast<double>(poses.size());
    for (const auto& p : poses) {
      xy += (p - mean).head<2>().squaredNorm();
      phi += std::pow(p[2] - mean[2], 2);
    }
    noise.dof += static_cast<int>(poses.size()) - 1;
  }
  if (noise.dof > 0) noise.sigma = {std::sqrt(xy / (2 * noise.dof)), std::sqrt(phi / noise.dof)};
  return noise;
}

NoiseRatio noise_ratio(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  const Eigen::MatrixXd U = orthonormal(all_columns(space, signals));
  const Eigen::VectorXd r = space.residual - U * (U.transpose() * space.residual);
  const Eigen::VectorXd left = Eigen::VectorXd::Ones(space.rows()) - U.rowwise().squaredNorm();
  double xy = 0, xy_dof = 0, phi = 0, phi_dof = 0;
  for (Eigen::Index i = 0; i < space.rows(); ++i) {
    (i % 3 == 2 ? phi : xy) += r[i] * r[i];
    (i % 3 == 2 ? phi_dof : xy_dof) += left[i];
  }
  NoiseRatio ratio;
  ratio.xy = std::sqrt(xy / xy_dof);
  ratio.phi = std::sqrt(phi / phi_dof);
  ratio.u_xy = ratio.xy / std::sqrt(2 * xy_dof);
  ratio.u_phi = ratio.phi / std::sqrt(2 * phi_dof);
  return ratio;
}

std::vector<std::size_t> bad_readings(const ResidualSpace& space, const Eigen::MatrixXd& signals) {
  const RobustFit fit = robust_fit(space, all_columns(space, signals));
  const auto n = static_cast<double>(space.readings.size());
  double threshold = 12;
  while (chi2_tail(threshold, 3) * n > kFalseOutlier) threshold += 0.25;
  if (heavy_tails(fit, threshold)) threshold = kTenSigmasSquared;
  std::vector<std::size_t> bad;
  for (Eigen::Index i = 0; i < fit.distance.size(); ++i) {
    if (fit.distance[i] > threshold) bad.push_back(static_cast<std::size_t>(i));
  }
  if (static_cast<double>(bad.size()) > kMostBad * n) bad.clear();
  return bad;
}

}  // namespace trammel
