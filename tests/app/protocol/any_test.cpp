// A protocol drives any plan on any stage, waits for a person, and goes on after a death in any of
// its steps.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <map>
#include <nlohmann/json.hpp>

#include "app/files/plan_json.hpp"
#include "app/job/run.hpp"
#include "app/protocol/run.hpp"
#include "store/campaign.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::protocol;
using tests::run_here;

namespace {

using Json = nlohmann::json;

const std::string kExamples = tests::source_folder() + "/examples/";

Json with_steps(const Json& steps) {
  return {{"format", "protocol/1"},
          {"name", "lab"},
          {"robot", kExamples + "paper/robot.json"},
          {"steps", steps}};
}

/// A campaign of every kind of step, in some 100 points.
Json whole() {
  const Json fit = {{"grid", "lattice"}, {"half_width_mm", 60}, {"step_mm", 30}};
  const Json judge = {{"grid", "circle"}, {"points", 12}, {"radius_mm", 40}};
  return with_steps({
      {{"name", "nests"}, {"kind", "pause"}, {"ask", "put nest 2 on"}},
      {{"name", "fit"}, {"kind", "measure"}, {"plan", fit}},
      {{"name", "judge"}, {"kind", "measure"}, {"plan", judge}, {"set", "validate"}},
      {{"name", "rbf"}, {"kind", "calibrate"}, {"method", "rbf"}, {"sessions", {"fit"}}},
      {{"name", "warm"}, {"kind", "pause"}, {"ask", "warm up to 22 degC"}},
      {{"name", "judge-rbf"},
       {"kind", "measure"},
       {"plan", judge},
       {"set", "validate"},
       {"compensate", "rbf"}},
      {{"name", "page"}, {"kind", "report"}, {"json", "report.json"}},
  });
}

/// In a process of its own, which is killed when it has stored the second point of a measure step
/// or ended any other.
void run_and_kill_in(const std::filesystem::path& folder, const std::string& step_name) {
  const pid_t child = fork();
  if (child == 0) {
    const Protocol protocol = read_protocol(folder / "protocol.json");
    store::Connection connection = store::open(folder / "trammel.db", store::Access::create);
    std::string now;  // the step that is being done
    const auto follow = [&](std::size_t k) {
      now = k < protocol.steps.size() ? protocol.steps[k].name : "";
    };
    std::size_t n_done = 0;
    follow(0);
    session::Surroundings around;
    around.correction_of = [](store::Connection& db, store::Id id) {
      return job::correction_of(db, id);
    };
    around.stored = [&](int n) {
      if (now == step_name && n == 2) kill(getpid(), SIGKILL);
    };
    const Person person{.tell =
                            [&](const StepOutcome& step) {
                              if (step.name == step_name) kill(getpid(), SIGKILL);
                              follow(++n_done);
                            },
                        .confirms = [](const auto&, const auto&) { return true; }};
    static_cast<void>(run(connection, protocol, requests_of(protocol), around, person));
    _exit(0);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFSIGNALED(status));
}

/// What was measured at each planned point of each session.
std::map<std::pair<std::string, int>, Pose> measured(const std::filesystem::path& db) {
  store::Connection connection = store::open(db, store::Access::read_only);
  const store::CampaignRow campaign = store::require_campaign(connection, "lab");
  std::map<std::pair<std::string, int>, Pose> poses;
  for (const store::SessionRow& session : store::list_sessions(connection, campaign.id)) {
    if (session.name.find(", reference") != std::string::npos) continue;
    std::map<store::Id, int> seq_of;
    for (const auto& a : store::attempts(connection, session.id)) seq_of[a.id] = a.point_seq;
    for (const auto& r : store::readings(connection, campaign.id, {session.id})) {
      const bool is_new = poses
                              .emplace(std::pair(session.name, seq_of.at(r.attempt_id.value())),
                                       r.data.reading.measured.value())
                              .second;
      CHECK(is_new);
    }
  }
  return poses;
}

}  // namespace

