#include "core/simulate/truth_check.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"

namespace trammel::simulate {

namespace {

void require(bool ok, const std::string& field, const std::string& got,
             const std::string& expected) {
  if (ok) return;
  throw InputError({.what = "the virtual robot is not usable",
                    .where = {.field = field},
                    .got = got,
                    .expected = expected});
}

constexpr double kMostMeasureS = 24 * 3600;  // dates of many readings are still dates

void finite(double value, const std::string& field) {
  require(std::isfinite(value), field, std::to_string(value), "a finite number");
}

void finite(const Pose& pose, const std::string& field) {
  require(pose.vector().allFinite(), field, "a number that is not finite", "finite numbers");
}

void positive(double value, const std::string& field) {
  require(std::isfinite(value) && value > 0, field, std::to_string(value), "more than 0");
}

void not_negative(double value, const std::string& field) {
  require(std::isfinite(value) && value >= 0, field, std::to_string(value), "0 or more");
}

void share(double value, const std::string& field, bool one_allowed) {
  const bool below = one_allowed ? value <= 1 : value < 1;
  require(value >= 0 && below, field, std::to_string(value),
          one_allowed ? "0 to 1" : "0 to below 1");
}

void rail(const Machine& machine, int index, const std::string& field) {
  const int n = machine.kind->n_chains;
  require(index >= 0 && index < n, field, std::to_string(index + 1),
          n == 1 ? "1" : "1 to " + std::to_string(n));
}

/// What a kind of machine has not cannot err.
void check_kind(const DriveTruth& d, const MachineKind& kind) {
  const bool is_ppr = kind.chain == &kPprChain;
  const std::string chain(kind.chain->name);
  require(is_ppr || d.guide_yaw_rad_per_mm.isZero(0), "drive.guide_yaw_deg_per_mm", "not 0",
          "0: a " + chain + " chain has no passive guide");
  require(kind.chain != &kRprChain || d.guide_bow_per_mm.isZero(0), "drive.guide_bow_per_mm",
          "not 0", "0: a " + chain + " chain has no guide");
  require(!kind.has_point_platform() || d.load_mm2 == 0, "drive.platform_load.m_mm2",
          std::to_string(d.load_mm2), "0: no drive holds the platform's angle");
}

void check_drive(const DriveTruth& d, const Machine& machine) {
  const int n = machine.kind->n_chains;
  const auto vector = [n](const auto& v, const char* field) {
    require(v.allFinite(), field, "a number that is not finite", "finite numbers");
    require(n == kChains || v.size() < kChains || v.bottomRows(kChains - n).isZero(0), field,
            "an error of a drive that is not there", std::to_string(n) + " drives");
  };
  check_kind(d, *machine.kind);
  vector(d.lead_scale, "drive.lead_scale");
  vector(d.lead_curvature_per_mm, "drive.lead_curvature_per_mm");
  vector(d.screw_sin_mm, "drive.screw_sin_mm");
  vector(d.screw_cos_mm, "drive.screw_cos_mm");
  vector(d.backlash_mm, "drive.backlash_mm");
  vector(d.thermal_growth_per_k, "drive.thermal_growth_per_k");
  vector(d.axis_crosstalk, "drive.axis_crosstalk");
  vector(d.guide_bow_per_mm, "drive.guide_bow_per_mm");
  vector(d.guide_yaw_rad_per_mm, "drive.guide_yaw_deg_per_mm");
  vector(d.load_mm, "drive.load_mm");
  finite(d.load_mm2, "drive.load_mm2");
  vector(d.lead_cubic_per_mm2, "drive.lead_cubic_per_mm2");
  vector(d.stick_slip, "drive.stick_slip");
  vector(d.transient_mm, "drive.transient_mm");
  positive(d.transient_tau_s, "drive.transient_tau_s");
  not_negative(d.thermal_lag_s, "drive.thermal_lag_s");
}

void check_tracker(const TrackerTruth& t) {
  not_negative(t.sigma_xy_mm, "tracker.sigma_xy_mm");
  not_negative(t.sigma_phi_rad, "tracker.sigma_phi_deg");
  share(t.correlation, "tracker.correlation", false);
  finite(t.drift_per_h, "tracker.drift_per_h");
  finite(t.scale, "tracker.scale");
  finite(t.swirl_rad_per_mm, "tracker.swirl_rad_per_mm");
  share(t.outlier_share, "tracker.outlier_share", true);
  finite(t.outlier_mm, "tracker.outlier_mm");
}

}  // namespace

void check(const Truth& truth) {
  validate(truth.nominal);
  Machine built = truth.nominal;
  built.chains = truth.actual;
  validate(built);
  finite(truth.phi_zero_rad, "phi_zero_deg");
  check_drive(truth.drive, truth.nominal);
  check_tracker(truth.tracker);
  for (const BumpTruth& bump : truth.bumps) {
    rail(truth.nominal, bump.rail, "bumps.rail");
    finite(bump.centre_mm, "bumps.centre_mm");
    positive(bump.width_mm, "bumps.width_mm");
    finite(bump.height_mm, "bumps.height_mm");
  }
  for (const HarmonicTruth& wave : truth.harmonics) {
    rail(truth.nominal, wave.rail, "harmonics.rail");
    positive(wave.period_mm, "harmonics.period_mm");
    finite(wave.sin_mm, "harmonics.sin_mm");
    finite(wave.cos_mm, "harmonics.cos_mm");
  }
  for (const ShiftTruth& shift : truth.shifts) {
    finite(shift.time_s, "shifts.time_s");
    finite(shift.by, "shifts.by");
  }
  for (const EpochTruth& epoch : truth.epochs) {
    require(epoch.l_zero_mm.allFinite(), "epochs.l_zero_mm", "a number that is not finite",
            "finite numbers");
    finite(epoch.frame, "epochs.frame");
  }
  finite(truth.temperature.start_degc, "temperature.start_degc");
  finite(truth.temperature.rise_k, "temperature.rise_k");
  positive(truth.temperature.tau_s, "temperature.tau_s");
  positive(truth.motion.speed_mm_s, "motion.speed_mm_s");
  not_negative(truth.motion.settle_s, "motion.settle_s");
  not_negative(truth.motion.measure_s, "motion.measure_s");
  require(truth.motion.measure_s <= kMostMeasureS, "motion.measure_s",
          std::to_string(truth.motion.measure_s), "at most a day");
}

}  // namespace trammel::simulate
