// The geometry of machines of every kind, identified from their readings and judged on poses that
// no fit has seen.

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

const PoseSigma kNoise{{0.001, rad_from_deg(0.0005)}};

/// A machine whose parameters are off by their tolerances.
RobotModel off_nominal(const Machine& machine, Random& random) {
  RobotModel truth = nominal_model(machine);
  for (const MachineParameter& p : parameters_of(*machine.kind)) {
    truth.machine.chains[static_cast<std::size_t>(p.chain)][p.place] +=
        p.tolerance * random.normal();
  }
  return truth;
}

std::vector<Reading> measured(const RobotModel& truth, int n, double turn_rad, Random& random,
                              const PoseSigma& noise = kNoise) {
  const Machine& machine = truth.nominal;
  const Limits& limits = machine.drives[0].limits;
  const double half_mm = (limits.l_max_mm - limits.l_min_mm) / 5;
  std::vector<Reading> readings;
  while (std::ssize(readings) < n) {
    Reading r;
    r.seq = static_cast<int>(readings.size()) + 1;
    r.target = machine.home;
    r.target.x_mm += random.uniform(-half_mm, half_mm);
    if (machine.kind->n_chains > 1) r.target.y_mm += random.uniform(-half_mm, half_mm);
    if (!machine.kind->has_point_platform()) r.target.phi_rad += random.uniform(-1, 1) * turn_rad;
    r.conditions.cmd_mm = r.conditions.from_mm = drives_of(machine, r.target);
    const Prediction at = predict(truth, r.conditions);
    if (!at.ok()) continue;
    Eigen::Vector3d pose = at.pose.vector();
    for (int c = 0; c < 3; ++c) pose[c] += noise.each[c] * random.normal();
    r.measured = Pose::from(pose);
    readings.push_back(r);
  }
  return readings;
}

Machine skewed_uvw() {
  Machine machine = starting_machine("3-PPR");
  for (ChainValues& p : machine.chains) p[1] += rad_from_deg(1.5);
  return machine;
}

}  // namespace

TEST_CASE("each kind's geometry is identified as far as its readings can tell", "[calibrate]") {
  struct Case {
    Machine machine;
    double turn_rad;
    Eigen::Index rank;
  };
  const std::vector<Case> cases = {
      {starting_machine("X"), 0, 1},
      {starting_machine("XY"), 0, 4},
      {starting_machine("3-PPR"), 0, 6},
      {starting_machine("3-PPR"), 0.02, 12},
      {skewed_uvw(), 0, 9},
      {skewed_uvw(), 0.02, 15},
      {starting_machine("3-RPR"), 0, 9},
      {starting_machine("3-RPR"), 0.2, 15},
  };
  Random random(5);
  for (const Case& c : cases) {
    INFO(c.machine.kind->name << " turned by " << c.turn_rad);
    // a stroke of 5 mm shows a skewed guide's alpha at a micrometre and less
    const PoseSigma noise{{1e-5, 1e-7}};
    const RobotModel truth = nominal_model(c.machine);
    const auto fit = fit_geometry(truth, measured(truth, 60, c.turn_rad, random, noise), noise);
    CHECK(fit.status == GeometryFit::Status::converged);
    CHECK(fit.identified.rank == c.rank);
  }
}

TEST_CASE(
    "on every kind, poses nobody measured are predicted as well as stated, and chi^2 counts "
    "what is measured",
    "[calibrate]") {
  for (const char* kind : {"X", "XY", "3-PPR", "3-RPR", "3-PRR"}) {
    INFO(kind);
    const Machine machine = starting_machine(kind);
    const int coordinates = static_cast<int>(std::ranges::count(machine.measured, true));
    Random random(7);
    double chi2 = 0, dof = 0, off2 = 0, expected = 0;
    for (int trial = 0; trial < 6; ++trial) {
      const RobotModel truth = off_nominal(machine, random);
      const double turn_rad = kind == std::string("3-PPR") ? 0.02 : 0.1;
      const auto fit =
          fit_geometry(nominal_model(machine), measured(truth, 50, turn_rad, random), kNoise);
      CHECK(fit.status == GeometryFit::Status::converged);
      CHECK(fit.dof == 50 * coordinates - fit.identified.rank);
      chi2 += fit.chi2;
      dof += fit.dof;
      for (const Reading& r : measured(truth, 20, turn_rad, random)) {
        const PredictedPose is = predict_with_covariance(fit, r.conditions);
        const Eigen::Vector3d off = is.pose.vector() - predict(truth, r.conditions).pose.vector();
        for (int c = 0; c < 3; ++c) {
          if (!machine.measured[static_cast<std::size_t>(c)]) continue;
          off2 += off[c] * off[c] / is.covariance(c, c);
          expected += 1;
        }
      }
    }
    // dof of 6 fits: 290 and more, so that chi^2 / dof leaves 1 +- 0.32 once in 10,000; errors of
    // one fit's poses are correlated, of no more than its rank: 4 sigmas of 2 / (6 rank)
    CHECK_THAT(chi2 / dof, WithinAbs(1, 0.32));
    CHECK(off2 / expected < 3.3);
    CHECK(off2 / expected > 0.1);
  }
}

