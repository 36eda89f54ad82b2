#include "store/clock.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;

TEST_CASE("a stored time reads back to its milliseconds, and no other text is one", "[store]") {
  CHECK(utc_ms("1970-01-01T00:00:00.000Z") == 0);
  CHECK(utc_ms("1970-01-01T00:00:01Z") == 1000);
  CHECK(*utc_ms("2024-03-01T00:00:00.250Z") - *utc_ms("2024-02-28T23:59:59.500Z") == 86'400'750);
  CHECK(*utc_ms("2027-01-01T00:00:00.000Z") - *utc_ms("2026-12-31T23:59:59.000Z") == 1000);
  CHECK(utc_ms("2200-12-31T23:59:59.999Z"));
  for (const char* no_time :
       {"", "yesterday", "1960-01-01T00:00:01.-254Z", "1969-12-31T23:59:59.999Z",
        "2201-01-01T00:00:00.000Z", "2026-02-30T00:00:00.000Z", "2026-01-01T24:00:00.000Z",
        "2026-01-01T00:60:00.000Z", "2026-01-01T00:00:60.000Z", "2026-01-01 00:00:00.000Z",
        "2026-01-01T00:00:00.000", "2026-01-01T00:00:00.0000Z", "2026-01-01T00:00:00,000Z",
        "+026-01-01T00:00:00.000Z", "2026-1--01T00:00:00.000Z"}) {
    CAPTURE(no_time);
    CHECK_FALSE(utc_ms(no_time));
  }
  CHECK(utc_ms(utc_now()));
}

TEST_CASE("a date that is put back goes on from the last one as the steady clock does", "[store]") {
  ForwardClock clock;
  CHECK(clock.now_ms(1'000'000, 500) == 1'000'000);
  CHECK(clock.now_ms(1'000'010, 510) == 1'000'010);
  CHECK(clock.now_ms(400'000, 530) == 1'000'030);  // put back by ten minutes
  CHECK(clock.now_ms(400'015, 545) == 1'000'045);
  CHECK(clock.now_ms(1'000'050, 546) == 1'000'050);  // set right again
  CHECK(clock.now_ms(9'000'000, 547) == 9'000'000);  // put on
  clock.not_before(8'000'000, 548);
  CHECK(clock.now_ms(9'000'001, 548) == 9'000'001);
  clock.not_before(10'000'000, 600);  // of an earlier process
  CHECK(clock.now_ms(9'000'100, 700) == 10'000'100);
}

TEST_CASE("no stored time stops the clock for good", "[store]") {
  not_before("2200-12-31T23:59:59.999Z");
  not_before("zzzz-zz-zzTzz:zz:zz.zzzZ");
  CHECK(utc_now() < "2200-01-01T00:00:00.000Z");
}
