#include "core/simulate/virtual_robot.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/simulate/truth_check.hpp"
#include "core/units.hpp"

namespace trammel::simulate {

namespace {

double direction(double travel) { return travel > 0 ? 1.0 : travel < 0 ? -1.0 : 0.0; }

/// dl = G^T w: drives of equal stiffness give way under a constant wrench, by virtual work.
Displacements load_errors(const DriveTruth& drive, const Geometry& geometry,
                          const ForwardResult& at) {
  const Eigen::Vector3d wrench(drive.load_mm[0], drive.load_mm[1], drive.load_mm2);
  const Eigen::Matrix3d G = velocity_jacobian(velocity_equation(rail_frames(geometry), at.at));
  return G.transpose() * wrench;
}

Displacements displacements_at_home(const Mechanism& nominal) {
  const InverseResult home = inverse(nominal.geometry, nominal.home);
  if (!home.ok()) {
    throw InputError({.what = "the home pose of the virtual robot is out of reach",
                      .where = {.field = "mechanism.home"}});
  }
  return home.l_mm;
}

Pose turned(const Pose& frame, const Pose& pose) {
  const double c = std::cos(frame.phi_rad), s = std::sin(frame.phi_rad);
  return {frame.x_mm + c * pose.x_mm - s * pose.y_mm, frame.y_mm + s * pose.x_mm + c * pose.y_mm,
          pose.phi_rad + frame.phi_rad};
}

}  // namespace

VirtualRobot::VirtualRobot(Truth truth) : truth_(std::move(truth)) {
  check(truth_);
  l_home_mm_ = displacements_at_home(truth_.nominal);
  if (!truth_.zeroed) return;
  set_joint_zeros();
}

void VirtualRobot::set_joint_zeros() {
  const Pose home{truth_.nominal.home.x_mm, truth_.nominal.home.y_mm, truth_.phi_zero_rad};
  const Conditions at_home{.cmd_mm = l_home_mm_,
                           .from_mm = l_home_mm_,
                           .epoch = 1,
                           .time_s = 0.0,
                           .temp_degc = temperature_degc(0)};
  // As at the machine: look where it stands, turn the zeros, look again. Converges at once but for
  // what depends on the pose.
  constexpr int kLooks = 6;
  for (int look = 0; look < kLooks; ++look) {
    const ForwardResult stands = solve(at_home);
    const InverseResult wanted = inverse(truth_.actual, home);
    if (!stands.ok() || !wanted.ok()) {
      throw InputError({.what = "the robot as built cannot reach its home",
                        .where = {.field = "geometry_errors"}});
    }
    const Displacements off = wanted.l_mm - inverse(truth_.actual, stands.pose).l_mm;
    for (int i = 0; i < kChains; ++i) {
      truth_.actual.chains[static_cast<std::size_t>(i)].l_zero_mm += off[i];
    }
  }
}

double VirtualRobot::temperature_degc(double time_s) const {
  const TemperatureTruth& t = truth_.temperature;
  return t.start_degc - t.rise_k * std::expm1(-std::max(time_s, 0.0) / t.tau_s);
}

double VirtualRobot::structure_temperature_degc(const Conditions& conditions) const {
  const double time_s = conditions.time_s.value_or(0);
  const double shown = conditions.temp_degc.value_or(temperature_degc(time_s));
  const double behind =
      temperature_degc(time_s) - temperature_degc(time_s - truth_.drive.thermal_lag_s);
  return shown - behind;
}

double VirtualRobot::travel_s(const Displacements& from_mm, const Displacements& to_mm) const {
  return (to_mm - from_mm).cwiseAbs().maxCoeff() / truth_.motion.speed_mm_s;
}

const EpochTruth& VirtualRobot::epoch(int number) const {
  static const EpochTruth kNone;
  if (truth_.epochs.empty()) return kNone;
  const auto last = truth_.epochs.size() - 1;
  return truth_.epochs[std::min(last, static_cast<std::size_t>(std::max(number, 1) - 1))];
}

Displacements VirtualRobot::joint_errors(const Conditions& conditions) const {
  const DriveTruth& d = truth_.drive;
  const Eigen::Array3d l = conditions.cmd_mm.array();
  const Eigen::Array3d s = l - l_home_mm_.array();
  const Eigen::Array3d travel = l - conditions.from_mm.array();
  const Eigen::Array3d turn = 2 * kPi * l / truth_.nominal.screw_lead_mm;
  const double warmer = structure_temperature_degc(conditions) - kReferenceTemperatureDegc;
  const double fading = std::exp(-conditions.time_s.value_or(0) / d.transient_tau_s);

  Eigen::Array3d dl = d.lead_scale.array() * s + d.lead_curvature_per_mm.array() * s.square() +
                      d.lead_cubic_per_mm2.array() * s.cube();
  dl += d.screw_sin_mm.array() * turn.sin() + d.screw_cos_mm.array() * turn.cos();
  dl -= 0.5 * d.backlash_mm.array() * travel.unaryExpr(&direction) + d.stick_slip.array() * travel;
  dl += d.thermal_growth_per_k.array() * l * warmer + d.transient_mm.array() * fading;
  dl += (d.axis_crosstalk * s.matrix()).array();
  for (const BumpTruth& bump : truth_.bumps) {
    const double u = (l[bump.rail] - bump.centre_mm) / bump.width_mm;
    dl[bump.rail] += bump.height_mm * std::exp(-u * u);
  }
  for (const HarmonicTruth& wave : truth_.harmonics) {
    const double phase = 2 * kPi * l[wave.rail] / wave.period_mm;
    dl[wave.rail] += wave.sin_mm * std::sin(phase) + wave.cos_mm * std::cos(phase);
  }
  return dl.matrix();
}

ForwardResult VirtualRobot::solve(const Conditions& conditions) const {
  Geometry geometry = truth_.actual;
  const Displacements s = conditions.cmd_mm - l_home_mm_;
  for (int i = 0; i < kChains; ++i) {
    geometry.chains[static_cast<std::size_t>(i)].h_mm +=
        truth_.drive.guide_bow_per_mm[i] * s[i] * s[i];
  }
  const Displacements moved =
      conditions.cmd_mm + joint_errors(conditions) + epoch(conditions.epoch).l_zero_mm;
  const ForwardResult unloaded = forward(geometry, moved, truth_.nominal.home);
  if (!unloaded.ok()) return unloaded;
  const Displacements load = load_errors(truth_.drive, geometry, unloaded);
  if (load.isZero(0)) return unloaded;
  return forward(geometry, moved + load, unloaded.pose);
}

ForwardResult VirtualRobot::true_pose(const Conditions& conditions) const {
  return solve(conditions);
}

ForwardResult VirtualRobot::seen_pose(const Conditions& conditions) const {
  ForwardResult result = true_pose(conditions);
  if (result.ok()) result.pose = seen(result.pose, conditions);
  return result;
}

Pose VirtualRobot::seen(Pose pose, const Conditions& conditions) const {
  const TrackerTruth& t = truth_.tracker;
  const double time_s = conditions.time_s.value_or(0);
  const double hours = time_s / kSecondsPerHour;
  pose = turned(epoch(conditions.epoch).frame, pose);
  for (const ShiftTruth& shift : truth_.shifts) {
    if (time_s >= shift.time_s) pose = turned(shift.by, pose);
  }
  const double swirl =
      t.swirl_rad_per_mm * std::sqrt(pose.x_mm * pose.x_mm + pose.y_mm * pose.y_mm);
  const double phi = pose.phi_rad;  // the swirl is of the line of sight, not of the platform
  pose = turned({0, 0, swirl}, pose);
  return {(pose.x_mm + t.drift_per_h.x_mm * hours) * (1 + t.scale),
          (pose.y_mm + t.drift_per_h.y_mm * hours) * (1 + t.scale),
          phi + t.drift_per_h.phi_rad * hours};
}

ForwardResult VirtualRobot::read(const Conditions& conditions, std::uint64_t reading) const {
  ForwardResult seen = seen_pose(conditions);
  if (!seen.ok()) return seen;
  const Pose noise = reading_noise(truth_.tracker, truth_.seed, reading);
  seen.pose = Pose::from(seen.pose.vector() + noise.vector());
  return seen;
}

}  // namespace trammel::simulate
