#include "app/session/session.hpp"

#include <cmath>

#include "app/files/plan_json.hpp"
#include "app/session/lock.hpp"
#include "app/session/settings.hpp"
#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "core/plan/named.hpp"
#include "core/units.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

/// Asks to stop when so many questions have been asked.
Surroundings stopping_after(int questions, int level = 1) {
  Surroundings around;
  around.stop_signals = [questions, level, asked = 0]() mutable {
    return ++asked > questions ? level : 0;
  };
  return around;
}

}  // namespace

TEST_CASE("a session measures every point once, with the move that led to it", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const Plan plan = small_plan();
  const Outcome outcome = run(db, request_for(plan), {});
  CHECK(outcome.state == State::done);
  CHECK(outcome.exit_code() == ExitCode::ok);
  CHECK(outcome.n_stored == 16);
  const auto readings = by_point(db, "c", "s");
  REQUIRE(readings.size() == 16);
  const Mechanism mechanism = paper_mechanism();
  for (const PlannedPoint& point : plan.points) {
    const Reading& r = readings.at(point.seq);
    const Displacements cmd = inverse(mechanism.geometry, point.target).l_mm;
    CHECK(r.conditions.cmd_mm == cmd);
    for (int i = 0; i < kChains; ++i) {
      const int direction = point.approach[static_cast<std::size_t>(i)];
      if (direction != 0) {
        CHECK_THAT(r.conditions.from_mm[i], WithinAbs(cmd[i] - 5 * direction, 1e-9));
      } else if (point.seq > 1) {
        CHECK(r.conditions.from_mm[i] == readings.at(point.seq - 1).conditions.cmd_mm[i]);
      }
    }
    CHECK(std::hypot(r.measured->x_mm - point.target.x_mm, r.measured->y_mm - point.target.y_mm) <
          1);
  }
  for (int seq = 2; seq <= 16; ++seq) {
    CHECK(*readings.at(seq).conditions.time_s > *readings.at(seq - 1).conditions.time_s + 10);
    CHECK(*readings.at(seq).conditions.temp_degc > *readings.at(seq - 1).conditions.temp_degc);
  }
}

TEST_CASE("a simulated stage never measures in a real campaign", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const Request request = request_for(small_plan());
  REQUIRE(run(db, request, {}).state == State::done);
  Campaign real = store::load_campaign(db, store::require_campaign(db, "c").id).campaign;
  real.name = "real";
  real.simulated = false;
  store::add_campaign(db, real);
  Request into_real = request;
  into_real.campaign = "real";
  CHECK_THROWS_WITH(run(db, into_real, {}), Contains("the campaign is real"));
  CHECK(store::list_sessions(db, store::require_campaign(db, "real").id).empty());
}

TEST_CASE("stopped after any point and resumed, a session gives the undisturbed bits",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection whole = store::open(folder.path() / "whole.db", store::Access::create);
  REQUIRE(run(whole, request_for(small_plan()), {}).state == State::done);
  const auto expected = by_point(whole, "c", "s");
  for (const int level : {1, 2}) {
    for (const int questions : {1, 2, 5, 14, 30}) {
      INFO("stop level " << level << " after question " << questions);
      const std::string name = std::to_string(level) + "-" + std::to_string(questions) + ".db";
      store::Connection db = store::open(folder.path() / name, store::Access::create);
      const Outcome first = run(db, request_for(small_plan()), stopping_after(questions, level));
      CHECK(first.state == State::stopped);
      CHECK(first.exit_code() == ExitCode::interrupted);
      const Outcome rest = resume(db, "c", "s", {});
      CHECK(rest.state == State::done);
      CHECK(rest.n_before == first.n_stored);
      CHECK(rest.n_before + rest.n_stored == 16);
      const auto readings = by_point(db, "c", "s");
      REQUIRE(readings.size() == 16);
      for (const auto& [seq, reading] : readings) CHECK(same_bits(reading, expected.at(seq)));
    }
  }
}

TEST_CASE("a resume opens an epoch and measures reference points in a session apart", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  REQUIRE(run(db, request_for(small_plan()), stopping_after(14)).n_stored >= 3);
  REQUIRE(resume(db, "c", "s", {}).state == State::done);
  const auto visits = by_point(db, "c", "s, reference 1");
  REQUIRE(visits.size() == 3);
  const auto readings = by_point(db, "c", "s");
  for (const auto& [seq, visit] : visits) {
    CHECK(visit.target == readings.at(seq).target);
    CHECK(visit.conditions.epoch == 2);
    CHECK_FALSE(visit.measured == readings.at(seq).measured);  // a reading of its own
  }
  CHECK(readings.at(1).conditions.epoch == 1);
  CHECK(readings.at(16).conditions.epoch == 2);
}

TEST_CASE("a resume closes what a runner left open that died at a reference point", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  REQUIRE(run(db, request_for(small_plan()), stopping_after(14, 1)).state == State::stopped);
  const auto faults = std::make_shared<Faults>();
  faults->measure = [](int call) -> device::Status {
    if (call == 2) throw std::runtime_error("the runner dies");
    return device::Status::ok;
  };
  Surroundings around;
  around.open = opening(faults);
  CHECK_THROWS_AS(resume(db, "c", "s", around), std::runtime_error);
  const auto open_attempts = [&db] {
    int n = 0;
    for (const auto& session : store::session_names(db, store::require_campaign(db, "c").id)) {
      for (const auto& attempt : store::attempts(db, session.id)) n += attempt.status == "open";
    }
    return n;
  };
  CHECK(open_attempts() == 1);
  CHECK(resume(db, "c", "s", {}).state == State::done);
  CHECK(open_attempts() == 0);
}

