#include "core/calibrate/map_uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/linear/decompositions.hpp"

namespace trammel {

namespace {

using Weights = Eigen::MatrixX3d;  // of each sample (row) on each joint

std::vector<Place> places_of(std::span<const JointSample> samples) {
  std::vector<Place> places;
  for (const JointSample& s : samples) places.push_back({s.x_mm, s.y_mm});
  return places;
}

/// Readings in one place, as idw and rbf take them: how many share the place of each sample.
std::vector<double> sharing(std::span<const JointSample> samples) {
  const std::vector<std::size_t> group = group_places(places_of(samples));
  std::vector<double> count(samples.size(), 0), shared;
  for (const std::size_t g : group) count[g] += 1;
  for (const std::size_t g : group) shared.push_back(count[g]);
  return shared;
}

Weights weights_at(const MapUncertainty& of, const IdwMap& map, Place at) {
  const auto n = static_cast<Eigen::Index>(of.samples.size());
  const std::vector<std::size_t> group = group_places(places_of(of.samples));
  Eigen::VectorXd w(n);
  for (Eigen::Index k = 0; k < n; ++k) {  // what the map gives where this sample alone is 1
    const std::size_t place = group[static_cast<std::size_t>(k)];
    const double d2 =
        std::pow(map.x_mm[place] - at.x_mm, 2) + std::pow(map.y_mm[place] - at.y_mm, 2);
    w[k] = d2;
  }
  std::vector<double> nearest;  // squared distances of the places
  for (std::size_t j = 0; j < map.x_mm.size(); ++j) {
    nearest.push_back(std::pow(map.x_mm[j] - at.x_mm, 2) + std::pow(map.y_mm[j] - at.y_mm, 2));
  }
  std::ranges::sort(nearest);
  const auto last = map.options.neighbours == 0
                        ? nearest.size() - 1
                        : static_cast<std::size_t>(map.options.neighbours) - 1;
  const double smallest = std::max(nearest.front(), 1e-24), limit = nearest[last];
  const std::vector<double> shared = sharing(of.samples);
  for (Eigen::Index k = 0; k < n; ++k) {  // relative to the nearest, so that nothing overflows
    const double ratio = smallest / std::max(w[k], 1e-24);
    w[k] = w[k] > limit
               ? 0.0
               : std::pow(ratio, map.options.power / 2) / shared[static_cast<std::size_t>(k)];
  }
  w /= w.sum();
  return w.replicate<1, 3>();
}

Eigen::VectorXd activations(const RbfNetwork& map, Place at) {
  Eigen::VectorXd phi(map.cx_mm.size() + 1);
  phi.head(map.cx_mm.size()) =
      (-((map.cx_mm - at.x_mm).square() + (map.cy_mm - at.y_mm).square()) / map.sigma_mm.square())
          .exp()
          .matrix();
  phi[map.cx_mm.size()] = 1;
  return phi;
}

/// w = (Phi' Phi + lambda D)^-1 Phi' e of training, over merged places.
Eigen::MatrixXd training_of(const RbfNetwork& map, std::span<const JointSample> samples) {
  const std::vector<JointSample> merged = merge_places(samples);
  const auto m = map.cx_mm.size() + 1;
  Eigen::MatrixXd Phi(static_cast<Eigen::Index>(merged.size()), m);
  for (std::size_t j = 0; j < merged.size(); ++j) {
    Phi.row(static_cast<Eigen::Index>(j)) =
        activations(map, {merged[j].x_mm, merged[j].y_mm}).transpose();
  }
  Eigen::MatrixXd G = Phi.transpose() * Phi;
  const double lambda = map.relative_ridge * G.diagonal().mean();
  G.diagonal().head(m - 1).array() += lambda;
  const Eigen::MatrixXd of_places = Cholesky(std::move(G)).solve(Eigen::MatrixXd(Phi.transpose()));
  const std::vector<std::size_t> group = group_places(places_of(samples));
  const std::vector<double> shared = sharing(samples);
  Eigen::MatrixXd of_samples(m, static_cast<Eigen::Index>(samples.size()));
  for (std::size_t k = 0; k < samples.size(); ++k) {
    of_samples.col(static_cast<Eigen::Index>(k)) =
        of_places.col(static_cast<Eigen::Index>(group[k])) / shared[k];
  }
  return of_samples;
}

Weights weights_at(const MapUncertainty& of, const RbfNetwork& map, Place at) {
  const Eigen::VectorXd w = of.network.transpose() * activations(map, at);
  return w.replicate<1, 3>();
}

/// (K + n^2 I)^-1 k, and the rest on the mean of all samples.
Weights weights_at(const MapUncertainty& of, const GpMap& map, Place at) {
  Weights w(static_cast<Eigen::Index>(of.samples.size()), 3);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const GpJoint& joint = map.joints[static_cast<std::size_t>(i)];
    w.col(i) = Cholesky(covariance(map, joint)).solve(Eigen::VectorXd(covariances(map, joint, at)));
    w.col(i).array() += (1 - w.col(i).sum()) / static_cast<double>(w.rows());
  }
  return w;
}

Eigen::Matrix3d jacobian_at(const NominalMachine& machine, const Reading& reading) {
  const MachineAt at = machine.at(reading.conditions.cmd_mm, reading.target, true);
  if (at.ok()) return machine.invertible(at.J_V);
  throw InputError({.what = "the nominal robot cannot reach the displacements of a reading",
                    .where = {.point = "seq " + std::to_string(reading.seq)}});
}

}  // namespace

