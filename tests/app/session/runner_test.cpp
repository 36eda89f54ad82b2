// What the runner does when a device does not do its part. The devices are the simulated ones with
// one that fails as told in front.

#include "app/session/runner.hpp"

#include <map>
#include <memory>
#include <utility>

#include "app/device/open.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
using device::Status;

namespace {

/// The status by the number of the call.
Faults::Ask at(std::map<int, Status> script) {
  return [script = std::move(script)](int call) {
    const auto told = script.find(call);
    return told == script.end() ? Status::ok : told->second;
  };
}

/// One session of the small plan, walked with failing devices.
struct Bench {
  TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  device::Devices devices = device::open_devices("sim:" + kPaperRobot, "sim");
  Course course;
  std::shared_ptr<Faults> faults = std::make_shared<Faults>();

  Bench() {
    Campaign campaign;
    campaign.name = "c";
    campaign.simulated = true;
    campaign.machine = machine_of(devices.mechanism);
    store::add_campaign(db, campaign);
    course.campaign = store::require_campaign(db, "c");
    course.plan = small_plan();
    course.planned_mm = planned_commands(course.plan, devices.mechanism, NominalCorrection{});
    store::NewSession session;
    session.campaign_id = course.campaign.id;
    session.name = "s";
    session.plan_name = course.plan.name;
    for (const PlannedPoint& p : course.plan.points) {
      session.points.push_back({.seq = p.seq,
                                .set = p.set,
                                .target = p.target,
                                .approach = p.approach,
                                .repeat = p.repeat,
                                .reference = p.reference,
                                .role = p.group,
                                .planned_mm = course.planned_mm[0]});
    }
    course.session = store::get_session(db, store::create_session(db, session));
    devices.clock->start(course.plan, 0);
  }

  Outcome walk() {
    const auto failing = std::make_shared<device::Devices>(with_faults(std::move(devices), faults));
    return Runner(db, failing, course, surroundings).walk(false, true);
  }

  int attempts_of(int seq, const std::string& status) {
    int n = 0;
    for (const store::Attempt& a : store::attempts(db, course.session.id)) {
      n += a.point_seq == seq && a.status == status ? 1 : 0;
    }
    return n;
  }

  Surroundings surroundings;
};

}  // namespace

TEST_CASE("a lost beam is tried again, stored as failed, and the readings are the same bits",
          "[session]") {
  Bench calm;
  REQUIRE(calm.walk().state == State::done);
  const auto expected = by_point(calm.db, "c", "s");
  Bench bench;
  bench.faults->measure = at({{1, Status::beam_broken},
                              {5, Status::timeout},
                              {6, Status::unstable},
                              {13, Status::beam_broken}});
  CHECK(bench.walk().state == State::done);
  CHECK(bench.attempts_of(1, "failed") == 1);
  CHECK(bench.attempts_of(4, "failed") == 2);
  CHECK(bench.attempts_of(10, "failed") == 1);
  const auto readings = by_point(bench.db, "c", "s");
  REQUIRE(readings.size() == 16);
  for (const auto& [seq, reading] : readings) {
    INFO("point " << seq);
    CHECK(same_bits(reading, expected.at(seq)));
  }
}

TEST_CASE("a beam that stays lost ends the session after three tries", "[session]") {
  Bench bench;
  bench.faults->measure =
      at({{3, Status::beam_broken}, {4, Status::beam_broken}, {5, Status::beam_broken}});
  const Outcome outcome = bench.walk();
  CHECK(outcome.state == State::faulted);
  CHECK(outcome.exit_code() == ExitCode::device);
  CHECK(outcome.n_stored == 2);
  CHECK(bench.attempts_of(3, "failed") == 3);
  CHECK_THAT(outcome.detail, Contains("point 3") && Contains("beam broken"));
  CHECK(by_point(bench.db, "c", "s").size() == 2);  // no invalid reading is stored
}

TEST_CASE("a limit, following error or fault is never tried again, and the stage is stopped",
          "[session]") {
  for (const Status status : {Status::limit, Status::following_error, Status::fault}) {
    Bench bench;
    bench.faults->move = at({{4, status}});
    const Outcome outcome = bench.walk();
    CHECK(outcome.state == State::faulted);
    CHECK(outcome.n_stored == 3);
    CHECK(bench.attempts_of(4, "failed") == 1);
    CHECK(bench.faults->stops == 1);
    CHECK(bench.faults->calls_before_stop == 0);
    CHECK(store::get_session(bench.db, bench.course.session.id).last_event == "faulted");
  }
}

TEST_CASE("a command far from what was checked is not sent", "[session]") {
  Bench bench;
  bench.course.planned_mm[6][1] += 1.5;
  const Outcome outcome = bench.walk();
  CHECK(outcome.state == State::faulted);
  CHECK(outcome.n_stored == 6);
  CHECK_THAT(outcome.detail, Contains("point 7"));
}

}  // namespace trammel::session
