#include "core/plane/blocks.hpp"

#include <set>

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("blocks hold neighbours together, repeats in one, and every block has points",
          "[assess]") {
  Random random(85);
  std::vector<Place> places;
  for (int k = 0; k < 60; ++k) {
    places.push_back({random.uniform(-100, 100), random.uniform(-100, 100)});
  }
  places.push_back(places[3]);
  const auto blocks = spatial_blocks(places, 6);
  CHECK(blocks.back() == blocks[3]);
  CHECK(std::set<int>(blocks.begin(), blocks.end()).size() == 6);
  int nearest_in_block = 0;
  for (std::size_t a = 0; a < 60; ++a) {
    std::size_t nearest = a == 0 ? 1 : 0;
    const auto d2 = [&](std::size_t b) {
      const double dx = places[a].x_mm - places[b].x_mm, dy = places[a].y_mm - places[b].y_mm;
      return dx * dx + dy * dy;
    };
    for (std::size_t b = 0; b < 60; ++b) {
      if (b != a && d2(b) < d2(nearest)) nearest = b;
    }
    nearest_in_block += blocks[a] == blocks[nearest] ? 1 : 0;
  }
  CHECK(nearest_in_block > 45);  // random folds would have 10 of 60
}

TEST_CASE("fewer places than blocks give a block each", "[assess]") {
  const std::vector<Place> places = {{0, 0}, {1, 0}, {0, 0}};
  const auto blocks = spatial_blocks(places, 6);
  CHECK(blocks[0] == blocks[2]);
  CHECK(blocks[0] != blocks[1]);
}
