#include "core/calibrate/correction.hpp"

#include <cmath>

#include "core/error.hpp"
#include "core/judge/deviation.hpp"
#include "core/statistics/summary.hpp"
#include "tests/core/calibrate/campaigns.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

/// Joint errors of a robot whose drives lie, as a function of place.
Eigen::Vector3d lie(double x, double y) { return {1e-3 * x, -2e-3 * y, 5e-4 * (x + y)}; }

std::vector<JointSample> lie_samples() {
  std::vector<JointSample> samples;
  for (const Pose& p : eighty_points()) samples.push_back({p.x_mm, p.y_mm, lie(p.x_mm, p.y_mm)});
  return samples;
}

/// The pose the lying robot takes under a command: a fixed point, since the lie depends on place.
Pose lying_pose(const Displacements& cmd) {
  Pose pose = forward(paper_mechanism().geometry, cmd).pose;
  return forward(paper_mechanism().geometry, cmd + lie(pose.x_mm, pose.y_mm)).pose;
}

}  // namespace

TEST_CASE("on the robot a geometry correction believes in, the target is reached", "[calibrate]") {
  Random random(41);
  for (int k = 0; k < 50; ++k) {
    const Geometry truth = random_geometry(random);
    const Pose target = random_pose(random);
    const auto cmd = commanded(GeometryCorrection{truth}, paper_mechanism(), {.target = target});
    REQUIRE(cmd.ok());
    const ForwardResult at = forward(truth, cmd.l_mm);
    CHECK(pose_difference(at.pose, target).cwiseAbs().maxCoeff() < 1e-9);
    const ForwardResult thought =
        believed(GeometryCorrection{truth}, paper_mechanism(), {.cmd_mm = cmd.l_mm});
    CHECK(pose_difference(thought.pose, target).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("a map takes the drives' lie out at its samples, and between them mostly",
          "[calibrate]") {
  const Correction idw = MapCorrection{fit_idw(lie_samples())};
  const Correction rbf = MapCorrection{train_rbf(lie_samples()).network};
  for (const Pose& target : {Pose{30, 0, 0}, Pose{-50, 50, 0}}) {
    const auto cmd = commanded(idw, paper_mechanism(), {.target = target});
    CHECK(position_error_mm(lying_pose(cmd.l_mm), target) < 1e-3);  // second order of 0.1 mm
  }
  Random random(42);
  std::vector<double> before, by_rbf;
  for (int k = 0; k < 100; ++k) {
    const Pose target{random.uniform(-80, 80), random.uniform(-80, 80), 0};
    const auto plain = commanded(NominalCorrection{}, paper_mechanism(), {.target = target});
    const auto cmd = commanded(rbf, paper_mechanism(), {.target = target});
    before.push_back(position_error_mm(lying_pose(plain.l_mm), target));
    by_rbf.push_back(position_error_mm(lying_pose(cmd.l_mm), target));
  }
  CHECK(*improvement_pct(summarise(before), summarise(by_rbf)) > 95);
}

TEST_CASE("a smooth map is looked up where the command stands, not at the target", "[calibrate]") {
  // The lie changes by 2e-3 of the way and is 0.2 mm: looked up at the target it leaves 0.4 um.
  const Correction gp = MapCorrection{fit_gp(lie_samples())};
  for (const Pose& target : {Pose{30, 0, 0}, Pose{-50, 50, 0}, Pose{70, -70, 0}}) {
    const auto cmd = commanded(gp, paper_mechanism(), {.target = target});
    CHECK(position_error_mm(lying_pose(cmd.l_mm), target) < 5e-5);
  }
}

TEST_CASE("readings predicted after are those of the robot sent through all corrected commands",
          "[calibrate]") {
  // Steps of 0.2 mm beside corrections of 0.5 mm: most corrected commands lie on the other side of
  // where the uncorrected move began.
  RobotModel truth = nominal_model(paper_mechanism());
  truth.machine.chains[1][4] = 0.5;
  truth.effects = {{&find_effect("backlash"), Eigen::Vector3d(0.1, 0.1, 0.1)}};
  std::vector<Reading> readings;
  Displacements at = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  for (int k = 0; k < 60; ++k) {
    const double turn = 0.2 * k;
    Reading r;
    r.seq = k + 1;
    r.target = {5 * std::cos(turn), 5 * std::sin(turn), 0};
    r.conditions.cmd_mm = inverse(paper_mechanism().geometry, r.target).l_mm;
    r.conditions.from_mm = at;
    r.measured = predict(truth, r.conditions).pose;
    at = r.conditions.cmd_mm;
    readings.push_back(r);
  }
  const Correction correction = ModelCorrection{truth};
  const auto predicted = predicted_after(correction, paper_mechanism(), readings);
  at = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  for (std::size_t k = 0; k < readings.size(); ++k) {
    Move move = move_of(readings[k]);
    move.from_mm = at;
    const auto cmd = commanded(correction, paper_mechanism(), move);
    REQUIRE(cmd.ok());
    const Pose real = predict(truth, {.cmd_mm = cmd.l_mm, .from_mm = at}).pose;
    REQUIRE(predicted[k]);
    CHECK(position_error_mm(*predicted[k], real) < 1e-6);
    at = cmd.l_mm;
  }
}

TEST_CASE("in-sample after is the fit's own residual, epochs with their shifts", "[calibrate]") {
  Random random(48);
  RobotModel model = nominal_model(paper_mechanism());
  set_geometry(model.machine, random_geometry(random));
  model.epochs[2] = {{0.1, -0.2, 0.05}, {0.2, -0.1, rad_from_deg(0.02)}};
  for (Reading r : measure(model.geometry(), eighty_points(), random)) {
    if (r.seq > 40) r.conditions.epoch = 2;
    const Pose expected = predict(model, r.conditions).pose;
    r.measured = Pose{expected.x_mm + 0.02, expected.y_mm - 0.01, expected.phi_rad + 1e-4};
    const auto after = predicted_after(ModelCorrection{model}, paper_mechanism(), r);
    REQUIRE(after);
    const Eigen::Vector3d left = pose_difference(*after, r.target);
    CHECK(std::abs(left[0] - 0.02) < 1e-3);
    CHECK(std::abs(left[1] + 0.01) < 1e-3);
    CHECK(std::abs(left[2] - 1e-4) < 1e-5);
  }
}

TEST_CASE("the reading predicted after compensation is the reading that robot then gives",
          "[calibrate]") {
  Random random(43);
  const Geometry truth = random_geometry(random);
  for (const Reading& r : measure(truth, eighty_points(), random, {1e-12, 1e-12})) {
    const Correction correction = GeometryCorrection{truth};
    const auto predicted = predicted_after(correction, paper_mechanism(), r);
    const auto cmd = commanded(correction, paper_mechanism(), move_of(r));
    const ForwardResult real = forward(truth, cmd.l_mm);
    REQUIRE(predicted);
    CHECK(position_error_mm(*predicted, real.pose) < 2e-3);  // second order of 0.5 mm
    CHECK(position_error_mm(*predicted, r.target) < 2e-3);
  }
}

TEST_CASE("with a physical model the command reads the target under the planned move",
          "[calibrate]") {
  Random random(44);
  RobotModel model = nominal_model(paper_mechanism());
  set_geometry(model.machine, random_geometry(random));
  model.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(3.2e-3, 2e-3, 4.1e-3)},
                   {&find_effect("backlash"), Eigen::Vector3d(0.08, 0.08, 0.08)},
                   {&find_effect("thermal_growth"), Eigen::Vector3d(1e-5, 1e-5, 1e-5)},
                   {&find_effect("screw_periodic"),
                    (Eigen::VectorXd(6) << 6e-3, 0, 6e-3, 0, 0, 6e-3).finished()}};
  Displacements from = inverse(paper_mechanism().geometry, Pose{}).l_mm;
  for (int k = 0; k < 60; ++k) {
    Move move{.target = random_pose(random), .from_mm = from, .temp_degc = 22.5};
    if (k % 2 == 1) move.approach = {1, -1, 1};
    const auto cmd = commanded(ModelCorrection{model}, paper_mechanism(), move);
    REQUIRE(cmd.ok());
    Conditions c{.cmd_mm = cmd.l_mm, .from_mm = from, .temp_degc = 22.5};
    if (k % 2 == 1) c.from_mm = cmd.l_mm - Displacements(5, -5, 5);
    CHECK(pose_difference(predict(model, c).pose, move.target).cwiseAbs().maxCoeff() < 1e-9);
    from = cmd.l_mm;
  }
}

TEST_CASE("a move too short for its backlash still gets a command", "[calibrate]") {
  RobotModel model = nominal_model(paper_mechanism());
  model.effects = {{&find_effect("backlash"), Eigen::Vector3d(0.5, 0.5, 0.5)}};
  const Pose target{10, 20, 0};
  const Displacements there = inverse(paper_mechanism().geometry, target).l_mm;
  for (const double short_mm : {-0.1, 0.0, 1e-6, 0.1}) {
    const Move move{.target = target, .from_mm = there + Displacements::Constant(short_mm)};
    const auto cmd = commanded(ModelCorrection{model}, paper_mechanism(), move);
    REQUIRE(cmd.ok());
    CHECK((cmd.l_mm - there).cwiseAbs().maxCoeff() <= 0.25 + 1e-9);
  }
}

TEST_CASE("a hybrid takes out what its model leaves", "[calibrate]") {
  Random random(45);
  RobotModel truth = nominal_model(paper_mechanism());
  set_geometry(truth.machine, random_geometry(random));
  truth.effects = {{&find_effect("lead_curvature"), Eigen::Vector3d(1e-5, -1e-5, 1e-5)}};
  RobotModel poorer = truth;  // lacks the curvature: a map of position can hold it
  poorer.effects.clear();
  std::vector<Reading> readings;
  for (const Pose& target : eighty_points()) {
    Reading r;
    r.seq = 1 + static_cast<int>(readings.size());
    r.target = target;
    r.conditions.cmd_mm = inverse(paper_mechanism().geometry, target).l_mm;
    r.conditions.from_mm = r.conditions.cmd_mm;
    r.measured = predict(truth, r.conditions).pose;
    readings.push_back(r);
  }
  const Correction hybrid = HybridCorrection{poorer, fit_gp(samples_left(poorer, readings))};
  double model_mm = 0, hybrid_mm = 0;
  for (int k = 0; k < 40; ++k) {
    const Move move{.target = {random.uniform(-80, 80), random.uniform(-80, 80), 0}};
    for (const bool with_map : {false, true}) {
      const auto cmd = commanded(with_map ? hybrid : Correction{ModelCorrection{poorer}},
                                 paper_mechanism(), move);
      REQUIRE(cmd.ok());
      const Pose real = predict(truth, {.cmd_mm = cmd.l_mm, .from_mm = cmd.l_mm}).pose;
      (with_map ? hybrid_mm : model_mm) += position_error_mm(real, move.target) / 40;
    }
  }
  CHECK(hybrid_mm < model_mm / 10);
}

TEST_CASE("an unreachable target names its chain under any correction", "[calibrate]") {
  const Move far{.target = {5000, 0, 0}};
  const Geometry nominal = paper_mechanism().geometry;
  for (const Correction& c :
       {Correction{NominalCorrection{}}, Correction{GeometryCorrection{nominal}},
        Correction{MapCorrection{fit_idw(lie_samples())}}}) {
    CHECK_FALSE(commanded(c, paper_mechanism(), far).ok());
  }
}

TEST_CASE("joint errors come from the command, so a compensated reading tells the same",
          "[calibrate]") {
  Reading r;
  r.target = {40, -20, 0};
  for (const double moved : {0.0, 0.3}) {
    r.conditions.cmd_mm =
        inverse(paper_mechanism().geometry, r.target).l_mm + Displacements::Constant(moved);
    const Displacements error(0.1, -0.2, 0.05);
    r.measured = forward(paper_mechanism().geometry, r.conditions.cmd_mm + error).pose;
    CHECK((joint_error_mm(paper_mechanism(), r) - error).norm() < 1e-9);
  }
  r.measured.reset();
  CHECK_THROWS_AS(joint_error_mm(paper_mechanism(), r), InputError);
}
