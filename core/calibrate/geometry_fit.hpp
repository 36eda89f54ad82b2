#pragma once
// Nonlinear identification of the complete base (and of named effects) on the exact loop closure.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "core/calibrate/identifiability.hpp"
#include "core/calibrate/parameters.hpp"
#include "core/measure/reading.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

/// Readings against a model, whitened: row 3i.. of reading i is (x, y, phi) over its sigma.
struct WhitenedSystem {
  Eigen::VectorXd residual;  // (measured - predicted) / sigma, shape (3N)
  Eigen::MatrixXd jacobian;  // d predicted / d z / sigma, shape (3N, parameters)
};

/// Throws InputError naming the seq of a reading that the model cannot reach.
WhitenedSystem whitened_system(const RobotModel& model, std::span<const Reading> readings,
                               const TrackerSigma& sigma,
                               const std::vector<FreeParameter>& parameters);

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

/// Makes successive readings independent whose noise is correlated in time (AR(1), per epoch):
///   row_i <- (row_i - rho^d row_(i-1)) / sqrt(1 - rho^(2 d)),  d = seq_i - seq_(i-1)
/// for the 3 rows of each reading in `rows`, shape (3N, any). Nothing happens for rho = 0.
void decorrelate(Eigen::Ref<Eigen::MatrixXd> rows, std::span<const Reading> readings, double rho);

struct GeometryFitOptions {
  int max_iterations = 50;
  bool huber = false;            // readings beyond kHuber sigmas (of three coordinates) count less
  double correlation = 0;        // of the noise of one reading with that of the one before
  bool tolerance_prior = false;  // tolerances as priors: each parameter is nominal +- its tolerance
};
inline constexpr double kHuber = 3.0;  // sqrt of chi^2(3): 0.03 of clean readings lie beyond

struct [[nodiscard]] GeometryFit {
  enum class Status { converged, max_iterations };
  Status status = Status::max_iterations;
  int iterations = 0;
  RobotModel model;
  std::vector<FreeParameter> parameters;
  Eigen::VectorXd z;  // change from the starting model, in scales
  Eigen::MatrixXd
      covariance;  // of z, on the identifiable directions (pseudo-inverse), shape (n, n)
  Identifiable identified;
  WhitenedSystem system;    // at the solution
  Eigen::VectorXd weights;  // of readings, 1 without huber, shape (N)
  double chi2 = 0;          // |residual|^2, unweighted
  int dof = 0;              // 3N - rank
};

/// Fits the parameters of `start` (base, and the effects it has non-zero values for) to `readings`.
///
///   z = argmin |W (r(z))|^2 over the identifiable directions; what the readings do not determine
///   stays at the start (minimum change, counted in tolerances).
/// Gauss-Newton on the truncated singular value decomposition of the whitened Jacobian, halved
/// while a step does not lower the sum (Levenberg's concern; the steps are small and the problem
/// mild). Stop: max |dz| in identified directions, times s, below 1e-7 sigmas. Covariance for known
/// sigma: V S^-2 V' (GUM); multiply by chi2/dof when sigma is estimated. Accuracy: recovery of
/// predicted poses on unseen points (geometry_fit_test.cpp); the rank and sum of squares of an
/// independent linear program.
/// @throws InputError when there are no readings, or a sigma is not positive.
GeometryFit fit_geometry(const RobotModel& start, std::span<const Reading> readings,
                         const TrackerSigma& sigma, const GeometryFitOptions& options = {});

/// Predicted reading and its covariance (model only, without the reading's noise), in mm, rad.
struct PredictedPose {
  Pose pose;
  Eigen::Matrix3d covariance;
};
PredictedPose predict_with_covariance(const GeometryFit& fit, const Conditions& conditions);

}  // namespace trammel
