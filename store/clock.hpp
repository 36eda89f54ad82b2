#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace trammel::store {

/// Now, by the computer's date: 2026-01-31T12:34:56.789Z. It never goes back within a process, nor
/// behind what it was shown by not_before (ForwardClock). Throws StoreError where the date is
/// before 1970 or after 2200: such a clock is not set. Proof: utc_test.cpp.
std::string utc_now();

/// From here on utc_now() is not before `utc` either, a stored time. One of the last year, or of
/// none, is passed over: no row may stop the clock for good.
void not_before(std::string_view utc);

/// Milliseconds since 1970 of a time as utc_now() writes it, with or without its milliseconds.
/// Nothing for any other text, and for years before 1970 or after 2200.
std::optional<std::int64_t> utc_ms(std::string_view utc);

/// A date that never goes back. Where the computer's own is put back, it goes on from the last one
/// as the steady clock does:
///   now = date                            where date >= last
///   now = last + (steady - steady_last)   else
class ForwardClock {
 public:
  std::int64_t now_ms(std::int64_t date_ms, std::int64_t steady_ms);
  void not_before(std::int64_t date_ms, std::int64_t steady_ms);

 private:
  std::int64_t last_ms_ = 0;
  std::int64_t steady_ms_ = 0;
};

std::string new_uuid();  // random, version 4

}  // namespace trammel::store
