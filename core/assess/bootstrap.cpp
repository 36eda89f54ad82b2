#include "core/assess/bootstrap.hpp"

#include <string>
#include <vector>

#include "core/assess/summary.hpp"
#include "core/error.hpp"
#include "core/random.hpp"

namespace trammel {

namespace {

constexpr std::size_t kFewest = 5;

void require_pairs(std::span<const double> a, std::span<const double> b) {
  if (a.size() == b.size()) return;
  throw InputError({.what = "the points before and after do not pair",
                    .got = std::to_string(a.size()) + " and " + std::to_string(b.size())});
}

/// The figure of each resample of the pairs' sums.
template <class Figure>
Interval resampled(std::span<const double> a, std::span<const double> b, std::uint64_t seed,
                   int replicates, const Figure& figure) {
  Random random = Random::stream(seed, "bootstrap");
  std::vector<double> figures;
  for (int r = 0; r < replicates; ++r) {
    double sum_a = 0, sum_b = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
      const auto pick = static_cast<std::size_t>(random.below(a.size()));
      sum_a += a[pick];
      sum_b += b[pick];
    }
    figures.push_back(figure(sum_a, sum_b));
  }
  return {quantile(figures, 0.025), quantile(figures, 0.975)};
}

}  // namespace

std::optional<Interval> improvement_interval_pct(std::span<const double> before,
                                                 std::span<const double> after, std::uint64_t seed,
                                                 int replicates) {
  require_pairs(before, after);
  bool any_zero_sum_possible = false;
  for (const double b : before) any_zero_sum_possible = any_zero_sum_possible || b <= 0;
  if (before.size() < kFewest || any_zero_sum_possible) return std::nullopt;
  return resampled(before, after, seed, replicates,
                   [](double b, double a) { return 100 * (1 - a / b); });
}

std::optional<Interval> paired_difference(std::span<const double> a, std::span<const double> b,
                                          std::uint64_t seed, int replicates) {
  require_pairs(a, b);
  if (a.size() < kFewest) return std::nullopt;
  const auto n = static_cast<double>(a.size());
  return resampled(a, b, seed, replicates, [n](double x, double y) { return (x - y) / n; });
}

}  // namespace trammel