TEST_CASE("a resume is refused when the set-up has moved", "[session]") {
  const TemporaryFolder folder;
  std::string text = read_text(kPaperRobot);
  const std::string moved =
      R"("epochs": [{}, {"frame": {"x_mm": 0.5, "y_mm": 0, "phi_deg": 0}}], "seed")";
  text.replace(text.find("\"seed\""), 6, moved);
  const auto robot = folder.write("robot.json", text);
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Request request = request_for(small_plan());
  request.stage = "sim:" + robot.string();
  REQUIRE(run(db, request, stopping_after(10)).state == State::stopped);
  const Outcome outcome = resume(db, "c", "s", {});
  CHECK(outcome.state == State::faulted);
  CHECK(outcome.exit_code() == ExitCode::safety_stop);
  CHECK_THAT(outcome.detail, Contains("the set-up has moved"));
  CHECK(outcome.n_stored == 0);
}

TEST_CASE("a resume on another robot than the session began with is refused", "[session]") {
  const TemporaryFolder folder;
  const auto robot = folder.write("robot.json", read_text(kPaperRobot));
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Request request = request_for(small_plan());
  request.stage = "sim:" + robot.string();
  REQUIRE(run(db, request, stopping_after(4)).state == State::stopped);
  folder.write("robot.json", read_text(kPaperRobot) + " ");
  CHECK_THROWS_AS(resume(db, "c", "s", {}), InputError);
}

TEST_CASE("an unsafe plan is refused before anything is stored, with all its violations",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Plan plan = small_plan();
  plan.points[3].target.x_mm = 900;
  plan.points[9].target.y_mm = std::nan("");
  const Outcome outcome = run(db, request_for(plan), {});
  CHECK(outcome.state == State::stopped);
  CHECK(outcome.exit_code() == ExitCode::safety_stop);
  REQUIRE(outcome.violations.size() >= 2);
  CHECK(outcome.violations.front().seq == 4);
  CHECK(outcome.violations.back().seq == 10);
  CHECK(store::list_campaigns(db).empty());
}

TEST_CASE("a second session goes on in time under the same set-up, unless set up anew",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const Plan plan = small_plan();
  REQUIRE(run(db, request_for(plan, "before"), {}).state == State::done);
  REQUIRE(run(db, request_for(plan, "after"), {}).state == State::done);
  const auto before = by_point(db, "c", "before"), after = by_point(db, "c", "after");
  CHECK(*after.at(1).conditions.time_s > *before.at(16).conditions.time_s + 600);
  CHECK(after.at(1).conditions.epoch == 1);  // nothing was homed in between
  CHECK_FALSE(after.at(1).measured == before.at(1).measured);
  Request again = request_for(plan, "new");
  again.new_set_up = true;
  REQUIRE(run(db, again, {}).state == State::done);
  CHECK(by_point(db, "c", "new").at(1).conditions.epoch == 2);
}

TEST_CASE("run_or_resume does a session once", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const Request request = request_for(small_plan());
  CHECK(run_or_resume(db, request, stopping_after(6)).state == State::stopped);
  CHECK(run_or_resume(db, request, {}).state == State::done);
  const Outcome third = run_or_resume(db, request, {});
  CHECK(third.state == State::done);
  CHECK(third.n_stored == 0);
  CHECK_THROWS_AS(run(db, request, {}), InputError);
}

TEST_CASE("a campaign has one runner, and its lock names the process", "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  REQUIRE(run(db, request_for(small_plan()), stopping_after(4)).state == State::stopped);
  const std::string uuid = store::require_campaign(db, "c").uuid;
  CHECK_FALSE(CampaignLock::holder(db.file(), uuid).has_value());
  {
    const CampaignLock lock(db.file(), uuid);
    CHECK(CampaignLock::holder(db.file(), uuid) == ::getpid());
    CHECK_THROWS_WITH(resume(db, "c", "s", {}), Contains(std::to_string(::getpid())));
  }
  CHECK(resume(db, "c", "s", {}).state == State::done);
}

TEST_CASE("a plan written as JSON reads back bit for bit; a wrong one names file and field",
          "[session]") {
  const TemporaryFolder folder;
  PlanRequest request{.name = "p", .groups = {{"g", circle({3, 4, 7}, 9)}}};
  request.orientations_rad = {rad_from_deg(1.7)};
  request.approaches = {Approach{1, 0, -1}};
  request.set = ReadingSet::validate;
  request.references = 2;
  const Plan plan = build_plan(request);
  const Plan back = read_plan(folder.write("plan.json", plan_json(plan).dump()));
  REQUIRE(back.points.size() == plan.points.size());
  for (std::size_t k = 0; k < plan.points.size(); ++k) {
    const PlannedPoint &a = plan.points[k], &b = back.points[k];
    CHECK(a.target.x_mm == b.target.x_mm);
    CHECK(a.target.phi_rad == b.target.phi_rad);
    CHECK((a.approach == b.approach && a.set == b.set && a.reference == b.reference &&
           a.group == b.group && a.repeat == b.repeat));
  }
  const auto bad = folder.write("bad.json", R"({"schema": "trammel/plan/1", "name": "x",
    "points": [{"seq": 1, "x_mm": 0, "y_mm": 0, "approach": [0, 2, 0]}]})");
  CHECK_THROWS_WITH(read_plan(bad), Contains("bad.json:2") && Contains("approach"));
  CHECK_THROWS_AS(plan_of("paper-81"), NotFoundError);
  CHECK(plan_of("paper-80").points.size() == 80);
}

}  // namespace trammel::session
