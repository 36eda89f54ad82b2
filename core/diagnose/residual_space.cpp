#include "core/diagnose/residual_space.hpp"

#include <algorithm>
#include <unsupported/Eigen/SpecialFunctions>

#include "core/linear/decompositions.hpp"

namespace trammel {

ResidualSpace residual_space(const GeometryFit& fit, std::span<const Reading> readings,
                             const TrackerSigma& sigma, double correlation) {
  ResidualSpace space;
  space.readings.assign(readings.begin(), readings.end());
  space.sigma = sigma;
  space.correlation = correlation;
  for (const Reading& reading : readings) {
    space.predictions.push_back(moment_of(fit.model, reading.conditions));
  }
  space.Q = orthonormal(product(fit.system.jacobian, fit.identified.directions), 0);
  space.residual = space.project(fit.system.residual);
  return space;
}

double chi2_tail(double value, double k) {
  if (value <= 0) return 1;
  return Eigen::numext::igammac(0.5 * k, 0.5 * value);
}

Eigen::MatrixXd orthonormal(const Eigen::MatrixXd& columns, double surviving) {
  return orthonormal_basis(columns, std::max(surviving, 1e-10));
}

}  // namespace trammel
