#include "app/session/status.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/session/wishes.hpp"
#include "store/statement.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
using device::Status;

TEST_CASE("a status counts what happened: points, failed tries by class, deviations, drift",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  const auto faults = std::make_shared<Faults>();
  faults->measure = [](int call) {
    return call == 2 || call == 3 ? Status::beam_broken : call == 6 ? Status::unstable : Status::ok;
  };
  Surroundings around;
  around.open = opening(faults);
  int stored = 0;
  around.stored = [&](int n) { stored = n; };
  around.stop_signals = [&] { return stored >= 9 ? 1 : 0; };
  REQUIRE(run(db, request_for(small_plan()), around).state == State::stopped);
  const auto campaign = store::require_campaign(db, "c");
  SessionStatus status = status_of(db, campaign, "s", std::nullopt);
  CHECK(status.simulated);
  CHECK(status.state == "stopped");
  CHECK_FALSE(status.detail.empty());
  CHECK_THROWS_WITH(run(db, request_for(small_plan()), {}), Contains("resume it"));
  CHECK(status.n_ok == 9);
  CHECK(status.n_points == 16);
  CHECK(status.retries == std::map<std::string, int>{{"beam broken", 2}, {"unstable", 1}});
  CHECK(status.last.size() == 9);
  CHECK(status.drift.empty());
  CHECK_FALSE(status.left_s);
  const auto readings = by_point(db, "c", "s");
  for (const auto& d : status.last) {
    const Reading& r = readings.at(d.point);
    CHECK(d.off.x() == r.measured->x_mm - r.target.x_mm);
    CHECK(d.off.z() == r.measured->phi_rad - r.target.phi_rad);
  }
  REQUIRE(resume(db, "c", "s", {}).state == State::done);
  status = status_of(db, campaign, "s", std::nullopt);
  CHECK(status.state == "done");
  CHECK(status.detail.empty());
  CHECK(status.epoch == 2);
  CHECK_THROWS_WITH(run(db, request_for(small_plan()), {}),
                    Contains("finished session") && !Contains("resume it"));
  REQUIRE(status.drift.size() == 3);
  for (const auto& d : status.drift) {
    CHECK(d.epoch == 2);
    CHECK(d.off.head<2>().norm() > 0);
    CHECK(d.off.head<2>().norm() < 0.1);  // the virtual robot comes back; what is left is noise
  }
  CHECK(current_session(db, campaign) == "s");
}

TEST_CASE("a runner that says nothing for too long is stalled; one that is paused is not",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Surroundings around;
  std::optional<SessionStatus> running, stalled, paused;
  const auto look = [&](double later_s) {
    const auto campaign = store::require_campaign(db, "c");
    const std::string last = status_of(db, campaign, "s", 1).last_utc;
    std::string then = last;
    // The same day is enough: minutes are added within the hour, hours within the day.
    const int minutes = std::stoi(last.substr(14, 2)) + static_cast<int>(later_s / 60);
    const int hours = std::stoi(last.substr(11, 2)) + minutes / 60;
    if (hours > 23) return std::optional<SessionStatus>{};
    then.replace(11, 5, fmt::format("{:02}:{:02}", hours, minutes % 60));
    return std::optional(status_of(db, campaign, "s", 1, then));
  };
  around.stored = [&](int n) {
    if (n == 10) {
      running = look(0);
      stalled = look(120);
      const auto id = store::find_session(db, store::require_campaign(db, "c").id, "s")->id;
      ask(db, id, Wish::pause);
    }
  };
  around.sleep = [&](double) {
    if (!paused) paused = look(120);
    ask(db, store::find_session(db, store::require_campaign(db, "c").id, "s")->id, Wish::go_on);
  };
  REQUIRE(run(db, request_for(small_plan()), around).state == State::done);
  REQUIRE(running);
  CHECK(running->state == "running");
  CHECK(running->process == 1);
  CHECK(running->detail.empty());  // what was left when it began is not what is left now
  CHECK_FALSE(running->stalled);
  REQUIRE(running->left_s);
  CHECK_THAT(*running->left_s, WithinAbs(6 * *running->seconds_per_point, 1e-9));
  if (!stalled || !paused) return;  // around midnight
  CHECK(stalled->stalled);
  CHECK(stalled->silent_s >= 60);
  CHECK_THAT(status_text(*stalled), Contains("STALLED") && Contains(" min (alarm after 1:00 min)"));
  CHECK(paused->state == "paused");
  CHECK(paused->detail == "by the operator");
  CHECK_FALSE(paused->stalled);
}

