#include "core/judge/tolerance.hpp"

#include <array>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE(
    "a guard band of U on either side of the tolerance decides, and between them nothing does",
    "[judge]") {
  // In quarters, which are exact: T = 1, U = 0.25.
  CHECK(conformity(0.75, 0.25, 1) == Conformity::passes);  // at the limit of acceptance
  CHECK(conformity(0.7501, 0.25, 1) == Conformity::undecided);
  CHECK(conformity(1, 0.25, 1) == Conformity::undecided);
  CHECK(conformity(1.25, 0.25, 1) == Conformity::undecided);
  CHECK(conformity(1.2501, 0.25, 1) == Conformity::fails);
  CHECK(conformity(0, 1.5, 1) == Conformity::undecided);  // known too badly to accept anything
  CHECK(conformity(1, 0, 1) == Conformity::passes);       // an exact instrument
}

TEST_CASE("an error at the tolerance itself is decided by chance in less than 1 of 20 readings",
          "[judge]") {
  // One coordinate, true error at the tolerance, u = 0.01, U = 2 u: a decision either way is wrong
  // or lucky with 2.3 % each. 10,000 draws, seed 7: the count of decisions is 455 +- 21, and beyond
  // 5 of these in 1 of 1.7 million seeds.
  Random random(7);
  int decided = 0;
  for (int k = 0; k < 10'000; ++k) {
    const double seen = 1 + 0.01 * random.normal();
    decided += conformity(seen, 0.02, 1) == Conformity::undecided ? 0 : 1;
  }
  CHECK(decided > 455 - 105);
  CHECK(decided < 455 + 105);
}

TEST_CASE("a machine fails at its worst point and passes at all", "[judge]") {
  using enum Conformity;
  CHECK(conformity_of_all(std::array{passes, passes}) == passes);
  CHECK(conformity_of_all(std::array{passes, undecided}) == undecided);
  CHECK(conformity_of_all(std::array{undecided, fails, passes}) == fails);
  CHECK(conformity_of_all({}) == undecided);
}

TEST_CASE("no tolerance and no uncertainty are refused by name", "[judge]") {
  CHECK_THROWS_AS(conformity(0.1, 0.1, 0), InputError);
  CHECK_THROWS_AS(conformity(0.1, -0.1, 1), InputError);
  CHECK_THROWS_AS(conformity(0.1, 1.0 / 0.0, 1), InputError);
}
