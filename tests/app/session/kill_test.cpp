// The real program, killed from outside at random times.

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "app/files/plan_json.hpp"
#include "core/statistics/random.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

namespace trammel::tests {

namespace {

constexpr int kKilled = -1;

pid_t start(const std::vector<std::string>& words) {
  std::vector<char*> argv;
  const std::string program = tests::build_folder() + "/trammel";
  argv.push_back(const_cast<char*>(program.c_str()));
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::execv(program.c_str(), argv.data());
    ::_exit(127);
  }
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kKilled;
}

/// Exit code, or kKilled.
int run_and_kill_after(const std::vector<std::string>& words, double seconds) {
  const pid_t child = start(words);
  std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
  ::kill(child, SIGKILL);
  return wait_for(child);
}

/// The same, killed once `log` holds `n_lines`: lines, not seconds, are as many on any machine.
int run_and_kill_at(const std::vector<std::string>& words, const WireLog& log,
                    std::size_t n_lines) {
  const pid_t child = start(words);
  int status = 0;
  while (log.size() < n_lines) {
    if (::waitpid(child, &status, WNOHANG) == child) {
      return WIFEXITED(status) ? WEXITSTATUS(status) : kKilled;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  ::kill(child, SIGKILL);
  return wait_for(child);
}

bool has_session(const std::string& file, const std::string& name = "paper-80") {
  if (!std::filesystem::exists(file)) return false;
  try {
    store::Connection db = store::open(file, store::Access::read_only);
    const auto campaign = store::find_campaign(db, "c");
    return campaign && store::find_session(db, campaign->id, name);
  } catch (const Error&) {
    return false;  // killed while the file was being made
  }
}

std::vector<std::string> words_for(const std::string& file) {
  if (has_session(file)) return {"session", "resume", "c", "--db", file, "--session", "paper-80"};
  return {"session",           "run", "c", "--db", file, "--plan", "paper-80", "--stage",
          "sim:" + kPaperRobot};
}

}  // namespace

TEST_CASE("killed at random times and resumed, a campaign has the bits of an undisturbed one",
          "[session][release]") {
  const TemporaryFolder folder;
  const std::string whole = (folder.path() / "whole.db").string();
  const auto began = std::chrono::steady_clock::now();
  REQUIRE(wait_for(start(words_for(whole))) == 0);
  const std::chrono::duration<double> takes = std::chrono::steady_clock::now() - began;
  store::Connection undisturbed = store::open(whole, store::Access::read_only);
  const auto expected = by_point(undisturbed, "c", "paper-80");
  REQUIRE(expected.size() == 80);

  // A machine that has become faster since `takes` was measured needs more campaigns.
  constexpr int kCampaigns = 3, kKills = 6;
  Random random(20240973);
  int kills = 0;
  for (int n = 0; n < kCampaigns || kills < kKills; ++n) {
    REQUIRE(n < 20);
    const std::string file = (folder.path() / (std::to_string(n) + ".db")).string();
    int code = kKilled;
    for (int tries = 0; code != 0 && tries < 100; ++tries) {
      // The last tries are left alone, so that a slow machine also gets to the end.
      const double patience = tries < 20 ? random.uniform(0, 0.4) * takes.count() : 60.0;
      code = tries < 20 ? run_and_kill_after(words_for(file), patience)
                        : wait_for(start(words_for(file)));
      kills += code == kKilled ? 1 : 0;
      REQUIRE((code == 0 || code == kKilled));
    }
    store::Connection db = store::open(file, store::Access::read_only);
    const auto readings = by_point(db, "c", "paper-80");  // throws when a point is stored twice
    REQUIRE(readings.size() == 80);
    for (const auto& [seq, reading] : readings) {
      INFO("campaign " << n << ", point " << seq);
      CHECK(same_bits(reading, expected.at(seq)));
    }
  }
}

TEST_CASE(
    "killed at random lines on the wire the program leaves an emulated stage that comes to rest, "
    "and resumes to the readings of an undisturbed run",
    "[session][sockets][release]") {
  const Plan plan = small_plan();
  SocketCampaign calm(plan);
  REQUIRE(calm.run().state == session::State::done);
  const std::size_t lines_of_all = calm.lab.log.size();
  const auto expected = by_point(calm.db, "c", "s");

  SocketCampaign lab(plan);
  const std::string file = (lab.folder.path() / "killed.db").string();
  const std::string plan_file = lab.folder.write("plan.json", plan_json(plan).dump()).string();
  const std::vector<std::string> run = {"session",
                                        "run",
                                        "c",
                                        "--db",
                                        file,
                                        "--session",
                                        "s",
                                        "--plan",
                                        plan_file,
                                        "--plan-check",
                                        lab.request.plan_check,
                                        "--stage",
                                        lab.request.stage,
                                        "--tracker",
                                        lab.request.tracker};
  const std::vector<std::string> resume = {"session", "resume",    "c", "--db",
                                           file,      "--session", "s"};
  Random random(20240973);
  int kills = 0, code = kKilled;
  for (int tries = 0; code != 0; ++tries) {
    REQUIRE(tries < 60);
    const auto words = has_session(file, "s") ? resume : run;
    const WireLog& log = lab.lab.log;
    code = tries < 20 ? run_and_kill_at(words, log, log.size() + random.below(lines_of_all / 3))
                      : wait_for(start(words));
    REQUIRE((code == 0 || code == kKilled));
    kills += code == kKilled ? 1 : 0;
    int looks = 0;  // each look lets a moment pass there
    while (lab.lab.robot.standing().moving) REQUIRE(++looks < 100'000);
  }
  CHECK(kills >= 3);
  store::Connection db = store::open(file, store::Access::read_only);
  const auto readings = by_point(db, "c", "s");  // throws when a point is stored twice
  REQUIRE(readings.size() == plan.points.size());
  for (const auto& [seq, reading] : readings) {
    CAPTURE(seq);
    const Reading& calm_one = expected.at(seq);
    CHECK(reading.conditions.cmd_mm == calm_one.conditions.cmd_mm);
    CHECK(reading.conditions.from_mm == calm_one.conditions.from_mm);
    const Eigen::Vector3d off = reading.measured->vector() - calm_one.measured->vector();
    CHECK(std::hypot(off[0], off[1]) < 2 * kSeenMm);
    CHECK(std::abs(off[2]) < 2 * kSeenRad);
  }
}

TEST_CASE("Ctrl-C once finishes the point, and the session can be resumed", "[session]") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "t.db").string();
  const pid_t child = start(words_for(file));
  while (!has_session(file)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  ::kill(child, SIGINT);
  const int code = wait_for(child);
  REQUIRE((code == 130 || code == 0));  // 0: it was done before the signal came
  {
    store::Connection db = store::open(file, store::Access::read_only);
    const auto campaign = store::require_campaign(db, "c");
    const auto session = store::find_session(db, campaign.id, "paper-80");
    CHECK(session->last_event == (code == 130 ? "stopped" : "done"));
    for (const store::Attempt& a : store::attempts(db, session->id)) CHECK(a.status == "ok");
  }
  CHECK(wait_for(start(words_for(file))) == 0);
}

}  // namespace trammel::tests
