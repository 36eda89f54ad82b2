#include "core/statistics/interval.hpp"

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// Share of `trials` campaigns of n points whose interval holds the true improvement of 80 %:
/// errors before are lengths of plane vectors, after a fifth of such lengths drawn anew, which keep
/// a third of what the point had before.
double coverage(std::size_t n, int trials, Random& random) {
  const auto length = [&] { return std::hypot(random.normal(), random.normal()); };
  int covered = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> before, after;
    for (std::size_t k = 0; k < n; ++k) {
      before.push_back(length());
      after.push_back(0.2 * (before.back() / 3 + length() * 2 / 3));
    }
    const auto interval = improvement_interval_pct(before, after);
    REQUIRE(interval);
    covered += interval->low <= 80 && 80 <= interval->high ? 1 : 0;
  }
  return static_cast<double>(covered) / trials;
}

}  // namespace

TEST_CASE(
    "the 95 % interval of the improvement covers the truth in 95 of 100 campaigns, of five "
    "points too",
    "[assess]") {
  Random random(81);
  for (const std::size_t n : {5U, 10U, 20U, 60U}) {
    const double share = coverage(n, 4000, random);
    INFO("n = " << n << ": " << share);
    // binomial sd 0.34 %: a true 95 % leaves 93.3 to 96.7 % in 1 of 10^6 runs
    CHECK(share > 0.933);
    CHECK(share < 0.967);
  }
}

TEST_CASE("the interval of the improvement is Student's of the log ratio, worked out by hand",
          "[assess]") {
  const std::vector<double> before = {1, 2, 3, 4, 5}, after = {0.5, 0.5, 1, 1, 2};
  // a / b = 1/3; a_k / a - b_k / b: 1/6, -1/6, 0, -1/3, 1/3; squares 5/18; s = sqrt(5/18 / 20)
  const double width = 2.776445105198 * std::sqrt(5.0 / 18 / 20);
  const auto interval = improvement_interval_pct(before, after);
  REQUIRE(interval);
  CHECK_THAT(interval->low, WithinAbs(100 * (1 - std::exp(width) / 3), 1e-9));
  CHECK_THAT(interval->high, WithinAbs(100 * (1 - std::exp(-width) / 3), 1e-9));
  const auto wider = improvement_interval_pct(before, after, 0.1);
  CHECK(wider->low < interval->low);
  CHECK(wider->high > interval->high);
}

TEST_CASE("a method against itself differs by nothing, against a worse one by less than nothing",
          "[assess]") {
  Random random(82);
  std::vector<double> good, bad;
  for (int k = 0; k < 40; ++k) {
    good.push_back(random.uniform(0, 0.1));
    bad.push_back(good.back() + random.uniform(0, 0.05));
  }
  const auto same = paired_difference(good, good);
  CHECK(same->low == 0);
  CHECK(same->high == 0);
  CHECK(paired_difference(good, bad)->high < 0);
}

TEST_CASE("few points, a zero before or after and unpaired points have no interval", "[assess]") {
  const std::vector<double> four(4, 1.0), five(5, 1.0), zero(5, 0.0);
  CHECK_FALSE(improvement_interval_pct(four, four));
  CHECK_FALSE(improvement_interval_pct(zero, five));
  CHECK_FALSE(improvement_interval_pct(five, zero));
  CHECK(improvement_interval_pct(five, five));
  CHECK_THROWS_AS(improvement_interval_pct(four, five), InputError);
}
