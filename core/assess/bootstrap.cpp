#include "core/assess/bootstrap.hpp"

#include <algorithm>
#include <array>
#include <limits>
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
constexpr std::size_t kKeptPicks = 1U << 20;  // 2 MB

template <class Pick>
void draw(Random& random, std::size_t n, std::span<Pick> picks) {
  for (Pick& pick : picks) pick = static_cast<Pick>(random.below(n));
}

/// Which points all resamples take, one after the other. They depend on the seed and the number of
/// points alone: campaigns of an archive share them, and drawing is most of the work.
const std::vector<std::uint16_t>& kept_picks(std::uint64_t seed, std::size_t n,
                                             std::size_t replicates) {
  struct Kept {
    std::uint64_t seed = 0;
    std::size_t n = 0;
    std::vector<std::uint16_t> picks = {};
  };
  thread_local Kept last;
  if (last.seed != seed || last.n != n || last.picks.size() != n * replicates) {
    Random random = Random::stream(seed, "bootstrap");
    last = {seed, n, std::vector<std::uint16_t>(n * replicates)};
    draw<std::uint16_t>(random, n, last.picks);
  }
  return last.picks;
}

/// The figure of each resample of the pairs' sums.
template <class Figure>
Interval resampled(std::span<const double> a, std::span<const double> b, std::uint64_t seed,
                   int replicates, const Figure& figure) {
  const std::size_t n = a.size(), all = static_cast<std::size_t>(replicates);
  std::vector<Real<2>> pairs;
  for (std::size_t k = 0; k < n; ++k) pairs.push_back(Real<2>{a[k], b[k]});
  std::vector<double> figures;
  figures.reserve(all + kSideBySide);
  const auto add = [&](const auto* picks) {
    std::array<Real<2>, kSideBySide> sum{};
    for (std::size_t k = 0; k < n; ++k) {
      for (std::size_t s = 0; s < kSideBySide; ++s) sum[s] += pairs[picks[s * n + k]];
    }
    for (const Real<2>& s : sum) figures.push_back(figure(s[0], s[1]));
  };
  const std::size_t groups = (all + kSideBySide - 1) / kSideBySide, group = kSideBySide * n;
  if (groups * group <= kKeptPicks && n <= std::numeric_limits<std::uint16_t>::max()) {
    const auto& picks = kept_picks(seed, n, groups * kSideBySide);
    for (std::size_t g = 0; g < groups; ++g) add(picks.data() + g * group);
  } else {
    Random random = Random::stream(seed, "bootstrap");
    std::vector<std::uint32_t> picks(group);
    for (std::size_t g = 0; g < groups; ++g) {
      draw<std::uint32_t>(random, n, picks);
      add(picks.data());
    }
  }
  figures.resize(all);  // the last group may have made some more
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
