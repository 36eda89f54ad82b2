// Programs: as DL took them, run statement by statement in threads of their own.

#include <algorithm>
#include <cmath>

#include "app/emulate/galil.hpp"

namespace trammel::emulate {

namespace {

constexpr double kLongestMs = 2147483646;
constexpr int kMostSteps = 1000;  // of a thread at once: one without WT lets the others live

std::string_view unpadded(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

}  // namespace

void Programs::load(const std::vector<std::string>& lines) {
  statements_.clear();
  for (std::string_view line : lines) {
    while (!line.empty()) {
      const std::size_t end = std::min(line.find(';'), line.size());
      if (const auto one = unpadded(line.substr(0, end)); !one.empty())
        statements_.emplace_back(one);
      line.remove_prefix(std::min(end + 1, line.size()));
    }
  }
}

std::size_t Programs::labelled(std::string_view label) const {
  const auto found = std::ranges::find(statements_, label);
  if (found == statements_.end()) throw Refused{10};
  return static_cast<std::size_t>(found - statements_.begin());
}

void Programs::start(std::string_view label, int thread) {
  if (statements_.empty()) throw Refused{10};
  const std::size_t from = label.empty() ? 0 : labelled(label);
  threads_.at(static_cast<std::size_t>(thread)) = {from, Clock::now()};
}

int Programs::place(int thread) const {
  const Thread& t = threads_.at(static_cast<std::size_t>(thread));
  return t.next ? static_cast<int>(*t.next) : -1;
}

bool Programs::any_runs() const {
  return std::ranges::any_of(threads_, [](const Thread& t) { return t.next.has_value(); });
}

std::optional<double> Programs::work() {
  std::optional<double> next_s;
  for (Thread& t : threads_) {
    for (int steps = 0; steps < kMostSteps && t.next && t.due <= Clock::now(); ++steps) step(t);
    if (!t.next) continue;
    const std::chrono::duration<double> left = t.due - Clock::now();
    next_s = std::min(next_s.value_or(left.count()), std::max(0.0, left.count()));
  }
  return next_s;
}

/// "a=b" alone.
bool Programs::holds(std::string_view condition) {
  const std::size_t equals = condition.find('=');
  if (equals == std::string_view::npos) throw Refused{4};
  return galil_.value(condition.substr(0, equals)) == galil_.value(condition.substr(equals + 1));
}

/// WT n waits n ms, JP goes to a label (when a condition holds), EN ends; all else is as from the
/// host, but that nobody is answered. A statement that is refused ends its thread.
void Programs::step(Thread& t) {
  if (*t.next >= statements_.size()) return t.next.reset();
  const std::string& text = statements_[(*t.next)++];
  if (text.starts_with('#')) return;
  const std::string_view arguments =
      unpadded(std::string_view(text).substr(std::min<std::size_t>(2, text.size())));
  try {
    if (text.starts_with("EN")) {
      t.next.reset();
    } else if (text.starts_with("WT")) {
      const double ms = galil_.value(arguments);
      if (!(ms >= 0 && ms <= kLongestMs)) throw Refused{6};
      t.due = Clock::now() + std::chrono::milliseconds(std::llround(ms));
    } else if (text.starts_with("JP")) {
      const std::size_t comma = arguments.find(',');
      const bool goes = comma == std::string_view::npos || holds(arguments.substr(comma + 1));
      if (goes) t.next = labelled(unpadded(arguments.substr(0, comma)));
    } else {
      if (galil_.line(text).ends_with('?')) t.next.reset();
    }
  } catch (const Refused& refused) {
    galil_.error = refused.code;
    t.next.reset();
  }
}

}  // namespace trammel::emulate
