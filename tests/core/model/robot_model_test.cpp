#include "core/model/robot_model.hpp"

#include "core/calibrate/parameters.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/workspace.hpp"

using namespace trammel;

namespace {

Conditions conditions_at(const Pose& pose, const Displacements& from_by_mm, double time_s,
                         double temp_degc) {
  Conditions c;
  c.cmd_mm = inverse(paper_mechanism().geometry, pose).l_mm;
  c.from_mm = c.cmd_mm + from_by_mm;
  c.time_s = time_s;
  c.temp_degc = temp_degc;
  return c;
}

RobotModel with_effect(const std::string& name, const std::vector<double>& values) {
  RobotModel model = nominal_model(paper_mechanism());
  const Effect& effect = find_effect(name);
  model.effects.push_back({&effect, Eigen::Map<const Eigen::VectorXd>(
                                        values.data(), static_cast<Eigen::Index>(values.size()))});
  return model;
}

/// Displacements that a robot without errors has at the pose the model predicts, less the command.
Displacements seen_as_joint_error(const RobotModel& model, const Conditions& c) {
  const Prediction at = predict(model, c);
  REQUIRE(at.ok());
  return inverse(geometry_of(model.nominal), at.pose).l_mm - c.cmd_mm;
}

const Pose kPose{40, -30, 0.03};
const Conditions kConditions = conditions_at(kPose, {-5, 5, -5}, 7200, 23.5);
const Displacements kTravel = kConditions.cmd_mm - inverse(paper_mechanism().geometry, Pose{}).l_mm;

}  // namespace

TEST_CASE("a model without effects predicts the nominal pose", "[model]") {
  const Prediction at = predict(nominal_model(paper_mechanism()), kConditions);
  REQUIRE(at.ok());
  CHECK((at.pose.vector() - kPose.vector()).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("joint effects move a rail by what their formula says by hand", "[model]") {
  const double s2 = kTravel[1], l2 = kConditions.cmd_mm[1];
  struct Case {
    std::string name;
    std::vector<double> values;
    double rail_2_mm;
  };
  const std::vector<Case> cases = {
      {"lead_scale", {0, 2e-3, 0}, 2e-3 * s2},
      {"lead_curvature", {0, 1e-5, 0}, 1e-5 * s2 * s2},
      {"screw_periodic",
       {0, 0, 0.02, 0.01, 0, 0},
       0.02 * std::sin(2 * kPi * l2 / 10) + 0.01 * std::cos(2 * kPi * l2 / 10)},
      {"backlash", {0, 0.08, 0}, +0.04},  // rail 2 came from above: direction -1
      {"thermal_growth", {0, 2e-5, 0}, 2e-5 * l2 * 3.5},
      {"axis_crosstalk", {0, 0, 0, 1e-3, 0, 0}, 1e-3 * kTravel[2]},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    const Displacements dl = seen_as_joint_error(with_effect(c.name, c.values), kConditions);
    CHECK_THAT(dl[1], WithinAbs(c.rail_2_mm, 1e-9));
    CHECK_THAT(dl[0], WithinAbs(0, 1e-9));
    CHECK_THAT(dl[2], WithinAbs(0, 1e-9));
  }
}

TEST_CASE("a platform load moves the drives by the transposed Jacobian", "[model]") {
  const RobotModel model = with_effect("platform_load", {0.5, -0.2, 10});
  const Displacements dl = seen_as_joint_error(model, kConditions);
  const Prediction at = predict(nominal_model(paper_mechanism()), kConditions);
  const Eigen::Vector3d w(0.5, -0.2, 10);
  CHECK((dl - at.moment.J_V.transpose() * w).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("a bent guide is a rail offset growing with the square of travel", "[model]") {
  const Prediction bent = predict(with_effect("guide_bow", {2e-5, 0, 0}), kConditions);
  RobotModel offset = nominal_model(paper_mechanism());
  offset.machine.chains[0][6] = 2e-5 * kTravel[0] * kTravel[0];
  CHECK((bent.pose.vector() - predict(offset, kConditions).pose.vector()).cwiseAbs().maxCoeff() <
        1e-10);
}

TEST_CASE("reading effects change the reading alone", "[model]") {
  const Eigen::Vector3d drift =
      predict(with_effect("tracker_drift", {0.1, -0.05, 0.01}), kConditions).pose.vector() -
      kPose.vector();
  CHECK((drift - Eigen::Vector3d(0.2, -0.1, rad_from_deg(0.02))).cwiseAbs().maxCoeff() < 1e-9);
  const Pose scaled = predict(with_effect("tracker_scale", {1e-4}), kConditions).pose;
  CHECK_THAT(scaled.x_mm, WithinAbs(40 * 1.0001, 1e-9));
  CHECK_THAT(scaled.phi_rad, WithinAbs(kPose.phi_rad, 1e-12));
}

TEST_CASE("an effect whose condition is not recorded adds nothing", "[model]") {
  Conditions c = kConditions;
  c.temp_degc.reset();
  c.time_s.reset();
  for (const char* name : {"thermal_growth", "tracker_drift"}) {
    const Prediction at = predict(with_effect(name, {1e-4, 1e-4, 1e-4}), c);
    CHECK((at.pose.vector() - kPose.vector()).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("the derivative by every free parameter is the finite difference of the prediction",
          "[model]") {
  Random random(11);
  RobotModel model = nominal_model(paper_mechanism());
  set_geometry(model.machine, tests::random_geometry(random));
  model.epochs[2] = {{0.1, -0.2, 0.05}, {0.1, 0.2, 0.001}};
  std::size_t of_effects = 0;
  for (const Effect& effect : effect_catalogue()) {
    if (!exists(effect, model.nominal)) continue;
    of_effects += static_cast<std::size_t>(std::ranges::count_if(
        effect.parameters, [](const EffectParameter& p) { return p.on != On::choice; }));
    Eigen::VectorXd v(static_cast<Eigen::Index>(effect.parameters.size()));
    for (Eigen::Index k = 0; k < v.size(); ++k) {
      v[k] =
          0.1 * random.uniform(0.2, 1) * effect.parameters[static_cast<std::size_t>(k)].usual_max;
    }
    model.effects.push_back({&effect, v});
  }
  Reading first, second;
  first.conditions = second.conditions = kConditions;
  second.conditions.epoch = 2;
  auto parameters = base_parameters(model.nominal, {first, second});
  add_effect_parameters(parameters, model);
  REQUIRE(parameters.size() == 21 + 6 + of_effects);
  const Prediction at = predict(model, second.conditions);
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
    CHECK((slope - J.col(j)).norm() < 5e-3 * J.col(j).norm() + 1e-7);
  }
}

TEST_CASE("an unknown effect is answered with the names there are", "[model]") {
  CHECK_THROWS_AS(find_effect("gremlins"), NotFoundError);
  CHECK_THROWS_WITH(find_effect("gremlins"), Contains("backlash"));
}
