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