MapUncertainty map_uncertainty(const JointMap& map, const NominalMachine& machine,
                               std::span<const JointSample> samples,
                               std::span<const Reading> readings, const TrackerSigma& sigma) {
  TRAMMEL_ASSERT(samples.size() == readings.size());
  MapUncertainty out{
      .map = map, .samples = {samples.begin(), samples.end()}, .J_V = {}, .field = {}};
  out.sigma_mm << sigma.xy_mm, sigma.xy_mm, kPhiLengthOfFieldMm * sigma.phi_rad;
  std::vector<JointSample> field = out.samples;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    out.J_V.push_back(jacobian_at(machine, readings[k]));
    field[k].error_mm = out.J_V[k] * samples[k].error_mm;
    field[k].error_mm[2] *= kPhiLengthOfFieldMm;
  }
  out.field = fit_gp(field);
  for (std::size_t c = 0; c < 3; ++c) {
    out.covariance[c] = covariance(out.field, out.field.joints[c]);
  }
  if (const auto* rbf = std::get_if<RbfNetwork>(&map)) out.network = training_of(*rbf, samples);
  return out;
}

Eigen::Vector3d pose_variance(const MapUncertainty& of, Place at, const Eigen::Matrix3d& J_V) {
  const Weights w = std::visit([&](const auto& m) { return weights_at(of, m, at); }, of.map);
  const Eigen::Vector3d unit(1, 1, kPhiLengthOfFieldMm);
  std::array<std::array<Eigen::VectorXd, 3>, 3> M;  // [c][b], of all samples
  for (auto& row : M) row.fill(Eigen::VectorXd(w.rows()));
  for (Eigen::Index k = 0; k < w.rows(); ++k) {
    const Eigen::Matrix3d M_k = unit.asDiagonal() * J_V * w.row(k).transpose().asDiagonal() *
                                inverse(of.J_V[static_cast<std::size_t>(k)]) *
                                unit.cwiseInverse().asDiagonal();
    for (Eigen::Index c = 0; c < 3; ++c) {
      for (Eigen::Index b = 0; b < 3; ++b) {
        M[static_cast<std::size_t>(c)][static_cast<std::size_t>(b)][k] = M_k(c, b);
      }
    }
  }
  Eigen::Vector3d variance;
  for (std::size_t c = 0; c < 3; ++c) {
    const GpJoint& process = of.field.joints[c];
    double square =
        process.signal_mm * process.signal_mm - 2 * M[c][c].dot(covariances(of.field, process, at));
    double bias = process.mean_mm;
    for (std::size_t b = 0; b < 3; ++b) {
      square += M[c][b].dot(of.covariance[b] * M[c][b]);
      bias -= of.field.joints[b].mean_mm * M[c][b].sum();
    }
    const auto i = static_cast<Eigen::Index>(c);
    const double n = process.noise_mm;
    square += bias * bias + std::max(0.0, n * n - of.sigma_mm[i] * of.sigma_mm[i]);
    variance[i] = std::max(square, 0.0) / (unit[i] * unit[i]);
  }
  return variance;
}

}  // namespace trammel
