#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/plane/place.hpp"

namespace trammel {

struct KMeans {
  std::vector<Place> centres;
  int iterations = 0;
};

/// `k` centres of `points`: k-means++ from `seed`, then Lloyd's steps until no point changes its
/// centre (at most 300). An emptied centre moves to the point farthest from its own. With k equal
/// to the number of points the centres are the points. Precondition: 1 <= k <= number of points,
/// points distinct. Proof: separated clusters are found, the same seed gives the same bits
/// (rbf_test.cpp).
KMeans kmeans(std::span<const Place> points, int k, std::uint64_t seed);

}  // namespace trammel
