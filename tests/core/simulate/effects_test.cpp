// Each effect alone on a perfect robot, against displacements worked out by hand.

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "core/mechanism/inverse.hpp"
#include "core/mechanism/velocity.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

namespace trammel::simulate {

namespace {

constexpr double kToleranceMm = 1e-9;  // of forward and inverse kinematics

Truth perfect() {
  Truth truth;
  truth.nominal = machine_of(paper_mechanism());
  truth.actual = truth.nominal.chains;
  return truth;
}

Displacements home_mm() { return inverse(paper_mechanism().geometry, Pose{}).l_mm; }

/// What the drives really did: the displacements of the pose they led to, less the command.
Displacements joint_errors(const Truth& truth, const Conditions& conditions) {
  const MachinePose at = VirtualRobot(truth).true_pose(conditions);
  REQUIRE(at.ok());
  return inverse(paper_mechanism().geometry, at.pose).l_mm - conditions.cmd_mm;
}

struct Case {
  std::string name;
  std::function<void(DriveTruth&)> set;
  Conditions conditions;
  Displacements expected_mm;
};

Conditions at_travel(const Displacements& s_mm) {
  return {.cmd_mm = home_mm() + s_mm,
          .from_mm = home_mm(),
          .epoch = 1,
          .time_s = 0.0,
          .temp_degc = 20.0};
}

Conditions at_place(const Displacements& l_mm, double temp_degc = 20) {
  return {.cmd_mm = l_mm, .from_mm = l_mm, .epoch = 1, .time_s = 0.0, .temp_degc = temp_degc};
}

std::vector<Case> cases() {
  const Conditions moved = at_travel({10, -20, 30});
  Conditions later = moved;
  later.time_s = 600;
  Conditions still = at_travel({10, -20, 0});  // rail 3 has not moved
  return {
      {"lead_scale",
       [](DriveTruth& d) {
         d.lead_scale = {1e-3, 2e-3, 3e-3};
       },
       moved,
       {0.01, -0.04, 0.09}},
      {"lead_curvature",
       [](DriveTruth& d) {
         d.lead_curvature_per_mm = {1e-5, 2e-5, -1e-5};
       },
       moved,
       {0.001, 0.008, -0.009}},
      {"lead_cubic",
       [](DriveTruth& d) {
         d.lead_cubic_per_mm2 = {1e-6, 1e-6, 1e-6};
       },
       moved,
       {0.001, -0.008, 0.027}},
      {"screw_periodic, sine",
       [](DriveTruth& d) {
         d.screw_sin_mm = {0.006, 0.007, 0.008};
       },
       at_place({262.5, 265, 267.5}),
       {0.006, 0, -0.008}},
      {"screw_periodic, cosine",
       [](DriveTruth& d) {
         d.screw_cos_mm = {0.006, 0.007, 0.008};
       },
       at_place({262.5, 265, 270}),
       {0, -0.007, 0.008}},
      {"backlash",
       [](DriveTruth& d) {
         d.backlash_mm = {0.1, 0.2, 0.3};
       },
       still,
       {-0.05, 0.1, 0}},
      {"stick_slip",
       [](DriveTruth& d) {
         d.stick_slip = {1e-3, 1e-3, 1e-3};
       },
       still,
       {-0.01, 0.02, 0}},
      {"thermal_growth",
       [](DriveTruth& d) {
         d.thermal_growth_per_k = {1e-5, 2e-5, -1e-5};
       },
       at_place({250, 260, 270}, 23),
       {0.0075, 0.0156, -0.0081}},
      {"axis_crosstalk",
       [](DriveTruth& d) { d.axis_crosstalk << 0, 1e-3, 0, 0, 0, 2e-3, 1e-4, 0, 0; },
       moved,
       {-0.02, 0.06, 0.001}},
      {"transient",
       [](DriveTruth& d) {
         d.transient_mm = {0.1, 0.2, 0.3};
       },
       later, Displacements(0.1, 0.2, 0.3) * 0.36787944117144233},
  };
}

}  // namespace

TEST_CASE("a perfect robot stands where it is told", "[simulate]") {
  const Pose target{37, -52, 0.04};
  const Displacements l = inverse(paper_mechanism().geometry, target).l_mm;
  const Pose pose = VirtualRobot(perfect()).seen_pose(at_place(l, 27)).pose;
  CHECK_THAT((pose.vector() - target.vector()).cwiseAbs().maxCoeff(), WithinAbs(0, 1e-9));
}

TEST_CASE("each drive effect moves the rails by its formula", "[simulate]") {
  for (const Case& c : cases()) {
    INFO(c.name);
    Truth truth = perfect();
    c.set(truth.drive);
    const Displacements got = joint_errors(truth, c.conditions);
    INFO("got " << got.transpose() << ", expected " << c.expected_mm.transpose());
    CHECK((got - c.expected_mm).cwiseAbs().maxCoeff() < kToleranceMm);
    CHECK(c.expected_mm.cwiseAbs().maxCoeff() > 1e-4);
  }
}

TEST_CASE("a bump and a harmonic of another period stay on their rail", "[simulate]") {
  Truth truth = perfect();
  truth.bumps = {{1, 250, 10, 0.05}};
  CHECK_THAT(joint_errors(truth, at_place({260, 250, 260}))[1], WithinAbs(0.05, kToleranceMm));
  const Displacements at_width = joint_errors(truth, at_place({260, 260, 260}));
  CHECK_THAT(at_width[1], WithinAbs(0.05 / std::exp(1.0), kToleranceMm));
  CHECK_THAT(joint_errors(truth, at_place({260, 230, 260}))[1],
             WithinAbs(0.05 * std::exp(-4.0), kToleranceMm));
  CHECK_THAT(at_width[0], WithinAbs(0, kToleranceMm));
  truth.bumps.clear();
  truth.harmonics = {{2, 5, 0.01, 0.02}};
  CHECK_THAT(joint_errors(truth, at_place({260, 260, 262.5}))[2], WithinAbs(-0.02, kToleranceMm));
  CHECK_THAT(joint_errors(truth, at_place({260, 260, 261.25}))[2], WithinAbs(0.01, kToleranceMm));
}

TEST_CASE("a thermal lag shows the structure the temperature of that much earlier", "[simulate]") {
  Truth truth = perfect();
  truth.temperature = {20, 3, 1000};
  truth.drive.thermal_growth_per_k = {1e-5, 0, 0};
  truth.drive.thermal_lag_s = 1000;
  Conditions c = at_place({250, 260, 260});
  c.time_s = 1000;
  c.temp_degc.reset();
  CHECK_THAT(joint_errors(truth, c)[0], WithinAbs(0, kToleranceMm));  // T(0) = 20
  c.time_s = 2000;
  CHECK_THAT(joint_errors(truth, c)[0],
             WithinAbs(1e-5 * 250 * 3 * (1 - std::exp(-1.0)), kToleranceMm));
}

TEST_CASE("a bowed guide moves B off its line by c s^2", "[simulate]") {
  Truth truth = perfect();
  truth.drive.guide_bow_per_mm = {2e-5, 0, 0};
  const Conditions c = at_travel({100, 20, -30});
  Geometry bowed = paper_mechanism().geometry;
  bowed.chains[0].h_mm = 0.2;  // 2e-5 * 100^2
  const Pose pose = VirtualRobot(truth).true_pose(c).pose;
  const Displacements back = inverse(bowed, pose).l_mm;
  CHECK((back - c.cmd_mm).cwiseAbs().maxCoeff() < kToleranceMm);
}

TEST_CASE("a load gives way as virtual work says, by differences of the pose", "[simulate]") {
  Truth truth = perfect();
  truth.drive.load_mm = {0.03, -0.02};
  truth.drive.load_mm2 = 5;
  const Conditions c = at_travel({30, -10, -20});
  const VirtualRobot rigid(perfect());
  Displacements expected;
  for (int j = 0; j < kChains; ++j) {
    constexpr double kStepMm = 1e-3;
    Conditions up = c, down = c;
    up.cmd_mm[j] += kStepMm;
    down.cmd_mm[j] -= kStepMm;
    const Eigen::Vector3d slope =
        (rigid.true_pose(up).pose.vector() - rigid.true_pose(down).pose.vector()) / (2 * kStepMm);
    expected[j] = slope.dot(Eigen::Vector3d(0.03, -0.02, 5));
  }
  CHECK((joint_errors(truth, c) - expected).cwiseAbs().maxCoeff() < 1e-7);
  CHECK(expected.cwiseAbs().minCoeff() > 1e-3);
}

TEST_CASE("drift, scale, shift, swirl and frame move the reading, not the platform", "[simulate]") {
  const Pose target{100, 0, 0.02};
  Conditions c = at_place(inverse(paper_mechanism().geometry, target).l_mm);
  c.time_s = 1800;
  const auto seen = [&](const Truth& truth) {
    const VirtualRobot robot(truth);
    CHECK_THAT(robot.true_pose(c).pose.x_mm, WithinAbs(100, kToleranceMm));
    return Eigen::Vector3d(robot.seen_pose(c).pose.vector() - target.vector());
  };
  const auto close = [](const Eigen::Vector3d& got, const Eigen::Vector3d& expected) {
    INFO("got " << got.transpose() << ", expected " << expected.transpose());
    CHECK((got - expected).cwiseAbs().maxCoeff() < 1e-9);
  };
  Truth truth = perfect();
  truth.tracker.drift_per_h = {0.1, -0.2, 0.001};
  close(seen(truth), {0.05, -0.1, 0.0005});
  truth = perfect();
  truth.tracker.scale = 1e-4;
  close(seen(truth), {0.01, 0, 0});
  truth = perfect();
  truth.tracker.swirl_rad_per_mm = 1e-5;  // 1e-3 rad at 100 mm
  close(seen(truth), {100 * (std::cos(1e-3) - 1), 100 * std::sin(1e-3), 0});
  truth = perfect();
  truth.shifts = {{1800, {0.3, -0.1, 0}}, {1801, {9, 9, 9}}};
  close(seen(truth), {0.3, -0.1, 0});
  truth = perfect();
  truth.epochs = {{Displacements::Zero(), {0.5, 0.25, 0.001}}};
  close(seen(truth), {0.5 + 100 * (std::cos(1e-3) - 1), 0.25 + 100 * std::sin(1e-3), 0.001});
}

TEST_CASE("each epoch has its own joint zeros; beyond the list the last one holds", "[simulate]") {
  Truth truth = perfect();
  truth.epochs = {{{0.1, 0, 0}, {}}, {{0, -0.2, 0}, {}}};
  Conditions c = at_place({250, 260, 270});
  CHECK_THAT(joint_errors(truth, c)[0], WithinAbs(0.1, kToleranceMm));
  for (const int epoch : {2, 3, 17}) {
    c.epoch = epoch;
    CHECK_THAT(joint_errors(truth, c)[0], WithinAbs(0, kToleranceMm));
    CHECK_THAT(joint_errors(truth, c)[1], WithinAbs(-0.2, kToleranceMm));
  }
}

}  // namespace trammel::simulate
