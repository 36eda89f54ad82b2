#include "core/assess/bootstrap.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "core/assess/summary.hpp"
#include "core/error.hpp"
#include "core/lanes.hpp"
#include "core/random.hpp"

namespace trammel {

namespace {

constexpr std::size_t kFewest = 5;

void require_pairs(std::span<const double> a, std::span<const double> b) {
  if (a.size() == b.size()) return;
  throw InputError({.what = "the points before and after do not pair",
                    .got = std::to_string(a.size()) + " and " + std::to_string(b.size())});
}

constexpr std::size_t kSideBySide = 4;        // resamples: a sum waits for its last addition
constexpr std::size_t kKeptPicks = 1U << 20;  // 4 MB

using Picks = std::vector<std::uint32_t>;

void draw(Random& random, std::size_t n, std::span<std::uint32_t> picks) {
  for (std::uint32_t& pick : picks) pick = static_cast<std::uint32_t>(random.below(n));
}

/// Which points all resamples take, one after the other. They depend on the seed and the number of
/// points alone: campaigns of an archive share them, and drawing is most of the work.
const Picks& kept_picks(std::uint64_t seed, std::size_t n, std::size_t replicates) {
  struct Kept {
    std::uint64_t seed = 0;
    std::size_t n = 0;
    Picks picks = {};
  };
  thread_local Kept last;
  if (last.seed != seed || last.n != n || last.picks.size() != n * replicates) {
    Random random = Random::stream(seed, "bootstrap");
    last = {seed, n, Picks(n * replicates)};
    draw(random, n, last.picks);
  }
  return last.picks;
}

/// The figure of each resample of the pairs' sums.
template <class Figure>
Interval resampled(std::span<const double> a, std::span<const double> b, std::uint64_t seed,
                   int replicates, const Figure& figure) {
  const std::size_t n = a.size(), all = static_cast<std::size_t>(replicates);
  const bool keep = n * all <= kKeptPicks;
  const Picks* kept = keep ? &kept_picks(seed, n, all) : nullptr;
  Random random = Random::stream(seed, "bootstrap");
  Picks drawn(keep ? 0 : kSideBySide * n);
  std::vector<Real<2>> pairs;
  for (std::size_t k = 0; k < n; ++k) pairs.push_back(Real<2>{a[k], b[k]});
  std::vector<double> figures;
  figures.reserve(all);
  for (std::size_t r = 0; r < all; r += kSideBySide) {
    const std::size_t count = std::min(kSideBySide, all - r);
    if (!keep) draw(random, n, std::span(drawn).first(count * n));
    const std::uint32_t* group = keep ? kept->data() + r * n : drawn.data();
    std::array<const std::uint32_t*, kSideBySide> from{};
    for (std::size_t s = 0; s < kSideBySide; ++s) from[s] = group + std::min(s, count - 1) * n;
    std::array<Real<2>, kSideBySide> sum{};
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t s = 0; s < kSideBySide; ++s) sum[s] += pairs[from[s][k]];
    }
    for (std::size_t s = 0; s < count; ++s) figures.push_back(figure(sum[s][0], sum[s][1]));
  }
  const auto [low, high] = quantiles(figures, 0.025, 0.975);
  return {low, high};
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
