// From the wish to stop to the stop on the wire, in the stage's own time: whatever moves it, and
// whatever else the program waits for.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <future>
#include <thread>

#include "app/files/plan_json.hpp"
#include "app/session/hands.hpp"
#include "tests/app/session/socket_campaign.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

namespace trammel::session {

using namespace tests;
using Clock = std::chrono::steady_clock;

namespace {

/// Rails that need 12 s to their home switches; a tracker whose link stalls when told.
struct Slow {
  SocketCampaign campaign;
  std::atomic<int> signals = 0;
  std::atomic<bool> stalls = false;

  explicit Slow(double start_mm) : campaign(two_points(), options(start_mm)) {
    campaign.around.stop_signals = [this] { return signals.load(); };
    campaign.lab.to_tracker.late_s = [this](std::string_view) { return stalls ? 2.0 : 0.0; };
  }
  static Plan two_points() {
    Plan plan = small_plan();
    plan.points.resize(2);
    return plan;
  }
  static SocketOptions options(double start_mm) {
    SocketOptions options;
    options.step_s = 0;  // the world's own time
    options.reply_timeout_s = 5;
    for (emulate::RailSetup& rail : options.rails) rail.start_mm = start_mm;
    return options;
  }

  /// Waits for the n-th line that begins so.
  void await(std::string_view line, int n = 1) const {
    const auto patience = Clock::now() + std::chrono::seconds(30);
    while (campaign.lab.log.count(line) < n && Clock::now() < patience) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  /// Seconds from `wish` to the next ST or AB; a minute where there is none.
  [[nodiscard]] double stop_after_s(Clock::time_point wish) const {
    for (const WireLog::Line& line : campaign.lab.log.lines()) {
      if (line.at < wish || line.to != emulate::Emulated::stage) continue;
      if (!line.text.starts_with("ST") && !line.text.starts_with("AB")) continue;
      return std::chrono::duration<double>(line.at - wish).count();
    }
    return 60;
  }
  /// Until the rails rest.
  [[nodiscard]] double rest_after_s(Clock::time_point wish) const {
    while (campaign.lab.robot.standing().moving) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return std::chrono::duration<double>(Clock::now() - wish).count();
  }
};

// v / a of homing (5 mm/s) and of moves (20 mm/s) at 100 mm/s^2, and a look of this test.
constexpr double kHomingRestS = kStopDelayS + 0.05 + 0.1, kMoveRestS = kStopDelayS + 0.2 + 0.1;

}  // namespace

TEST_CASE("asked to stop now while it homes, the stage is stopped", "[session][sockets]") {
  Slow slow(60);
  auto outcome = std::async(std::launch::async, [&] { return slow.campaign.run(); });
  slow.await("BGABC");
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  REQUIRE(slow.campaign.lab.robot.standing().moving);
  slow.signals = 1;  // the control: to finish the point is no stop at once
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  CHECK(slow.campaign.lab.log.count("ST") == 0);
  CHECK(slow.campaign.lab.robot.standing().moving);
  const auto wish = Clock::now();
  slow.signals = 2;
  CHECK(slow.rest_after_s(wish) < kHomingRestS);
  CHECK(slow.stop_after_s(wish) < kStopDelayS);
  const Outcome stopped = outcome.get();
  CHECK(stopped.exit_code() == ExitCode::interrupted);
  CHECK_THAT(stopped.detail, Contains("stopped by the operator"));
}

TEST_CASE("asked to stop now, a stage stops though the tracker's link stalls",
          "[session][sockets]") {
  Slow slow(0);
  auto outcome = std::async(std::launch::async, [&] { return slow.campaign.run(); });
  slow.await("BGABC", 2);  // the home switches, the first point
  slow.stalls = true;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  REQUIRE(slow.campaign.lab.robot.standing().moving);
  const auto wish = Clock::now();
  slow.signals = 2;
  CHECK(slow.rest_after_s(wish) < kMoveRestS);
  CHECK(slow.stop_after_s(wish) < kStopDelayS);
  CHECK(outcome.get().exit_code() == ExitCode::interrupted);
}

TEST_CASE("a terminal that is closed, and SIGTERM, stop the stage and are on record",
          "[session][sockets]") {
  for (const int signal : {SIGHUP, SIGTERM}) {
    CAPTURE(signal);
    Slow slow(60);
    const std::string file = (slow.campaign.folder.path() / "p.db").string();
    const std::string plan =
        slow.campaign.folder.write("plan.json", plan_json(Slow::two_points()).dump()).string();
    std::vector<std::string> words = {build_folder() + "/trammel",
                                      "session",
                                      "run",
                                      "c",
                                      "--db",
                                      file,
                                      "--session",
                                      "s",
                                      "--plan",
                                      plan,
                                      "--plan-check",
                                      slow.campaign.request.plan_check,
                                      "--stage",
                                      slow.campaign.request.stage,
                                      "--tracker",
                                      slow.campaign.request.tracker};
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
      ::close(STDOUT_FILENO);  // closed streams are nothing to die of
      ::close(STDERR_FILENO);
      ::execv(argv[0], argv.data());
      ::_exit(127);
    }
    slow.await("BGABC");
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    REQUIRE(slow.campaign.lab.robot.standing().moving);
    const auto wish = Clock::now();
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

}  // namespace trammel::session
