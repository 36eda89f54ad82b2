#include "core/plane/kmeans.hpp"

#include <algorithm>
#include <limits>

#include "core/error.hpp"
#include "core/statistics/random.hpp"

namespace trammel {

namespace {

constexpr int kMaxLloydSteps = 300;  // a bound: it ends where the owners stand still

double d2(Place a, Place b) {
  const double dx = a.x_mm - b.x_mm, dy = a.y_mm - b.y_mm;
  return dx * dx + dy * dy;
}

/// k-means++: each next centre is drawn with the square of the distance to those there are.
std::vector<Place> start(std::span<const Place> points, std::size_t k, Random& random) {
  std::vector<Place> centres = {points[random.below(points.size())]};
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  while (centres.size() < k) {
    double total = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      nearest[i] = std::min(nearest[i], d2(points[i], centres.back()));
      total += nearest[i];
    }
    double draw = random.uniform() * total;
    std::size_t pick = points.size();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (nearest[i] <= 0) continue;
      pick = i;
      draw -= nearest[i];
      if (draw < 0) break;
    }
    TRAMMEL_ASSERT(pick < points.size());
    centres.push_back(points[pick]);
  }
  return centres;
}

/// Index of the nearest centre of each point; true when any changed.
bool assign(std::span<const Place> points, const std::vector<Place>& centres,
            std::vector<std::size_t>& owner) {
  bool changed = false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::size_t best = 0;
    double best_d2 = d2(points[i], centres[0]);
    for (std::size_t c = 1; c < centres.size(); ++c) {
      const double trial = d2(points[i], centres[c]);
      if (trial < best_d2) {
        best = c;
        best_d2 = trial;
      }
    }
    changed = changed || owner[i] != best;
    owner[i] = best;
  }
  return changed;
}

void move_centres(std::span<const Place> points, const std::vector<std::size_t>& owner,
                  std::vector<Place>& centres) {
  std::vector<Place> sums(centres.size());
  std::vector<double> counts(centres.size(), 0);
  std::size_t farthest = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sums[owner[i]].x_mm += points[i].x_mm;
    sums[owner[i]].y_mm += points[i].y_mm;
    counts[owner[i]] += 1;
    if (d2(points[i], centres[owner[i]]) > d2(points[farthest], centres[owner[farthest]])) {
      farthest = i;
    }
  }
  const Place lonely = points[farthest];
  for (std::size_t c = 0; c < centres.size(); ++c) {
    centres[c] = counts[c] > 0 ? Place{sums[c].x_mm / counts[c], sums[c].y_mm / counts[c]} : lonely;
  }
}

}  // namespace

KMeans kmeans(std::span<const Place> points, int k, std::uint64_t seed) {
  TRAMMEL_ASSERT(k >= 1 && static_cast<std::size_t>(k) <= points.size());
  if (static_cast<std::size_t>(k) == points.size()) return {{points.begin(), points.end()}, 0};
  Random random = Random::stream(seed, "kmeans");
  KMeans result{start(points, static_cast<std::size_t>(k), random), 0};
  std::vector<std::size_t> owner(points.size(), points.size());
  while (result.iterations < kMaxLloydSteps && assign(points, result.centres, owner)) {
    move_centres(points, owner, result.centres);
    ++result.iterations;
  }
  return result;
}

}  // namespace trammel