TEST_CASE("what is not measured changes no bit of a fit", "[calibrate]") {
  Random random(8);
  Machine machine = starting_machine("XY");
  machine.measured = {true, false, false};
  const RobotModel truth = nominal_model(machine);
  auto readings = measured(truth, 40, 0, random);
  const auto fit = fit_geometry(nominal_model(machine), readings, kNoise);
  for (Reading& r : readings) r.measured->y_mm = r.measured->phi_rad = 1e3 * random.normal();
  PoseSigma other = kNoise;
  other.each[1] = other.each[2] = 0;
  const auto again = fit_geometry(nominal_model(machine), readings, other);
  CHECK(again.z == fit.z);
  CHECK(again.chi2 == fit.chi2);
  CHECK(fit.dof == 40 - fit.identified.rank);
  CHECK(fit.identified.rank == 2);  // x: its zero, and the direction of the other axis
  const auto far = outlying_readings(fit, readings);
  CHECK(far.empty());
}

TEST_CASE("each coordinate is weighed by its own noise", "[calibrate]") {
  const Machine machine = starting_machine("XY");
  const PoseSigma noise{{0.01, 1}, 0.1};
  CHECK(noise.each == Eigen::Vector3d(0.01, 0.001, 1));
  Random random(9);
  const RobotModel truth = off_nominal(machine, random);
  const auto fit =
      fit_geometry(nominal_model(machine), measured(truth, 200, 0, random, noise), noise);
  CHECK_THAT(fit.chi2 / fit.dof, WithinAbs(1, 0.28));  // 4 sigmas of sqrt(2 / 396)
  const PredictedPose at = predict_with_covariance(fit, {});
  CHECK_THAT(std::sqrt(at.covariance(1, 1) / at.covariance(0, 0)), WithinAbs(0.1, 0.03));
}

TEST_CASE("the zero of a parasitic angle belongs to the base, epoch by epoch", "[calibrate]") {
  Machine machine = starting_machine("XY");
  machine.measured[2] = true;
  Random random(10);
  RobotModel truth = off_nominal(machine, random);
  truth.epochs[1].frame.phi_rad = 0.01;
  truth.epochs[2] = {{0.05, 0.02, 0}, {0.1, -0.1, -0.02}};
  auto readings = measured(truth, 40, 0, random);
  for (std::size_t k = 20; k < readings.size(); ++k) {
    readings[k].conditions.epoch = 2;
    Eigen::Vector3d pose = predict(truth, readings[k].conditions).pose.vector();
    for (int c = 0; c < 3; ++c) pose[c] += kNoise.each[c] * random.normal();
    readings[k].measured = Pose::from(pose);
  }
  const auto fit = fit_geometry(nominal_model(machine), readings, kNoise);
  CHECK(fit.status == GeometryFit::Status::converged);
  CHECK(fit.chi2 < 1.6 * fit.dof);  // 120 - 10: 4 sigmas
}

TEST_CASE("whatever is measured, what readings cannot show is held, and the rest is plausible",
          "[calibrate]") {
  const PoseSigma noise{{0.0005, rad_from_deg(0.0003)}};
  for (const MachineKind& kind : machine_kinds()) {
    for (unsigned subset = 1; subset < 8; ++subset) {
      Machine machine = starting_machine(kind.name);
      for (std::size_t c = 0; c < 3; ++c) machine.measured[c] = (subset >> c & 1U) != 0;
      if (subset == 4) {  // phi alone
        CHECK_THROWS_AS(validate(machine), InputError);
        continue;
      }
      if (machine.measured[2] && !kind.measurable[2]) continue;
      if (machine.measured[1] && !kind.measurable[1]) continue;
      INFO(kind.name << " measured " << subset);
      Random random(11);
      RobotModel truth = off_nominal(machine, random);
      if (kind.has_point_platform()) {  // screws that are long, which no geometry explains
        const Effect& screw = find_effect("lead_scale");
        truth.effects.push_back({&screw, Eigen::Vector3d(4e-5, kind.n_chains > 1 ? -2e-5 : 0, 0)});
      }
      const double turn_rad = kind.has_point_platform() ? 0 : 0.02;
      const auto fit = fit_geometry(nominal_model(machine),
                                    measured(truth, 120, turn_rad, random, noise), noise);
      CHECK(fit.z.allFinite());
      const auto scaled = scaled_parameters(fit.parameters);
      const Identifiability known = identifiability(fit.system.jacobian, scaled);
      for (std::size_t k = 0; k < fit.parameters.size(); ++k) {
        const FreeParameter& p = fit.parameters[k];
        INFO(p.name);
        const auto row = static_cast<Eigen::Index>(k);
        if (p.held) {
          CHECK(fit.z[row] == 0);
          CHECK_FALSE(known.identified[k]);
          CHECK(std::ranges::any_of(known.null_space, [&](const NullDirection& d) {
            return d.sentence.starts_with(p.name + " is not identified: no reading depends on it");
          }));
        } else if (known.identified[k]) {  // off by its tolerances, and known to its uncertainty
          CHECK(std::abs(fit.z[row]) < 4 + 4 * std::sqrt(fit.covariance(row, row)));
        }
      }
    }
  }
}

TEST_CASE("of an XY stage of which one coordinate is measured, the other axis is held",
          "[calibrate]") {
  for (const std::size_t measured_one : {0U, 1U}) {
    Machine machine = starting_machine("XY");
    machine.measured = {measured_one == 0, measured_one == 1, false};
    Random random(12);
    RobotModel truth = off_nominal(machine, random);
    const auto fit = fit_geometry(nominal_model(machine), measured(truth, 40, 0, random), kNoise);
    std::string held;
    for (const FreeParameter& p : fit.parameters) {
      if (p.held) held += p.name + " ";
    }
    CHECK(held == (measured_one == 0 ? "gamma_2 l_2 c_2 " : "gamma_1 l_1 c_1 "));
  }
}
