#pragma once
// What is left of readings, and of any signal, once a model has been refitted to it.

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/linear/products.hpp"
#include "core/measure/reading.hpp"
#include "core/model/robot_model.hpp"

namespace trammel {

/// The whitened readings around a fit: everything in sigmas, 3 rows a reading (x, y, phi), 0 for a
/// coordinate that is not measured.
///
/// M = I - Q Q' takes out what the model's free parameters could imitate; `residual` = M r. A
/// signal e seen through M is what survives the refit; |M e|^2 is the noncentrality it gives a
/// chi^2 test.
struct ResidualSpace {
  std::vector<Reading> readings;
  std::vector<Prediction> predictions;   // of the fit, with the moments effects act in
  Machine machine;                       // nominal
  std::vector<ActiveEffect> remembered;  // shapes of the effects with a memory that take part
  PoseSigma sigma;
  double correlation = 0;    // of successive readings: taken out of residual, Q and signals alike
  Eigen::MatrixXd Q;         // orthonormal, shape (3N, rank)
  Eigen::VectorXd residual;  // shape (3N)

  [[nodiscard]] Eigen::Index rows() const { return residual.size(); }
  [[nodiscard]] bool is_measured(Eigen::Index row) const {
    return machine.measured[static_cast<std::size_t>(row % 3)];
  }
  /// How many coordinates a reading has.
  [[nodiscard]] int coordinates() const {
    return static_cast<int>(std::ranges::count(machine.measured, true));
  }
  [[nodiscard]] int dof() const { return static_cast<int>(coordinates() * rows() / 3 - Q.cols()); }
  [[nodiscard]] Eigen::MatrixXd project(const Eigen::MatrixXd& signal) const {
    return without(Q, signal);
  }
};

/// Around `fit`, which was made on `readings` with `sigma` and `correlation`.
ResidualSpace residual_space(const GeometryFit& fit, std::span<const Reading> readings,
                             const PoseSigma& sigma, double correlation = 0);

/// The linearisation of the same exact fit in which its effects are not yet decided on: Q holds the
/// base alone, and the residual has the effects' fitted signals given back,
///   y = M (r + sum_k v_k dX/dv_k)
/// so that a search around it weighs every set to first order at the fit. About the base, what is
/// left of second order of an effect of 1e-2 is some micrometres, and other effects follow those.
ResidualSpace undecided_space(const GeometryFit& fit, std::span<const Reading> readings,
                              const PoseSigma& sigma, double correlation = 0);

/// Whitened signal of a deviation given per reading, shape (3N). Not projected.
template <typename DeviationOf>
Eigen::VectorXd whitened_signal(const ResidualSpace& space, DeviationOf deviation_of) {
  Eigen::VectorXd column(space.rows());
  const Eigen::Vector3d sigma = space.sigma.of(space.machine.measured);
  for (std::size_t i = 0; i < space.readings.size(); ++i) {
    const Prediction& at = space.predictions[i];
    column.segment<3>(3 * static_cast<Eigen::Index>(i)) =
        response(at, deviation_of(space.readings[i], at.moment)).cwiseQuotient(sigma);
  }
  decorrelate(column, space.readings, space.correlation);
  return column;
}

/// Upper tail of chi^2 with `k` degrees of freedom.
double chi2_tail(double value, double k);

/// Orthonormal basis of the columns, those that survive: directions whose share of the column's own
/// length is below `surviving` are left out.
Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, double surviving = 1e-5);

}  // namespace trammel
