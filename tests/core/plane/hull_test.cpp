#include "core/plane/hull.hpp"

#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("the hull of a grid is its corners, whatever the order", "[assess]") {
  std::vector<Place> grid;
  for (int k = 0; k < 25; ++k) {
    grid.push_back({10.0 * ((k * 7) % 25 / 5), 10.0 * ((k * 7) % 5)});
  }
  const auto hull = convex_hull(grid);
  CHECK(hull.size() == 4);
  for (const Place p : grid) CHECK(inside(hull, p));
  CHECK_FALSE(inside(hull, {41, 20}));
  CHECK_FALSE(inside(hull, {-0.001, 20}));
}

TEST_CASE("every point of a cloud is inside its own hull, mixtures too", "[assess]") {
  Random random(83);
  std::vector<Place> cloud;
  for (int k = 0; k < 60; ++k) cloud.push_back({random.normal(), random.normal()});
  const auto hull = convex_hull(cloud);
  for (std::size_t k = 0; k + 1 < cloud.size(); ++k) {
    CHECK(inside(hull, cloud[k]));
    CHECK(inside(
        hull, {(cloud[k].x_mm + cloud[k + 1].x_mm) / 2, (cloud[k].y_mm + cloud[k + 1].y_mm) / 2}));
  }
}

TEST_CASE("one place and one line have a hull of themselves alone", "[assess]") {
  const std::vector<Place> spot(4, Place{1, 2});
  CHECK(inside(convex_hull(spot), {1, 2}));
  CHECK_FALSE(inside(convex_hull(spot), {1, 3}));
  const std::vector<Place> line = {{0, 0}, {5, 5}, {10, 10}};
  CHECK(inside(convex_hull(line), {3, 3}));
  CHECK_FALSE(inside(convex_hull(line), {3, 4}));
  CHECK_FALSE(inside({}, {0, 0}));
}
