#include "core/judge/verdict.hpp"

#include <cmath>

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE(
    "a perfect robot's mean leaves its bounds once in 100 on each side, of few readings and "
    "many, of a known sigma and of repeats",
    "[judge]") {
  constexpr int kTrials = 10000;
  Random random(91);
  for (const int repeats : {0, 40}) {
    for (const std::size_t n : {5U, 20U, 80U}) {
      int low = 0, high = 0;
      for (int trial = 0; trial < kTrials; ++trial) {
        double mean = 0;
        for (std::size_t k = 0; k < n; ++k) {
          mean += std::hypot(random.normal(), random.normal()) / static_cast<double>(n);
        }
        double square = 0;  // of a sigma estimated from repeats: 2 * 40 coordinates
        for (int k = 0; k < 2 * repeats; ++k) square += std::pow(random.normal(), 2);
        const double sigma = repeats > 0 ? std::sqrt(square / (2 * repeats)) : 1.0;
        const PerfectMean perfect = perfect_mean(n, sigma, repeats);
        low += mean < perfect.low_mm ? 1 : 0;
        high += mean > perfect.high_mm ? 1 : 0;
      }
      INFO("n = " << n << ", repeats " << repeats << ": " << low << " below, " << high << " above");
      // 1 %: 100 +- 10, five of them for what the approximations cost
      CHECK(std::abs(low - 100) < 50);
      CHECK(std::abs(high - 100) < 50);
    }
  }
}

TEST_CASE("the verdict tells the floor, what lies above it, and what lies below any robot",
          "[judge]") {
  CHECK_THAT(floor_verdict(0.0135, 80, 0.010, 0), Contains("at the floor"));
  CHECK_THAT(floor_verdict(0.0325, 80, 0.010, 0), Contains("30.0 um unexplained"));
  CHECK_THAT(floor_verdict(0.0, 80, 0.010, 0), Contains("below the floor"));
  CHECK_THAT(floor_verdict(0.0100, 80, 0.010, 0), Contains("below the floor"));
  CHECK_THAT(floor_verdict(0.0100, 5, 0.010, 0), Contains("at the floor"));
  CHECK_THAT(floor_verdict(0.0160, 5, 0.010, 0), Contains("at the floor"));  // 1.28 of it
  CHECK_THAT(floor_verdict(0.0160, 80, 0.010, 0), Contains("unexplained"));
}
