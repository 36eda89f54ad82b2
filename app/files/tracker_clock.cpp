#include "app/files/tracker_clock.hpp"

#include <fmt/format.h>

#include <array>
#include <chrono>

#include "app/files/numbers.hpp"
#include "core/error.hpp"

namespace trammel {

namespace {

/// Three whole numbers between two equal separators: "11.10.2022".
struct ThreeNumbers {
  std::array<int, 3> value = {};
  std::array<std::size_t, 3> digits = {};
};

std::optional<ThreeNumbers> three_numbers(std::string_view text, std::string_view separators) {
  const std::size_t at = text.find_first_of(separators);
  if (at == std::string_view::npos) return std::nullopt;
  const std::size_t next = text.find(text[at], at + 1);
  if (next == std::string_view::npos) return std::nullopt;
  const std::array<std::string_view, 3> parts = {
      text.substr(0, at), text.substr(at + 1, next - at - 1), text.substr(next + 1)};
  ThreeNumbers numbers;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto value = parse_integer(parts[k]);
    if (!value || *value < 0 || parts[k].size() > 4) return std::nullopt;
    numbers.value[k] = *value;
    numbers.digits[k] = parts[k].size();
  }
  return numbers;
}

/// "15:06:48.043", seconds of the day.
std::optional<double> time_of_day_s(std::string_view text) {
  const std::size_t first = text.find(':');
  const std::size_t second = text.find(':', first == std::string_view::npos ? first : first + 1);
  if (second == std::string_view::npos) return std::nullopt;
  const auto h = parse_integer(text.substr(0, first));
  const auto min = parse_integer(text.substr(first + 1, second - first - 1));
  const auto s = parse_number(text.substr(second + 1));
  const bool ok =
      h && min && s && *h >= 0 && *h < 24 && *min >= 0 && *min < 60 && *s >= 0 && *s < 61;
  return ok ? std::optional(*h * 3600.0 + *min * 60.0 + *s) : std::nullopt;
}

std::chrono::year_month_day day_of(const ClockReading& clock, DateOrder order) {
  const bool month_first = clock.iso || order == DateOrder::month_first;
  const auto month = static_cast<unsigned>(month_first ? clock.first : clock.second);
  const auto day = static_cast<unsigned>(month_first ? clock.second : clock.first);
  return std::chrono::year(clock.year) / std::chrono::month(month) / std::chrono::day(day);
}

std::string as_written(const ClockReading& clock) {
  return fmt::format("{:02}/{:02}/{}", clock.first, clock.second, clock.year);
}

[[noreturn]] void refuse_date(const ClockLine& at, const std::optional<DateOrder>& order,
                              int deciding_line, const std::string& file) {
  throw InputError(
      {.what = "the date can't be read as the others are",
       .where = {.file = file, .line = at.line, .field = "date"},
       .got = as_written(at.clock),
       .expected = order ? date_order_names()[static_cast<std::size_t>(*order)] : "a date",
       .hint = deciding_line > 0 ? fmt::format("line {} decides otherwise", deciding_line)
                                 : std::string()});
}

}  // namespace

const std::vector<std::string>& date_order_names() {
  static const std::vector<std::string> names = {"day-first", "month-first"};
  return names;
}

std::optional<DateOrder> date_order(std::string_view name) {
  if (name.empty()) return std::nullopt;
  TRAMMEL_ASSERT(name == "day-first" || name == "month-first");
  return name == "day-first" ? DateOrder::day_first : DateOrder::month_first;
}

std::optional<ClockReading> parse_clock(std::string_view text) {
  if (text.starts_with('\'')) text.remove_prefix(1);
  const std::size_t gap = text.find_first_of(" T");
  if (gap == std::string_view::npos) return std::nullopt;
  const std::string_view clock_part =
      text.substr(std::min(text.find_first_not_of(' ', gap + 1), text.size()));
  const auto date = three_numbers(text.substr(0, gap), "./-");
  const auto of_day = time_of_day_s(clock_part);
  if (!date || !of_day) return std::nullopt;
  ClockReading clock{.of_day_s = *of_day};
  clock.iso = date->digits[0] == 4;
  const auto& v = date->value;
  clock.year = clock.iso ? v[0] : v[2];
  clock.first = clock.iso ? v[1] : v[0];
  clock.second = clock.iso ? v[2] : v[1];
  if (!clock.iso && date->digits[2] == 2) clock.year += 2000;
  if (clock.year < 1970 || clock.year > 2200 || clock.first < 1 || clock.first > 31 ||
      clock.second < 1 || clock.second > 31) {
    return std::nullopt;
  }
  return clock;
}

DateReading date_reading(const std::vector<ClockLine>& lines, std::optional<DateOrder> asked,
                         const std::string& file) {
  DateReading reading{.order = asked, .why = "there are no dates"};
  if (asked && !lines.empty()) {
    reading.why = date_order_names()[static_cast<std::size_t>(*asked)] + ", as asked for";
  }
  int deciding_line = 0;
  bool all_iso = !lines.empty();
  for (const ClockLine& at : lines) {
    std::optional<DateOrder> says;
    if (!at.clock.iso && at.clock.first > 12) says = DateOrder::day_first;
    if (!at.clock.iso && at.clock.second > 12) says = DateOrder::month_first;
    all_iso = all_iso && at.clock.iso;
    const DateOrder order = says.value_or(reading.order.value_or(DateOrder::month_first));
    if (!day_of(at.clock, order).ok() || (says && reading.order && says != reading.order)) {
      refuse_date(at, reading.order, deciding_line, file);
    }
    if (!says || reading.order) continue;
    deciding_line = at.line;
    reading = {says, fmt::format("line {} decides: {}", at.line, as_written(at.clock))};
  }
  if (all_iso && !reading.order) reading = {DateOrder::month_first, "the year stands first"};
  if (!reading.order && !lines.empty()) {
    reading.why = fmt::format(
        "{} in line {} is a date with the day first as well as with the month first, and no line "
        "decides (SpatialAnalyzer writes the month first)",
        as_written(lines.front().clock), lines.front().line);
  }
  return reading;
}

double clock_s(const ClockReading& clock, DateOrder order) {
  const auto days = std::chrono::sys_days(day_of(clock, order)).time_since_epoch();
  return static_cast<double>(days.count()) * 86400.0 + clock.of_day_s;
}

std::string clock_text(const ClockReading& clock, DateOrder order) {
  const auto day = day_of(clock, order);
  const int whole_s = static_cast<int>(clock.of_day_s);
  return fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}", static_cast<int>(day.year()),
                     static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()),
                     whole_s / 3600, whole_s / 60 % 60, whole_s % 60);
}

}  // namespace trammel