TEST_CASE("a protocol takes every plan that plan create makes, and a plan's file", "[protocol]") {
  const tests::TemporaryFolder folder;
  struct Kind {
    Json plan;
    std::vector<std::string> words;  // of plan create
  };
  const std::vector<Kind> kinds = {
      {"paper-80", {"paper-80"}},
      {"circles", {"circles"}},
      {{{"grid", "paper-48"}, {"step_mm", 15}, {"repeats", 2}},
       {"paper-48", "--step", "15", "--repeats", "2"}},
      {{{"grid", "lattice"},
        {"step_mm", 25},
        {"within_mm", {-30, 60}},
        {"approaches", {{1, 1, 1}, {-1, -1, -1}}},
        {"order", "nearest"}},
       {"lattice", "--step", "25", "--within", "-30", "60", "--approach", "+++,---", "--order",
        "nearest"}},
      {{{"grid", "circle"}, {"centre_mm", {10, -5}}, {"radius_mm", 30}, {"points", 9}},
       {"circle", "--centre", "10", "-5", "--radius", "30", "--points", "9"}},
      {{{"grid", "rail"}, {"travel_mm", 20}, {"targets", 3}, {"runs", 1}},
       {"rail", "--travel", "20", "--targets", "3", "--runs", "1"}},
      {{{"grid", "optimal"}, {"points", 4}, {"half_width_mm", 40}, {"criterion", "A"}, {"seed", 3}},
       {"optimal", "--points", "4", "--half-width", "40", "--criterion", "A", "--seed", "3"}},
  };
  Json steps = Json::array();
  std::vector<std::string> made;
  for (const Kind& kind : kinds) {
    std::vector<std::string> words = {"plan", "create"};
    words.insert(words.end(), kind.words.begin(), kind.words.end());
    made.push_back(run_here(words, folder.path()).out);
    REQUIRE(Json::parse(made.back()).at("points").size() >= 4);
    steps.push_back(
        {{"name", "s" + std::to_string(steps.size())}, {"kind", "measure"}, {"plan", kind.plan}});
  }
  folder.write("own.json", made[4]);
  made.push_back(made[4]);
  steps.push_back({{"name", "s7"}, {"kind", "measure"}, {"plan", "own.json"}});
  const auto file = folder.write("protocol.json", with_steps(steps).dump());
  const Requests requests = requests_of(read_protocol(file));
  for (std::size_t k = 0; k < made.size(); ++k) {
    CAPTURE(k);
    CHECK(plan_json(requests.at("s" + std::to_string(k)).plan).dump(1) + "\n" == made[k]);
  }
}

TEST_CASE("a real stage is refused without the record of each plan, and check writes them",
          "[protocol]") {
  const tests::TemporaryFolder folder;
  Json protocol = with_steps(
      {{{"name", "a"}, {"kind", "measure"}, {"plan", "paper-80"}, {"plan_check", "80.json"}},
       {{"name", "b"}, {"kind", "measure"}, {"plan", "paper-48"}, {"plan_check", "48.json"}},
       {{"name", "c"}, {"kind", "measure"}, {"plan", "paper-80"}, {"plan_check", "80.json"}}});
  protocol.erase("robot");
  protocol["stage"] = "galil:" + kExamples + "stage/galil.json";
  const std::map<std::string, std::string> trackers = {{"t2sa:", "stage/t2sa.json"},
                                                       {"file:", "stage/tracker_file.json"}};
  for (const auto& [kind, tracker] : trackers) {
    CAPTURE(kind);
    protocol["tracker"] = kind + kExamples + tracker;
    folder.write("protocol.json", protocol.dump());
    const auto refused = run_here({"protocol", "run", "protocol.json"}, folder.path());
    CHECK(refused.exit_code == 6);
    CHECK_THAT(refused.err, Contains("80.json is not there") && Contains("--record"));
    CHECK_FALSE(std::filesystem::exists(folder.path() / "trammel.db"));
    const auto checked =
        run_here({"protocol", "check", "protocol.json", "--record"}, folder.path());
    CHECK(checked.exit_code == 0);
    CHECK_THAT(checked.out, Contains("2 records written"));
    const auto dry = run_here({"protocol", "run", "protocol.json", "--dry-run"}, folder.path());
    CHECK(dry.exit_code == 0);
    CHECK_THAT(dry.out, Contains("left to measure: ") && !Contains("missing"));
    for (const char* record : {"80.json", "48.json"}) {
      REQUIRE(std::filesystem::remove(folder.path() / record));
    }
  }
  // Two plans and one record; a record that is another plan's.
  protocol["steps"][1]["plan_check"] = "80.json";
  folder.write("protocol.json", protocol.dump());
  CHECK(run_here({"protocol", "check", "protocol.json", "--record"}, folder.path()).exit_code == 4);
  const auto other = run_here({"protocol", "run", "protocol.json"}, folder.path());
  CHECK(other.exit_code == 6);
  CHECK_THAT(other.err, Contains("another plan"));
  // Margins that the plan does not keep.
  protocol["check"] = {{"limit_margin_mm", 250}};
  folder.write("protocol.json", protocol.dump());
  CHECK(run_here({"protocol", "check", "protocol.json"}, folder.path()).exit_code == 5);
}

