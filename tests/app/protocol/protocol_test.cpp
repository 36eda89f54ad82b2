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

}  // namespace

TEST_CASE("the paper's protocol is read, and its schema accepts it", "[protocol]") {
  CHECK(schema_errors(paper(), kSchema).empty());
  const Protocol protocol = read_protocol(kPaper);
  CHECK(protocol.name == "paper");
  CHECK(protocol.robot.filename() == "robot.json");
  REQUIRE(protocol.steps.size() >= 10);
  const auto& compensated = std::get<MeasureStep>(protocol.steps[2].what);
  CHECK(compensated.plan == "paper-80");
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
  CHECK(next.next_points_of == "diagnose-3");
  CHECK(next.set == ReadingSet::identify);
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
         p["steps"][0]["approach"] = {1, 1};
       }),
       "steps[0].approach"},
      {changed([](Json& p) {
         p["steps"][0]["approach"] = {1, 1, 2};
       }),
       "steps[0].approach"},
      {changed([](Json& p) { p["format"] = "protocol/2"; }), "format"},
      {changed([](Json& p) { p.erase("robot"); }), "robot"},
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
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.field);
    CHECK_FALSE(schema_errors(bad.protocol, kSchema).empty());
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
