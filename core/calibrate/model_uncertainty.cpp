#include "core/calibrate/model_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/linear/products.hpp"

namespace trammel {

namespace {

/// Whitened size of some rows that is beyond noise of size 1, in sigmas: no test, since a lack that
/// chance might explain is there as often as not.
double lack(double mean_square, double share_of_freedom) {
  return std::sqrt(std::max(0.0, mean_square / share_of_freedom - 1));
}

}  // namespace

ModelUncertainty model_uncertainty(const RobotModel& model, std::span<const Reading> readings,
                                   const TrackerSigma& sigma) {
  ModelUncertainty out{.model = model, .parameters = {}, .covariance = {}};
  out.parameters = base_parameters(model.nominal, {readings.begin(), readings.end()});
  hold_unseen(out.parameters, model.nominal, readings, sigma);
  add_effect_parameters(out.parameters, model);
  const WhitenedSystem system = whitened_system(model, readings, sigma, out.parameters);
  const Identifiable known = identifiable(system.jacobian);
  // rows of what is not measured are 0 and count for nothing
  const Coordinates& measured = model.nominal.measured;
  const auto n_readings = static_cast<double>(readings.size());
  const double rows = n_readings * measured_by(model);
  const double rows_xy = n_readings * std::max(1, measured[0] + measured[1]);
  const double freedom = rows - static_cast<double>(known.rank);
  const double s2 = freedom > 0 ? std::max(1.0, system.residual.squaredNorm() / freedom) : 1.0;
  const Eigen::Index n = known.directions.rows();
  out.covariance = s2 * covariance(known) +
                   without(known.directions, Eigen::MatrixXd(Eigen::MatrixXd::Identity(n, n)));
  double xy = 0, phi = 0;
  for (Eigen::Index i = 0; i < system.residual.size(); i += 3) {
    xy += system.residual.segment<2>(i).squaredNorm();
    phi += system.residual[i + 2] * system.residual[i + 2];
  }
  if (freedom > 0) {
    out.lack_xy_mm = sigma.xy_mm * lack(xy / rows_xy, freedom / rows);
    out.lack_phi_rad = sigma.phi_rad * lack(phi / n_readings, freedom / rows);
  }
  return out;
}

Eigen::Matrix3d pose_covariance(const ModelUncertainty& of, const Conditions& conditions) {
  const Prediction at = predict(of.model, conditions);
  if (!at.ok()) {
    throw InputError({.what = "the model cannot reach the commanded displacements asked for"});
  }
  const Eigen::Matrix3Xd J = derivative(of.model, of.parameters, conditions, at);
  const Eigen::Vector3d left(of.lack_xy_mm, of.lack_xy_mm, of.lack_phi_rad);
  const Eigen::Matrix3d spread = left.cwiseAbs2().asDiagonal();
  return rows_product(product(J, of.covariance), J) + spread;
}

}  // namespace trammel
