// The built program as emulators, in one process and in two.

#include <signal.h>

#include <nlohmann/json.hpp>

#include "tests/app/emulate/client.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

namespace trammel::tests {

namespace {

const std::string kPaperRobot = source_folder() + "/examples/paper/robot.json";

std::vector<std::string> emulator(const std::string& device, std::vector<std::string> more) {
  std::vector<std::string> words = {"emulate",   device, "--robot", kPaperRobot,
                                    "--speedup", "5000", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string moved_and_seen(int stage_port, int tracker_port) {
  Client stage(stage_port), tracker(tracker_port);
  CHECK(stage.galil("SHABC;PAA=8192;PAB=-8192;BGAB", 4) == "::::");
  stage.until_at_rest();
  tracker.tracker("!CMDEXE:PLATFORM");
  return tracker.tracker("?OFFSET:PLATFORM;BASE");
}

}  // namespace

TEST_CASE("two processes emulate the laboratory that one emulates", "[emulate]") {
  const TemporaryFolder folder;
  Served one(emulator("galil", {"--tracker-port", "0"}), folder.path());
  const auto both = nlohmann::json::parse(one.first_line());
  CHECK(schema_errors(both, "emulate-galil.schema.json") == "");
  const std::string seen = moved_and_seen(both.at("port"), both.at("tracker_port"));
  CHECK_THAT(seen, Contains("ACK-300 Object Offset Report"));

  Served stage(emulator("galil", {}), folder.path());
  const int stage_port = nlohmann::json::parse(stage.first_line()).at("port");
  Served tracker(emulator("tracker", {"--stage", "127.0.0.1:" + std::to_string(stage_port)}),
                 folder.path());
  const auto second = nlohmann::json::parse(tracker.first_line());
  CHECK(schema_errors(second, "emulate-tracker.schema.json") == "");
  CHECK(moved_and_seen(stage_port, second.at("port")) == seen);

  CHECK(one.stop(SIGINT).exit_code == 0);
  CHECK(stage.stop(SIGTERM).exit_code == 0);
  CHECK(tracker.stop(SIGTERM).exit_code == 0);
}

TEST_CASE("a fault on the command line strikes in the process, at its count", "[emulate]") {
  const TemporaryFolder folder;
  Served stage(emulator("galil", {"--fault", "dropped@2:;BG"}), folder.path());
  const int port = nlohmann::json::parse(stage.first_line()).at("port");
  Client client(port);
  CHECK(client.galil("SHA;PRA=10;BGA", 3) == ":::");
  client.until_at_rest("A");
  CHECK(client.galil("EO 0;BGA").empty());
  CHECK(client.closed());
  CHECK(stage.stop(SIGTERM).exit_code == 0);
}

TEST_CASE("an emulator that cannot start says why and serves nothing", "[emulate]") {
  const TemporaryFolder folder;
  const auto code = [&folder](const std::vector<std::string>& words) {
    const Finished finished = run_program(words, folder.path());
    CHECK(finished.out.empty());
    CHECK_FALSE(finished.err.empty());
    return finished.exit_code;
  };
  CHECK(code({"emulate", "galil", "--robot", "nowhere.json"}) == 3);
  CHECK(code(emulator("galil", {"--fault", "beam-break@1"})) == 2);
  CHECK(code(emulator("galil", {"--sign", "1,1"})) == 2);
  CHECK(code(emulator("galil", {"--sign", "2"})) == 2);
  CHECK(code(emulator("galil", {"--start-mm", "5000"})) == 4);
  CHECK(code(emulator("galil", {"--port", "70000"})) == 2);
  CHECK(code(emulator("tracker", {"--stage", "127.0.0.1:1"})) == 7);
  CHECK(code(emulator("tracker", {"--nests", "nowhere.json"})) == 3);
}

}  // namespace trammel::tests
