// Corrections of machines that are no 3-PRR, on the virtual robot of each (core/simulate, written
// apart): what is commanded under a correction, and what is predicted of it, against what the robot
// does.

#include "core/calibrate/correction.hpp"
#include "core/calibrate/geometry_fit.hpp"
#include "core/calibrate/joint_error.hpp"
#include "core/error.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

struct Sample {
  simulate::VirtualRobot robot;
  std::vector<Reading> readings;
};

/// 60 noise-free readings of a machine with geometry errors, leads that are off and backlash.
Sample sampled(const char* kind, std::uint64_t seed) {
  Random random(seed);
  simulate::Truth truth;
  truth.nominal = starting_machine(kind);
  truth.actual = truth.nominal.chains;
  for (const MachineParameter& p : parameters_of(*truth.nominal.kind)) {
    truth.actual[static_cast<std::size_t>(p.chain)][p.place] += 0.2 * p.tolerance * random.normal();
  }
  const int n = truth.nominal.kind->n_chains;
  truth.drive.lead_scale.head(n) = Eigen::Vector3d(2e-4, -1e-4, 3e-4).head(n);
  truth.drive.backlash_mm.head(n) = Eigen::Vector3d(0.004, 0.002, 0.003).head(n);
  Sample s{.robot = simulate::VirtualRobot(truth), .readings = {}};
  const bool small = std::string(kind) == "3-PPR";
  const MachineSolver solver(truth.nominal);
  for (int k = 0; k < 60; ++k) {
    Reading r;
    r.seq = k + 1;
    const double reach = small ? 2 : 80;
    r.target = truth.nominal.home;
    r.target.x_mm += random.uniform(-reach, reach);
    if (n > 1) r.target.y_mm += random.uniform(-reach, reach);
    if (n > 2) r.target.phi_rad += rad_from_deg(random.uniform(-0.5, 0.5));
    r.conditions.cmd_mm = r.conditions.from_mm = solver.drives(r.target).l_mm;
    for (int i = 0; i < n; ++i) r.conditions.from_mm[i] += random.uniform() < 0.5 ? 1 : -1;
    r.measured = s.robot.seen_pose(r.conditions).pose;
    s.readings.push_back(r);
  }
  return s;
}

double apart_mm(const Pose& a, const Pose& b) {
  return std::max((a.vector() - b.vector()).head<2>().norm(),
                  100 * std::abs(a.phi_rad - b.phi_rad));
}

/// The robot's pose under what the correction commands for the target of a reading.
Pose corrected(const Sample& s, const Correction& correction, const Reading& r) {
  const auto at = commanded(correction, s.robot.truth().nominal, move_of(r));
  REQUIRE(at.ok());
  Conditions c = r.conditions;
  c.cmd_mm = at.l_mm;
  for (int i = 0; i < kChains; ++i) {  // from the same side
    c.from_mm[i] = at.l_mm[i] + (r.conditions.from_mm[i] - r.conditions.cmd_mm[i]);
  }
  return s.robot.seen_pose(c).pose;
}

}  // namespace

TEST_CASE("a fitted model brings every kind of machine to its targets, and predicts it",
          "[calibrate]") {
  for (const char* kind : {"3-PPR", "3-RPR", "XY", "X"}) {
    CAPTURE(kind);
    const Sample s = sampled(kind, 5);
    RobotModel start = nominal_model(s.robot.truth().nominal);
    for (const char* name : {"lead_scale", "backlash"}) {
      const Effect& effect = find_effect(name);
      Eigen::VectorXd values = Eigen::VectorXd::Zero(3);
      for (int k = 0; k < 3; ++k) values[k] = exists(effect, k, start.nominal) ? 1e-6 : 0;
      start.effects.push_back({&effect, values});
    }
    const Correction correction =
        ModelCorrection{fit_geometry(start, s.readings, TrackerSigma{0.0005, 1e-5}).model};
    double before = 0, after = 0, predicted = 0;
    for (const Reading& r : s.readings) {
      before = std::max(before, apart_mm(*r.measured, r.target));
      const Pose stands = corrected(s, correction, r);
      after = std::max(after, apart_mm(stands, r.target));
      const auto expected = predicted_after(correction, s.robot.truth().nominal, r);
      REQUIRE(expected);
      predicted = std::max(predicted, apart_mm(*expected, stands));
    }
    INFO("before " << before << ", after " << after << " mm");
    CHECK(before > 0.002);
    CHECK(after < 1e-5);  // without noise the fit is exact but for what converges
    CHECK(predicted < 1e-5);
  }
}

TEST_CASE("maps of joint errors bring other machines nearer, and need all coordinates measured",
          "[calibrate]") {
  for (const char* kind : {"3-PPR", "XY", "X"}) {
    CAPTURE(kind);
    const Sample s = sampled(kind, 9);
    const Machine& machine = s.robot.truth().nominal;
    const Correction map = MapCorrection{fit_idw(joint_samples(machine, s.readings), {}), {}};
    double before = 0, after = 0;
    for (const Reading& r : s.readings) {
      before += apart_mm(*r.measured, r.target);
      after += apart_mm(corrected(s, map, r), r.target);
    }
    CHECK(after < 0.5 * before);
    Machine half = machine;
    half.measured[0] = false;
    CHECK_THROWS_WITH(joint_samples(half, s.readings),
                      Contains("every coordinate that the machine moves"));
  }
}

TEST_CASE("a coordinate that is not measured is no error, and stays as it is believed",
          "[calibrate]") {
  Sample s = sampled("XY", 3);
  Machine machine = s.robot.truth().nominal;
  machine.measured = {true, false, false};
  const Correction correction = ModelCorrection{nominal_model(machine)};
  for (Reading r : s.readings) {
    r.measured->y_mm = r.measured->phi_rad = 0;  // as a reading holds it
    const auto after = predicted_after(correction, machine, r);
    REQUIRE(after);
    CHECK(std::abs(after->y_mm - r.target.y_mm) < 1e-9);
    CHECK(std::abs(after->x_mm - r.measured->x_mm) < 1e-9);
  }
}
