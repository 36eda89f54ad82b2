// Thousands of points on devices that fail at random, with a runner that is stopped and dies.

#include <memory>
#include <set>

#include "core/calibrate/lsq.hpp"
#include "core/statistics/random.hpp"
#include "store/verify.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
using device::Status;

namespace {

constexpr int kPoints = 2000;

Plan long_plan() {
  PlanRequest request{.name = "long", .groups = {{"", paper_80()}}};
  request.repeats = kPoints / 80;
  return build_plan(request);
}

struct Died {};  // of what nobody catches: a life ends between two statements

/// Failures at random, a share of all calls each.
void fail_at_random(Faults& faults, Random& random) {
  const auto with = [&random](double share, std::vector<Status> what) {
    return [&random, share, what](int) {
      if (random.uniform() >= share) return Status::ok;
      return what[random.below(what.size())];
    };
  };
  faults.measure = with(0.01, {Status::beam_broken, Status::timeout, Status::unstable,
                               Status::unstable, Status::fault});
  faults.move = with(0.004, {Status::timeout, Status::timeout, Status::limit,
                             Status::following_error, Status::fault});
  faults.beam = with(0.001, {Status::beam_broken, Status::timeout});
  faults.thermometer = with(0.001, {Status::timeout});
}

/// As one epoch: every resume homes, and the virtual robot comes back to the same place.
Eigen::VectorXd identified(const std::map<int, Reading>& readings) {
  const device::Devices devices = device::open_devices("sim:" + kPaperRobot, "sim");
  std::vector<Reading> all;
  for (const auto& [seq, reading] : readings) {
    all.push_back(reading);
    all.back().seq = seq;
  }
  return identify_linear(mechanism_of(devices.machine), all, *devices.sigma,
                         {.shared_epochs = true})
      .values();
}

}  // namespace

TEST_CASE(
    "2,000 points under random faults, stops and deaths: nothing acknowledged is lost, nothing "
    "repeated, and the parameters are those of a calm run",
    "[session]") {
  const TemporaryFolder folder;
  Request request = request_for(long_plan());
  request.policy.beam_patience_s = 3;
  store::Connection calm = store::open(folder.path() / "calm.db", store::Access::create);
  REQUIRE(run(calm, request, {}).state == State::done);
  const auto expected = by_point(calm, "c", "s");

  Random random(20240973);
  const auto faults = std::make_shared<Faults>();
  fail_at_random(*faults, random);
  store::Connection db = store::open(folder.path() / "soak.db", store::Access::create);
  int acknowledged = 0, lives = 0, deaths = 0, lost = 0;
  State state = State::planned;
  std::set<State> ends;
  while (state != State::done && lives < 500) {
    Surroundings around;
    around.open = opening(faults);
    const int before = acknowledged,
              dies_after = random.below(2) == 0 ? static_cast<int>(random.below(100)) : -1;
    const int stops_after = random.below(3) == 0 ? static_cast<int>(random.below(100)) : -1;
    int here = 0;
    around.stored = [&](int n) {
      here = n;
      acknowledged = before + n;
      if (n == dies_after) throw Died{};
    };
    around.stop_signals = [&] { return stops_after >= 0 && here >= stops_after ? 1 : 0; };
    try {
      state = run_or_resume(db, request, around).state;
      ends.insert(state);
    } catch (const Died&) {
      ++deaths;
    }
    ++lives;
    const auto session = store::find_session(db, store::require_campaign(db, "c").id, "s");
    lost += session->n_ok < acknowledged ? 1 : 0;
    CHECK(session->n_ok == acknowledged);
  }
  CHECK(state == State::done);
  CHECK(lost == 0);
  CHECK(lives > 20);
  CHECK(deaths > 3);
  CHECK(ends == std::set<State>{State::stopped, State::faulted, State::done});
  CHECK(faults->calls_before_stop == 0);
  const auto readings = by_point(db, "c", "s");  // throws when a point is stored twice
  REQUIRE(readings.size() == kPoints);
  int different = 0;
  for (const auto& [seq, reading] : readings) {
    different += same_bits(reading, expected.at(seq)) ? 0 : 1;
  }
  CHECK(different == 0);
  CHECK((identified(readings) - identified(expected)).cwiseAbs().maxCoeff() == 0);
  CHECK(store::verify(db).ok());
}

}  // namespace trammel::session
