// What a user can get wrong beyond a campaign's files: refused in words, with nothing left behind.

#include <nlohmann/json.hpp>

#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using tests::Finished;
using tests::read_text;
using tests::run_program;
using tests::TemporaryFolder;

namespace {

using OrderedJson = nlohmann::ordered_json;
using Words = std::vector<std::string>;

const std::string kRefusedRobot = tests::source_folder() + "/examples/paper/robot.json";

OrderedJson small_protocol() {
  return {{"format", "protocol/1"},
          {"name", "small"},
          {"robot", "robot.json"},
          {"steps",
           {{{"name", "first"}, {"kind", "measure"}, {"plan", "paper-48"}},
            {{"name", "found"},
             {"kind", "calibrate"},
             {"method", "idw"},
             {"sessions", OrderedJson::array({"first"})}},
            {{"name", "again"},
             {"kind", "measure"},
             {"plan", "paper-48"},
             {"set", "validate"},
             {"compensate", "found"}}}}};
}

bool no_database(const TemporaryFolder& folder) {
  return !std::filesystem::exists(folder.path() / "trammel.db");
}

}  // namespace

TEST_CASE("a database without a name is refused, and not taken for one that is not named",
          "[cli]") {
  const TemporaryFolder folder;
  const Finished unnamed = run_program({"campaign", "list", "--db", ""}, folder.path());
  CHECK(unnamed.exit_code == 2);
  CHECK_THAT(unnamed.err, Contains("a database has a name"));
  CHECK(run_program({"campaign", "list"}, folder.path()).exit_code == 3);  // ./trammel.db
}

TEST_CASE("a protocol whose robot or parameters are wrong leaves no database", "[cli]") {
  const TemporaryFolder folder;
  OrderedJson protocol = small_protocol();
  folder.write("p.json", protocol.dump(1));
  const Words run = {"protocol", "run", "p.json"};
  CHECK(run_program(run, folder.path()).exit_code == 3);  // no robot
  CHECK(no_database(folder));

  folder.write("robot.json", "{}");
  CHECK(run_program(run, folder.path()).exit_code == 4);
  CHECK(no_database(folder));

  folder.write("robot.json", read_text(kRefusedRobot));
  protocol["steps"][1]["parameters"] = {{"power", -1}};
  folder.write("p.json", protocol.dump(1));
  const Finished power = run_program(run, folder.path());
  CHECK(power.exit_code == 4);
  CHECK_THAT(power.err, Contains("p.json:") && Contains("steps[1].parameters"));
  CHECK(no_database(folder));
}

TEST_CASE("a plan beyond the stroke is refused before there is a database, each fault listed",
          "[cli]") {
  const TemporaryFolder folder;
  OrderedJson robot = OrderedJson::parse(read_text(kRefusedRobot));
  robot["mechanism"]["limits"] = {{"l_min_mm", 200}, {"l_max_mm", 320}};
  folder.write("robot.json", robot.dump());
  folder.write("p.json", small_protocol().dump());
  const Finished run = run_program({"protocol", "run", "p.json"}, folder.path());
  CHECK(run.exit_code == 6);
  CHECK_THAT(run.err, Contains("first") && Contains("above upper limit") &&
                          Contains("below lower limit") && Contains("mm, limit 318.000 mm"));
  CHECK(no_database(folder));
  const Finished json = run_program({"protocol", "run", "p.json", "--json"}, folder.path());
  CHECK(OrderedJson::parse(json.out).at("steps")[0].at("violations").size() > 1);

  const Finished session = run_program(
      {"session", "run", "c", "--plan", "paper-48", "--stage", "sim:robot.json"}, folder.path());
  CHECK(session.exit_code == 6);
  CHECK(no_database(folder));
  CHECK(run_program({"session", "run", "c", "--plan", "paper-48", "--stage", "sim:robot.json",
                     "--compensate", "1"},
                    folder.path())
            .exit_code == 3);
  CHECK(no_database(folder));
}

TEST_CASE("a reading left out after it was measured makes a new job, and the protocol goes on",
          "[cli]") {
  const TemporaryFolder folder;
  folder.write("robot.json", read_text(kRefusedRobot));
  folder.write("p.json", small_protocol().dump());
  const Words run = {"protocol", "run", "p.json"};
  REQUIRE(run_program(run, folder.path()).exit_code == 0);
  const Words exclude = {"reading", "exclude", "small", "--seq", "3", "--reason", "beam touched"};
  REQUIRE(run_program(exclude, folder.path()).exit_code == 0);
  const Finished again = run_program(run, folder.path());
  CHECK(again.exit_code == 0);
  CHECK_THAT(again.err, Contains("idw, job 2\n") && Contains("48 points  (done before)\nnext"));
  CHECK_THAT(run_program({"campaign", "show", "small"}, folder.path()).out,
             Contains("idw (job 1)"));
}

