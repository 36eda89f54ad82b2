#pragma once
// Nonlinear identification of the complete base (and of named effects) on the exact loop closure.

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/calibrate/parameters.hpp"
#include "core/measure/pose_sigma.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

/// Readings against a model, whitened: row 3i.. of reading i is (x, y, phi) over its sigma; 0 for a
/// coordinate that is not measured.
struct WhitenedSystem {
  Eigen::VectorXd residual;  // (measured - predicted) / sigma, shape (3N)
  Eigen::MatrixXd jacobian;  // d predicted / d z / sigma, shape (3N, parameters)
};

/// Throws InputError naming the seq of a reading that the model cannot reach.
WhitenedSystem whitened_system(const RobotModel& model, std::span<const Reading> readings,
                               const PoseSigma& sigma,
                               const std::vector<FreeParameter>& parameters);

/// Holds what moves the readings, all together, by less than kLeastSignal sigmas a tolerance at the
/// nominal machine: of an XY stage of which x alone is measured, all of its y axis. A fit that is
/// elsewhere would find such a parameter at second order (x errs with x as the product of two
/// guides' errors) and take up with it what the model lacks. Effects are never held.
/// Proof: machine_fit_test.cpp.
void hold_unseen(std::vector<FreeParameter>& parameters, const Machine& nominal,
                 std::span<const Reading> readings, const PoseSigma& sigma);

/// How many coordinates a reading of the model's machine has.
int measured_by(const RobotModel& model);

/// Directions of parameter space that readings determine, by what they carry against the noise.
///
/// The singular value s of a direction of the whitened Jacobian (z in tolerances) says how many
/// sigmas the readings move, all together, when the model moves by one tolerance along it; 1/s
/// tolerances is the standard deviation it gets. Below kLeastSignal the readings do not know of
/// the direction.
struct Identifiable {
  Eigen::MatrixXd directions;  // orthonormal in z, shape (parameters, rank)
  Eigen::VectorXd singular;    // all of them, falling
  Eigen::Index rank = 0;
};
Identifiable identifiable(const Eigen::MatrixXd& whitened_jacobian);

/// Of z for known sigma, V S^-2 V' on the directions (pseudo-inverse), shape (parameters,
/// parameters).
Eigen::MatrixXd covariance(const Identifiable& known);

/// Makes successive readings independent whose noise is correlated in time (AR(1), per epoch):
///   row_i <- (row_i - rho^d row_(i-1)) / sqrt(1 - rho^(2 d)),  d = seq_i - seq_(i-1)
/// for the 3 rows of each reading in `rows`, shape (3N, any). Nothing happens for rho = 0.
void decorrelate(Eigen::Ref<Eigen::MatrixXd> rows, std::span<const Reading> readings, double rho);

struct GeometryFitOptions {
  int max_iterations = 50;
  bool huber = false;            // readings beyond kHuber sigmas count less
  double correlation = 0;        // of the noise of one reading with that of the one before
  bool tolerance_prior = false;  // tolerances as priors: each parameter is nominal +- its tolerance
};
/// By the number of coordinates k: sqrt of chi^2(k), beyond which 0.03 of clean readings lie.
inline constexpr std::array<double, 4> kHuber = {0, 2.18, 2.65, 3.0};

struct [[nodiscard]] GeometryFit {
  /// stalled: no step lowers the sum any more, though the readings would still move.
  enum class Status { converged, stalled, max_iterations };
  Status status = Status::max_iterations;
  int iterations = 0;
  int damped = 0;  // of these, steps that Gauss-Newton alone would not have made
  RobotModel model;
  std::vector<FreeParameter> parameters;
  Eigen::VectorXd z;  // change from the starting model, in scales
  Eigen::MatrixXd
      covariance;  // of z, on the identifiable directions (pseudo-inverse), shape (n, n)
  Identifiable identified;
  WhitenedSystem system;    // at the solution
  Eigen::VectorXd weights;  // of readings, 1 without huber, shape (N)
  double scale = 1;         // sigmas that Huber's limit was counted in: the residuals' own spread
  double chi2 = 0;          // |residual|^2, unweighted
  int dof = 0;              // measured coordinates of all readings - rank
};

/// Fits the parameters of `start` (base, and the effects it has non-zero values for) to `readings`.
///
///   z = argmin |W r(z)|^2 over the identifiable directions; what the readings do not determine
///   stays at the start (minimum change, counted in tolerances).
/// Levenberg-Marquardt with analytic Jacobians, in the axes of the singular value decomposition
/// J = U S V' of the whitened Jacobian, truncated at kLeastSignal; z counts tolerances, so that the
/// damping is the same for lengths and angles:
///   step(lambda) = V (S^2 + lambda)^-1 S U' r + (back to the start, outside V) / (1 + lambda /
///   s_1^2)
/// without the way back where a step with it does not lower the sum (what the readings do not know
/// then stays where it is). lambda = 0 (Gauss-Newton) while that lowers the sum; else from 1e-8
/// s_1^2 up by tens until a step does, and down by tens after it (Levenberg 1944, Marquardt 1963).
/// A step out of reach lowers nothing. One decomposition a step, however many lambda are tried.
/// Huber: weights min(1, kHuber / |r|), |r| of a reading's coordinates in sigmas times `scale`, the
/// residuals' own spread where that is more (median |r| over that of chi(k)). Stop: max |s dz| of
/// the undamped step, over the identified directions, below 1e-7 sigmas. Covariance for known
/// sigma: V S^-2 V' (GUM); goodness.hpp says by how much to widen it. Accuracy: recovery of
/// predicted poses on unseen points, also of robots 3 mm and 1 deg from nominal in every parameter
/// (geometry_fit_test.cpp); the rank and sum of squares of an independent linear program.
/// @throws InputError when there are no readings, or a sigma is not positive.
GeometryFit fit_geometry(const RobotModel& start, std::span<const Reading> readings,
                         const PoseSigma& sigma, const GeometryFitOptions& options = {});

/// A reading that does not belong to the rest.
struct OutlyingReading {
  int seq = 0;
  double sigmas = 0;  // sqrt of d2, below
  double weight = 1;  // that it had in the fit
};
inline constexpr double kFalseOutlying = 0.01;  // over all readings of a fit

/// Readings beyond what noise explains, in the order given. Each is judged against what the others
/// expect of it, by the model and a smooth field of each coordinate (smooth_terms, where there are
/// two rows a column): what the model lacks in common is no reading's fault.
///   d2 = r' (I - H)^-1 r / scale^2,   H = J Cov J' of its own three rows (leverage)
/// beyond the limit of chi^2(k) of its k coordinates for false_alarm / N (Bonferroni). The worst,
/// and those of half its d2, are set aside and the rest fitted again (linearised at the solution),
/// until none of the rest lies beyond or a quarter is aside: a wrong reading pulls the fit, and
/// right ones then look wrong. What was set aside is judged at the end against the fit without it:
/// r' (I + H)^-1 r / scale^2. scale: the residuals' own spread, at least 1. A fit that wrong
/// readings pull far is no place to linearise: give one with `huber`. They are named, not dropped.
/// Proof: geometry_fit_test.cpp.
std::vector<OutlyingReading> outlying_readings(const GeometryFit& fit,
                                               std::span<const Reading> readings,
                                               double false_alarm = kFalseOutlying);

/// Predicted reading and its covariance (model only, without the reading's noise), in mm, rad.
struct PredictedPose {
  Pose pose;
  Eigen::Matrix3d covariance;
};
PredictedPose predict_with_covariance(const GeometryFit& fit, const Conditions& conditions);

}  // namespace trammel
