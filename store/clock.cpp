#include "store/clock.hpp"

#include <sodium.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <mutex>

#include "core/error.hpp"

namespace trammel::store {

namespace {

using namespace std::chrono;

constexpr int kFirstYear = 1970, kLastYear = 2200;

struct Shared {
  std::mutex mutex;
  ForwardClock clock;
};
Shared& shared() {
  static Shared one;
  return one;
}

std::int64_t steady_now_ms() {
  return duration_cast<milliseconds>(steady_clock::now().time_since_epoch()).count();
}

/// A number of `n` digits from `at` on; nothing for any other character.
std::optional<int> digits(std::string_view text, std::size_t at, std::size_t n) {
  if (at + n > text.size()) return std::nullopt;
  int value = 0;
  for (const char c : text.substr(at, n)) {
    if (c < '0' || c > '9') return std::nullopt;
    value = 10 * value + (c - '0');
  }
  return value;
}

}  // namespace

std::int64_t ForwardClock::now_ms(std::int64_t date_ms, std::int64_t steady_ms) {
  if (date_ms < last_ms_) date_ms = last_ms_ + (steady_ms - steady_ms_);
  last_ms_ = date_ms;
  steady_ms_ = steady_ms;
  return date_ms;
}

void ForwardClock::not_before(std::int64_t date_ms, std::int64_t steady_ms) {
  if (date_ms <= last_ms_) return;
  last_ms_ = date_ms;
  steady_ms_ = steady_ms;
}

std::string utc_now() {
  const auto date = duration_cast<milliseconds>(system_clock::now().time_since_epoch());
  const milliseconds now{[&] {
    const std::lock_guard lock(shared().mutex);
    return shared().clock.now_ms(date.count(), steady_now_ms());
  }()};
  const auto day = floor<days>(now);
  const year_month_day ymd{sys_days(day)};
  const int year = static_cast<int>(ymd.year());
  if (date.count() < 0 || year < kFirstYear || year > kLastYear) {
    throw StoreError({.what = "the computer's date is not set: nothing is stored under it",
                      .got = "the year " + std::to_string(year),
                      .expected = "1970 to 2200",
                      .hint = "set the date of this computer"});
  }
  const hh_mm_ss time(now - day);
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02d.%03dZ", year,
                static_cast<unsigned>(ymd.month()), static_cast<unsigned>(ymd.day()),
                static_cast<int>(time.hours().count()), static_cast<int>(time.minutes().count()),
                static_cast<int>(time.seconds().count()),
                static_cast<int>(time.subseconds().count()));
  return text.data();
}

void not_before(std::string_view utc) {
  const auto ms = utc_ms(utc);
  if (!ms || digits(utc, 0, 4) == kLastYear) return;
  const std::lock_guard lock(shared().mutex);
  shared().clock.not_before(*ms, steady_now_ms());
}

std::optional<std::int64_t> utc_ms(std::string_view utc) {
  constexpr std::string_view kForm = "0000-00-00T00:00:00";
  if (!utc.ends_with('Z') || (utc.size() != kForm.size() + 1 && utc.size() != kForm.size() + 5)) {
    return std::nullopt;
  }
  for (std::size_t k = 0; k < kForm.size(); ++k) {
    if (kForm[k] != '0' && utc[k] != kForm[k]) return std::nullopt;
  }
  const bool fraction = utc.size() > kForm.size() + 1;
  const auto y = digits(utc, 0, 4), mo = digits(utc, 5, 2), d = digits(utc, 8, 2);
  const auto h = digits(utc, 11, 2), mi = digits(utc, 14, 2), s = digits(utc, 17, 2);
  const auto ms = fraction ? digits(utc, 20, 3) : 0;
  if (!y || !mo || !d || !h || !mi || !s || !ms) return std::nullopt;
  if (fraction && utc[kForm.size()] != '.') return std::nullopt;
  const year_month_day day{year(*y), month(static_cast<unsigned>(*mo)),
                           std::chrono::day(static_cast<unsigned>(*d))};
  if (*y < kFirstYear || *y > kLastYear || !day.ok() || *h > 23 || *mi > 59 || *s > 59) {
    return std::nullopt;
  }
  return milliseconds(sys_days(day).time_since_epoch() + hours(*h) + minutes(*mi) + seconds(*s) +
                      milliseconds(*ms))
      .count();
}

std::string new_uuid() {
  std::array<unsigned char, 16> b{};
  randombytes_buf(b.data(), b.size());
  b[6] = static_cast<unsigned char>((b[6] & 0x0f) | 0x40);
  b[8] = static_cast<unsigned char>((b[8] & 0x3f) | 0x80);
  std::string uuid;
  for (std::size_t i = 0; i < b.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) uuid += '-';
    constexpr std::string_view digits = "0123456789abcdef";
    uuid += {digits[b[i] >> 4U], digits[b[i] & 15U]};
  }
  return uuid;
}

}  // namespace trammel::store
