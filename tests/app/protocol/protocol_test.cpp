#include "app/protocol/protocol.hpp"

#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::protocol;
using tests::schema_errors;

namespace {

using Json = nlohmann::json;

const std::string kPaper = tests::source_folder() + "/examples/paper/protocol.json";
constexpr const char* kSchema = "protocol.schema.json";

nlohmann::json paper() { return nlohmann::json::parse(tests::read_text(kPaper)); }

ErrorText error_of(const nlohmann::json& protocol) {
  const tests::TemporaryFolder folder;
  const auto path = folder.write("protocol.json", protocol.dump(1));
  try {
    (void)read_protocol(path);
  } catch (const InputError& error) {
    return error.text();
  }
  FAIL("nothing was refused: " + protocol.dump());
  return {};
}

/// `change` applied to the paper's protocol.
template <class Change>
nlohmann::json changed(Change change) {
  nlohmann::json protocol = paper();
  change(protocol);
  return protocol;
}

/// One that names all that a protocol can.
template <class Change>
nlohmann::json real(Change change) {
  Json protocol = Json::parse(R"({
    "format": "protocol/1", "name": "lab", "stage": "galil:stage.json", "tracker": "t2sa:tracker.json",
    "policy": {"gate_mm": 2, "gate_deg": 1, "low_degc": 19, "high_degc": 23, "hysteresis_k": 0.2,
               "reference_every": 20, "base_every": 40, "drift_mm": 0.1, "patience_s": 60,
               "poll_s": 5, "retry_wait_s": 1, "beam_patience_s": 100},
    "check": {"limit_margin_mm": 5, "link_clearance_mm": 20},
    "steps": [
      {"name": "nests", "kind": "pause", "ask": "put nest 2 on"},
      {"name": "fit", "kind": "measure", "plan": "plans/fit.json", "plan_check": "fit.check.json"},
      {"name": "judge", "kind": "measure", "set": "validate", "new_set_up": true,
       "policy": {"base_every": 0}, "check": {"limit_margin_mm": 1}, "tracker": "file:other.json",
       "plan": {"grid": "lattice", "half_width_mm": 60, "step_mm": 30, "repeats": 3,
                "orientations_deg": [-5, 5], "approaches": [[1, 1, 1], [-1, -1, -1]],
                "order": "random", "seed": 7, "references": 2, "within_mm": [-40, 60]}},
      {"name": "page", "kind": "report", "html": "page.html"}]})");
  change(protocol);
  return protocol;
}

}  // namespace

TEST_CASE("a protocol names devices, gates, conditions, margins, plans and records", "[protocol]") {
  const Json json = real([](Json&) {});
  CHECK(schema_errors(json, kSchema).empty());
  const Protocol lab = parse_protocol(json.dump(), "/lab/one/protocol.json");
  const auto& fit = std::get<MeasureStep>(lab.steps.at(1).what);
  CHECK(std::get<std::filesystem::path>(fit.plan) == "/lab/one/plans/fit.json");
  CHECK(fit.plan_check == "/lab/one/fit.check.json");
  CHECK(fit.setting.stage == "galil:/lab/one/stage.json");
  CHECK(fit.setting.tracker == "t2sa:/lab/one/tracker.json");
  CHECK(fit.setting.policy.gate_mm == 2.0);
  CHECK(fit.setting.policy.high_degc == 23.0);
  CHECK(fit.setting.policy.base_every == 40);
  CHECK(fit.setting.check.limit_margin_mm == 5);
  CHECK_FALSE(fit.set);
  const auto& judge = std::get<MeasureStep>(lab.steps.at(2).what);
  CHECK(judge.setting.tracker == "file:/lab/one/other.json");
  CHECK(judge.setting.policy.base_every == 0);
  CHECK(judge.setting.policy.gate_mm == 2.0);
  CHECK(judge.setting.check.limit_margin_mm == 1);
  CHECK(judge.setting.check.link_clearance_mm == 20);
  CHECK(judge.new_set_up);
  const auto& grid = std::get<job::GridRequest>(judge.plan);
  // Of 25 points 16 lie within -40 and 60; two orientations, two directions, three rounds.
  const Plan plan = job::grid_plan(grid, machine_of(paper_mechanism())).plan;
  CHECK(plan.points.size() == 16 * 2 * 2 * 3);
  CHECK(plan.points.back().repeat == 3);
}

