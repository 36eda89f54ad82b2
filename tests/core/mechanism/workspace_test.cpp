#include "core/mechanism/workspace.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

namespace trammel {

namespace {

Pose turned_by_120(const Pose& pose) {
  const double c = std::cos(rad_from_deg(120)), s = std::sin(rad_from_deg(120));
  return {c * pose.x_mm - s * pose.y_mm, s * pose.x_mm + c * pose.y_mm, pose.phi_rad};
}

}  // namespace

TEST_CASE("the paper's points are reachable and far from singular", "[mechanism]") {
  for (const WorkspaceCell& cell : workspace(paper_mechanism(), {100, 10, 0})) {
    INFO(cell.pose.x_mm << ", " << cell.pose.y_mm);
    CHECK(cell.reach.ok());
    CHECK(cell.reach.stroke_left_mm > 50);
    CHECK(cell.reach.singularity.margin() > 0.3);
  }
}

TEST_CASE("the workspace looks the same after a turn by 120 deg", "[mechanism]") {
  const Mechanism mechanism = paper_mechanism();
  for (const WorkspaceCell& cell : workspace(mechanism, {500, 50, rad_from_deg(5)})) {
    const Reach other = reach(mechanism, turned_by_120(cell.pose));
    REQUIRE(other.status == cell.reach.status);
    if (!other.ok()) continue;
    CHECK_THAT(other.stroke_left_mm, WithinAbs(cell.reach.stroke_left_mm, 1e-9));
    CHECK_THAT(other.singularity.margin(), WithinAbs(cell.reach.singularity.margin(), 1e-9));
  }
}

TEST_CASE("a pose beyond a limit, out of reach or not finite says which chain", "[mechanism]") {
  Mechanism mechanism = paper_mechanism();
  const Pose up{0, 100, 0};
  const double l1 = inverse(mechanism.geometry, up).l_mm[0];
  mechanism.limits.l_min_mm = l1 + 0.5;
  const Reach low = reach(mechanism, up);
  CHECK(low.status == Reach::Status::limit);
  CHECK(low.chain == 0);
  CHECK_THAT(low.stroke_left_mm, WithinAbs(-0.5, 1e-12));
  const Reach far = reach(mechanism, {1000, 0, 0});
  CHECK(far.status == Reach::Status::unreachable);
  CHECK(far.chain == 0);  // its rail is vertical: it cannot follow along x
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(reach(mechanism, {0, nan, 0}).status == Reach::Status::not_finite);
}

TEST_CASE("a workspace grid holds every cell once, and refuses what is no grid", "[mechanism]") {
  const auto map = workspace(paper_mechanism(), {20, 10, 0.1});
  REQUIRE(map.size() == 25);
  CHECK(map.front().pose == Pose{-20, -20, 0.1});
  CHECK(map[1].pose == Pose{-10, -20, 0.1});
  CHECK(map.back().pose == Pose{20, 20, 0.1});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(workspace(paper_mechanism(), {100, 0, 0}), InputError);
  CHECK_THROWS_AS(workspace(paper_mechanism(), {nan, 10, 0}), InputError);
  CHECK_THROWS_AS(workspace(paper_mechanism(), {100, 10, nan}), InputError);
  CHECK_THROWS_AS(workspace(paper_mechanism(), {1e6, 1, 0}), InputError);
}

}  // namespace trammel
