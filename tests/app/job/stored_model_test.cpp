#include "app/job/stored_model.hpp"

#include <set>

#include "app/job/compensation_table.hpp"
#include "app/job/model_json.hpp"
#include "app/job/run.hpp"
#include "core/units.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

RobotModel bent_robot() {
  RobotModel robot = nominal_model(paper_mechanism());
  robot.machine.chains[1][0] += rad_from_deg(0.02);
  robot.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(0.003, 0.002, 0.004)},
                   {&find_effect("backlash"), Eigen::Vector3d(0.08, 0, 0.1)},
                   {&find_effect("thermal_growth"), Eigen::Vector3d(1e-5, 0, 0)}};
  return robot;
}

/// nominal -> bent, with what a fit says of some of its parameters.
store::CampaignRow store_chain(PaperStore& paper) {
  const auto add = [&](const std::string& name, std::optional<int> parent, const RobotModel& robot,
                       const Json& effects, const Json& geometry) {
    const Json parameters = {{"correction", correction_json(ModelCorrection{robot})},
                             {"effects", effects},
                             {"geometry", geometry}};
    return store::add_model(paper.db, {.campaign_id = paper.campaign,
                                       .name = name,
                                       .parent = parent,
                                       .parameters_json = parameters.dump(),
                                       .identify_rms_mm = 0.01});
  };
  const int first =
      add("nominal", {}, nominal_model(paper_mechanism()), Json::array(), Json::array());
  const Json effects = {
      {{"effect", "lead_scale"}, {"name", "k_1"}, {"value", 0.003}, {"std", 1e-5}, {"unit", "1"}},
      {{"effect", "lead_scale"}, {"name", "k_2"}, {"value", 0.0021}, {"std", 1e-5}, {"unit", "1"}}};
  const Json geometry = {{{"name", "alpha_2"},
                          {"unit", "deg"},
                          {"identified", true},
                          {"change", 0.02},
                          {"std", 0.001}},
                         {{"name", "l_1"}, {"unit", "mm"}, {"identified", false}}};
  add("+bent", first, bent_robot(), effects, geometry);
  return store::require_campaign(paper.db, "paper");
}

const ModelParameter& parameter(const StoredModel& model, const std::string& name) {
  for (const ModelParameter& p : model.parameters) {
    if (p.name == name) return p;
  }
  throw std::runtime_error("no parameter " + name);
}

}  // namespace

TEST_CASE("a version shows its own values, with the deviations of their fit and no others",
          "[job]") {
  PaperStore paper;
  const store::CampaignRow campaign = store_chain(paper);
  const StoredModel model = find_model(paper.db, campaign, "last");
  CHECK(model.row.version == 2);
  CHECK(parameter(model, "k_1").std == 1e-5);
  CHECK_FALSE(parameter(model, "k_2").std);  // 0.0021 was fitted in another model
  CHECK(parameter(model, "k_2").value == 0.002);
  CHECK(parameter(model, "alpha_2").std == 0.001);
  CHECK_THAT(parameter(model, "alpha_2").value, WithinAbs(30.02, 1e-9));
  CHECK(not_identified(model) == std::vector<std::string>{"l_1"});
  CHECK_THAT(model_words(model).at(0), Contains("1 of 21") && Contains("l_1"));
  CHECK_THROWS_AS(find_model(paper.db, campaign, "3"), NotFoundError);
  CHECK_THROWS_AS(find_model(paper.db, campaign, "first"), NotFoundError);
}

TEST_CASE("a difference of versions is what differs and nothing else", "[job]") {
  PaperStore paper;
  const store::CampaignRow campaign = store_chain(paper);
  const StoredModel a = find_model(paper.db, campaign, "1");
  const StoredModel b = find_model(paper.db, campaign, "2");
  CHECK(differences(a, a).empty());
  std::set<std::string> names;
  for (const ParameterDifference& d : differences(a, b)) names.insert(d.b.value().name);
  CHECK(names == std::set<std::string>{"alpha_2", "k_1", "k_2", "k_3", "w_1", "w_3", "c_1"});
}

TEST_CASE("under the model every row of a compensation table reads its target to 1e-9 mm",
          "[job]") {
  const RobotModel robot = bent_robot();
  const CompensationTable table = compensation_table(
      robot,
      {.step_mm = 50, .half_width_mm = 100, .phi_rad = {0, rad_from_deg(3)}, .temp_degc = 23.0});
  CHECK(table.directed == std::array<bool, 3>{true, false, true});
  CHECK(table.n_targets == 50);
  CHECK(table.rows.size() == 4 * 50);
  for (const TableRow& row : table.rows) {
    const Eigen::Vector3d way(row.approach[0], row.approach[1], row.approach[2]);
    const Prediction at =
        predict(robot, {.cmd_mm = row.cmd_mm, .from_mm = row.cmd_mm - way, .temp_degc = 23.0});
    REQUIRE(at.ok());
    const Eigen::Vector3d off = at.pose.vector() - row.target.vector();
    CHECK(off.head<2>().norm() < 1e-9);
    CHECK(std::abs(off[2]) < 1e-11);
  }
}

TEST_CASE("a compensation table leaves unreachable targets out and counts them", "[job]") {
  const CompensationTable table =
      compensation_table(nominal_model(paper_mechanism()), {.step_mm = 200, .half_width_mm = 600});
  CHECK(table.directed == std::array<bool, 3>{false, false, false});
  CHECK(table.n_targets == 49);
  CHECK(table.n_unreachable > 0);
  CHECK(table.rows.size() == static_cast<std::size_t>(table.n_targets - table.n_unreachable));
  CHECK_THAT(table_csv(table),
             Catch::Matchers::StartsWith("target_x_mm,target_y_mm,target_phi_deg,cmd_l1_mm,"));
  CHECK_THROWS_AS(compensation_table(bent_robot(), {.step_mm = 0}), InputError);
  CHECK_THROWS_AS(compensation_table(bent_robot(), {.step_mm = 0.01}), InputError);
}

TEST_CASE("an effect whose condition is not given is named as left out", "[job]") {
  CHECK(idle_effects(bent_robot(), true, false).empty());
  CHECK(idle_effects(bent_robot(), false, false) ==
        std::vector<std::string>{"thermal_growth needs a temperature"});
}

TEST_CASE("a session is compensated by the last version of a job, not by a step on the way",
          "[job]") {
  PaperStore paper;
  const store::CampaignRow campaign = store_chain(paper);
  const Outcome fit = run(paper.db, {.campaign = "paper", .stage = "geometry"});
  const Json result = Json::parse(fit.job.data.result_json);
  const Json parameters = {{"correction", result["correction"]},
                           {"effects", Json::array()},
                           {"geometry", Json::array()}};
  const int version = store::add_model(paper.db, {.campaign_id = paper.campaign,
                                                  .name = "geometry",
                                                  .job_id = fit.job.id,
                                                  .parameters_json = parameters.dump()});
  CHECK(find_compensation(paper.db, "paper", std::to_string(fit.job.id)) == fit.job.id);
  CHECK(find_compensation(paper.db, "paper", "model:" + std::to_string(version)) == fit.job.id);
  CHECK_THROWS_AS(find_compensation(paper.db, "paper", "model:2"), InputError);
  CHECK_THROWS_AS(find_compensation(paper.db, "paper", "model:9"), NotFoundError);
}
