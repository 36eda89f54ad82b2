#pragma once
// Dates as trackers' programs write them: with the day first, or the month, and no word about it.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace trammel {

enum class DateOrder { day_first, month_first };
/// "day-first", "month-first"
const std::vector<std::string>& date_order_names();
/// None for "": not said. Precondition: one of the names.
std::optional<DateOrder> date_order(std::string_view name);

/// One time stamp, taken apart but not yet understood.
struct ClockReading {
  int first = 0, second = 0;  // day and month, in one order or the other; of 2022-10-11: 10 and 11
  int year = 0;
  bool iso = false;  // the year stood first: month, day, no doubt
  double of_day_s = 0;
};

/// "02/12/25 16:40:57", "'11.10.2022 15:06:48.043", "2022-10-11T15:06:48". None: it is no time.
std::optional<ClockReading> parse_clock(std::string_view text);

/// How the dates of one file are to be read.
struct DateReading {
  std::optional<DateOrder> order = {};  // none: nothing decides, or nothing is there to decide
  std::string why = {};                 // in words, with the line that decides
};

struct ClockLine {
  int line = 0;
  ClockReading clock;
};
/// A number above 12 decides. Throws InputError when two lines contradict one another, or a date is
/// none in the order `asked`. Proof: tracker_clock_test.cpp.
DateReading date_reading(const std::vector<ClockLine>& lines, std::optional<DateOrder> asked,
                         const std::string& file);

/// Seconds of the tracker's own clock since 1970, as if it showed UTC: for differences.
double clock_s(const ClockReading& clock, DateOrder order);

/// "2025-02-12T16:40:57"
std::string clock_text(const ClockReading& clock, DateOrder order);

}  // namespace trammel