TEST_CASE("what a terminal is shown says SIMULATED large, and acts on nothing it is given",
          "[session]") {
  SessionStatus status;
  status.simulated = true;
  status.campaign = "\x1b[2Jevil";
  status.session = "s\r\n";
  status.state = "running";
  status.detail = "\x07 beep";
  status.n_points = 10;
  status.n_ok = 4;
  const std::string text = status_text(status, 72);
  CHECK_THAT(text, Contains("= SIMULATED ="));
  CHECK_THAT(text, Contains("4/10"));
  for (const char c : text) CHECK((c == '\n' || static_cast<unsigned char>(c) >= 0x20));
  status.simulated = false;
  CHECK_THAT(status_text(status), !Contains("SIMULATED"));
}

TEST_CASE("no row makes the status fail, and what it says comes from the rows that can be read",
          "[session]") {
  const TemporaryFolder folder;
  const auto file = folder.path() / "t.db";
  {
    store::Connection db = store::open(file, store::Access::create);
    REQUIRE(run(db, request_for(small_plan()), {}).state == State::done);
  }
  const auto status = [&file] {
    store::Connection db = store::open(file, store::Access::read_only);
    return status_of(db, store::require_campaign(db, "c"), "s", std::nullopt);
  };
  const SessionStatus before = status();
  // As a clock before 1970 had them written once, and as a stranger may.
  for (const char* time : {"1960-01-01T00:00:01.-254Z", "zzzz-zz-zzTzz:zz:zz.zzzZ",
                           "2026-02-30T00:00:00.000Z", "9999-12-31T23:59:59.999Z"}) {
    store::Connection raw(file, store::Access::write);
    for (const char* kind : {"note", kBaseEvent}) {
      store::Statement insert(
          raw,
          "INSERT INTO session_event (session_id, number, kind, detail, at_utc) "
          "SELECT session_id, (SELECT 1 + max(number) FROM session_event AS e "
          "WHERE e.session_id = session.session_id), ?, '{no JSON', ? FROM "
          "session WHERE name = 's'");
      insert << kind << time;
      insert.run();
    }
  }
  const SessionStatus after = status();
  CHECK(after.last_utc == before.last_utc);
  CHECK(after.started_utc == before.started_utc);
  CHECK(after.silent_s >= before.silent_s);
  CHECK(after.n_ok == 16);
  CHECK(after.base.size() == before.base.size());
}

TEST_CASE("the times of a session never go back, though the date was put back before its resume",
          "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Surroundings around;
  around.stop_signals = [n = 0]() mutable { return ++n > 14 ? 1 : 0; };
  REQUIRE(run(db, request_for(small_plan()), around).state == State::stopped);
  const auto campaign = store::require_campaign(db, "c");
  const auto session = store::find_session(db, campaign.id, "s");
  {  // what a computer wrote whose date was an hour ahead
    store::Statement ahead(db,
                           "INSERT INTO session_event (session_id, number, kind, detail, at_utc) "
                           "SELECT ?1, 1 + max(number), 'note', '', "
                           "strftime('%Y-%m-%dT%H:%M:%fZ', 'now', '+1 hour') FROM session_event "
                           "WHERE session_id = ?1");
    ahead << session->id;
    ahead.run();
  }
  const std::string ahead_utc = store::events(db, session->id).back().at_utc;
  ask(db, session->id, Wish::pause);
  REQUIRE(resume(db, "c", "s", {}).state == State::done);
  std::string last;
  const auto events = store::events(db, session->id);
  for (const store::Event& event : events) {
    CHECK(event.at_utc >= last);
    last = event.at_utc;
  }
  for (const store::Attempt& attempt : store::attempts(db, session->id)) {
    CHECK(attempt.closed_utc >= attempt.opened_utc);
    if (attempt.epoch == 2) CHECK(attempt.opened_utc >= ahead_utc);
  }
  const auto status = status_of(db, campaign, "s", std::nullopt);
  CHECK(status.seconds_per_point.value() >= 0);
}

}  // namespace trammel::session