TEST_CASE("stage and tracker go together, and a pause stands before what it is for", "[protocol]") {
  CHECK(error_of(real([](Json& p) { p["stage"] = "sim:robot.json"; })).where.field == "tracker");
  CHECK(error_of(real([](Json& p) { p.erase("tracker"); })).where.field == "stage");
  CHECK(error_of(real([](Json& p) { p["steps"][2]["tracker"] = "sim"; })).where.field ==
        "steps[2].tracker");
  CHECK(error_of(real([](Json& p) { std::swap(p["steps"][0], p["steps"][2]); })).where.field ==
        "steps[2].kind");
  CHECK(error_of(real([](Json& p) { p["policy"]["high_degc"] = 19.1; })).where.field ==
        "policy.low_degc");
  // A field that does nothing for the grid.
  CHECK(error_of(real([](Json& p) { p["steps"][2]["plan"]["radius_mm"] = 5; })).where.field ==
        "steps[2].plan.radius_mm");
  CHECK(error_of(real([](Json& p) { p["steps"][2]["plan"]["step_mm"] = 0; })).where.field ==
        "steps[2].plan");
}

TEST_CASE("the paper's protocol is read, and its schema accepts it", "[protocol]") {
  CHECK(schema_errors(paper(), kSchema).empty());
  const Protocol protocol = read_protocol(kPaper);
  CHECK(protocol.name == "paper");
  const auto robot = std::filesystem::path(kPaper).parent_path() / "robot.json";
  REQUIRE(protocol.steps.size() >= 10);
  const auto& compensated = std::get<MeasureStep>(protocol.steps[2].what);
  CHECK(std::get<job::GridRequest>(compensated.plan).grid == "paper-80");
  CHECK(compensated.setting.stage == "sim:" + robot.string());
  CHECK(compensated.setting.tracker == "sim");
  CHECK(compensated.compensate == "lsq");
  CHECK(compensated.set == ReadingSet::validate);
}

TEST_CASE("the paper's protocol ends with at most three rounds of suggested points and the model",
          "[protocol]") {
  const Protocol protocol = read_protocol(kPaper);
  const auto step = [&protocol](const std::string& name) {
    for (const Step& s : protocol.steps) {
      if (s.name == name) return s.what;
    }
    throw std::runtime_error("no step " + name);
  };
  const auto next = std::get<MeasureStep>(step("next-3"));
  CHECK(std::get<NextPointsOf>(next.plan).step == "diagnose-3");
  CHECK_FALSE(next.set);
  CHECK_FALSE(next.compensate);
  CHECK(std::get<DiagnoseStep>(step("diagnose-4")).sessions.size() == 5);
  CHECK(std::get<MeasureStep>(step("measure-48-model")).compensate == "diagnose-4");
  // What the diagnosis is judged on it may not fit.
  CHECK(std::get<MeasureStep>(step("measure-48")).set == ReadingSet::validate);
}

