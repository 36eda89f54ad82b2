#include "app/session/stop_signal.hpp"

#include <atomic>
#include <csignal>

namespace trammel::session {

namespace {

std::atomic<int> signals{0};
std::atomic<int> last_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);  // a handler may touch nothing else

extern "C" void count_signal(int signal) {
  last_signal.store(signal, std::memory_order_relaxed);
  signals.fetch_add(signal == SIGINT ? 1 : 2, std::memory_order_relaxed);
}

}  // namespace

void count_stop_signals() {
  struct sigaction action {};
  action.sa_handler = &count_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  sigaction(SIGHUP, &action, &before);
  if (before.sa_handler == SIG_IGN) sigaction(SIGHUP, &before, nullptr);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, nullptr);
}

int stop_signals() { return signals.load(std::memory_order_relaxed); }

std::string stop_signal_words() {
  const int signal = last_signal.load(std::memory_order_relaxed);
  if (signal == SIGHUP) return "SIGHUP, its terminal was closed";
  return signal == SIGTERM ? "SIGTERM" : "the operator";
}

}  // namespace trammel::session
