#pragma once
// How well a fitted robot model knows where the robot stands.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"

namespace trammel {

struct ModelUncertainty {
  RobotModel model;
  std::vector<FreeParameter> parameters;
  Eigen::MatrixXd covariance;  // of z, in tolerances, shape (n, n)
  double lack_xy_mm = 0;       // standard deviation of what the model leaves beyond the noise
  double lack_phi_rad = 0;
};

/// Of a model fitted to `readings` with `sigma`:
///   Cov(z) = s^2 V S^-2 V' + V0 V0',   s^2 = chi^2 / dof, at least 1
/// V, S from the whitened Jacobian at the solution (GUM); V0 what the readings do not determine:
/// known by its tolerance alone, it counts with that where a pose feels it. Lack of fit: what the
/// residuals of x and y (of phi) show beyond sigma. Throws InputError as whitened_system.
ModelUncertainty model_uncertainty(const RobotModel& model, std::span<const Reading> readings,
                                   const TrackerSigma& sigma);

/// Covariance of the pose under `conditions`, without any reading's noise: J Cov J' + lack of fit,
/// shape (3, 3): mm, mm, rad. Throws InputError where the model cannot reach the displacements.
/// Proof: coverage by simulation (model_uncertainty_test.cpp).
Eigen::Matrix3d pose_covariance(const ModelUncertainty& of, const Conditions& conditions);

}  // namespace trammel
