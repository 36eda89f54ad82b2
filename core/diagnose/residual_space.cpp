#include "core/diagnose/residual_space.hpp"

#include <algorithm>
#include <unsupported/Eigen/SpecialFunctions>

#include "core/linear/decompositions.hpp"
#include "core/model/predictor.hpp"

namespace trammel {

namespace {

ResidualSpace bare_space(const GeometryFit& fit, std::span<const Reading> readings,
                         const PoseSigma& sigma, double correlation) {
  ResidualSpace space;
  space.readings.assign(readings.begin(), readings.end());
  space.machine = fit.model.nominal;
  space.sigma = sigma;
  space.correlation = correlation;
  for (const ActiveEffect& active : fit.model.effects) {
    if (active.effect->recall == nullptr) continue;
    space.remembered.push_back(active);
    for (int k = 0; k < active.values.size(); ++k) {
      if (!is_shape(*active.effect, k)) space.remembered.back().values[k] = 0;
    }
  }
  const Predictor expected(fit.model);
  for (const Reading& reading : readings) {
    space.predictions.push_back(expected.predict(reading.conditions));
  }
  return space;
}

}  // namespace

ResidualSpace residual_space(const GeometryFit& fit, std::span<const Reading> readings,
                             const PoseSigma& sigma, double correlation) {
  ResidualSpace space = bare_space(fit, readings, sigma, correlation);
  space.Q = orthonormal(product(fit.system.jacobian, fit.identified.directions), 0);
  space.residual = space.project(fit.system.residual);
  return space;
}

ResidualSpace undecided_space(const GeometryFit& fit, std::span<const Reading> readings,
                              const PoseSigma& sigma, double correlation) {
  ResidualSpace space = bare_space(fit, readings, sigma, correlation);
  Eigen::VectorXd y = fit.system.residual;
  std::vector<Eigen::Index> base;
  for (std::size_t j = 0; j < fit.parameters.size(); ++j) {
    const FreeParameter& p = fit.parameters[j];
    const auto column = static_cast<Eigen::Index>(j);
    if (p.kind != FreeParameter::Kind::effect) {
      base.push_back(column);
      continue;
    }
    const ActiveEffect& active = fit.model.effects[static_cast<std::size_t>(p.owner)];
    if (is_shape(*active.effect, p.index)) continue;  // stays as fitted
    const double value = active.values[p.index];
    y += value / p.scale * fit.system.jacobian.col(column);
  }
  const Eigen::MatrixXd J = fit.system.jacobian(Eigen::all, base);
  space.Q = orthonormal(J * identifiable(J).directions, 0);
  space.residual = space.project(y);
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
