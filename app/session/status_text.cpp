// A session's status for a terminal.

#include <fmt/format.h>

#include <algorithm>

#include "app/files/numbers.hpp"
#include "app/session/status.hpp"
#include "app/terminal/progress.hpp"
#include "app/terminal/text.hpp"
#include "core/units.hpp"

namespace trammel::session {

namespace {

constexpr std::size_t kShown = 5;  // deviations and drifts

std::string rule(int width, const std::string& word) {
  const auto left =
      static_cast<std::size_t>(std::max(2, (width - static_cast<int>(word.size()) - 2) / 2));
  return std::string(left, '=') + " " + word + " " + std::string(left, '=') + "\n";
}

std::string bar(const SessionStatus& s, int width) {
  const int room = std::clamp(width - 30, 10, 60);
  const int full = s.n_points > 0 ? room * s.n_ok / s.n_points : 0;
  return "[" + std::string(static_cast<std::size_t>(full), '#') +
         std::string(static_cast<std::size_t>(room - full), '.') + "]";
}

std::string times(const SessionStatus& s) {
  std::string text;
  if (s.left_s) text += ", " + terminal::clock_text(*s.left_s) + " left";
  if (s.seconds_per_point) text += fmt::format(", {:.3g} s a point", *s.seconds_per_point);
  return text;
}

std::string retries(const SessionStatus& s) {
  std::string text;
  for (const auto& [what, n] : s.retries)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, what);
  if (s.n_interrupted > 0)
    text += fmt::format("{}{} interrupted", text.empty() ? "" : ", ", s.n_interrupted);
  return "failed tries: " + (text.empty() ? "none" : text) + "\n";
}

std::string base_nests(const SessionStatus& s) {
  if (s.base.empty()) return "";
  std::string text = "base nests           moved mm     chance       gate  nest\n";
  for (std::size_t k = s.base.size() - std::min(s.base.size(), kShown); k < s.base.size(); ++k) {
    const BaseCheck& b = s.base[k].check;
    text += fmt::format("  after {:<10} {:>10.4f} {:>10.4f} {:>10.4f}  {}{}\n", b.after, b.moved_mm,
                        b.chance_mm, b.gate_mm, terminal::printable(b.nest),
                        b.off     ? ", beyond the gate"
                        : b.moved ? ", more than chance"
                                  : "");
  }
  return text;
}

/// Columns of what is measured, and of the length.
std::string heads(const Coordinates& measured) {
  std::string text;
  for (std::size_t c = 0; c < 3; ++c) {
    if (measured[c])
      text += fmt::format("{:>11}", c == 2 ? "dphi deg" : c == 1 ? "dy mm" : "dx mm");
  }
  return text + "    |d| mm\n";
}
std::string cells(const Eigen::Vector3d& off, const Coordinates& measured) {
  std::string text;
  for (int c = 0; c < 3; ++c) {
    if (!measured[static_cast<std::size_t>(c)]) continue;
    text += fmt::format(" {:>10.4f}", c == 2 ? deg_from_rad(off[c]) : off[c]);
  }
  return text + fmt::format(" {:>9.4f}\n", off.head<2>().norm());
}

}  // namespace

std::string status_text(const SessionStatus& s, int width) {
  std::string text;
  if (s.simulated) text += rule(width, "SIMULATED");
  text += fmt::format("{} / {}: {}", terminal::printable(s.campaign),
                      terminal::printable(s.session), s.state);
  if (s.process) text += fmt::format(" (process {})", *s.process);
  text += "\n";
  if (!s.detail.empty()) text += "  " + terminal::printable(s.detail) + "\n";
  text += fmt::format("{} {}/{}{}\n", bar(s, width), s.n_ok, s.n_points, times(s));
  if (s.stalled) {
    text += fmt::format("STALLED: nothing was stored for {} (alarm after {})\n",
                        terminal::clock_text(s.silent_s), terminal::clock_text(s.stall_after_s));
  }
  text += retries(s);
  if (!s.last.empty()) text += "last deviations  " + heads(s.measured);
  const std::size_t from = s.last.size() - std::min(s.last.size(), kShown);
  for (std::size_t k = from; k < s.last.size(); ++k) {
    text += fmt::format("  point {:<9}", s.last[k].point) + cells(s.last[k].off, s.measured);
  }
  if (!s.drift.empty()) text += "reference points " + heads(s.measured);
  const std::size_t first = s.drift.size() - std::min(s.drift.size(), kShown);
  for (std::size_t k = first; k < s.drift.size(); ++k) {
    const auto& d = s.drift[k];
    text += fmt::format("  {:<5} epoch {:<3}", d.point, d.epoch) + cells(d.off, s.measured);
  }
  return text + base_nests(s);
}

}  // namespace trammel::session
