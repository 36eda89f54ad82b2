#include "app/files/numbers.hpp"

#include "core/statistics/random.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("only decimal numbers are numbers", "[exchange]") {
  for (const char* bad : {"", " 1", "1 ", "nan", "NaN", "inf", "-Infinity", "0x1p3", "1e999", "1,5",
                          "--1", "+-1", "1e", "abc", "1.2.3", "١"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_number(bad).has_value());
  }
  CHECK(parse_number("-1.5e-3") == -0.0015);
  CHECK(parse_number("+2") == 2.0);
  CHECK(parse_number(".5") == 0.5);
}

TEST_CASE("a number's text parses back to the same bits", "[exchange]") {
  Random random(3);
  for (int k = 0; k < 5000; ++k) {
    const double value = random.normal() * std::pow(10, random.uniform(-12, 18));
    CHECK(parse_number(number_text(value)) == value);
  }
  CHECK(number_text(0.1) == "0.1");
  CHECK(number_text(0.00001) == "0.00001");
  CHECK(number_text(-261.8112062) == "-261.8112062");
}

TEST_CASE("degrees survive the way through radians as written", "[exchange]") {
  Random random(5);
  for (int k = 0; k < 5000; ++k) {
    const double written = std::round(random.uniform(-180, 180) * 1e6) / 1e6;
    CHECK(exact_deg(rad_from_deg(written)) == written);
  }
  for (int k = 0; k < 5000; ++k) {
    const double full = random.uniform(-180, 180);  // 17 digits
    CHECK(rad_from_deg(exact_deg(rad_from_deg(full))) == rad_from_deg(full));
  }
}
