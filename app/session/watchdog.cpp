#include "app/session/watchdog.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <utility>

#include "app/device/tcp.hpp"

namespace trammel::session {

struct Watchdog::Shared {
  std::mutex mutex;
  std::condition_variable changed;
  std::function<void()> call;  // taken when it is empty again
  bool busy = false;
  bool hangs = false;
  bool ends = false;
  std::exception_ptr thrown;

  void work() {
    std::unique_lock lock(mutex);
    for (;;) {
      changed.wait(lock, [this] { return call || ends; });
      if (!call) return;
      std::function<void()> mine = std::exchange(call, nullptr);
      lock.unlock();
      std::exception_ptr error;
      try {
        mine();
      } catch (...) {
        error = std::current_exception();
      }
      mine = nullptr;  // what it held goes before it counts as returned
      lock.lock();
      thrown = error;
      busy = false;
      changed.notify_all();
    }
  }
};

Watchdog::Watchdog()
    : shared_(std::make_shared<Shared>()), thread_([shared = shared_] { shared->work(); }) {}

Watchdog::~Watchdog() {
  bool hangs = false;
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->ends = true;
    shared_->changed.notify_all();
    hangs = shared_->hangs;
  }
  hangs ? thread_.detach() : thread_.join();
}

bool Watchdog::run(Seconds deadline, std::function<void()> call,
                   const std::function<void()>& meanwhile) {
  using Clock = std::chrono::steady_clock;
  const auto end = device::in_s(deadline.count());
  const auto tick = std::chrono::duration_cast<Clock::duration>(kTick);
  std::unique_lock lock(shared_->mutex);
  if (shared_->hangs) return false;
  shared_->call = std::move(call);
  shared_->busy = true;
  shared_->changed.notify_all();
  const auto returned = [this] { return !shared_->busy; };
  while (!shared_->changed.wait_until(lock, std::min(end, Clock::now() + tick), returned)) {
    if (Clock::now() >= end) {
      shared_->hangs = true;
      shared_->ends = true;  // the thread ends when the call does, if ever
      return false;
    }
    if (!meanwhile) continue;
    lock.unlock();
    meanwhile();
    lock.lock();
  }
  if (const std::exception_ptr error = std::exchange(shared_->thrown, nullptr)) {
    std::rethrow_exception(error);
  }
  return true;
}

}  // namespace trammel::session
