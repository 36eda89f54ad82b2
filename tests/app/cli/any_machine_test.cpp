// Machines that are no 3-PRR through the command line: what serves them, what is refused and in
// which words. examples/xy-stage, uvw-stage and one-axis go through a whole campaign each.

#include <nlohmann/json.hpp>

#include "app/files/machine_json.hpp"
#include "core/mechanism/machine.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::run_here;

namespace {

/// A virtual XY stage whose instrument reads x alone, with backlash on x.
std::string half_seen_stage() {
  Machine machine = starting_machine("XY");
  machine.measured = {true, false, false};
  return nlohmann::ordered_json{{"format", "robot/1"},
                                {"mechanism", machine_json(machine)},
                                {"drive", {{"backlash_mm", {0.02, 0}}}},
                                {"tracker", {{"sigma_xy_mm", 0.001}}}}
      .dump();
}

}  // namespace

TEST_CASE("a coordinate that no instrument reads stops no session and is no error", "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("robot.json", half_seen_stage());
  const auto at = folder.path();
  CHECK(run_here({"plan", "create", "lattice", "--half-width", "100", "--step", "50", "--approach",
                  "++,--", "--mechanism", "robot.json", "--out", "plan.json"},
                 at)
            .exit_code == 0);
  const auto session =
      run_here({"session", "run", "half", "--plan", "plan.json", "--stage", "sim:robot.json"}, at);
  INFO(session.err);
  REQUIRE(session.exit_code == 0);
  CHECK_THAT(session.err, Contains("trammel calibrate geometry half"));
  const auto fitted = run_here({"calibrate", "geometry", "half", "--effects", "backlash"}, at);
  INFO(fitted.out << fitted.err);
  CHECK(fitted.exit_code == 0);
  CHECK_THAT(fitted.out, Contains("position_mm") && !Contains("attitude_deg"));
  // what is refused says what there is
  const auto refused = [&](const std::vector<std::string>& words, const char* says) {
    const auto answer = run_here(words, at);
    CHECK(answer.exit_code == 4);
    CHECK_THAT(answer.err, Contains(says));
  };
  refused({"calibrate", "lsq", "half"}, "trammel calibrate geometry");
  refused({"calibrate", "idw", "half"}, "every coordinate that the machine moves");
  refused({"calibrate", "geometry", "half", "--effects", "platform_load"},
          "one of lead_scale, lead_curvature, screw_periodic, backlash");
}

TEST_CASE(
    "a protocol's lattice is a line on a stage of one axis, its directions those of its drive",
    "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("robot.json",
               nlohmann::ordered_json{{"format", "robot/1"},
                                      {"mechanism", machine_json(starting_machine("X"))},
                                      {"tracker", {{"sigma_xy_mm", 0.001}}}}
                   .dump());
  const auto protocol = [&](const std::string& grid) {
    folder.write("protocol.json", R"({"format": "protocol/1", "name": "p",
      "stage": "sim:robot.json", "steps": [{"name": "fit", "kind": "measure",
        "plan": {"approaches": [[1], [-1]], )" +
                                      grid +
                                      R"(}},
      {"name": "geo", "kind": "calibrate", "method": "geometry", "sessions": ["fit"]}]})");
    return run_here({"protocol", "run", "protocol.json"}, folder.path());
  };
  const auto beside = protocol(R"("grid": "circle", "centre_mm": [0, 200])");
  CHECK(beside.exit_code == 4);
  CHECK_THAT(beside.err, Contains("lies on the machine's axis"));
  const auto line = protocol(R"("grid": "lattice")");
  INFO(line.err);
  CHECK(line.exit_code == 0);
  CHECK_THAT(line.err, Contains("42 points"));  // 21 from either side
}
