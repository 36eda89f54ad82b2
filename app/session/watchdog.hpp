#pragma once
// A call that may never return, and someone who notices.

#include <chrono>
#include <functional>
#include <memory>
#include <thread>

namespace trammel::session {

/// Makes calls on a thread of its own, one at a time, and waits for each no longer than told.
///
/// A call that has not returned in time keeps the thread for good: what it uses must be its own
/// (capture shared pointers, by value). After that the watchdog takes no more calls.
/// Proof: watchdog_test.cpp.
class Watchdog {
 public:
  Watchdog();
  ~Watchdog();
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;

  using Seconds = std::chrono::duration<double>;
  /// How often `meanwhile` is asked while a call is waited for.
  static constexpr Seconds kTick{0.02};

  /// False: `call` has not returned within `deadline`, or one before it never did. `meanwhile` runs
  /// on the caller's thread. What `call` throws is thrown here.
  [[nodiscard]] bool run(Seconds deadline, std::function<void()> call,
                         const std::function<void()>& meanwhile = {});

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace trammel::session
