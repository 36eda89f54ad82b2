#include "core/assess/bootstrap.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "core/assess/summary.hpp"
#include "core/cpu_level.hpp"
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

constexpr std::size_t kKeptBytes = 4U << 20;
constexpr std::size_t kLanes = kPartialSums;
using Lanes = PartialSums;

std::size_t filled_up(std::size_t n) { return (n + kLanes - 1) / kLanes * kLanes; }

/// How often a resample takes each of n points.
template <class Count>
void draw(Random& random, std::size_t n, std::span<Count> counts) {
  std::ranges::fill(counts, Count{0});
  for (std::size_t k = 0; k < n; ++k) ++counts[random.below(n)];
}

/// The counts of all resamples, one after the other, each filled up to whole lanes. They depend on
/// the seed and the number of points alone: campaigns of an archive share them, and drawing is most
/// of the work.
template <class Count>
const std::vector<Count>& kept_counts(std::uint64_t seed, std::size_t n, std::size_t replicates) {
  struct Kept {
    std::uint64_t seed = 0;
    std::size_t n = 0;
    std::vector<Count> counts = {};
  };
  thread_local Kept last;
  const std::size_t row = filled_up(n);
  if (last.seed != seed || last.n != n || last.counts.size() != row * replicates) {
    Random random = Random::stream(seed, "bootstrap");
    last = {seed, n, std::vector<Count>(row * replicates)};
    for (std::size_t r = 0; r < replicates; ++r) {
      draw(random, n, std::span(last.counts).subspan(r * row, row));
    }
  }
  return last.counts;
}

struct Sums {
  double a = 0;
  double b = 0;
};

/// Sums of the points, each as often as it is taken, of some resamples.
template <class Count>
void add_up(const std::vector<double>& a, const std::vector<double>& b, const Count* counts,
            std::span<Sums> sums) {
  typedef Count Counts __attribute__((vector_size(kLanes * sizeof(Count))));
  at_level(cpu_level(), [&]<int>() {
    for (Sums& sum : sums) {
      Lanes sum_a = {}, sum_b = {};
      for (std::size_t k = 0; k < a.size(); k += kLanes, counts += kLanes) {
        Counts some;
        Lanes of_a, of_b;
        std::memcpy(&some, counts, sizeof some);
        std::memcpy(&of_a, &a[k], sizeof of_a);
        std::memcpy(&of_b, &b[k], sizeof of_b);
        const Lanes times = __builtin_convertvector(some, Lanes);
        sum_a += times * of_a;
        sum_b += times * of_b;
      }
      sum = {total(sum_a), total(sum_b)};
    }
  });
}

template <class Count>
std::vector<Sums> resampled_sums(std::span<const double> a, std::span<const double> b,
                                 std::uint64_t seed, std::size_t replicates) {
  const std::size_t n = a.size(), row = filled_up(n);
  std::vector<double> filled_a(a.begin(), a.end()), filled_b(b.begin(), b.end());
  filled_a.resize(row);
  filled_b.resize(row);
  std::vector<Sums> sums(replicates);
  if (row * replicates * sizeof(Count) <= kKeptBytes) {
    add_up(filled_a, filled_b, kept_counts<Count>(seed, n, replicates).data(), sums);
    return sums;
  }
  Random random = Random::stream(seed, "bootstrap");
  std::vector<Count> counts(row);
  for (Sums& sum : sums) {
    draw<Count>(random, n, counts);
    add_up(filled_a, filled_b, counts.data(), std::span(&sum, 1));
  }
  return sums;
}

/// The figure of each resample of the pairs' sums.
template <class Figure>
Interval resampled(std::span<const double> a, std::span<const double> b, std::uint64_t seed,
                   int replicates, const Figure& figure) {
  const auto all = static_cast<std::size_t>(replicates);
  const bool few = a.size() <= std::numeric_limits<std::uint8_t>::max();
  std::vector<double> figures;
  figures.reserve(all);
  for (const Sums& sum : few ? resampled_sums<std::uint8_t>(a, b, seed, all)
                             : resampled_sums<std::uint32_t>(a, b, seed, all)) {
    figures.push_back(figure(sum.a, sum.b));
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
