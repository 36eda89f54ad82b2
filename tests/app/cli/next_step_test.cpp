// What the program suggests can be typed, and does something else than what has just failed.

#include "app/cli/next_step.hpp"

#include <algorithm>
#include <sstream>

#include "app/terminal/columns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::Finished;
using tests::run_command;
using tests::run_here;

namespace {

/// The line behind "next: ", less what a person is asked to do before.
std::string next_of(const Finished& done) {
  const std::size_t at = done.err.find("next: ");
  REQUIRE(at != std::string::npos);
  const std::string line = done.err.substr(at + 6, done.err.find('\n', at) - at - 6);
  const std::size_t then = line.find("then: ");
  return then == std::string::npos ? line : line.substr(then + 6);
}

}  // namespace

TEST_CASE("a wrong line is not suggested again", "[cli]") {
  const tests::TemporaryFolder folder;
  folder.write("bad.json", R"({"type": "3-PRR"})");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"plan", "check", "nowhere.json"},
                                             {"mechanism", "check", "nowhere.json"},
                                             {"plan", "create", "circle", "--within", "1", "2"},
                                             {"campaign", "import", "nowhere"}}) {
    CAPTURE(words);
    const Finished failed = run_here(words, folder.path());
    CHECK(failed.exit_code != 0);
    CAPTURE(failed.err);
    if (failed.err.find("next: ") == std::string::npos) continue;  // the message says what to do
    std::string wrong = "trammel";
    for (const std::string& word : words) wrong += " " + word;
    CHECK(next_of(failed) != wrong);
    CHECK(run_here({"plan", "check", "--help"}).exit_code == 0);
  }
  const Finished bad = run_here({"mechanism", "check", "bad.json"}, folder.path());
  CHECK(bad.exit_code == 4);  // the file is wrong, the line is not
  CHECK(next_of(bad) == "trammel mechanism check bad.json");
}

TEST_CASE("a campaign whose name begins with - is suggested as a shell takes it", "[cli]") {
  const tests::TemporaryFolder folder;
  const Finished imported = run_here(
      {"campaign", "import", tests::kDriveError, "--name=-x y", "--db", "a.db"}, folder.path());
  REQUIRE(imported.exit_code == 0);
  const std::string line = next_of(imported);
  CHECK(line == "trammel calibrate lsq --db a.db -- '-x y'");
  const std::string program = tests::build_folder() + "/trammel";
  const Finished done = run_command({"sh", "-c", program + line.substr(7)}, folder.path());
  CAPTURE(done.err);
  CHECK(done.exit_code == 0);
  CHECK(next_of(done) == "trammel report --db a.db -- '-x y'");
}

TEST_CASE("a question about no table or view is answered with those there are", "[cli]") {
  const tests::TemporaryFolder folder;
  REQUIRE(run_here({"campaign", "import", tests::kDriveError, "--db", "a.db"}, folder.path())
              .exit_code == 0);
  for (const char* sql : {"v_nosuch", "SELECT * FROM v_nosuch", "SELECT nosuch FROM v_job"}) {
    CAPTURE(sql);
    const Finished asked = run_here({"query", sql, "--db", "a.db"}, folder.path());
    CHECK(asked.exit_code == 4);
    CHECK_THAT(asked.err, Contains("v_point_error, v_point_status") && Contains("v_accuracy"));
  }
}

TEST_CASE("numbers of 200 digits are refused, and no message repeats them", "[cli]") {
  const tests::TemporaryFolder folder;
  const std::string digits(200, '7');
  REQUIRE(run_here({"campaign", "import", tests::kDriveError, "--db", "a.db"}, folder.path())
              .exit_code == 0);
  folder.write("plan.json",
               R"({"schema": "trammel/plan/1", "name": "a", "points": [{"seq": 1, "x_mm": )" +
                   digits + R"(, "y_mm": 0}]})");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"plan", "create", "lattice", "--step", digits},
                                             {"plan", "create", "lattice", "--seed", digits},
                                             {"plan", "create", "lattice", "--step", digits + "x"},
                                             {"plan", "create", "circle", "--centre", digits, "0"},
                                             {"plan", "show", "plan.json"},
                                             {"template", "machine", digits},
                                             {"job", "show", digits, "--db", "a.db"},
                                             {"campaign", "show", digits, "--db", "a.db"}}) {
    CAPTURE(words);
    const Finished refused = run_here(words, folder.path());
    CHECK((refused.exit_code >= 2 && refused.exit_code <= 4));
    CHECK(refused.out.empty());
    CHECK_THAT(refused.err, !Contains(digits));
  }
}

