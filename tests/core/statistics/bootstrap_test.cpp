#include "core/statistics/bootstrap.hpp"

#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/statistics/summary.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("the 95 % interval of the improvement covers the truth in about 95 of 100 campaigns",
          "[assess]") {
  // before ~ U(0.1, 0.3), after = a fifth of it, give or take: the true improvement is 80 %
  Random random(81);
  int covered = 0;
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> before, after;
    for (int k = 0; k < 60; ++k) {
      before.push_back(random.uniform(0.1, 0.3));
      after.push_back(before.back() * random.uniform(0, 0.4));
    }
    const auto interval = improvement_interval_pct(before, after, 1, 500);
    REQUIRE(interval);
    covered += interval->low <= 80 && 80 <= interval->high ? 1 : 0;
  }
  // 0.95 * 300 = 285, binomial sd 3.8; the percentile method is a little short: 4 sd and 1 %
  CHECK(covered > 266);
  CHECK(covered < 300);
}

TEST_CASE("the interval is that of resamples drawn and summed one by one, of few points and many",
          "[assess]") {
  Random random(83);
  for (const std::size_t n : {5U, 7U, 8U, 80U, 255U, 256U, 300U}) {
    for (const int replicates : {1, 33, 2000}) {
      std::vector<double> a, b;
      for (std::size_t k = 0; k < n; ++k) {
        a.push_back(random.uniform(-1, 1));
        b.push_back(random.uniform(-1, 1));
      }
      Random draws = Random::stream(9, "bootstrap");
      std::vector<double> figures;
      for (int r = 0; r < replicates; ++r) {
        double sum = 0;
        for (std::size_t k = 0; k < n; ++k) {
          const std::size_t point = draws.below(n);
          sum += a[point] - b[point];
        }
        figures.push_back(sum / static_cast<double>(n));
      }
      CAPTURE(n, replicates);
      const auto interval = paired_difference(a, b, 9, replicates);
      REQUIRE(interval);
      CHECK_THAT(interval->low, WithinAbs(quantile(figures, 0.025), 1e-13));
      CHECK_THAT(interval->high, WithinAbs(quantile(figures, 0.975), 1e-13));
    }
  }
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

TEST_CASE("few points, a zero before and unpaired points have no interval", "[assess]") {
  const std::vector<double> four(4, 1.0), five(5, 1.0), zero(5, 0.0);
  CHECK_FALSE(improvement_interval_pct(four, four));
  CHECK_FALSE(improvement_interval_pct(zero, five));
  CHECK(improvement_interval_pct(five, five));
  CHECK_THROWS_AS(improvement_interval_pct(four, five), InputError);
}
