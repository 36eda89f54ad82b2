#include "app/files/tracker_clock.hpp"

#include "core/error.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

std::vector<ClockLine> clock_lines(const std::vector<std::string>& texts) {
  std::vector<ClockLine> lines;
  for (const std::string& text : texts) {
    lines.push_back({static_cast<int>(lines.size()) + 4, parse_clock(text).value()});
  }
  return lines;
}

}  // namespace

TEST_CASE("times of SpatialAnalyzer, Leica and ISO 8601 are read, others are none", "[points]") {
  const auto sa = parse_clock("02/12/25 16:40:57");
  REQUIRE(sa);
  CHECK(clock_text(*sa, DateOrder::month_first) == "2025-02-12T16:40:57");
  CHECK(clock_text(*sa, DateOrder::day_first) == "2025-12-02T16:40:57");
  const auto leica = parse_clock("'11.10.2022 15:06:48.043");
  REQUIRE(leica);
  CHECK(clock_text(*leica, DateOrder::day_first) == "2022-10-11T15:06:48");
  CHECK_THAT(clock_s(*leica, DateOrder::day_first), WithinAbs(1665500808.043, 1e-6));
  const auto iso = parse_clock("2022-10-11T15:06:48");
  REQUIRE(iso);
  CHECK(clock_s(*iso, DateOrder::day_first) == 1665500808);
  for (const char* none :
       {"", "16:40:57", "02/12/25", "2/30", "1.2.3 4:5", "99/99/25 10:00:00", "02/12/25 25:00:00",
        "-1/2/25 10:00:00", "02/12/25 10:00:00x", "02/12/1969 10:00:00", "02/12/2201 10:00:00"}) {
    CAPTURE(none);
    CHECK_FALSE(parse_clock(none));
  }
}

TEST_CASE("a number above 12 decides which comes first, and names its line", "[points]") {
  const auto day =
      date_reading(clock_lines({"02.12.2025 10:00:00", "13.12.2025 10:00:00"}), {}, "f");
  CHECK(day.order == DateOrder::day_first);
  CHECK_THAT(day.why, Contains("line 5"));
  const auto month = date_reading(clock_lines({"02/12/25 10:00:00", "02/13/25 10:00:00"}), {}, "f");
  CHECK(month.order == DateOrder::month_first);
  CHECK(date_reading(clock_lines({"2025-02-12 10:00:00"}), {}, "f").order);
}

TEST_CASE("dates that can be read two ways stay open until somebody says", "[points]") {
  const auto lines = clock_lines({"02/12/25 10:00:00", "03/12/25 10:00:00"});
  const auto open = date_reading(lines, {}, "f");
  CHECK_FALSE(open.order);
  CHECK_THAT(open.why, Contains("02/12/2025") && Contains("no line decides"));
  CHECK(date_reading(lines, DateOrder::day_first, "f").order == DateOrder::day_first);
  CHECK_FALSE(date_reading({}, {}, "f").order);
}

TEST_CASE("dates that contradict one another, or the option, are refused with their line",
          "[points]") {
  const auto both = clock_lines({"13/02/25 10:00:00", "02/13/25 10:00:00"});
  CHECK_THROWS_WITH(date_reading(both, {}, "f"), Contains("f:5") && Contains("line 4"));
  const auto day = clock_lines({"13/02/25 10:00:00"});
  CHECK_THROWS_AS(date_reading(day, DateOrder::month_first, "f"), InputError);
  const auto none = clock_lines({"30/02/25 10:00:00"});
  CHECK_THROWS_AS(date_reading(none, {}, "f"), InputError);  // no 30 February
}