TEST_CASE("a name that is too long is refused as such: the database is sound", "[cli]") {
  const tests::TemporaryFolder folder;
  const std::string longest(200, 'n');
  const auto import = [&folder](const std::string& name) {
    return run_here({"campaign", "import", tests::kDriveError, "--name", name}, folder.path());
  };
  CHECK(import(longest).exit_code == 0);
  const Finished refused = import(longest + "n");
  CHECK(refused.exit_code == 4);
  CHECK_THAT(refused.err, Contains("1 to 200 characters") && !Contains("SQL"));
}

TEST_CASE("a real stage without a look at its plan is shown the line that records one", "[cli]") {
  const tests::TemporaryFolder folder;
  const std::string stage = tests::source_folder() + "/examples/stage/galil.json";
  REQUIRE(run_here({"plan", "create", "lattice", "--step", "50", "--out", "p.json"}, folder.path())
              .exit_code == 0);
  const Finished refused =
      run_here({"session", "run", "lab", "--plan", "p.json", "--stage", "galil:" + stage,
                "--tracker", "t2sa:" + tests::source_folder() + "/examples/stage/t2sa.json"},
               folder.path());
  CHECK(refused.exit_code == 6);
  const std::string line = next_of(refused);
  CHECK(line == "trammel plan check p.json --mechanism " + stage + " --record p.check.json");
  const Finished checked =
      run_command({"sh", "-c", tests::build_folder() + "/trammel" + line.substr(7)}, folder.path());
  CHECK(checked.exit_code == 0);
  CHECK_THAT(next_of(checked), Contains("--plan-check p.check.json"));
}

TEST_CASE("what a campaign does not have is looked for in it, not in the list of campaigns",
          "[cli]") {
  const tests::TemporaryFolder folder;
  const auto run = [&folder](std::vector<std::string> words) {
    words.insert(words.end(), {"--db", "a.db"});
    return run_here(words, folder.path());
  };
  REQUIRE(run({"campaign", "import", tests::kDriveError}).exit_code == 0);
  const Finished none =
      run({"reading", "exclude", "drive-error", "--seq", "9999", "--reason", "x"});
  CHECK(none.exit_code == 3);
  CHECK(next_of(none) == "trammel campaign show drive-error --db a.db");
  CHECK(next_of(run({"report", "nobody"})) == "trammel campaign list --db a.db");

  REQUIRE(run({"calibrate", "idw", "drive-error"}).exit_code == 0);
  const Finished no_model =
      run({"model", "export", "drive-error", "--format", "linuxcnc", "--out", "cnc"});
  CHECK(no_model.exit_code == 3);
  CHECK_THAT(no_model.err,
             Contains("--job 1 --db a.db` writes the correction of its calibration, idw"));
}

TEST_CASE("on a terminal of 20 columns help and errors stand in lines that fit", "[cli][release]") {
  const tests::TemporaryFolder folder;
  REQUIRE(run_here({"campaign", "import", tests::kDriveError, "--db", "a.db"}, folder.path())
              .exit_code == 0);
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"--help"}, {"plan", "create", "--help"}, {"report", "--help"}}) {
    CAPTURE(words);
    std::istringstream narrow(tests::run_on_terminal(words, folder.path(), true, 20));
    int n = 0;
    for (std::string line; std::getline(narrow, line); ++n) {
      if (line.ends_with('\r')) line.pop_back();
      CAPTURE(line);
      const std::size_t text = std::min(line.find_first_not_of(' '), line.size());
      CHECK((terminal::columns_of(line) <= 20 || line.find(' ', text) == std::string::npos));
    }
    CHECK(n > 20);
  }
}
