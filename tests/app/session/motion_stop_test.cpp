// From the wish to stop to the stop on the wire, in the stage's own time: whatever moves it, and
// whatever else the program waits for.

#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <future>
#include <thread>

#include "app/session/hands.hpp"
#include "tests/app/session/slow_campaign.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

// v / a of homing (5 mm/s) and of moves (20 mm/s) at 100 mm/s^2, and a look of this test.
constexpr double kHomingRestS = kStopDelayS + 0.05 + 0.1, kMoveRestS = kStopDelayS + 0.2 + 0.1;

}  // namespace

TEST_CASE("asked to stop now while it homes, the stage is stopped", "[session][sockets]") {
  SlowCampaign slow(60);
  auto outcome = std::async(std::launch::async, [&] { return slow.run(); });
  slow.await("BGABC");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  REQUIRE(slow.lab.robot.standing().moving);
  slow.signals = 1;  // the control: to finish the point is no stop at once
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  CHECK(slow.lab.log.count("ST") == 0);
  CHECK(slow.lab.robot.standing().moving);
  const auto wish = SlowCampaign::Clock::now();
  slow.signals = 2;
  CHECK(slow.rest_after_s(wish) < kHomingRestS);
  CHECK(slow.stop_after_s(wish) < kStopDelayS);
  const Outcome stopped = outcome.get();
  CHECK(stopped.exit_code() == ExitCode::interrupted);
  CHECK_THAT(stopped.detail, Contains("stopped by the operator"));
}

TEST_CASE("asked to stop now, a stage stops though a link stalls, the tracker's or its own",
          "[session][sockets]") {
  struct Case {
    const char* name;
    double start_mm;
    int begins;  // 1: the home switches, 2: the first point
    std::atomic<bool> SlowCampaign::*stalls;
  };
  for (const Case& c : {Case{"moving, the tracker's", 0, 2, &SlowCampaign::stalls},
                        {"moving, the stage's", 0, 2, &SlowCampaign::stage_stalls},
                        {"homing, the stage's", 60, 1, &SlowCampaign::stage_stalls}}) {
    CAPTURE(c.name);
    SlowCampaign slow(c.start_mm);
    auto outcome = std::async(std::launch::async, [&] { return slow.run(); });
    slow.await("BGABC", c.begins);
    slow.*c.stalls = true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    REQUIRE(slow.lab.robot.standing().moving);
    const auto wish = SlowCampaign::Clock::now();
    slow.signals = 2;
    CHECK(slow.rest_after_s(wish) < (c.begins == 1 ? kHomingRestS : kMoveRestS));
    CHECK(slow.stop_after_s(wish) < kStopDelayS);
    slow.*c.stalls = false;
    CHECK(outcome.get().exit_code() == ExitCode::interrupted);
  }
}

TEST_CASE("a terminal that is closed, and SIGTERM, stop the stage and are on record",
          "[session][sockets]") {
  for (const int signal : {SIGHUP, SIGTERM}) {
    CAPTURE(signal);
    SlowCampaign slow(60);
    const std::string file = slow.file();
    const pid_t child = slow.program_homes();
    REQUIRE(slow.lab.robot.standing().moving);
    const auto wish = SlowCampaign::Clock::now();
    ::kill(child, signal);
    CHECK(slow.rest_after_s(wish) < kHomingRestS);
    CHECK(slow.stop_after_s(wish) < kStopDelayS);
    int status = 0;
    ::waitpid(child, &status, 0);
    REQUIRE(WIFEXITED(status));
    store::Connection db = store::open(file, store::Access::read_only);
    const auto session = store::find_session(db, store::require_campaign(db, "c").id, "s");
    CHECK(session->last_event == "stopped");
    const auto events = store::events(db, session->id);
    CHECK_THAT(events.back().detail, Contains(signal == SIGHUP ? "SIGHUP" : "SIGTERM"));
  }
}

TEST_CASE("a program that is killed leaves rails that the controller stops, where it watches",
          "[session][sockets]") {
  constexpr double kWatchS = 0.5;
  for (const int signal : {SIGKILL, SIGSTOP}) {
    CAPTURE(signal);
    SlowCampaign watched(60, kWatchS);
    const pid_t child = watched.program_homes();
    REQUIRE(watched.lab.robot.standing().moving);
    const auto killed = SlowCampaign::Clock::now();
    ::kill(child, signal);
    CHECK(watched.rest_after_s(killed) < kWatchS + 0.05 + 0.1);  // v / a, and a look of this test
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    CHECK(Client(watched.lab.stage_server.port()).number("MG _MOA") == 1);
    ::kill(child, SIGCONT);  // one that was only held learns what has happened meanwhile
    int status = 0;
    ::waitpid(child, &status, 0);
    if (signal == SIGKILL) continue;
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 7);
    store::Connection db = store::open(watched.file(), store::Access::read_only);
    const auto session = store::find_session(db, store::require_campaign(db, "c").id, "s");
    CHECK_THAT(store::events(db, session->id).back().detail, Contains("has not heard from"));
  }
  SlowCampaign alone(60);  // the control: nobody stops them
  const pid_t child = alone.program_homes();
  ::kill(child, SIGKILL);
  int status = 0;
  ::waitpid(child, &status, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(900));  // more than the watched ones need
  CHECK(alone.lab.robot.standing().moving);
}

}  // namespace trammel::session