TEST_CASE("what the schema refuses the reader refuses, naming the path", "[protocol]") {
  struct Bad {
    Json protocol;
    const char* field;
  };
  const std::size_t next = 11, diagnose = 10;
  const std::vector<Bad> all = {
      {changed([&](Json& p) {
         p["steps"][next]["plan"] = {{"points_of", "x"}};
       }),
       "steps[11].plan.next_points_of"},
      {changed([&](Json& p) { p["steps"][next]["plan"]["count"] = 5; }), "steps[11].plan.count"},
      {changed([&](Json& p) { p["steps"][next]["plan"] = 7; }), "steps[11].plan"},
      {changed([&](Json& p) { p["steps"][next]["set"] = "validate"; }), "steps[11].set"},
      {changed([&](Json& p) { p["steps"][next]["compensate"] = "lsq"; }), "steps[11].compensate"},
      {changed([&](Json& p) { p["steps"][diagnose].erase("sessions"); }), "steps[10].sessions"},
      {changed([&](Json& p) { p["steps"][diagnose]["method"] = "lsq"; }), "steps[10].method"},
      {changed([](Json& p) { p["steps"][1]["method"] = "diagnose"; }), "steps[1].method"},
      {changed([](Json& p) {
         p["steps"][0]["approach"] = {1, 1, 0, 1};
       }),
       "steps[0].approach"},
      {changed([](Json& p) {
         p["steps"][0]["approach"] = {1, 1, 2};
       }),
       "steps[0].approach"},
      {changed([](Json& p) { p["format"] = "protocol/2"; }), "format"},
      {changed([](Json& p) { p.erase("robot"); }), "stage"},
      {changed([](Json& p) { p["stage"] = "sim:robot.json"; }), "robot"},
      {changed([](Json& p) { p["robot"] = 7; }), "robot"},
      {changed([](Json& p) { p["steps"] = Json::array(); }), "steps"},
      {changed([](Json& p) { p["colour"] = "red"; }), "colour"},
      {changed([](Json& p) { p["steps"][0]["kind"] = "dance"; }), "steps[0].kind"},
      {changed([](Json& p) { p["steps"][0]["plan"] = "paper-81"; }), "steps[0].plan"},
      {changed([](Json& p) { p["steps"][0]["method"] = "lsq"; }), "steps[0].method"},
      {changed([](Json& p) { p["steps"][1]["method"] = "magic"; }), "steps[1].method"},
      {changed([](Json& p) { p["steps"][1]["sessions"] = "measure-80"; }), "steps[1].sessions"},
      {changed([](Json& p) { p["steps"][1]["sessions"] = Json::array(); }), "steps[1].sessions"},
      {changed([](Json& p) { p["steps"][1]["parameters"] = 1; }), "steps[1].parameters"},
      {changed([](Json& p) { p["steps"][2]["set"] = "predict"; }), "steps[2].set"},
      {changed([](Json& p) { p["steps"][3].erase("name"); }), "steps[3].name"},
      {changed([](Json& p) { p["name"] = ""; }), "name"},
      {real([](Json& p) { p["stage"] = "galil:"; }), "stage"},
      {real([](Json& p) { p["stage"] = "drone:stage.json"; }), "stage"},
      {real([](Json& p) { p["tracker"] = "t2sa"; }), "tracker"},
      {real([](Json& p) { p["policy"]["gate_mm"] = 0; }), "policy.gate_mm"},
      {real([](Json& p) { p["policy"]["poll_s"] = -1; }), "policy.poll_s"},
      {real([](Json& p) { p["policy"]["base_every"] = 1.5; }), "policy.base_every"},
      {real([](Json& p) { p["policy"]["reference_every"] = -1; }), "policy.reference_every"},
      {real([](Json& p) { p["policy"]["colour"] = 1; }), "policy.colour"},
      {real([](Json& p) { p["check"]["limit_margin_mm"] = -2; }), "check.limit_margin_mm"},
      {real([](Json& p) { p["check"]["margin"] = 2; }), "check.margin"},
      {real([](Json& p) { p["steps"][0].erase("ask"); }), "steps[0].ask"},
      {real([](Json& p) { p["steps"][0]["ask"] = ""; }), "steps[0].ask"},
      {real([](Json& p) { p["steps"][0]["plan"] = "paper-80"; }), "steps[0].plan"},
      {real([](Json& p) { p["steps"][1]["plan"] = "fit.csv"; }), "steps[1].plan"},
      {real([](Json& p) {
         p["steps"][1]["approach"] = {1, 1, 1};
       }),
       "steps[1].approach"},
      {real([](Json& p) { p["steps"][1]["plan_check"] = ""; }), "steps[1].plan_check"},
      {real([](Json& p) { p["steps"][1]["new_set_up"] = 1; }), "steps[1].new_set_up"},
      {real([](Json& p) { p["steps"][2]["plan"]["grid"] = "hexagon"; }), "steps[2].plan.grid"},
      {real([](Json& p) { p["steps"][2]["plan"]["colour"] = 1; }), "steps[2].plan.colour"},
      {real([](Json& p) { p["steps"][2]["plan"]["order"] = "up"; }), "steps[2].plan.order"},
      {real([](Json& p) { p["steps"][2]["plan"]["seed"] = -1; }), "steps[2].plan.seed"},
      {real([](Json& p) { p["steps"][2]["plan"]["repeats"] = 1.5; }), "steps[2].plan.repeats"},
      {real([](Json& p) { p["steps"][2]["plan"]["within_mm"] = {1}; }), "steps[2].plan.within_mm"},
      {real([](Json& p) {
         p["steps"][2]["plan"]["approaches"] = {1, 1, 1};
       }),
       "steps[2].plan.approaches"},
      {real([](Json& p) {
         p["steps"][2]["plan"]["approaches"] = Json::array({Json::array({1, 1, 0, 1})});
       }),
       "steps[2].plan.approaches"},
      {real([](Json& p) { p["steps"][3].erase("html"); }), "steps[3]"},
      {real([](Json& p) { p["steps"][3]["tolerance_mm"] = 0; }), "steps[3].tolerance_mm"},
      {real([](Json& p) { p["steps"][3]["pdf"] = "a.pdf"; }), "steps[3].pdf"},
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.field);
    // The schema does not tell the name of a grid from that of a file.
    if (std::string_view(bad.field) != "steps[1].approach") {
      CHECK_FALSE(schema_errors(bad.protocol, kSchema).empty());
    }
    const ErrorText error = error_of(bad.protocol);
    CHECK(error.where.field == bad.field);
    CHECK(error.where.line >= 1);
  }
}

