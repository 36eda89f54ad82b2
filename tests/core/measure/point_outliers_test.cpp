#include "core/measure/point_outliers.hpp"

#include "core/statistics/robust.hpp"

#include "tests/support/catch.hpp"
#include "tests/support/nests.hpp"

using namespace trammel;

TEST_CASE("the median is the middle, or the mean of the two in the middle", "[measure]") {
  CHECK(median({3}) == 3);
  CHECK(median({9, 1, 5}) == 5);
  CHECK(median({9, 1, 5, 2}) == 3.5);
}

TEST_CASE("gross outliers are found by their places, though a third of the points is wrong",
          "[measure]") {
  Random random(91);
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 100; ++k) {
    points.emplace_back(Eigen::Vector3d(2778, -5, -563) + tests::noise_mm(random, 0.015));
  }
  std::vector<std::size_t> wrong;
  for (std::size_t k = 1; k < 100; k += 3) {
    points[k] += Eigen::Vector3d(0, k == 1 ? 0.5 : 240, 0);
    wrong.push_back(k);
  }
  const Screened screened = screen(points);
  CHECK(screened.outliers == wrong);
  CHECK((screened.median_mm - Eigen::Vector3d(2778, -5, -563)).norm() < 0.02);
  CHECK(*screened.limit_mm < 0.5);
}

TEST_CASE("a set of ten normal points loses none in 1,999 of 2,000 cases", "[measure]") {
  Random random(92);
  int lost = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < 10; ++k) points.push_back(tests::noise_mm(random, 1));
    lost += screen(points).outliers.empty() ? 0 : 1;
  }
  CHECK(lost <= 2);
}

TEST_CASE("points closer than the least distance are no outliers, however quiet the rest",
          "[measure]") {
  std::vector<Eigen::Vector3d> points(9, Eigen::Vector3d(1, 2, 3));
  points.emplace_back(1, 2, 3.09);
  CHECK(screen(points).mad_mm == 0);
  CHECK(screen(points).outliers.empty());
  points.back().z() = 3.2;
  CHECK(screen(points).outliers == std::vector<std::size_t>{9});
}

TEST_CASE("four points don't say which of them is wrong", "[measure]") {
  const std::vector<Eigen::Vector3d> points = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {9, 9, 9}};
  CHECK_FALSE(screen(points).limit_mm);
  CHECK(screen(points).outliers.empty());
  CHECK_FALSE(screen({}).limit_mm);
}

TEST_CASE("a miss is exactly zero in all three coordinates", "[measure]") {
  CHECK(is_miss({0, 0, 0}));
  CHECK_FALSE(is_miss({0, 0, 1e-9}));
}
