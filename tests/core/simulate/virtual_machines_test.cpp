// The virtual robot of every kind of machine: what its drives and guides do wrong, by hand.

#include <cmath>

#include "core/error.hpp"
#include "core/simulate/virtual_robot.hpp"
#include "tests/support/catch.hpp"

namespace trammel::simulate {

namespace {

Truth perfect_machine(const char* kind) {
  Truth truth;
  truth.nominal = starting_machine(kind);
  truth.actual = truth.nominal.chains;
  return truth;
}

Conditions at_cmd(const Displacements& cmd_mm) {
  return {.cmd_mm = cmd_mm, .from_mm = cmd_mm, .epoch = 1, .time_s = 0.0, .temp_degc = 20.0};
}

Pose stands(const Truth& truth, const Displacements& cmd_mm) {
  const MachinePose at = VirtualRobot(truth).true_pose(at_cmd(cmd_mm));
  REQUIRE(at.ok());
  return at.pose;
}

void check_near(const Pose& got, const Pose& expected, double tolerance = 1e-9) {
  INFO("got " << got.vector().transpose() << ", expected " << expected.vector().transpose());
  CHECK((got.vector() - expected.vector()).cwiseAbs().maxCoeff() < tolerance);
}

}  // namespace

TEST_CASE("a perfect machine of every kind stands where its drives put it", "[simulate]") {
  for (const MachineKind& kind : machine_kinds()) {
    INFO(kind.name);
    const Truth truth = perfect_machine(kind.name.data());
    const MachineSolver solver(truth.nominal);
    Pose target = truth.nominal.home;
    target.x_mm += 2;
    if (kind.n_chains > 1) target.y_mm -= 1.5;
    if (kind.n_chains > 2) target.phi_rad += 0.004;
    const VirtualRobot robot(truth);
    const Conditions c = at_cmd(solver.drives(target).l_mm);
    check_near(robot.true_pose(c).pose, target);
    check_near(robot.read(c, 3).pose, target);
    CHECK(robot.home_mm() == solver.drives(truth.nominal.home).l_mm);
  }
}

TEST_CASE("each drive errs by its own lead, and so does a machine of one or two", "[simulate]") {
  Truth truth = perfect_machine("XY");
  truth.drive.lead_scale = {1e-4, -2e-4, 0};
  truth.drive.screw_sin_mm = {0, 0.003, 0};
  truth.nominal.drives[1].lead_mm = 4;
  check_near(stands(truth, {100, 41, 0}), {100.01, 41 - 0.0082 + 0.003, 0});
  truth = perfect_machine("X");
  truth.drive.backlash_mm = {0.01, 0, 0};
  Conditions c = at_cmd({30, 0, 0});
  c.from_mm = {35, 0, 0};
  check_near(VirtualRobot(truth).true_pose(c).pose, {30.005, 0, 0});
}

TEST_CASE("a bent guide of an XY stage shifts the other coordinate by the square of the way",
          "[simulate]") {
  Truth truth = perfect_machine("XY");
  truth.drive.guide_bow_per_mm = {0, 2e-7, 0};  // of the guide along x, which the y drive carries
  check_near(stands(truth, {100, 20, 0}), {100, 20 + 2e-7 * 1e4, 0});
  truth.nominal.home = {40, 0, 0};
  check_near(stands(truth, {100, 20, 0}), {100, 20 + 2e-7 * 3600, 0});
}

TEST_CASE("a carriage that yaws moves what stands off its axis, and turns a point platform",
          "[simulate]") {
  Truth truth = perfect_machine("XY");
  truth.nominal.measured = {true, true, true};
  truth.drive.guide_yaw_rad_per_mm = {1e-7, 0, 0};
  // The guide along y turns by 1e-5 rad about its carriage at x = 100: dx = -k s y (to k^2).
  check_near(stands(truth, {100, 80, 0}), {100 - 1e-5 * 80, 80, 0}, 1e-7);
  check_near(stands(truth, {100, 0, 0}), {100, 0, 0});
  CHECK_THAT(VirtualRobot(truth).read(at_cmd({100, 80, 0}), 1).pose.phi_rad,
             WithinAbs(1e-5, 1e-12));
  truth.nominal.measured = {true, true, false};
  CHECK(VirtualRobot(truth).read(at_cmd({100, 80, 0}), 1).pose.phi_rad == 0);
}

TEST_CASE("a bow of a 3-PPR follows its own joint, found by its closures", "[simulate]") {
  Truth truth = perfect_machine("3-PPR");
  truth.drive.guide_bow_per_mm = {0, 0, 1e-4};
  const Displacements cmd(3, 3, 2);
  const Pose pose = stands(truth, cmd);
  // Chain 3: drive along y, guide along x, joint at (100, 0) of the platform.
  const double along = pose.x_mm + 100 * (std::cos(pose.phi_rad) - 1);
  Machine bowed = truth.nominal;
  bowed.chains[2][3] += 1e-4 * along * along;
  CHECK((MachineSolver(bowed).drives(pose).l_mm - cmd).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(std::abs(pose.y_mm - 2) > 1e-4);
}

TEST_CASE("coordinates that are not measured are 0, with noise too", "[simulate]") {
  Truth truth = perfect_machine("XY");
  truth.nominal.measured = {true, false, false};
  truth.tracker.sigma_xy_mm = 0.01;
  truth.tracker.sigma_phi_rad = 0.01;
  const Pose pose = VirtualRobot(truth).read(at_cmd({5, 7, 0}), 4).pose;
  CHECK(pose.y_mm == 0);
  CHECK(pose.phi_rad == 0);
  CHECK(pose.x_mm != 5);
}

TEST_CASE("drives that follow a load of an XY stage give way as far as it pushes", "[simulate]") {
  Truth truth = perfect_machine("XY");
  truth.drive.load_mm = {0.02, -0.01};
  check_near(stands(truth, {50, 60, 0}), {50.02, 59.99, 0});
}

TEST_CASE("an error of what a machine has not is refused by its field", "[simulate]") {
  const auto refused = [](const char* kind, auto change, const char* field) {
    Truth truth = perfect_machine(kind);
    change(truth.drive);
    CHECK_THROWS_WITH(VirtualRobot(truth), Contains(field));
  };
  refused(
      "XY", [](DriveTruth& d) { d.lead_scale[2] = 1e-4; }, "drive.lead_scale");
  refused(
      "X", [](DriveTruth& d) { d.backlash_mm[1] = 1e-4; }, "drive.backlash_mm");
  refused(
      "3-PRR", [](DriveTruth& d) { d.guide_yaw_rad_per_mm[0] = 1e-6; }, "guide_yaw");
  refused(
      "3-RPR", [](DriveTruth& d) { d.guide_bow_per_mm[0] = 1e-6; }, "guide_bow");
  refused(
      "XY", [](DriveTruth& d) { d.load_mm2 = 1; }, "m_mm2");
  refused(
      "XY", [](DriveTruth& d) { d.axis_crosstalk(2, 0) = 1e-3; }, "axis_crosstalk");
}

}  // namespace trammel::simulate