TEST_CASE("a method's parameters are checked where the protocol is read", "[protocol]") {
  const ErrorText unknown = error_of(changed([](Json& p) {
    p["steps"][1]["parameters"] = {{"colour", 1}};
  }));
  CHECK(unknown.where.field == "steps[1].parameters.colour");
  CHECK(unknown.where.line > 1);
  CHECK(error_of(changed([](Json& p) {
          p["steps"][4]["parameters"] = {{"power", "2"}};
        })).where.field == "steps[4].parameters.power");
}

TEST_CASE("a step may only name earlier steps of the right kind, and no name is duplicate",
          "[protocol]") {
  CHECK(error_of(changed([](Json& p) { p["steps"][0]["compensate"] = "lsq"; })).where.field ==
        "steps[0].compensate");
  CHECK(error_of(changed([](Json& p) {
          p["steps"][2]["compensate"] = "measure-80";
        })).where.field == "steps[2].compensate");
  CHECK(error_of(changed([](Json& p) { p["steps"][1]["sessions"][0] = "lsq"; })).where.field ==
        "steps[1].sessions");
  CHECK(error_of(changed([](Json& p) { p["steps"][3]["name"] = "lsq"; })).where.field ==
        "steps[3].name");
  CHECK(error_of(changed([](Json& p) {
          p["steps"][11]["plan"]["next_points_of"] = "lsq";
        })).where.field == "steps[11].plan.next_points_of");
  CHECK(error_of(changed([](Json& p) {
          p["steps"][11]["plan"]["next_points_of"] = "diagnose-2";
        })).where.field == "steps[11].plan.next_points_of");
  // Points that may never be measured are not enough to work on.
  CHECK(error_of(changed([](Json& p) { p["steps"][12]["sessions"] = {"next-1"}; })).where.field ==
        "steps[12].sessions");
}
