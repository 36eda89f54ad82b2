#include "app/device/freshness.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

#include "app/files/numbers.hpp"
#include "core/units.hpp"

namespace trammel::device {

namespace {

constexpr double kBackS = 1;           // stamps are whole seconds
constexpr double kOldS = 2;            // the same, and a clock that is looked at twice
constexpr double kClocksApart = 1e-4;  // s per s: nine seconds a day
constexpr int kFirstYear = 2020, kLastYear = 2099;

/// The whole numbers of "11/27/2026", three of them.
std::optional<std::array<int, 3>> three_parts(std::string_view text, char separator) {
  std::array<int, 3> parts{};
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::size_t end = k + 1 < parts.size() ? text.find(separator) : text.size();
    if (end == std::string_view::npos) return std::nullopt;
    const auto part = parse_integer(text.substr(0, end));
    if (!part || *part < 0) return std::nullopt;
    parts[k] = *part;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return parts;
}

}  // namespace

std::optional<std::int64_t> parse_stamp_s(std::string_view text) {
  using namespace std::chrono;
  const std::size_t blank = text.find(' ');
  if (blank == std::string_view::npos) return std::nullopt;
  const auto date = three_parts(text.substr(0, blank), '/');
  const auto time = three_parts(text.substr(blank + 1), ':');
  if (!date || !time) return std::nullopt;
  const auto [m, d, y] = *date;
  const auto [hour, minute, second] = *time;
  if (y < kFirstYear || y > kLastYear || hour > 23 || minute > 59 || second > 60) {
    return std::nullopt;
  }
  const year_month_day day(year(y), month(static_cast<unsigned>(m)),
                           std::chrono::day(static_cast<unsigned>(d)));
  if (!day.ok()) return std::nullopt;
  const seconds since =
      sys_days(day).time_since_epoch() + hours(hour) + minutes(minute) + seconds(second);
  return since.count();
}

double host_now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::string Freshness::look_at_time(const std::optional<std::int64_t>& stamp_s, double asked_s,
                                    double answered_s) {
  if (!stamp_s) return "its time is none";
  const auto stamp = static_cast<double>(*stamp_s);
  std::string old;
  if (latest_s_ && stamp < static_cast<double>(*latest_s_) - kBackS) {  // (1)
    old = fmt::format("its time is {} s before that of an answer before it", *latest_s_ - *stamp_s);
  }
  if (ahead_s_) {
    *ahead_s_ -= kClocksApart * (answered_s - ahead_at_s_);
    ahead_at_s_ = answered_s;
    const double early_s = asked_s + *ahead_s_ - stamp;
    if (old.empty() && by_host_clock_ && early_s > kOldS) {  // (2)
      old = fmt::format("its time is {:.1f} s before the question", early_s);
    }
    const double jump_s = stamp - answered_s - *ahead_s_;
    if (by_host_clock_ && jump_s > kSecondsPerHour + kOldS) {  // (2)
      return fmt::format("its time is {:.1f} s after the answer", jump_s);
    }
    if (!old.empty() && !hour_taken_ && std::abs(jump_s + kSecondsPerHour) <= kOldS) {
      hour_taken_ = true;
      note_ = fmt::format("the instrument's clock has gone back by an hour, {:.1f} s", jump_s);
      ahead_s_ = stamp - answered_s;
      latest_s_ = *stamp_s;
      return "";
    }
  }
  if (!old.empty()) return old;
  latest_s_ = std::max(latest_s_.value_or(*stamp_s), *stamp_s);
  ahead_s_ = std::max(ahead_s_.value_or(stamp - answered_s), stamp - answered_s);
  ahead_at_s_ = answered_s;
  return "";
}

std::string Freshness::look_at_values(const std::string& nest, const std::vector<double>& values,
                                      bool moved) {
  now_[nest] = values;
  const auto last = last_.find(nest);
  if (!moved || last == last_.end() || last->second != values) return "";  // (3)
  return "it is the last one again, to the last bit, though the platform has moved";
}

void Freshness::taken() {
  for (auto& [nest, values] : now_) last_.insert_or_assign(nest, std::move(values));
  now_.clear();
}

}  // namespace trammel::device
