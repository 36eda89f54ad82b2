#include "app/terminal/progress.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "app/terminal/decimals.hpp"
#include "app/terminal/text.hpp"

namespace trammel::terminal {

namespace {

constexpr int kBarWidth = 24;
constexpr int kLines = 10;  // where stderr is no terminal

/// What nobody can read any more is no error: what goes on here goes on.
void talk(const std::string& text) { std::fputs(text.c_str(), stderr); }

}  // namespace

std::string clock_text(double seconds) {
  constexpr double kMostS = 3.6e9;  // a million hours; NaN compares false
  const long total = static_cast<long>((seconds > 0 ? std::min(seconds, kMostS) : 0.0) + 0.5);
  const long h = total / 3600, m = total / 60 % 60, s = total % 60;
  return h > 0 ? fmt::format("{}:{:02}:{:02} h", h, m, s) : fmt::format("{}:{:02} min", m, s);
}

Progress::Progress(bool quiet, bool terminal, int already, int total)
    : quiet_(quiet), terminal_(terminal), already_(already), done_(already), total_(total) {}

std::string Progress::time_left() const {
  const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - began_;
  return clock_text(passed.count() / (done_ - already_) * (total_ - done_));
}

void Progress::stored(double deviation_mm) {
  reached(done_ + 1, fmt::format(", last deviation {} mm", figure_text(deviation_mm)));
}

void Progress::reached(int done, const std::string& note) {
  const int before = done_;
  done_ = done;
  if (quiet_ || done == before) return;
  const std::string line = fmt::format("{}/{}, {} left{}", done_, total_, time_left(), note);
  if (terminal_) {
    const auto full = static_cast<std::size_t>(kBarWidth * done_ / total_);
    const std::string bar = std::string(full, '#') + std::string(kBarWidth - full, '.');
    talk(fmt::format("\r[{}] {}\x1b[K", bar, line));
  } else if (done_ == total_ || done_ * kLines / total_ != before * kLines / total_) {
    talk(line + "\n");
  }
}

void Progress::say(const std::string& text) {
  if (!quiet_) talk((terminal_ ? "\r\x1b[K" : "") + printable(text) + "\n");
}

void Progress::end() {
  if (!quiet_ && terminal_ && done_ > already_) talk("\n");
}

}  // namespace trammel::terminal
