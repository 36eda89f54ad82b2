#include "core/simulate/virtual_robot.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/simulate/truth_check.hpp"
#include "core/units.hpp"

namespace trammel::simulate {

namespace {

double direction(double travel) { return travel > 0 ? 1.0 : travel < 0 ? -1.0 : 0.0; }

Displacements displacements_at_home(const Machine& nominal) {
  const InverseResult home = MachineSolver(nominal).drives(nominal.home);
  if (!home.ok()) {
    throw InputError({.what = "the home pose of the virtual robot is out of reach",
                      .where = {.field = "mechanism.home"}});
  }
  return home.l_mm;
}

std::size_t place_of(const ChainKind& kind, std::string_view symbol) {
  const auto at = std::ranges::find(kind.parameters, symbol, &ChainParameter::symbol);
  return static_cast<std::size_t>(at - kind.parameters.begin());
}

/// The pose in the coordinates that the machine measures; 0 in the others.
Pose as_measured(const Machine& machine, const Pose& pose) {
  Eigen::Vector3d values = pose.vector();
  for (std::size_t c = 0; c < 3; ++c) {
    if (!machine.measured[c]) values[static_cast<Eigen::Index>(c)] = 0;
  }
  return Pose::from(values);
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
    const MachinePose stands = solve(at_home);
    Machine built = truth_.nominal;
    built.chains = truth_.actual;
    const MachineSolver solver(built);
    const InverseResult wanted = solver.drives(home);
    if (!stands.ok() || !wanted.ok()) {
      throw InputError({.what = "the robot as built cannot reach its home",
                        .where = {.field = "geometry_errors"}});
    }
    const Displacements off = wanted.l_mm - solver.drives(stands.pose).l_mm;
    for (int i = 0; i < built.kind->n_chains; ++i) {
      truth_.actual[static_cast<std::size_t>(i)][place_of(*built.kind->chain, "l")] += off[i];
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
  const auto& drives = truth_.nominal.drives;
  const Eigen::Array3d leads(drives[0].lead_mm, drives[1].lead_mm, drives[2].lead_mm);
  const Eigen::Array3d turn = 2 * kPi * l / leads;
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

/// The machine as its guides are with the drives at `s_mm` from home and the platform at `at`.
Machine VirtualRobot::bent(const Displacements& s_mm, const Pose& at) const {
  Machine machine = truth_.nominal;
  machine.chains = truth_.actual;
  const ChainKind& kind = *machine.kind->chain;
  const Pose& home = truth_.nominal.home;
  for (std::size_t i = 0; i < static_cast<std::size_t>(machine.kind->n_chains); ++i) {
    ChainValues& p = machine.chains[i];
    const auto row = static_cast<Eigen::Index>(i);
    const double bow = truth_.drive.guide_bow_per_mm[row];
    if (&kind == &kPrrChain) p[place_of(kind, "h")] += bow * s_mm[row] * s_mm[row];
    if (&kind != &kPprChain) continue;
    double& gamma = p[place_of(kind, "gamma")];
    const double arm = gamma - p[place_of(kind, "beta")];  // of the joint C, from the guide
    const double along =
        std::cos(gamma) * (at.x_mm - home.x_mm) + std::sin(gamma) * (at.y_mm - home.y_mm) +
        p[place_of(kind, "r")] * (std::cos(at.phi_rad - arm) - std::cos(home.phi_rad - arm));
    p[place_of(kind, "c")] += bow * along * along;
    // About where the drive stands, from which c is counted: gamma alone changes.
    gamma += truth_.drive.guide_yaw_rad_per_mm[row] * s_mm[row];
  }
  return machine;
}

MachinePose VirtualRobot::solve(const Conditions& conditions) const {
  const Displacements s = conditions.cmd_mm - l_home_mm_;
  const Displacements moved =
      conditions.cmd_mm + joint_errors(conditions) + epoch(conditions.epoch).l_zero_mm;
  const bool guides_follow_the_pose = truth_.nominal.kind->chain == &kPprChain;
  // The platform slides to where its guides are bent as they are there: each look is 1e-3 of the
  // one before for a guide that is out by as much as a milliradian.
  constexpr int kMostLooks = 20;
  constexpr double kStillMm = 1e-13;  // rounding of a pose
  MachineSolver solver(bent(s, truth_.nominal.home));
  MachinePose stands = solver.pose(moved, truth_.nominal.home);
  for (int look = 0; guides_follow_the_pose && stands.ok() && look < kMostLooks; ++look) {
    const Pose before = stands.pose;
    solver = MachineSolver(bent(s, before));
    stands = solver.pose(moved, before);
    if ((stands.pose.vector() - before.vector()).cwiseAbs().maxCoeff() <= kStillMm) break;
  }
  const DriveTruth& d = truth_.drive;
  const Eigen::Vector3d wrench(d.load_mm[0], d.load_mm[1], d.load_mm2);
  if (!stands.ok() || wrench.isZero(0)) return stands;
  // dl = G^T w: drives of equal stiffness give way under a constant wrench, by virtual work.
  const Displacements load = solver.look(stands.pose).J_V.transpose() * wrench;
  return solver.pose(moved + load, stands.pose);
}

MachinePose VirtualRobot::true_pose(const Conditions& conditions) const {
  return solve(conditions);
}

MachinePose VirtualRobot::seen_pose(const Conditions& conditions) const {
  MachinePose result = true_pose(conditions);
  if (!result.ok()) return result;
  if (truth_.nominal.kind->has_point_platform()) {
    result.pose.phi_rad += truth_.drive.guide_yaw_rad_per_mm.dot(conditions.cmd_mm - l_home_mm_);
  }
  result.pose = as_measured(truth_.nominal, seen(result.pose, conditions));
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

MachinePose VirtualRobot::read(const Conditions& conditions, std::uint64_t reading) const {
  MachinePose seen = seen_pose(conditions);
  if (!seen.ok()) return seen;
  const Pose noise = reading_noise(truth_.tracker, truth_.seed, reading);
  seen.pose = as_measured(truth_.nominal, Pose::from(seen.pose.vector() + noise.vector()));
  return seen;
}

}  // namespace trammel::simulate
