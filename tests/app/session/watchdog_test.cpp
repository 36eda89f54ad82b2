// Calls that do not return.

#include "app/session/watchdog.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;

namespace {

/// What hangs until it is let go.
class Gate {
 public:
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return open_; });
    ++passed_;
    changed_.notify_all();
  }
  void open() {
    const std::lock_guard lock(mutex_);
    open_ = true;
    changed_.notify_all();
  }
  void await_passed() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return passed_ > 0; });
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool open_ = false;
  int passed_ = 0;
};

}  // namespace

TEST_CASE("a watchdog returns what is quick, throws what was thrown, gives up what hangs",
          "[session]") {
  const auto gate = std::make_shared<Gate>();
  Watchdog dog;
  int done = 0;
  CHECK(dog.run(Watchdog::Seconds(5), [&done] { done = 1; }));
  CHECK(done == 1);
  CHECK_THROWS_AS(dog.run(Watchdog::Seconds(5), [] { throw std::runtime_error("x"); }) ? 0 : 0,
                  std::runtime_error);
  CHECK(dog.run(Watchdog::Seconds(5), [&done] { done = 2; }));
  CHECK(done == 2);
  int asked = 0;
  CHECK_FALSE(dog.run(
      Watchdog::Seconds(0.05), [gate] { gate->wait(); }, [&asked] { ++asked; }));
  CHECK(asked > 0);
  CHECK_FALSE(
      dog.run(Watchdog::Seconds(5), [&done] { done = 3; }));  // no call behind one that hangs
  CHECK(done == 2);
  gate->open();
  gate->await_passed();
}

TEST_CASE(
    "whatever device hangs, the stage is stopped, the session faulted, and what is stored stays",
    "[session]") {
  enum class Which { home, move, measure, beam, thermometer };
  for (const Which which :
       {Which::home, Which::move, Which::measure, Which::beam, Which::thermometer}) {
    CAPTURE(static_cast<int>(which));
    const auto gate = std::make_shared<Gate>();
    const auto point = std::make_shared<std::atomic<int>>(1);
    const auto faults = std::make_shared<Faults>();
    const int at = which == Which::home ? 1 : 3;
    const Faults::Ask hang = [gate, point, at](int) {
      if (*point == at) gate->wait();
      return device::Status::ok;
    };
    (which == Which::home      ? faults->home
     : which == Which::move    ? faults->move
     : which == Which::measure ? faults->measure
     : which == Which::beam    ? faults->beam
                               : faults->thermometer) = hang;
    const TemporaryFolder folder;
    store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
    Surroundings around;
    around.open = opening(faults);
    around.stored = [point](int n) { *point = n + 1; };
    around.deadlines = {.home_s = 0.1, .move_s = 0.1, .measure_s = 0.1, .ask_s = 0.1, .stop_s = 5};
    around.open = [faults](const std::string& stage, const std::string& tracker) {
      device::Devices devices = opening(faults)(stage, tracker);
      devices.motion.speed_mm_s = 200;  // so that the travel adds little to the deadline
      return devices;
    };
    const Outcome outcome = run(db, request_for(small_plan()), around);
    CHECK(outcome.state == State::faulted);
    CHECK(outcome.exit_code() == ExitCode::device);
    CHECK_THAT(outcome.detail, Contains("no answer within"));
    CHECK(faults->stops >= 1);
    CHECK(outcome.n_stored == at - 1);
    gate->open();
    gate->await_passed();
    CHECK(resume(db, "c", "s", {}).state == State::done);
    CHECK(by_point(db, "c", "s").size() == 16);
  }
}

TEST_CASE("asked to stop now, a stage that is on its way is stopped there", "[session]") {
  const auto faults = std::make_shared<Faults>();
  const auto signals = std::make_shared<std::atomic<int>>(0);
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Surroundings around;
  around.open = opening(faults);
  around.stop_signals = [signals] { return signals->load(); };
  // The beam is asked again and again on a slow move: the operator stops it in the middle.
  std::atomic<int> samples = 0;
  faults->beam = [&](int) {
    if (faults->moves == 5) {
      *signals = 2;
      ++samples;
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
    }
    return device::Status::ok;
  };
  const Outcome outcome = run(db, request_for(small_plan()), around);
  CHECK(outcome.state == State::stopped);
  CHECK(outcome.exit_code() == ExitCode::interrupted);
  CHECK(samples < 5);  // of the five of a whole move
  CHECK(faults->stops >= 1);
  CHECK(resume(db, "c", "s", {}).state == State::done);
}

}  // namespace trammel::session
