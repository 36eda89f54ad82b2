#include "core/plan/build.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

TEST_CASE("a plan has every pose at every orientation from every direction, twice", "[plan]") {
  PlanRequest request{.name = "full", .groups = {{"", paper_80()}}};
  request.orientations_rad = {-0.05, 0, 0.05};
  request.approaches = {Approach{1, 1, 1}, Approach{-1, -1, -1}};
  request.repeats = 2;
  request.references = 3;
  const Plan plan = build_plan(request);
  REQUIRE(plan.points.size() == 80 * 3 * 2 * 2);
  std::map<double, int> by_phi;
  int up = 0, second = 0, references = 0;
  for (const PlannedPoint& point : plan.points) {
    ++by_phi[point.target.phi_rad];
    up += point.approach == Approach{1, 1, 1} ? 1 : 0;
    second += point.repeat == 2 ? 1 : 0;
    references += point.reference ? 1 : 0;
  }
  CHECK(by_phi == std::map<double, int>{{-0.05, 320}, {0, 320}, {0.05, 320}});
  CHECK(up == 480);
  CHECK(second == 480);
  CHECK(references == 3);
  CHECK(plan.points[479].repeat == 1);  // the second round begins when the first is complete
  CHECK(plan.points[480].repeat == 2);
}

TEST_CASE("a random plan is the same for the same seed and differs between rounds", "[plan]") {
  PlanRequest request{.name = "r", .groups = {{"", paper_48()}}};
  request.order = Order::random;
  request.repeats = 2;
  const Plan a = build_plan(request), b = build_plan(request);
  int same_as_other_round = 0;
  for (std::size_t k = 0; k < 96; ++k) {
    CHECK(a.points[k].target == b.points[k].target);
    same_as_other_round += k < 48 && a.points[k].target == a.points[k + 48].target ? 1 : 0;
  }
  CHECK(same_as_other_round < 10);  // expected 1
}

TEST_CASE("a plan request that gives no points or too many is refused", "[plan]") {
  CHECK_THROWS_AS(build_plan({.name = "none"}), InputError);
  PlanRequest request{.name = "x", .groups = {{"", paper_80()}}};
  request.repeats = 0;
  CHECK_THROWS_AS(build_plan(request), InputError);
  request.repeats = 100000;
  CHECK_THROWS_AS(build_plan(request), InputError);
}

TEST_CASE("an invalid plan names the point and the field", "[plan]") {
  Plan plan = build_plan({.name = "x", .groups = {{"", paper_80()}}});
  plan.points[6].approach = {0, 2, 0};
  CHECK_THROWS_WITH(validate(plan), Contains("7") && Contains("approach"));
  plan.points[6].approach = {0, 0, 0};
  plan.points[9].seq = 9;
  CHECK_THROWS_WITH(validate(plan), Contains("seq"));
  plan.points[9].seq = 10;
  plan.points[3].target.x_mm = std::nan("");
  CHECK_THROWS_WITH(validate(plan), Contains("target"));
  plan.points[3].target.x_mm = 0;
  plan.approach_mm = 0;
  CHECK_THROWS_WITH(validate(plan), Contains("approach_mm"));
}

TEST_CASE("a move with a direction begins that far before the command, others as it comes",
          "[plan]") {
  const Plan plan{"p", 5, {}};
  PlannedPoint point;
  point.approach = {1, -1, 0};
  const Displacements cmd(100, 200, 300), at(90, 250, 310), at_from(80, 240, 320);
  const PlannedMove move = planned_move(plan, point, cmd, at, at_from);
  CHECK(move.pre_position);
  CHECK(move.pre_mm == Displacements(95, 205, 310));
  CHECK(move.from_mm == Displacements(95, 205, 310));
}

TEST_CASE("a rail that does not move keeps the direction of its last move", "[plan]") {
  const Plan plan{"p", 5, {}};
  const Displacements cmd(100, 200, 300), at(90, 200, 300 + 1e-9), at_from(80, 240, 320);
  const PlannedMove move = planned_move(plan, {}, cmd, at, at_from);
  CHECK_FALSE(move.pre_position);
  CHECK(move.from_mm == Displacements(90, 240, 320));
}

TEST_CASE("a rail plan moves one rail at a time, five runs in both directions", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  const Plan plan = rail_plan(mechanism, {});
  REQUIRE(plan.points.size() == 3 * 5 * 2 * 11);
  const Displacements home = inverse(mechanism.geometry, mechanism.home).l_mm;
  std::map<std::pair<double, int>, int> visits;  // of rail 2: (displacement, direction)
  for (const PlannedPoint& point : plan.points) {
    const Displacements s = inverse(mechanism.geometry, point.target).l_mm - home;
    const int rail = point.group.back() - '1';
    for (int i = 0; i < kChains; ++i) {
      const int direction = point.approach[static_cast<std::size_t>(i)];
      CHECK((direction != 0) == (i == rail));
      if (i != rail) CHECK_THAT(s[i], WithinAbs(0, 1e-9));
    }
    if (rail == 1) ++visits[{std::round(s[1]), point.approach[1]}];
  }
  CHECK(visits.size() == 22);
  for (const auto& [where, count] : visits) CHECK(count == 5);
  const double travel_mm = visits.rbegin()->first.first;
  CHECK(travel_mm == -visits.begin()->first.first);  // as far to either side of home
  CHECK_THROWS_AS(rail_plan(mechanism, {.half_travel_mm = 600}), InputError);
  CHECK_THROWS_AS(rail_plan(mechanism, {.targets = 1}), InputError);
}

}  // namespace trammel