TEST_CASE("a protocol that was changed after it was measured is not passed off as done", "[cli]") {
  const TemporaryFolder folder;
  folder.write("robot.json", read_text(kRefusedRobot));
  folder.write("p.json", small_protocol().dump());
  const Words run = {"protocol", "run", "p.json"};
  REQUIRE(run_program(run, folder.path()).exit_code == 0);
  CHECK_THAT(run_program(run, folder.path()).err, Contains("(done before)"));

  OrderedJson other = small_protocol();
  other["steps"][0]["plan"] = "paper-80";
  folder.write("p.json", other.dump());
  const Finished plan = run_program(run, folder.path());
  CHECK(plan.exit_code == 4);
  CHECK_THAT(plan.err, Contains("'first'") && Contains("paper-48 of 48 points"));

  other = small_protocol();
  other["steps"][1]["method"] = "lsq";
  folder.write("p.json", other.dump());
  const Finished correction = run_program(run, folder.path());
  CHECK(correction.exit_code == 4);
  CHECK_THAT(correction.err, Contains("'again'") && Contains("another correction"));
}

TEST_CASE("a number on the line is decimal and finite, or the line is wrong", "[cli]") {
  const TemporaryFolder folder;
  for (const Words& words :
       std::vector<Words>{{"plan", "check", "paper-80", "--limit-margin", "nan"},
                          {"plan", "check", "paper-80", "--singularity-margin", "inf"},
                          {"plan", "create", "lattice", "--step", "0x10"},
                          {"plan", "create", "lattice", "--step", "10mm"},
                          {"plan", "create", "paper-80", "--orientations", "0,nan"},
                          {"plan", "create", "paper-80", "--repeats", "010x"},
                          {"mechanism", "ik", kRefusedRobot, "--pose", "0x10", "2", "3"},
                          {"mechanism", "sensitivity", kRefusedRobot, "--angle", "nan"},
                          {"calibrate", "idw", "c", "--power", "nan"}}) {
    CAPTURE(words);
    const Finished answer = run_program(words, folder.path());
    CHECK(answer.exit_code == 2);
    CHECK(answer.out.empty());
    CHECK_THAT(answer.err, Contains("is no decimal number") || Contains("is no whole number"));
  }
  CHECK(
      run_program({"plan", "check", "paper-80", "--limit-margin", "-1"}, folder.path()).exit_code ==
      4);
  CHECK(run_program({"mechanism", "sensitivity", kRefusedRobot, "--angle", "0", "--length", "0"},
                    folder.path())
            .exit_code == 4);
}

TEST_CASE("an option that does nothing for a grid is refused with the grids it is for", "[cli]") {
  const TemporaryFolder folder;
  const auto create = [&folder](const Words& more) {
    Words words = {"plan", "create"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(words, folder.path());
  };
  const Finished radius = create({"paper-48", "--radius", "30"});
  CHECK(radius.exit_code == 2);
  CHECK_THAT(radius.err, Contains("--radius") && Contains("circle"));
  CHECK(create({"rail", "--order", "random"}).exit_code == 2);
  CHECK(create({"circles", "--step", "5"}).exit_code == 2);
  const Finished step = create({"paper-48", "--step", "5"});
  REQUIRE(step.exit_code == 0);
  const OrderedJson plan = OrderedJson::parse(step.out);
  CHECK(plan.at("points").size() == 48);
  CHECK(plan.at("points")[0].at("x_mm") == 5.0);
  CHECK(plan.at("points")[0].at("y_mm") == 10.0);
}

TEST_CASE("a campaign without readings, or with unknown columns, is refused whole", "[cli]") {
  const TemporaryFolder folder;
  const std::string source = tests::source_folder() + "/tests/support/campaigns/drive-error";
  folder.write("campaign.json", read_text(source + "/campaign.json"));
  std::string readings = read_text(source + "/readings.csv");
  folder.write("readings.csv", readings.substr(0, readings.find('\n') + 1));
  const Finished none = run_program({"campaign", "import", "."}, folder.path());
  CHECK(none.exit_code == 4);
  CHECK_THAT(none.err, Contains("readings.csv:1") && Contains("no readings"));
  readings.replace(readings.find("time_s"), 6, "tine_s");
  readings.replace(readings.find("temp_degc"), 9, "temp_degf");
  folder.write("readings.csv", readings);
  const Finished unknown = run_program({"campaign", "import", "."}, folder.path());
  CHECK(unknown.exit_code == 4);
  CHECK_THAT(unknown.err, Contains("unknown columns 'tine_s', 'temp_degf'"));
  CHECK(no_database(folder));
}