TEST_CASE("a protocol waits at a pause until a person confirms, once", "[protocol]") {
  const tests::TemporaryFolder folder;
  folder.write("protocol.json", whole().dump());
  const auto protocol = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"protocol", "run", "protocol.json"};
    words.insert(words.end(), more.begin(), more.end());
    return run_here(words, folder.path());
  };
  CHECK(protocol({"--confirm", "fit"}).exit_code == 2);
  const auto first = protocol({});
  CHECK(first.exit_code == 130);
  CHECK_THAT(first.err, Contains("put nest 2 on") &&
                            Contains("next: trammel protocol run protocol.json --confirm nests"));
  const auto second = protocol({"--confirm", "nests"});
  CHECK(second.exit_code == 130);
  CHECK_THAT(second.err, Contains("warm up to 22 degC") && Contains("--confirm warm"));
  // nests is over, and not asked for again.
  const auto third = protocol({"--confirm", "warm"});
  CHECK(third.exit_code == 0);
  CHECK(std::filesystem::exists(folder.path() / "report.json"));
  CHECK(protocol({}).exit_code == 0);
  const auto log = run_here(
      {"query", "SELECT detail FROM session_event WHERE kind = 'confirmed' ORDER BY event_id"},
      folder.path());
  CHECK_THAT(log.out, Contains("nests: put nest 2 on") && Contains("warm: warm up to 22 degC"));
}

TEST_CASE("a dry run names every step, and the time is the sum of what is left", "[protocol]") {
  const tests::TemporaryFolder folder;
  const Json protocol = whole();
  folder.write("protocol.json", protocol.dump());
  const auto look = [&] {
    const auto dry =
        run_here({"protocol", "run", "protocol.json", "--dry-run", "--json"}, folder.path());
    REQUIRE(dry.exit_code == 0);
    return Json::parse(dry.out);
  };
  const Json before = look();
  CHECK_FALSE(std::filesystem::exists(folder.path() / "trammel.db"));
  REQUIRE(before.at("steps").size() == protocol.at("steps").size());
  double sum_s = 0;
  for (std::size_t k = 0; k < before["steps"].size(); ++k) {
    const Json& step = before["steps"][k];
    CHECK(step.at("name") == protocol["steps"][k]["name"]);
    CHECK(step.contains("estimated_s") == (step.at("kind") == "measure"));
    sum_s += step.value("estimated_s", 0.0);
  }
  CHECK(before.at("estimated_s") == sum_s);
  CHECK(sum_s > 49 * 2);  // 49 points
  const auto text = run_here({"protocol", "run", "protocol.json", "--dry-run"}, folder.path());
  CHECK_THAT(text.out, Contains("warm up to 22 degC") && Contains("25 of 25 points to measure"));
  run_here({"protocol", "run", "protocol.json", "--confirm", "nests"}, folder.path());
  const Json after = look();
  CHECK(after.at("estimated_s") == before["steps"][5].at("estimated_s"));
  CHECK(after["steps"][0].at("done_before") == true);
  CHECK(after["steps"][4].at("done_before") == false);
}

TEST_CASE("killed in each step and run again, a protocol measures what it measures undisturbed",
          "[protocol]") {
  const tests::TemporaryFolder undisturbed;
  undisturbed.write("protocol.json", whole().dump());
  const std::vector<std::string> finish = {"protocol", "run", "protocol.json", "--confirm",
                                           "nests,warm"};
  REQUIRE(run_here(finish, undisturbed.path()).exit_code == 0);
  const auto expected = measured(undisturbed.path() / "trammel.db");
  CHECK(expected.size() == 25 + 12 + 12);
  const auto tables = [](const tests::TemporaryFolder& folder) {
    return Json::parse(tests::read_text(folder.path() / "report.json")).at("tables");
  };
  const tests::TemporaryFolder each;
  each.write("protocol.json", whole().dump());
  for (const Json& step : whole().at("steps")) run_and_kill_in(each.path(), step.at("name"));
  REQUIRE(run_here(finish, each.path()).exit_code == 0);
  const auto found = measured(each.path() / "trammel.db");
  REQUIRE(found.size() == expected.size());
  for (const auto& [point, pose] : expected) {
    CAPTURE(point.first, point.second);
    CHECK(found.at(point).vector() == pose.vector());
  }
  CHECK(tables(each) == tables(undisturbed));
}
