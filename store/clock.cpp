#include "store/clock.hpp"

#include <sodium.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "core/error.hpp"

namespace trammel::store {

std::string utc_now() {
  using namespace std::chrono;
  const auto now = time_point_cast<milliseconds>(system_clock::now());
  const std::time_t seconds = system_clock::to_time_t(now);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  constexpr int kFirstYear = 1970, kLastYear = 2200, kTmYear = 1900;
  if (const int year = parts.tm_year + kTmYear; year < kFirstYear || year >= kLastYear) {
    throw InputError({.what = "the computer's clock is wrong",
                      .got = "the year " + std::to_string(year),
                      .expected = "1970 to 2199",
                      .hint = "set it: times of readings come from it"});
  }
  std::array<char, 32> date{};
  std::strftime(date.data(), date.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%s.%03dZ", date.data(),
                static_cast<int>(now.time_since_epoch().count() % 1000));
  return text.data();
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
