#include "app/device/freshness.hpp"

#include <cmath>

#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::device;

namespace {

constexpr double kHost = 5000;                  // s, of the host's clock when it begins
constexpr std::int64_t kStart = 1'795'788'000;  // some stamp

/// An instrument that answers at once, `ahead_s` of its clock since the beginning.
std::string asked_at(Freshness& fresh, double host_s, double stamp_s) {
  return fresh.look_at_time(kStart + static_cast<std::int64_t>(std::floor(stamp_s)), kHost + host_s,
                            kHost + host_s + 0.05);
}

}  // namespace

TEST_CASE("a stamp is a date of the calendar, in this century", "[device][freshness]") {
  CHECK(parse_stamp_s("01/01/2026 00:00:00") == 1'767'225'600);
  CHECK(*parse_stamp_s("03/01/2028 00:00:00") - *parse_stamp_s("02/28/2028 23:59:59") == 86401);
  for (const char* none : {"99/99/0000 00:00:00", "11/27/1999 14:00:00", "02/29/2026 00:00:00",
                           "11/27/2026 24:00:00", "11/27/2026 14:60:00", "11/27/2026", "",
                           "11/27/2026 14:00", "27.11.2026 14:00:00", "11/27/2026 14:00:-1",
                           "1e308/1/2026 00:00:00", "00/10/2026 00:00:00", "11/00/2026 00:00:00"}) {
    CAPTURE(none);
    CHECK_FALSE(parse_stamp_s(none));
  }
}

TEST_CASE("answers of an instrument in time are of now, for hours, whole seconds or not",
          "[device][freshness]") {
  Freshness fresh;
  // 20 ppm slow against the host: 0.7 s in ten hours.
  for (double host_s = 0; host_s < 36'000; host_s += 7.3) {
    REQUIRE(asked_at(fresh, host_s, host_s * (1 - 2e-5)).empty());
  }
  CHECK(fresh.take_note().empty());
}

TEST_CASE("an answer older than its question is refused, once the clocks are known",
          "[device][freshness]") {
  for (const double lag_s : {0.5, 1.0, 3.1, 10.0, 86'400.0}) {
    CAPTURE(lag_s);
    Freshness fresh;
    CHECK(asked_at(fresh, 0, 0).empty());
    const std::string why = asked_at(fresh, 100, 100 - lag_s);
    CHECK(why.empty() == (lag_s <= 2));
    CHECK(asked_at(fresh, 110, 110).empty());  // it knows the clocks as before
  }
  Freshness own(false);  // a clock that runs with the work alone
  CHECK(asked_at(own, 0, 0).empty());
  CHECK(asked_at(own, 100, 3).empty());
}

TEST_CASE("an answer of the future is refused, but for clocks that are put forward by an hour",
          "[device][freshness]") {
  for (const double early_s : {1.0, 3600.0, 3700.0, 86'400.0, 2e9}) {
    CAPTURE(early_s);
    Freshness fresh;
    CHECK(asked_at(fresh, 0, 0).empty());
    CHECK(asked_at(fresh, 100, 100 + early_s).empty() == (early_s <= 3600));
    if (early_s > 3600) CHECK(asked_at(fresh, 110, 110).empty());  // it knows the clocks as before
  }
}

TEST_CASE("time does not go back within a connection, but by an hour, once",
          "[device][freshness]") {
  Freshness fresh(false);
  CHECK(asked_at(fresh, 0, 0).empty());
  CHECK(asked_at(fresh, 10, 10).empty());
  CHECK(asked_at(fresh, 10.1, 9).empty());  // a second is the rounding
  CHECK_THAT(asked_at(fresh, 10.2, 8), Catch::Matchers::Contains("before that of an answer"));
  fresh.connected();
  CHECK(asked_at(fresh, 10.3, 8).empty());

  for (const double jump_s : {-3600.0, -3590.0, -3620.0, -7200.0, -60.0}) {
    CAPTURE(jump_s);
    Freshness clock;
    CHECK(asked_at(clock, 0, 0).empty());
    CHECK(asked_at(clock, 20, 20).empty());
    const std::string why = asked_at(clock, 40, 40 + jump_s);
    CHECK(why.empty() == (jump_s == -3600));
    CHECK(clock.take_note().empty() != (jump_s == -3600));
    if (!why.empty()) continue;
    CHECK(asked_at(clock, 60, 60 + jump_s).empty());
    CHECK_FALSE(asked_at(clock, 80, 60 + jump_s).empty());      // old against the new hour
    CHECK_FALSE(asked_at(clock, 80, 80 + 2 * jump_s).empty());  // not twice
  }
}

TEST_CASE("the last values again are none once the platform has moved", "[device][freshness]") {
  Freshness fresh;
  CHECK(fresh.look_at_values("P1", {1, 2, 3}, true).empty());
  CHECK(fresh.look_at_values("P1", {1, 2, 3}, true).empty());  // of a try that made no reading
  fresh.taken();
  CHECK(fresh.look_at_values("P1", {1, 2, 3}, false).empty());
  CHECK(fresh.look_at_values("P2", {1, 2, 3}, true).empty());
  CHECK(fresh.look_at_values("P1", {1, 2, std::nextafter(3, 4)}, true).empty());
  CHECK_FALSE(fresh.look_at_values("P1", {1, 2, 3}, true).empty());
}
