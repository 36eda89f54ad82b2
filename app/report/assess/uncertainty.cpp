#include "app/report/assess/uncertainty.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "core/calibrate/model_uncertainty.hpp"
#include "core/error.hpp"
#include "core/linear/decompositions.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

Expanded expanded(const Eigen::Matrix3d& covariance) {
  const Eigen::Matrix2d plane = covariance.topLeftCorner<2, 2>();
  const double worst = largest_eigenvalue(plane);
  return {.U_mm = 2 * std::sqrt(std::max(worst, 0.0)),
          .U_rad = 2 * std::sqrt(std::max(covariance(2, 2), 0.0))};
}

/// The conditions under which the corrected robot goes to the target of `reading`.
Conditions corrected(const Correction& correction, const Mechanism& mechanism,
                     const Reading& reading) {
  const InverseResult at = commanded(correction, mechanism, move_of(reading));
  if (!at.ok()) {
    throw InputError({.what = "the corrected robot cannot reach a target",
                      .where = {.point = "seq " + std::to_string(reading.seq)}});
  }
  Conditions conditions = reading.conditions;
  conditions.cmd_mm = at.l_mm;
  return conditions;
}

/// Covariance of the pose from that of the joints' map at a place: predictive, and what no place
/// explains beyond the readings' own noise.
Eigen::Matrix3d gp_covariance(const GpMap& map, const Mechanism& mechanism, const Reading& reading,
                              const TrackerSigma& sigma) {
  const Place place{reading.target.x_mm, reading.target.y_mm};
  const Eigen::Vector3d u = uncertainty_mm(map, {&place, 1}).front();
  Conditions conditions;
  conditions.cmd_mm = reading.conditions.cmd_mm;
  const Prediction at = predict(nominal_model(mechanism), conditions);
  if (!at.ok()) {
    throw InputError({.what = "the nominal robot cannot reach the displacements of a reading",
                      .where = {.point = "seq " + std::to_string(reading.seq)}});
  }
  const Eigen::Vector3d s(sigma.xy_mm, sigma.xy_mm, sigma.phi_rad);
  const Eigen::Matrix3d to_joints = inverse(at.moment.J_V) * s.asDiagonal();
  Eigen::Vector3d variance;
  for (int i = 0; i < kChains; ++i) {
    const double n = map.joints[static_cast<std::size_t>(i)].noise_mm;
    variance[i] = u[i] * u[i] + std::max(0.0, n * n - to_joints.row(i).squaredNorm());
  }
  return at.moment.J_V * variance.asDiagonal() * at.moment.J_V.transpose();
}

std::optional<PointUncertainty> of_model(const Correction& correction, const RobotModel& model,
                                         const Mechanism& mechanism,
                                         std::span<const Reading> fitted,
                                         const TrackerSigma& sigma) {
  const ModelUncertainty known = model_uncertainty(model, fitted, sigma);
  return PointUncertainty{
      "the covariance of the fitted model and its lack of fit (the robot's, without a reading's "
      "noise)",
      [=](const Reading& reading) {
        return expanded(pose_covariance(known, corrected(correction, mechanism, reading)));
      }};
}

std::optional<PointUncertainty> of_map(const GpMap& map, const Mechanism& mechanism,
                                       const TrackerSigma& sigma) {
  return PointUncertainty{
      "the Gaussian process: its predictive uncertainty and what no place explains (the robot's, "
      "without a reading's noise)",
      [=](const Reading& reading) {
        return expanded(gp_covariance(map, mechanism, reading, sigma));
      }};
}

std::optional<PointUncertainty> of_hybrid(const Correction& correction, const HybridCorrection& h,
                                          const GpMap& left, const Mechanism& mechanism,
                                          std::span<const Reading> fitted,
                                          const TrackerSigma& sigma) {
  ModelUncertainty known = model_uncertainty(h.model, fitted, sigma);
  known.lack_xy_mm = known.lack_phi_rad = 0;  // the map takes it, or counts it as unexplained
  return PointUncertainty{
      "the covariance of the fitted model and the Gaussian process on what it leaves (the robot's, "
      "without a reading's noise)",
      [=](const Reading& reading) {
        return expanded(pose_covariance(known, corrected(correction, mechanism, reading)) +
                        gp_covariance(left, mechanism, reading, sigma));
      }};
}

}  // namespace

std::optional<PointUncertainty> own_uncertainty(const Correction& correction,
                                                const Mechanism& mechanism,
                                                std::span<const Reading> fitted,
                                                const TrackerSigma& sigma) {
  if (const auto* m = std::get_if<ModelCorrection>(&correction)) {
    return of_model(correction, m->model, mechanism, fitted, sigma);
  }
  if (const auto* m = std::get_if<MapCorrection>(&correction)) {
    if (const auto* gp = std::get_if<GpMap>(&m->map)) return of_map(*gp, mechanism, sigma);
  }
  if (const auto* h = std::get_if<HybridCorrection>(&correction)) {
    if (const auto* gp = std::get_if<GpMap>(&h->left)) {
      return of_hybrid(correction, *h, *gp, mechanism, fitted, sigma);
    }
  }
  return std::nullopt;
}

PointUncertainty widened(const PointUncertainty& of, std::span<const Reading* const> readings,
                         std::span<const Pose> errors, const TrackerSigma& sigma) {
  TRAMMEL_ASSERT(!errors.empty() && errors.size() == readings.size());
  const auto n = static_cast<double>(errors.size());
  double place = 0, phi = 0, place_expected = 0, phi_expected = 0;
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const Expanded U = of.of(*readings[k]);
    const Pose& e = errors[k];
    place += (e.x_mm * e.x_mm + e.y_mm * e.y_mm) / (2 * n);
    phi += e.phi_rad * e.phi_rad / n;
    place_expected += (U.U_mm * U.U_mm / 4 + sigma.xy_mm * sigma.xy_mm) / n;
    phi_expected += (U.U_rad * U.U_rad / 4 + sigma.phi_rad * sigma.phi_rad) / n;
  }
  const auto more = [](double seen, double expected, double coordinates) {
    return seen > expected * (1 + 2 * std::sqrt(2 / coordinates)) ? seen - expected : 0.0;
  };
  const double more_mm2 = more(place, place_expected, 2 * n);
  const double more_rad2 = more(phi, phi_expected, n);
  if (more_mm2 == 0 && more_rad2 == 0) return of;
  return {of.basis + fmt::format(", widened by {:.4f} mm and {:.4f} deg (one standard deviation) "
                                 "that held-out points show beyond it",
                                 std::sqrt(more_mm2), deg_from_rad(std::sqrt(more_rad2))),
          [inner = of.of, more_mm2, more_rad2](const Reading& reading) {
            const Expanded U = inner(reading);
            return Expanded{.U_mm = 2 * std::sqrt(U.U_mm * U.U_mm / 4 + more_mm2),
                            .U_rad = 2 * std::sqrt(U.U_rad * U.U_rad / 4 + more_rad2)};
          }};
}

PointUncertainty held_out_uncertainty(std::span<const Pose> errors, const std::string& whence) {
  return {"the residuals of " + whence + " (the same at every point, a reading's noise included)",
          [same = expanded_from(errors)](const Reading&) { return same; }};
}

}  // namespace trammel::assess
