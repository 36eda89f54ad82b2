// Stages of one and two axes over sockets: the emulated controller with as many motors, the
// tracker, the runner, a database on disk, and a report at the end.

#include <signal.h>
#include <sys/wait.h>

#include <future>

#include "app/session/hands.hpp"
#include "tests/app/session/slow_campaign.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"

namespace trammel::session {

using namespace tests;
using emulate::Emulated;
using emulate::FaultKind;

namespace {

/// With lash and leads that a tracker of 10 um can see.
simulate::Truth axes(const char* kind) {
  simulate::Truth truth;
  truth.nominal = starting_machine(kind);
  truth.actual = truth.nominal.chains;
  for (int i = 0; i < truth.nominal.kind->n_chains; ++i) {
    truth.drive.lead_scale[i] = 1e-3;
    truth.drive.backlash_mm[i] = 0.15;
  }
  truth.tracker.sigma_xy_mm = 0.01;
  truth.tracker.sigma_phi_rad = rad_from_deg(0.01);
  truth.motion = {20, 1, 1};
  truth.seed = 12;
  return truth;
}

/// 5 places along each axis, reached from both sides.
Plan runs_on(const Machine& machine) {
  PlanRequest request{.name = "runs", .groups = {{"", {}}}};
  for (const double x : {-80.0, -43.0, 0.0, 37.0, 80.0}) {
    for (const double y : {-52.0, 61.0}) request.groups[0].poses.push_back({x, y, 0});
  }
  request.approaches = {Approach{1, 1, 0}, Approach{-1, -1, 0}};
  return plan_on(machine, build_plan(request));
}

}  // namespace

TEST_CASE("a campaign on a stage of one or two axes goes through the sockets to a report",
          "[session][sockets]") {
  for (const char* kind : {"XY", "X"}) {
    CAPTURE(kind);
    const simulate::Truth truth = axes(kind);
    SocketCampaign campaign(runs_on(truth.nominal), {.truth = truth});
    const Outcome outcome = campaign.run();
    INFO(outcome.detail);
    REQUIRE(outcome.state == State::done);
    const auto problems = campaign.problems();
    CAPTURE(problems);
    CHECK(problems.empty());
    CHECK(campaign.lab.log.count(kind == std::string("X") ? "BGA\r" : "BGAB\r") > 10);
    CHECK(campaign.lab.log.count("SHC") == 0);
    const std::vector<std::string> db = {"--db", (campaign.folder.path() / "t.db").string()};
    const auto run = [&](std::vector<std::string> words) {
      words.insert(words.end(), db.begin(), db.end());
      const Finished done = run_here(words);
      INFO(done.err);
      CHECK(done.exit_code == 0);
      return done.out;
    };
    const std::string fit = run({"calibrate", "geometry", "c", "--effects", "backlash,lead_scale"});
    CHECK_THAT(fit, Contains("backlash") && Contains("lead_scale"));
    CHECK_THAT(run({"diagnose", "c"}), Contains("lead_scale") && !Contains("rail"));
    const std::string report = run({"report", "c"});
    CHECK_THAT(report, Contains(std::string(kind) + ": screw lead 10 mm") && !Contains("rail"));
  }
}

TEST_CASE("faults of a stage of one or two axes are tried again or end the session by name",
          "[session][sockets]") {
  struct Case {
    Emulated where;
    emulate::Fault fault;
    bool ends;
    const char* says;
  };
  for (const char* kind : {"XY", "X"}) {
    const simulate::Truth truth = axes(kind);
    Plan plan = runs_on(truth.nominal);
    plan.points.resize(3);
    for (const Case& c :
         {Case{Emulated::stage, {FaultKind::lost_reply, 1, "BGA"}, false, "timeout"},
          {Emulated::stage, {FaultKind::half_reply, 1, "TEA"}, false, "timeout"},
          {Emulated::stage, {FaultKind::limit_hit}, true, "x axis ran into its"},
          {Emulated::stage, {FaultKind::amplifier_fault}, true, "x axis has an amplifier fault"},
          {Emulated::stage, {FaultKind::stall}, true, "x axis is"},
          {Emulated::tracker, {FaultKind::beam_lost, 2, ""}, false, "beam broken"},
          {Emulated::tracker, {FaultKind::unstable, 3, ""}, false, "unstable"}}) {
      CAPTURE(kind, c.says);
      SocketCampaign campaign(plan, {.truth = truth});
      campaign.arm(2, c.where, c.fault);
      const Outcome outcome = campaign.run();
      INFO(outcome.detail);
      REQUIRE(campaign.struck() == 1);
      std::string failed;
      for (const store::Attempt& a : campaign.attempts()) {
        if (a.status == "failed") failed += a.detail;
      }
      CHECK_THAT(failed, Contains(c.says) && !Contains("rail"));
      CHECK(outcome.state == (c.ends ? State::faulted : State::done));
      if (c.ends) {
        campaign.free_rails();
        CHECK(campaign.run().state == State::done);
      }
      CHECK(campaign.problems().empty());
    }
  }
}

TEST_CASE("asked to stop now, or killed, a stage of one or two axes comes to rest",
          "[session][sockets]") {
  constexpr double kWatchS = 0.5, kLookS = 0.1, kHomingRestS = 0.05;
  for (const char* kind : {"XY", "X"}) {
    CAPTURE(kind);
    {
      SlowCampaign slow(60, 0, axes(kind));
      auto outcome = std::async(std::launch::async, [&] { return slow.run(); });
      slow.await(slow.begins());
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      REQUIRE(slow.lab.robot.standing().moving);
      const auto wish = SlowCampaign::Clock::now();
      slow.signals = 2;
      CHECK(slow.rest_after_s(wish) < kStopDelayS + kHomingRestS + kLookS);
      CHECK(outcome.get().exit_code() == ExitCode::interrupted);
    }
    SlowCampaign watched(60, kWatchS, axes(kind));
    const pid_t child = watched.program_homes();
    REQUIRE(watched.lab.robot.standing().moving);
    const auto killed = SlowCampaign::Clock::now();
    ::kill(child, SIGKILL);
    CHECK(watched.rest_after_s(killed) < kWatchS + kHomingRestS + kLookS);
    int status = 0;
    ::waitpid(child, &status, 0);
    SlowCampaign alone(60, 0, axes(kind));  // the control: nobody stops it
    const pid_t other = alone.program_homes();
    ::kill(other, SIGKILL);
    ::waitpid(other, &status, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(900));
    CHECK(alone.lab.robot.standing().moving);
  }
}

}  // namespace trammel::session
