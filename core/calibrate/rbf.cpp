#include "core/calibrate/rbf.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/linear/lanes.hpp"
#include "core/linear/products.hpp"
#include "core/plane/kmeans.hpp"

namespace trammel {

namespace {

constexpr double kGridFirstMm = 10,
                 kGridLastMm = 640;  // spreads tried: step of the grid to beyond its width
constexpr double kLog2OfE = 1.44269504088896340736;

using Errors = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// What training needs of the samples: distances are taken once, spreads are tried on them.
struct Problem {
  Eigen::ArrayXXd d2;  // samples x neurons, mm^2
  Errors errors;       // samples x 3, mm
  double relative_ridge = 0;
};

struct Fit {
  Errors weights;  // neurons + 1 (the bias last) x 3
  double loo_rms_mm = 0;
};

/// Ridge least squares of one common spread, and its leave-one-out residuals.
///   w = (Phi' Phi + lambda D)^-1 Phi' e,  h_ii = phi_i (…)^-1 phi_i',  loo_i = r_i / (1 - h_ii)
Fit solve(const Problem& problem, double sigma_mm) {
  const Eigen::Index n = problem.d2.rows(), m = problem.d2.cols();
  Eigen::MatrixXd Phi(n, m + 1);
  Phi.leftCols(m) = (problem.d2 * (-1.0 / (sigma_mm * sigma_mm))).exp().matrix();
  Phi.col(m).setOnes();
  Eigen::MatrixXd G = gram(Phi);
  const double lambda = problem.relative_ridge * G.diagonal().mean();
  G.diagonal().head(m).array() += lambda;
  const Cholesky factor(std::move(G));
  Fit fit;
  fit.weights = factor.solve(transposed_product(Phi, problem.errors));
  const Eigen::MatrixXd half = factor.half(Phi.transpose());
  const Eigen::ArrayXd kept = 1.0 - half.colwise().squaredNorm().transpose().array();
  const Errors residual = problem.errors - product(Phi, fit.weights);
  // A sample the network reproduces whatever its value cannot be predicted from the others.
  const Eigen::ArrayXd safe = kept.max(1e-12);
  const double sum = (residual.array().colwise() / safe).square().sum();
  fit.loo_rms_mm = std::sqrt(sum / static_cast<double>(3 * n));
  return fit;
}

void require_options(const RbfOptions& options) {
  const auto refuse = [](const std::string& field, double got, const std::string& expected) {
    throw InputError({.what = "the network cannot be trained",
                      .where = {.field = field},
                      .got = std::to_string(got),
                      .expected = expected});
  };
  if (options.neurons < 1) refuse("neurons", options.neurons, "at least 1");
  if (!(std::isfinite(options.relative_ridge) && options.relative_ridge > 0)) {
    refuse("relative_ridge", options.relative_ridge, "a positive number");
  }
  if (!(std::isfinite(options.sigma_mm) && options.sigma_mm >= 0)) {
    refuse("sigma_mm", options.sigma_mm, "a positive length, or 0 to have it chosen");
  }
}

Problem make_problem(const std::vector<JointSample>& samples, const std::vector<Place>& centres,
                     double relative_ridge) {
  const auto n = static_cast<Eigen::Index>(samples.size());
  const auto m = static_cast<Eigen::Index>(centres.size());
  Problem problem{Eigen::ArrayXXd(n, m), Errors(n, 3), relative_ridge};
  for (Eigen::Index i = 0; i < n; ++i) {
    const JointSample& s = samples[static_cast<std::size_t>(i)];
    problem.errors.row(i) = s.error_mm.transpose();
    for (Eigen::Index j = 0; j < m; ++j) {
      const Place c = centres[static_cast<std::size_t>(j)];
      const double dx = s.x_mm - c.x_mm, dy = s.y_mm - c.y_mm;
      problem.d2(i, j) = dx * dx + dy * dy;
    }
  }
  return problem;
}

void choose_spread(const Problem& problem, RbfTraining& training) {
  for (const double sigma : spread_grid_mm()) {
    training.trials.push_back({sigma, solve(problem, sigma).loo_rms_mm});
  }
  const auto best = std::min_element(
      training.trials.begin(), training.trials.end(),
      [](const SpreadTrial& a, const SpreadTrial& b) { return a.loo_rms_mm < b.loo_rms_mm; });
  training.sigma_mm = best->sigma_mm;
  training.at_grid_end = best == training.trials.begin() || best + 1 == training.trials.end();
}

/// n queries side by side. scale_j = -log2(e) / sigma_j^2.
template <int n>
void predict_block(const RbfNetwork& network, const double* scale, const Place* at,
                   Eigen::Vector3d* out) {
  const Eigen::Index m = network.cx_mm.size();
  const double *cx = network.cx_mm.data(), *cy = network.cy_mm.data();
  const double *w1 = network.weights_mm.data(), *w2 = w1 + m, *w3 = w2 + m;
  Real<n> x, y, s1 = {}, s2 = {}, s3 = {};
  for (std::size_t j = 0; j < n; ++j) {
    x[j] = at[j].x_mm;
    y[j] = at[j].y_mm;
  }
  for (Eigen::Index k = 0; k < m; ++k) {
    const Real<n> dx = x - cx[k], dy = y - cy[k];
    const Real<n> activation = exp2_of_negative<n>((dx * dx + dy * dy) * scale[k]);
    s1 += activation * w1[k];
    s2 += activation * w2[k];
    s3 += activation * w3[k];
  }
  for (std::size_t j = 0; j < n; ++j) {
    out[j] = Eigen::Vector3d(s1[j], s2[j], s3[j]) + network.bias_mm;
  }
}

}  // namespace

std::vector<double> spread_grid_mm() {
  std::vector<double> grid;
  for (int k = 0; k < kSpreadGridSize; ++k) {
    grid.push_back(kGridFirstMm * std::pow(kGridLastMm / kGridFirstMm,
                                           static_cast<double>(k) / (kSpreadGridSize - 1)));
  }
  return grid;
}

RbfTraining train_rbf(std::span<const JointSample> samples, const RbfOptions& options) {
  require_options(options);
  require_places(samples, 2);
  const std::vector<JointSample> merged = merge_places(samples);
  std::vector<Place> places;
  for (const JointSample& s : merged) places.push_back({s.x_mm, s.y_mm});
  const int neurons =
      static_cast<int>(std::min(places.size(), static_cast<std::size_t>(options.neurons)));
  const KMeans clusters = kmeans(places, neurons, options.seed);
  const Problem problem = make_problem(merged, clusters.centres, options.relative_ridge);

  RbfTraining training;
  training.kmeans_iterations = clusters.iterations;
  training.sigma_mm = options.sigma_mm;
  if (options.sigma_mm == 0) choose_spread(problem, training);
  const Fit fit = solve(problem, training.sigma_mm);
  RbfNetwork& network = training.network;
  network.cx_mm.resize(neurons);
  network.cy_mm.resize(neurons);
  for (int j = 0; j < neurons; ++j) {
    network.cx_mm[j] = clusters.centres[static_cast<std::size_t>(j)].x_mm;
    network.cy_mm[j] = clusters.centres[static_cast<std::size_t>(j)].y_mm;
  }
  network.sigma_mm = Eigen::ArrayXd::Constant(neurons, training.sigma_mm);
  network.weights_mm = fit.weights.topRows(neurons);
  network.bias_mm = fit.weights.row(neurons).transpose();
  network.relative_ridge = options.relative_ridge;
  return training;
}

void predict(const RbfNetwork& network, std::span<const Place> at,
             std::span<Eigen::Vector3d> errors_mm, CpuLevel level) {
  TRAMMEL_ASSERT(at.size() == errors_mm.size());
  const Eigen::ArrayXd scale = -kLog2OfE / network.sigma_mm.square();
  at_level(level, [&]<int n>() {
    in_blocks<n>(at, errors_mm, [&](const Place* from, Eigen::Vector3d* to) {
      predict_block<n>(network, scale.data(), from, to);
    });
  });
}

Eigen::Vector3d predict(const RbfNetwork& network, Place at) {
  Eigen::Vector3d error;
  predict(network, {&at, 1}, {&error, 1});
  return error;
}

}  // namespace trammel
