#include "core/plan/check.hpp"

#include <cmath>

#include "core/mechanism/machine_kinematics.hpp"
#include "core/mechanism/workspace.hpp"
#include "core/plan/build.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

namespace {

using What = Violation::What;
using Place = Violation::Place;

Plan plan_of(const std::vector<Pose>& poses) {
  return build_plan({.name = "test", .groups = {{"", poses}}});
}

bool has(const std::vector<Violation>& all, int seq, Place place, What what, int rail = 0) {
  for (const Violation& v : all) {
    if (v.seq == seq && v.place == place && v.what == what && v.rail == rail) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("the paper's grids, circles and the rail plan have no violation", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  CHECK(check(plan_of(paper_80()), mechanism).empty());
  CHECK(check(plan_of(paper_48()), mechanism).empty());
  for (const Circle& c : paper_circles()) CHECK(check(plan_of(circle(c)), mechanism).empty());
  CHECK(check(rail_plan(mechanism, {}), mechanism).empty());
  PlanRequest turned{.name = "turned", .groups = {{"", paper_80()}}};
  turned.orientations_rad = {-0.1, 0.1};
  turned.approaches = {Approach{1, -1, 1}, Approach{-1, 1, -1}};
  CHECK(check(build_plan(turned), mechanism).empty());
}

TEST_CASE("a check lists every violation, not the first", "[plan]") {
  Mechanism mechanism = paper_mechanism();
  mechanism.limits = {100, 420};
  Plan plan = plan_of({{10, 0, 0}, {900, 0, 0}, {20, 0, 0}, {0, 200, 0}, {30, 0, 0}});
  plan.points[4].target.phi_rad = std::nan("");
  const auto all = check(plan, mechanism);
  CHECK(has(all, 2, Place::target, What::unreachable, 1));
  CHECK(has(all, 4, Place::target, What::lower_limit, 1));
  CHECK(has(all, 5, Place::target, What::not_finite));
  for (const Violation& v : all) CHECK((v.seq == 2 || v.seq == 4 || v.seq == 5));
}

TEST_CASE("the margin of a stroke limit is kept free, to a hair", "[plan]") {
  Mechanism mechanism = paper_mechanism();
  const double l1 = inverse(mechanism.geometry, Pose{0, 100, 0}).l_mm[0];
  const Plan plan = plan_of({{0, 100, 0}});
  mechanism.limits.l_min_mm = l1 - 2 - 1e-6;
  CHECK(check(plan, mechanism).empty());
  mechanism.limits.l_min_mm = l1 - 2 + 1e-6;
  const auto all = check(plan, mechanism);
  REQUIRE(all.size() == 1);
  CHECK(all[0].what == What::lower_limit);
  CHECK_THAT(all[0].got, WithinAbs(l1, 1e-12));
  CHECK_THAT(all[0].limit, WithinAbs(l1 + 1e-6, 1e-9));
  CHECK_THAT(describe(all[0]), Contains("point 1, target: rail 1 below lower limit"));
}

TEST_CASE("the start of an approach beyond a limit is found", "[plan]") {
  Mechanism mechanism = paper_mechanism();
  mechanism.limits.l_min_mm = inverse(mechanism.geometry, Pose{0, 100, 0}).l_mm[0] - 3;
  Plan plan = plan_of({{0, 100, 0}});
  CHECK(check(plan, mechanism).empty());
  plan.points[0].approach = {1, 0, 0};  // begins 5 mm below the target
  CHECK(has(check(plan, mechanism), 1, Place::approach, What::lower_limit, 1));
  plan.points[0].approach = {-1, 0, 0};
  CHECK(check(plan, mechanism).empty());
}

TEST_CASE("a path between two good targets that comes near a singular pose is found", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  const std::vector<Pose> ends = {{-190, 70, rad_from_deg(-72)}, {160, -90, rad_from_deg(-77)}};
  CheckOptions options;
  options.singularity_margin = 0.3;
  options.link_clearance_mm = 0;  // links do cross on this way: the next test
  for (const Pose& pose : ends)
    CHECK(reach(machine_of(mechanism), pose).singularity.margin() > 0.38);
  const auto all = check(plan_of(ends), mechanism, options);
  REQUIRE(all.size() == 1);
  CHECK(has(all, 2, Place::path, What::singular));
  CHECK(all[0].got < 0.15);
  CHECK(check(plan_of({ends[0]}), mechanism, options).empty());
}

TEST_CASE("a path on which links come too close, or the platform goes too fast, is found",
          "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  const Plan turned = plan_of({{-190, 70, rad_from_deg(-72)}});
  const auto close = check(turned, mechanism);
  REQUIRE(close.size() == 1);
  CHECK(has(close, 1, Place::path, What::collision));
  CHECK(describe(close[0]) == "point 1, path: links too close: 0.000 mm, limit 10.000 mm");
  const Plan plan = plan_of(paper_80());
  CheckOptions slow;
  slow.max_platform_mm_s = 20;  // as fast as the rails: on many ways the platform is faster
  const auto fast = check(plan, mechanism, slow);
  REQUIRE_FALSE(fast.empty());
  for (const Violation& v : fast) CHECK(v.what == What::too_fast);
  CHECK_THAT(describe(fast[0]), Contains("mm/s, limit 20.0 mm/s"));
  slow.max_platform_mm_s = 40;
  CHECK(check(plan, mechanism, slow).empty());
  CheckOptions rails;
  rails.speed_mm_s = 201;
  REQUIRE(check(plan, mechanism, rails).size() == 1);
  CHECK(describe(check(plan, mechanism, rails)[0]) ==
        "target: too fast: 201.0 mm/s, limit 200.0 mm/s");
  for (const auto value : {0.0, -1.0, std::nan("")}) {
    rails.max_speed_mm_s = value;
    CHECK_THROWS_WITH(check(plan, mechanism, rails), Contains("max_speed_mm_s"));
  }
}

TEST_CASE("a target that only the mirrored assembly of the platform reaches is found", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  // About phi = 60 deg the displacements are symmetric: 80 deg needs the same as 40 deg.
  const Pose mirrored{0, 0, rad_from_deg(80)};
  CHECK_FALSE(reach(machine_of(mechanism), mirrored).ok());
  CHECK(has(check(plan_of({mirrored}), mechanism), 1, Place::target, What::other_mode));
  CHECK(check(plan_of({{0, 0, rad_from_deg(40)}}), mechanism).empty());
}

TEST_CASE("a margin that would check nothing is refused, not passed over", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  const Plan plan = plan_of({{10, 0, 0}});
  const double nan = std::nan("");
  for (const CheckOptions& o : std::vector<CheckOptions>{{.limit_margin_mm = nan},
                                                         {.limit_margin_mm = -1},
                                                         {.limit_margin_mm = INFINITY},
                                                         {.singularity_margin = nan},
                                                         {.singularity_margin = -0.1},
                                                         {.singularity_margin = 1.1},
                                                         {.path_step_mm = 0},
                                                         {.path_step_mm = nan}}) {
    CAPTURE(o.limit_margin_mm, o.singularity_margin, o.path_step_mm);
    CHECK_THROWS_WITH(check(plan, mechanism, o), Contains("margin"));
    CHECK_THROWS_WITH(check_path(mechanism, {}, o), Contains("margin"));
  }
}

TEST_CASE("each kind of violation is described in its own unit", "[plan]") {
  CHECK(describe({.seq = 7,
                  .place = Place::path,
                  .what = What::upper_limit,
                  .got = 611.2,
                  .limit = 598,
                  .drive = "rail 2"}) ==
        "point 7, path: rail 2 above upper limit: 611.200 mm, limit 598.000 mm");
  CHECK(describe({.seq = 5, .what = What::singular, .got = 0.076, .limit = 0.1}) ==
        "point 5, target: near singular: margin 0.076, at least 0.100");
  CHECK(describe({.seq = 3, .what = What::disordered, .got = 3, .limit = 2}) ==
        "point 3, target: out of order: got 3, expected 2");
  CHECK(describe({.seq = 2, .what = What::unreachable, .drive = "rail 1"}) ==
        "point 2, target: rail 1 out of reach");
}

TEST_CASE("points out of order and commands of their own are checked", "[plan]") {
  const Mechanism mechanism = paper_mechanism();
  Plan plan = plan_of({{10, 0, 0}, {20, 0, 0}});
  const std::vector<Displacements> commands = {inverse(mechanism.geometry, Pose{10, 0, 0}).l_mm,
                                               Displacements(599, 270, 250)};
  CHECK(has(check(plan, mechanism, {}, commands), 2, Place::target, What::upper_limit, 1));
  plan.points[1].seq = 3;
  CHECK(has(check(plan, mechanism), 3, Place::target, What::disordered));
}

TEST_CASE("plans of every machine are checked on its own drives", "[plan]") {
  Machine stage = starting_machine("XY");
  CHECK(check(rail_plan(stage, {.half_travel_mm = 100, .targets = 5, .runs = 1}), stage).empty());
  stage.drives[1].limits = {-60, 60};
  const auto all = check(plan_of({{100, 50, 0}, {0, 70, 0}}), stage);
  REQUIRE(all.size() == 1);
  CHECK(has(all, 2, Place::target, What::upper_limit, 2));
  const Machine axis = starting_machine("X");
  const Plan runs = rail_plan(axis, {.half_travel_mm = 50, .targets = 6, .runs = 5});
  CHECK(runs.points.size() == 6 * 5 * 2);
  CHECK(check(runs, axis).empty());
  const Machine uvw = starting_machine("3-PPR");
  CHECK(check(plan_of({{1, 2, 0.01}, {-2, 0, -0.01}}), uvw).empty());
  CHECK(has(check(plan_of({{1, 2, 0.05}}), uvw), 1, Place::target, What::lower_limit, 1));
}

TEST_CASE("cylinders that would meet are seen on the way", "[plan]") {
  const Machine cylinders = starting_machine("3-RPR");
  CHECK(check(plan_of({{20, 10, 0}}), cylinders).empty());
  CHECK(has(check(plan_of({{20, 10, 0}}), cylinders, {.link_clearance_mm = 500}), 1, Place::path,
            What::collision));
}

TEST_CASE("a plan of another machine is refused by the point that tells", "[plan]") {
  CHECK_THROWS_WITH(check(plan_of({{0, 0, 0}, {1, 0, 0.1}}), starting_machine("XY")),
                    Contains("another machine") && Contains("(phi, 2)"));
  CHECK_THROWS_WITH(check(plan_of({{0, 5, 0}}), starting_machine("X")), Contains("y"));
  Plan directed = plan_of({{0, 5, 0}});
  directed.points[0].approach = {1, 0, -1};
  CHECK_THROWS_WITH(check(directed, starting_machine("XY")), Contains("drive 3"));
}

}  // namespace trammel
