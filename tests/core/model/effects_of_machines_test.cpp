// What each effect does on machines of the other kinds, against displacements worked out by hand
// and finite differences.

#include <vector>

#include "core/calibrate/parameters.hpp"
#include "core/model/robot_model.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

RobotModel with(const Machine& machine, const std::string& name,
                const std::vector<double>& values) {
  RobotModel model = nominal_model(machine);
  model.effects.push_back(
      {&find_effect(name),
       Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()))});
  return model;
}

/// What the effect adds to the reading at a target.
Eigen::Vector3d adds(const Machine& machine, const std::string& name,
                     const std::vector<double>& values, const Pose& target) {
  Conditions c;
  c.cmd_mm = drives_of(machine, target);
  c.from_mm = c.cmd_mm - Displacements(5, -5, 0);
  c.temp_degc = 23.5;
  c.time_s = 7200;
  const Prediction at = predict(with(machine, name, values), c);
  REQUIRE(at.ok());
  return at.pose.vector() - target.vector();
}

void check_is(const Eigen::Vector3d& is, const Eigen::Vector3d& expected) {
  INFO("is " << is.transpose() << ", expected " << expected.transpose());
  CHECK((is - expected).cwiseAbs().maxCoeff() < 1e-9);
}

bool has(const std::string& effect, const Machine& machine) {
  return exists(find_effect(effect), machine);
}

}  // namespace

TEST_CASE("an XY stage errs with each effect as its axes do", "[model]") {
  const Machine xy = starting_machine("XY");
  const Pose at{40, -30, 0};
  check_is(adds(xy, "lead_scale", {1e-4, 0, 0}, at), {40e-4, 0, 0});
  check_is(adds(xy, "lead_curvature", {0, 1e-6, 0}, at), {0, 900e-6, 0});
  check_is(adds(xy, "backlash", {0.02, 0.04, 0}, at), {-0.01, 0.02, 0});
  // the guide of the second chain lies along x: bent, it makes y err with the square of x
  check_is(adds(xy, "guide_bow", {0, 1e-6, 0}, at), {0, 1600e-6, 0});
  CHECK(sentence_of(find_effect("guide_bow"), xy, {1}) ==
        "the x axis is bent: y errs with the square of x");
  CHECK(sentence_of(find_effect("guide_yaw"), xy, {0}) ==
        "the x axis yaws as it travels: x errs with x times y, the lever arm (Abbe)");
  // Abbe: yaw k s of x gives dx = -k s y, and the platform turns
  const double turn_rad = rad_from_deg(1e-5 * 40);
  check_is(adds(xy, "guide_yaw", {1e-5, 0, 0}, at), {30 * turn_rad, 0, turn_rad});
  check_is(adds(xy, "guide_yaw", {0, 1e-5, 0}, at),
           {0, 40 * rad_from_deg(-30e-5), rad_from_deg(-30e-5)});
}

TEST_CASE("drives have a screw lead each", "[model]") {
  Machine xy = starting_machine("XY");
  xy.drives[1].lead_mm = 4;
  const Eigen::Vector3d d = adds(xy, "screw_periodic", {0.01, 0, 0.02, 0, 0, 0}, {12, 17, 0});
  check_is(d, {0.01 * std::sin(2 * kPi * 12 / 10), 0.02 * std::sin(2 * kPi * 17 / 4), 0});
}

TEST_CASE("effects exist where a machine has what they act on", "[model]") {
  const Machine x = starting_machine("X"), xy = starting_machine("XY"),
                uvw = starting_machine("3-PPR"), rpr = starting_machine("3-RPR"),
                prr = starting_machine("3-PRR");
  for (const Machine* m : {&x, &xy, &uvw, &rpr, &prr}) {
    for (const char* name : {"lead_scale", "backlash", "thermal_growth", "tracker_scale"}) {
      CHECK(has(name, *m));
    }
  }
  CHECK_FALSE(has("guide_bow", x));
  CHECK_FALSE(has("guide_bow", rpr));
  CHECK(has("guide_bow", prr));
  CHECK(has("guide_yaw", xy));
  CHECK(has("guide_yaw", uvw));
  CHECK_FALSE(has("guide_yaw", prr));      // its joint lies on its guide
  CHECK_FALSE(has("axis_crosstalk", xy));  // squareness: geometry
  CHECK_FALSE(has("platform_load", x));
  CHECK(exists(find_effect("lead_scale"), 1, xy));
  CHECK_FALSE(exists(find_effect("lead_scale"), 2, xy));
  CHECK_FALSE(exists(find_effect("tracker_drift"), 1, x));
  CHECK_FALSE(exists(find_effect("tracker_drift"), 2, xy));
}

TEST_CASE("on every kind the derivative of a reading is the finite difference of its prediction",
          "[model]") {
  Random random(11);
  for (const char* kind : {"3-PPR", "3-RPR", "XY", "X"}) {
    INFO(kind);
    Machine machine = starting_machine(kind);
    if (machine.kind->has_point_platform() && machine.kind->n_chains > 1)
      machine.measured[2] = true;
    RobotModel model = nominal_model(machine);
    for (const MachineParameter& p : parameters_of(*machine.kind)) {
      model.machine.chains[static_cast<std::size_t>(p.chain)][p.place] +=
          p.tolerance * random.normal();
    }
    model.epochs[2] = {{0.1, -0.2, 0.05}, {0.005, 0.01, 0.001}};
    for (const Effect& effect : effect_catalogue()) {
      Eigen::VectorXd v = usual_shapes(effect);
      for (Eigen::Index k = 0; k < v.size(); ++k) {
        if (!exists(effect, static_cast<int>(k), machine)) continue;
        v[k] = 0.01 * random.uniform(0.2, 1) *
               effect.parameters[static_cast<std::size_t>(k)].usual_max;
      }
      model.effects.push_back({&effect, v});
    }
    Reading first, second;
    Pose target = machine.home;
    target.x_mm += 3;
    if (machine.kind->n_chains > 1) target.y_mm -= 2;
    if (!machine.kind->has_point_platform()) target.phi_rad += 0.01;
    first.conditions.cmd_mm = drives_of(machine, target);
    first.conditions.from_mm = first.conditions.cmd_mm - Displacements(2, -2, 2);
    first.conditions.time_s = 7200;
    first.conditions.temp_degc = 23.5;
    second.conditions = first.conditions;
    second.conditions.epoch = 2;
    auto parameters = base_parameters(machine, {first, second});
    add_effect_parameters(parameters, model);
    const Prediction at = predict(model, second.conditions);
    REQUIRE(at.ok());
    const Eigen::Matrix3Xd J = derivative(model, parameters, second.conditions, at);
    const double h = 1e-3;
    for (Eigen::Index j = 0; j < J.cols(); ++j) {
      INFO(parameters[static_cast<std::size_t>(j)].name);
      const Eigen::VectorXd step = h * Eigen::VectorXd::Unit(J.cols(), j);
      const Eigen::Vector3d slope =
          (predict(moved(model, parameters, step), second.conditions).pose.vector() -
           predict(moved(model, parameters, -step), second.conditions).pose.vector()) /
          (2 * h);
      // effects are taken at the pose of the geometry alone and the frame turns the derivative:
      // second order
      CHECK((slope - J.col(j)).norm() < 2e-2 * J.col(j).norm() + 1e-6);
    }
  }
}
