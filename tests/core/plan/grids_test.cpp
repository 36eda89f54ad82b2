#include "core/plan/grids.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

namespace {

std::set<std::pair<double, double>> places(const std::vector<Pose>& poses) {
  std::set<std::pair<double, double>> set;
  for (const Pose& pose : poses) set.insert({pose.x_mm, pose.y_mm});
  return set;
}

double distance(const Pose& a, const Pose& b) {
  return std::hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm);
}

}  // namespace

TEST_CASE("paper-80 is 40 points on the axes and 40 on the diagonals", "[plan]") {
  const auto poses = paper_80();
  REQUIRE(poses.size() == 80);
  CHECK(places(poses).size() == 80);
  int axes = 0, diagonals = 0;
  for (const Pose& pose : poses) {
    axes += (pose.x_mm == 0) != (pose.y_mm == 0) ? 1 : 0;
    diagonals += std::abs(pose.x_mm) == std::abs(pose.y_mm) ? 1 : 0;
    CHECK(std::max(std::abs(pose.x_mm), std::abs(pose.y_mm)) <= 100);
    CHECK(pose.phi_rad == 0);
  }
  CHECK(axes == 40);
  CHECK(diagonals == 40);
  CHECK(poses.front() == Pose{10, 0, 0});
}

TEST_CASE("step and count of paper-80 are parameters", "[plan]") {
  const auto poses = paper_80(5, 4);
  REQUIRE(poses.size() == 32);
  CHECK(places(poses).count({20, -20}) == 1);
  CHECK_THROWS_AS(paper_80(0, 10), InputError);
  CHECK_THROWS_AS(paper_80(10, 0), InputError);
  CHECK_THROWS_AS(paper_80(std::numeric_limits<double>::quiet_NaN(), 10), InputError);
}

TEST_CASE("paper-48 has 12 points per quadrant and none of paper-80", "[plan]") {
  const auto poses = paper_48();
  REQUIRE(poses.size() == 48);
  CHECK(places(poses).size() == 48);
  const auto samples = places(paper_80());
  int first_quadrant = 0;
  for (const Pose& pose : poses) {
    CHECK(samples.count({pose.x_mm, pose.y_mm}) == 0);
    first_quadrant += pose.x_mm > 0 && pose.y_mm > 0 ? 1 : 0;
  }
  CHECK(first_quadrant == 12);
}

TEST_CASE("farthest points are each the farthest from samples and earlier choices", "[plan]") {
  auto known = paper_80();
  const auto chosen = farthest_points(known, 48);
  REQUIRE(chosen.size() == 48);
  for (const Pose& pose : chosen) {
    const auto nearest = [&](const Pose& p) {
      double best = std::numeric_limits<double>::infinity();
      for (const Pose& k : known) best = std::min(best, distance(p, k));
      return best;
    };
    double best = 0;
    for (const Pose& candidate : lattice(100, 10)) best = std::max(best, nearest(candidate));
    CHECK_THAT(nearest(pose), WithinAbs(best, 1e-9));
    known.push_back(pose);
  }
  CHECK_THROWS_AS(farthest_points(lattice(100, 10), 1), InputError);
}

TEST_CASE("the paper's circles have 72 points at 50 mm from their centres", "[plan]") {
  REQUIRE(paper_circles().size() == 4);
  for (const Circle& c : paper_circles()) {
    const auto poses = circle(c);
    REQUIRE(poses.size() == 72);
    for (const Pose& pose : poses) {
      CHECK_THAT(distance(pose, {c.x_mm, c.y_mm, 0}), WithinAbs(50, 1e-12));
    }
    CHECK_THAT(distance(poses[0], poses[1]), WithinAbs(100 * std::sin(M_PI / 72), 1e-12));
    CHECK_THAT(std::hypot(c.x_mm, c.y_mm), WithinAbs(50, 1e-12));
  }
  CHECK_THROWS_AS(circle({0, 0, 0}), InputError);
  CHECK_THROWS_AS(circle({0, 0, 10}, 2), InputError);
}

TEST_CASE("an order keeps every point; random depends on the seed alone", "[plan]") {
  const auto poses = paper_80();
  for (const Order order : {Order::as_listed, Order::random, Order::nearest}) {
    CHECK(places(ordered(poses, order, 3)) == places(poses));
  }
  CHECK(ordered(poses, Order::as_listed) == poses);
  CHECK(ordered(poses, Order::random, 3) == ordered(poses, Order::random, 3));
  CHECK(ordered(poses, Order::random, 3) != ordered(poses, Order::random, 4));
}

TEST_CASE("nearest order never leaves a closer point for later", "[plan]") {
  const auto poses = ordered(lattice(30, 10), Order::nearest, 1, {-30, -30, 0});
  CHECK(poses.front() == Pose{-30, -30, 0});
  double length = 0;
  for (std::size_t k = 1; k < poses.size(); ++k) {
    const double step = distance(poses[k - 1], poses[k]);
    length += step;
    for (std::size_t later = k + 1; later < poses.size(); ++later) {
      CHECK(distance(poses[k - 1], poses[later]) >= step - 1e-12);
    }
  }
  CHECK(length < 600);  // 49 points, 10 mm apart; row by row it is 780 mm
}

}  // namespace trammel
