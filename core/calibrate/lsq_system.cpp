#include "core/calibrate/lsq_system.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/calibrate/parameters.hpp"
#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/mechanism/error_model.hpp"
#include "core/mechanism/error_rows.hpp"
#include "core/mechanism/forward.hpp"
#include "core/units.hpp"

namespace trammel {

namespace {

constexpr int kEpochColumns = 6;

int geometry_columns(const LsqOptions& options) {
  return options.complete ? kGeometryParameters : kPaperParameters;
}

void require_weights(const TrackerSigma& sigma, const LsqOptions& options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0; };
  if (!positive(sigma.xy_mm) || !positive(sigma.phi_rad)) {
    throw InputError({.what = "the readings cannot be weighted",
                      .where = {.field = "tracker"},
                      .got = "sigma " + std::to_string(sigma.xy_mm) + " mm, " +
                             std::to_string(deg_from_rad(sigma.phi_rad)) + " deg",
                      .expected = "positive standard deviations"});
  }
  if (!positive(options.attitude_weight)) {
    throw InputError({.what = "attitude cannot be weighted",
                      .where = {.field = "attitude_weight"},
                      .got = std::to_string(options.attitude_weight),
                      .expected = "a positive factor (1: the tracker's sigmas as they are)"});
  }
}

/// Later epochs in order; they own columns unless shared.
std::vector<int> later_epochs(std::span<const Reading> readings, const LsqOptions& options) {
  std::set<int> epochs;
  for (const Reading& r : readings) epochs.insert(r.conditions.epoch);
  if (!epochs.empty()) epochs.erase(epochs.begin());
  if (options.shared_epochs) epochs.clear();
  return {epochs.begin(), epochs.end()};
}

void name_columns(LsqSystem& system, const std::vector<int>& later, int n_geometry) {
  for (int k = 0; k < n_geometry; ++k) {
    const GeometryParameter& p = geometry_parameters()[static_cast<std::size_t>(k)];
    system.parameters.push_back({p.name, p.is_angle, p.tolerance});
    system.epochs.push_back(1);
  }
  for (const int epoch : later) {
    const std::string of = " of epoch " + std::to_string(epoch);
    for (int i = 1; i <= kChains; ++i) {
      system.parameters.push_back({"zero_" + std::to_string(i) + of, false, kZeroToleranceMm});
    }
    system.parameters.push_back({"frame_x" + of, false, kFrameToleranceMm});
    system.parameters.push_back({"frame_y" + of, false, kFrameToleranceMm});
    system.parameters.push_back({"frame_phi" + of, true, kFrameToleranceRad});
    system.epochs.insert(system.epochs.end(), kEpochColumns, epoch);
  }
}

/// A pose that steps from near by did not find, with shorter ones and from home too.
ForwardResult modelled_pose(const RailFrames& rails, const Displacements& l_mm, const Pose& home,
                            const Reading& reading) {
  ForwardResult at = forward(rails, l_mm, reading.target);
  if (!at.ok()) at = forward(rails, l_mm, home);
  if (at.ok()) return at;
  throw InputError({.what = "the commanded displacements are out of the modelled robot's reach",
                    .where = {.point = "seq " + std::to_string(reading.seq)}});
}

EpochShift offset_of(const std::map<int, EpochShift>& offsets, const Reading& reading) {
  const auto known = offsets.find(reading.conditions.epoch);
  return known == offsets.end() ? EpochShift{} : known->second;
}

/// Weighted d(x, y, phi) of the three joint zeros and the frame of an epoch: the frame turns the
/// pose about O_A, d(x, y) / d phi = (-y, x), and moves it.
Eigen::Matrix<double, 3, kEpochColumns> epoch_columns(const Eigen::MatrixXd& weighted_J,
                                                      Eigen::Index row, const Pose& pose,
                                                      const Eigen::Vector3d& weight) {
  Eigen::Matrix<double, 3, kEpochColumns> J;
  for (int i = 0; i < kChains; ++i)
    J.col(i) = weighted_J.block<3, 1>(row, 6 * i + 4);  // as the joint zero l_i
  J.rightCols<3>() = weight.asDiagonal();
  J(0, 5) = -weight[0] * pose.y_mm;
  J(1, 5) = weight[1] * pose.x_mm;
  return J;
}

}  // namespace

LsqSystem lsq_system(const Mechanism& mechanism, std::span<const Reading> readings,
                     const TrackerSigma& sigma, const LsqOptions& options,
                     const std::map<int, EpochShift>& offsets) {
  require_weights(sigma, options);
  LsqSystem system;
  for (const Reading& r : readings) system.poses.push_back(r.target);
  name_columns(system, later_epochs(readings, options), geometry_columns(options));
  linearise(system, mechanism, readings, sigma, options, offsets);
  return system;
}

void linearise(LsqSystem& system, const Mechanism& mechanism, std::span<const Reading> readings,
               const TrackerSigma& sigma, const LsqOptions& options,
               const std::map<int, EpochShift>& offsets) {
  const Eigen::Index n_geometry = geometry_columns(options);
  const std::vector<int> later = later_epochs(readings, options);
  const auto rows = static_cast<Eigen::Index>(3 * readings.size());
  system.A.resize(rows, static_cast<Eigen::Index>(system.parameters.size()));
  system.A.rightCols(system.A.cols() - n_geometry).setZero();
  system.b.resize(rows);
  const Eigen::Vector3d weight(1 / sigma.xy_mm, 1 / sigma.xy_mm,
                               options.attitude_weight / sigma.phi_rad);
  const RailFrames rails = rail_frames(mechanism.geometry);
  std::vector<Displacements> l_mm;
  l_mm.reserve(readings.size());
  for (const Reading& r : readings) {
    if (!r.measured) {
      throw InputError({.what = "this reading has no measured pose",
                        .where = {.point = "seq " + std::to_string(r.seq)}});
    }
    l_mm.emplace_back(r.conditions.cmd_mm + offset_of(offsets, r).l_zero_mm);
  }
  Eigen::MatrixXd J;
  for (const std::size_t j : error_rows(rails, l_mm, system.poses, J)) {
    const ForwardResult at = modelled_pose(rails, l_mm[j], mechanism.home, readings[j]);
    system.poses[j] = at.pose;
    J.middleRows<3>(static_cast<Eigen::Index>(3 * j)) = error_jacobian(rails, at.at);
  }
  const Eigen::VectorXd weights = weight.replicate(static_cast<Eigen::Index>(readings.size()), 1);
  system.A.leftCols(n_geometry) = weights.asDiagonal() * J.leftCols(n_geometry);
  for (std::size_t j = 0; j < readings.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(3 * j);
    const Pose expected = in_frame(offset_of(offsets, readings[j]).frame, system.poses[j]);
    system.b.segment<3>(row) =
        weight.cwiseProduct(pose_difference(*readings[j].measured, expected));
    const auto own = std::find(later.begin(), later.end(), readings[j].conditions.epoch);
    if (own != later.end()) {
      system.A.block<3, kEpochColumns>(row, n_geometry + kEpochColumns * (own - later.begin())) =
          epoch_columns(system.A, row, system.poses[j], weight);
    }
  }
  for (std::size_t k = 0; k < system.parameters.size(); ++k) {
    system.A.col(static_cast<Eigen::Index>(k)) *= system.parameters[k].tolerance;
  }
}

}  // namespace trammel
