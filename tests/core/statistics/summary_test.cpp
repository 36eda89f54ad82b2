#include "core/statistics/summary.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "core/statistics/robust.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("p95 interpolates between order statistics whatever the order of the values",
          "[assess]") {
  std::vector<double> values;
  for (int k = 0; k < 21; ++k) values.push_back((k * 8) % 21);  // 0 … 20, shuffled
  const Summary s = summarise(values);
  CHECK(s.n == 21);
  CHECK(s.mean == 10);
  CHECK(s.min == 0);
  CHECK(s.max == 20);
  CHECK_THAT(s.p95, WithinAbs(19.0, 1e-14));
  values.push_back(21);
  CHECK_THAT(summarise(values).p95, WithinAbs(0.95 * 21, 1e-14));  // between 19 and 20
}

TEST_CASE("the median is the middle value, of an even number the mean of the two", "[statistics]") {
  CHECK(median({9, 1, 4}) == 4);
  CHECK(median({9, 1, 4, 7}) == 5.5);
  CHECK(median({3}) == 3);
}

TEST_CASE("quantiles are those of the sorted values, whatever their number, order and ties",
          "[assess]") {
  Random random(3);
  const auto of_sorted = [](const std::vector<double>& sorted, double q) {
    const double h = q * static_cast<double>(sorted.size() - 1);
    const auto at = static_cast<std::size_t>(h);
    const double above = sorted[std::min(at + 1, sorted.size() - 1)];
    return sorted[at] + (h - std::floor(h)) * (above - sorted[at]);
  };
  for (const std::size_t n : {1U, 2U, 3U, 7U, 200U, 512U, 2000U, 2001U}) {
    for (const std::uint64_t different : {1U, 9U, 1000U, 1'000'000U}) {
      std::vector<double> values;
      for (std::size_t k = 0; k < n; ++k) {
        values.push_back(static_cast<double>(random.below(different)) - 4);
      }
      if (different == 1000) std::ranges::sort(values);
      std::vector<double> sorted = values;
      std::ranges::sort(sorted);
      for (const double low : {0.0, 0.001, 0.025, 0.1, 0.49, 0.5}) {
        for (const double high : {0.5, 0.51, 0.9, 0.975, 0.9999, 1.0}) {
          CAPTURE(n, different, low, high);
          CHECK(quantiles(values, low, high) ==
                std::pair(of_sorted(sorted, low), of_sorted(sorted, high)));
          CHECK(quantile(values, low) == of_sorted(sorted, low));
        }
      }
    }
  }
  // What every 64th value tells of the others is wrong here.
  std::vector<double> periodic(2048, 5.0);
  for (std::size_t k = 0; k < periodic.size(); k += 32) periodic[k] = -1.0 - static_cast<double>(k);
  std::vector<double> sorted = periodic;
  std::ranges::sort(sorted);
  CHECK(quantile(periodic, 0.1) == of_sorted(sorted, 0.1));
}

TEST_CASE("one value is its own mean, extremes and 95 % point", "[assess]") {
  const double one = 0.25;
  const Summary s = summarise({&one, 1});
  CHECK(s.mean == 0.25);
  CHECK(s.p95 == 0.25);
  CHECK(s.min == s.max);
}

TEST_CASE("improvement is 100 (1 - after / before) and undefined from zero", "[assess]") {
  CHECK_THAT(*improvement_pct({.mean = 0.2115}, {.mean = 0.0241}), WithinAbs(88.60, 0.01));
  CHECK_FALSE(improvement_pct({.mean = 0}, {.mean = 0.1}).has_value());
}

TEST_CASE("a summary of nothing or of NaN is refused", "[assess]") {
  CHECK_THROWS_AS(summarise({}), InputError);
  const std::vector<double> bad = {1.0, std::nan("")};
  CHECK_THROWS_WITH(summarise(bad), Contains("2") && Contains("finite"));
}

TEST_CASE("the noise floor is the mean length of plane noise", "[assess]") {
  CHECK_THAT(noise_floor_mean_mm(0.010), WithinAbs(0.012533, 1e-6));
  Random random(7);
  double mean = 0;
  constexpr int kDraws = 40000;
  for (int k = 0; k < kDraws; ++k) mean += std::hypot(random.normal(), random.normal()) / kDraws;
  // standard error sqrt((4 - pi) / 2 / n) = 0.0033; five of them: false alarm below 1e-6
  CHECK_THAT(mean, WithinAbs(noise_floor_mean_mm(1.0), 0.0165));
}
