// Sessions that wait: for the temperature, for reference points, for the operator.

#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

#include "app/session/wishes.hpp"

namespace trammel::session {

using namespace tests;

namespace {

struct Room {
  TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  std::shared_ptr<Faults> faults = std::make_shared<Faults>();
  Surroundings around;
  Request request = request_for(small_plan());
  int stored = 0;

  Room() {
    around.open = opening(faults);
    around.stored = [this](int n) { stored = n; };
  }
  std::vector<std::string> told(const std::string& kind) {
    std::vector<std::string> details;
    const auto id = store::find_session(db, store::require_campaign(db, "c").id, "s")->id;
    for (const auto& e : store::events(db, id)) {
      if (e.kind == kind) details.push_back(e.detail);
    }
    return details;
  }
  int references() {
    int n = 0;
    for (const auto& s : store::list_sessions(db, store::require_campaign(db, "c").id)) {
      n += s.plan_name == "reference points" ? 1 : 0;
    }
    return n;
  }
};

}  // namespace

TEST_CASE("out of its temperature band a session is suspended, and goes on only well inside",
          "[session]") {
  Room room;
  room.request.policy.high_degc = 25;
  room.request.policy.hysteresis_k = 0.5;
  std::vector<double> seen;
  double now_degc = 20;
  room.faults->temperature = [&](device::TemperatureReport& r, int) {
    if (room.stored == 3 && now_degc == 20)
      now_degc = 25.4;
    else if (now_degc > 24.3)
      now_degc -= 0.2;  // 25.2, 25.0, 24.8, 24.6, 24.4
    r.temp_degc = now_degc;
    seen.push_back(now_degc);
  };
  CHECK(run(room.db, room.request, room.around).state == State::done);
  const auto paused = room.told("paused"), resumed = room.told("resumed");
  REQUIRE(paused.size() == 1);
  CHECK_THAT(paused[0], Contains("25.40 degC"));
  CHECK(resumed.size() == 1);
  for (const auto& [seq, reading] : by_point(room.db, "c", "s")) {
    CHECK(*reading.conditions.temp_degc <= (seq > 3 ? 24.5 : 25));  // never between: hysteresis
  }
  CHECK(by_point(room.db, "c", "s").size() == 16);
}

TEST_CASE("bad conditions that stay bad end the session after its patience, to be resumed",
          "[session]") {
  Room room;
  room.request.policy.low_degc = 18;
  room.request.policy.patience_s = 300;
  room.faults->temperature = [&](device::TemperatureReport& r, int) {
    r.temp_degc = room.stored >= 5 ? 15 : 20;
  };
  const Outcome outcome = run(room.db, room.request, room.around);
  CHECK(outcome.state == State::stopped);
  CHECK(outcome.n_stored == 5);
  CHECK_THAT(outcome.detail, Contains("15.00 degC"));
  room.faults->temperature = {};
  CHECK(resume(room.db, "c", "s", room.around).state == State::done);
}

TEST_CASE("reference points are visited every so many points; one that drifts suspends the session",
          "[session]") {
  Room calm;
  calm.request.policy.reference_every = 5;
  REQUIRE(run(calm.db, calm.request, calm.around).state == State::done);
  CHECK(calm.references() == 3);
  CHECK(calm.told("paused").empty());
  Room plain;
  REQUIRE(run(plain.db, plain.request, plain.around).state == State::done);
  const auto expected = by_point(plain.db, "c", "s");
  for (const auto& [seq, reading] : by_point(calm.db, "c", "s")) {
    CHECK(same_bits(reading, expected.at(seq)));  // visits change nothing of what comes after
  }

  Room drifting;
  drifting.request.policy.reference_every = 5;
  double off_mm = 0.3;
  drifting.faults->pose = [&](device::PoseReport& r, int) {
    if (drifting.stored != 10) return;  // the second visits
    r.pose.x_mm += off_mm;
    off_mm *= 0.8;  // comes back; good again within half of the tolerance
  };
  CHECK(run(drifting.db, drifting.request, drifting.around).state == State::done);
  REQUIRE(drifting.told("paused").size() == 1);
  CHECK_THAT(drifting.told("paused")[0], Contains("was measured again"));
  CHECK(drifting.told("resumed").size() == 1);
  CHECK(drifting.references() > 4);
}

TEST_CASE("paused through the database, a runner waits, and goes on in a new epoch or stops",
          "[session]") {
  for (const Wish then : {Wish::go_on, Wish::stop}) {
    Room room;
    const auto session = [&] {
      return store::find_session(room.db, store::require_campaign(room.db, "c").id, "s")->id;
    };
    store::Connection other = store::open(room.folder.path() / "t.db", store::Access::write);
    room.around.stored = [&](int n) {
      if (n == 7) ask(other, session(), Wish::pause);
    };
    int slept = 0;
    room.around.sleep = [&](double) {
      CHECK(store::get_session(room.db, session()).last_event == "paused");
      if (++slept == 3) ask(other, session(), then);
    };
    const Outcome outcome = run(room.db, room.request, room.around);
    CHECK(slept >= 3);
    CHECK(outcome.state == (then == Wish::stop ? State::stopped : State::done));
    CHECK(outcome.n_stored == (then == Wish::stop ? 7 : 16));
    const auto readings = by_point(room.db, "c", "s");
    CHECK(readings.at(7).conditions.epoch == 1);
    if (then == Wish::go_on) CHECK(readings.at(8).conditions.epoch == 2);
    CHECK(room.faults->homes == 1);  // it was homed all the time
  }
}

TEST_CASE("what was asked of a runner that is gone asks nothing of the next", "[session]") {
  Room room;
  room.around.stop_signals = [&] { return room.stored >= 4 ? 1 : 0; };
  REQUIRE(run(room.db, room.request, room.around).state == State::stopped);
  const auto id = store::find_session(room.db, store::require_campaign(room.db, "c").id, "s")->id;
  ask(room.db, id, Wish::stop_now);
  ask(room.db, id, Wish::pause);
  CHECK(store::get_session(room.db, id).last_event == "stopped");
  CHECK(resume(room.db, "c", "s", {}).state == State::done);
}

TEST_CASE("a policy that cannot be held to is refused with its name", "[session]") {
  for (const auto& [field, spoil] : std::map<std::string, std::function<void(Policy&)>>{
           {"gate_mm", [](Policy& p) { p.gate_mm = 0; }},
           {"drift_mm", [](Policy& p) { p.drift_mm = std::nan(""); }},
           {"reference_every", [](Policy& p) { p.reference_every = -1; }},
           {"temperature", [](Policy& p) { p.low_degc = 20, p.high_degc = 20.5; }}}) {
    Room room;
    spoil(room.request.policy);
    CHECK_THROWS_WITH(run(room.db, room.request, room.around), Contains(field));
    CHECK(store::list_campaigns(room.db).empty());
  }
}

}  // namespace trammel::session
