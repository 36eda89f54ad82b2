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

TEST_CASE("what nobody measured is not shown of a session, in words or numbers", "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("robot.json", half_seen_stage());
  const auto at = folder.path();
  REQUIRE(run_here({"plan", "create", "lattice", "--half-width", "100", "--step", "50",
                    "--mechanism", "robot.json", "--out", "plan.json"},
                   at)
              .exit_code == 0);
  REQUIRE(
      run_here({"session", "run", "half", "--plan", "plan.json", "--stage", "sim:robot.json"}, at)
          .exit_code == 0);
  CHECK_THAT(run_here({"session", "status", "half"}, at).out,
             Contains("dx mm") && !Contains("dy mm") && !Contains("dphi"));
  const auto status =
      nlohmann::json::parse(run_here({"session", "status", "half", "--json"}, at).out);
  for (const auto& row : status.at("status").at("last")) {
    CHECK(row.contains("x_mm"));
    CHECK_FALSE(row.contains("y_mm"));
    CHECK_FALSE(row.contains("phi_deg"));
    CHECK(row.at("position_mm").get<double>() < 1);
  }
  CHECK_THAT(run_here({"assess", "half"}, at).out, !Contains("axis 2") && !Contains("AP_y"));
  CHECK_THAT(run_here({"mechanism", "workspace", "robot.json"}, at).out, !Contains("phi"));
}

TEST_CASE("a dry run refuses what the run would: another machine, and a method it has not",
          "[cli]") {
  const tests::TemporaryFolder folder;
  const auto at = folder.path();
  folder.write("robot.json", half_seen_stage());
  folder.write("other.json",
               nlohmann::ordered_json{{"format", "robot/1"},
                                      {"mechanism", machine_json(starting_machine("XY"))},
                                      {"tracker", {{"sigma_xy_mm", 0.001}}}}
                   .dump());
  REQUIRE(run_here({"plan", "create", "lattice", "--half-width", "50", "--step", "50",
                    "--mechanism", "robot.json", "--out", "plan.json"},
                   at)
              .exit_code == 0);
  const auto run = [&](const char* robot, bool dry) {
    std::vector<std::string> words = {"session", "run",       "c",
                                      "--plan",  "plan.json", "--session",
                                      robot,     "--stage",   std::string("sim:") + robot};
    if (dry) words.emplace_back("--dry-run");
    return run_here(words, at);
  };
  REQUIRE(run("robot.json", false).exit_code == 0);
  for (const bool dry : {true, false}) {
    const auto refused = run("other.json", dry);
    CHECK(refused.exit_code == 4);
    CHECK_THAT(refused.err, Contains("the campaign is of another mechanism"));
  }
  CHECK(run("robot.json", true).exit_code == 0);  // the control
  const auto protocol = [&](const char* robot, const char* method) {
    folder.write("p.json", std::string(R"({"format": "protocol/1", "name": "c", "stage": "sim:)") +
                               robot + R"(", "steps": [{"name": "fit", "kind": "measure",
        "plan": "plan.json"}, {"name": "m", "kind": "calibrate", "method": ")" +
                               method + R"(", "sessions": ["fit"]}]})");
    return run_here({"protocol", "check", "p.json"}, at);
  };
  CHECK(protocol("robot.json", "geometry").exit_code == 0);
  CHECK_THAT(protocol("other.json", "geometry").err, Contains("another mechanism"));
  CHECK_THAT(protocol("robot.json", "lsq").err, Contains("trammel calibrate geometry"));
  CHECK(protocol("robot.json", "lsq").exit_code == 4);
  CHECK_THAT(protocol("robot.json", "idw").err, Contains("every coordinate"));
}

TEST_CASE("a word of numbers is one pose, and a direction is one of a drive that is there",
          "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("robot.json", half_seen_stage());
  const auto at = folder.path();
  for (const char* signs : {"+++", "0-+", "++-"}) {
    const auto refused = run_here({"plan", "create", "lattice", "--approach", signs, "--mechanism",
                                   "robot.json", "--out", "p.json"},
                                  at);
    CHECK(refused.exit_code == 2);
    CHECK_THAT(refused.err, Contains("an XY machine has 2 drives"));
  }
  REQUIRE(run_here({"plan", "create", "lattice", "--half-width", "50", "--step", "50", "--approach",
                    "+-,--", "--mechanism", "robot.json", "--out", "plan.json"},
                   at)
              .exit_code == 0);
  REQUIRE(run_here({"session", "run", "c", "--plan", "plan.json", "--stage", "sim:robot.json"}, at)
              .exit_code == 0);
  REQUIRE(run_here({"diagnose", "c"}, at).exit_code == 0);
  const auto predict = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"model", "predict", "c", "last"};
    words.insert(words.end(), more.begin(), more.end());
    return run_here(words, at);
  };
  CHECK(predict({"--pose", "10,5"}).exit_code == 0);
  CHECK(predict({"--pose", "10,5", "-3,4"}).exit_code == 0);
  for (const char* word : {"10,5,3,4", "10,5,3", "10,", "10,a"}) {
    CHECK(predict({"--pose", word}).exit_code == 2);
  }
  CHECK(predict({"--pose", "10,5", "--approach", "+++"}).exit_code == 2);
}
