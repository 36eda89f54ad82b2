#include "core/statistics/bootstrap.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/linear/cpu_level.hpp"
#include "core/linear/lanes.hpp"
#include "core/statistics/random.hpp"
#include "core/statistics/summary.hpp"

namespace trammel {

namespace {

constexpr std::size_t kFewest = 5;

void require_pairs(std::span<const double> a, std::span<const double> b) {
  if (a.size() == b.size()) return;
  throw InputError({.what = "the points before and after do not pair",
                    .got = std::to_string(a.size()) + " and " + std::to_string(b.size())});
}

constexpr std::size_t kKeptBytes = 4U << 20;
constexpr std::size_t kLanes = 16;  // resamples side by side

/// How often each of n points is taken by kLanes resamples: a word of `bits` a count for each of
/// them, then the words of the next points.
template <unsigned bits>
struct Counts {
  static constexpr std::size_t kPerWord = 64 / bits;
  static std::size_t words(std::size_t n) { return (n + kPerWord - 1) / kPerWord * kLanes; }
  static void draw(Random& random, std::size_t n, std::span<std::uint64_t> counts) {
    std::ranges::fill(counts, 0U);
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t point = random.below(n);
        counts[point / kPerWord * kLanes + lane] += std::uint64_t{1} << point % kPerWord * bits;
      }
    }
  }
};

/// The counts of all resamples. They depend on the seed and the number of points alone: campaigns
/// of an archive share them, and drawing is most of the work.
template <unsigned bits>
const std::vector<std::uint64_t>& kept_counts(std::uint64_t seed, std::size_t n,
                                              std::size_t blocks) {
  struct Kept {
    std::uint64_t seed = 0;
    std::size_t n = 0;
    std::vector<std::uint64_t> counts = {};
  };
  thread_local Kept last;
  const std::size_t words = Counts<bits>::words(n);
  if (last.seed != seed || last.n != n || last.counts.size() != words * blocks) {
    Random random = Random::stream(seed, "bootstrap");
    last = {seed, n, std::vector<std::uint64_t>(words * blocks)};
    for (std::size_t k = 0; k < blocks; ++k) {
      Counts<bits>::draw(random, n, std::span(last.counts).subspan(k * words, words));
    }
  }
  return last.counts;
}

using LaneSums = std::array<double, kLanes>;

struct Sums {
  LaneSums a, b;
};

/// Sums of the points, each as often as it is taken, of some blocks of resamples.
///   count = (2^52 | count) - 2^52, whose lowest bits are the count
template <unsigned bits>
void add_up(std::span<const double> a, std::span<const double> b, const std::uint64_t* counts,
            std::span<Sums> sums) {
  constexpr std::size_t kPerWord = Counts<bits>::kPerWord;
  constexpr std::uint64_t kMask = (std::uint64_t{1} << bits) - 1;
  constexpr double k2To52 = 4503599627370496.0;
  at_level(cpu_level(), [&]<int n>() {
    typedef std::uint64_t Words __attribute__((vector_size(8 * n)));
    constexpr std::size_t kPairs = 2;  // of lanes: one alone would wait for each of its sums
    const auto add_some = [&](const std::uint64_t* from, double* to_a, double* to_b) {
      Real<n> sum_a[kPairs] = {}, sum_b[kPairs] = {};
      for (std::size_t k = 0; k < a.size(); from += kLanes) {
        Words words[kPairs];
        std::memcpy(words, from, sizeof words);
        for (const std::size_t end = std::min(k + kPerWord, a.size()); k < end; ++k) {
          for (std::size_t p = 0; p < kPairs; ++p) {
            const Words low = (words[p] & kMask) | std::bit_cast<std::uint64_t>(k2To52);
            const Real<n> times = reinterpret_cast<Real<n>>(low) - k2To52;
            sum_a[p] += times * a[k];
            sum_b[p] += times * b[k];
            words[p] >>= bits;
          }
        }
      }
      std::memcpy(to_a, sum_a, sizeof sum_a);
      std::memcpy(to_b, sum_b, sizeof sum_b);
    };
    for (Sums& sum : sums) {
      for (std::size_t lane = 0; lane < kLanes; lane += kPairs * n) {
        add_some(counts + lane, &sum.a[lane], &sum.b[lane]);
      }
      counts += Counts<bits>::words(a.size());
    }
  });
}

template <unsigned bits>
std::vector<Sums> resampled_sums(std::span<const double> a, std::span<const double> b,
                                 std::uint64_t seed, std::size_t blocks) {
  const std::size_t words = Counts<bits>::words(a.size());
  std::vector<Sums> sums(blocks);
  if (words * blocks * sizeof(std::uint64_t) <= kKeptBytes) {
    add_up<bits>(a, b, kept_counts<bits>(seed, a.size(), blocks).data(), std::span(sums));
    return sums;
  }
  Random random = Random::stream(seed, "bootstrap");
  std::vector<std::uint64_t> counts(words);
  for (Sums& sum : sums) {
    Counts<bits>::draw(random, a.size(), std::span(counts));
    add_up<bits>(a, b, counts.data(), std::span(&sum, 1));
  }
  return sums;
}

/// The figure of each resample of the pairs' sums.
template <class Figure>
Interval resampled(std::span<const double> a, std::span<const double> b, std::uint64_t seed,
                   int replicates, const Figure& figure) {
  const auto all = static_cast<std::size_t>(replicates);
  const std::size_t blocks = (all + kLanes - 1) / kLanes;
  const bool few = a.size() < 256;  // a point can be taken each time
  std::vector<double> figures;
  figures.reserve(blocks * kLanes);
  for (const Sums& sum :
       few ? resampled_sums<8>(a, b, seed, blocks) : resampled_sums<32>(a, b, seed, blocks)) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      figures.push_back(figure(sum.a[lane], sum.b[lane]));
    }
  }
  figures.resize(all);
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
