#include "app/session/stop_signal.hpp"

#include <atomic>
#include <csignal>

namespace trammel::session {

namespace {

std::atomic<int> signals{0};
static_assert(std::atomic<int>::is_always_lock_free);  // a handler may touch nothing else

extern "C" void count_signal(int) { signals.fetch_add(1, std::memory_order_relaxed); }

}  // namespace

void count_stop_signals() {
  struct sigaction action {};
  action.sa_handler = &count_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int stop_signals() { return signals.load(std::memory_order_relaxed); }

}  // namespace trammel::session
