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
  for (const WorkspaceCell& cell : workspace(machine_of(paper_mechanism()), {100, 10, 0})) {
    INFO(cell.pose.x_mm << ", " << cell.pose.y_mm);
    CHECK(cell.reach.ok());
    CHECK(cell.reach.stroke_left_mm > 50);
    CHECK(cell.reach.singularity.margin() > 0.3);
  }
}

TEST_CASE("the workspace looks the same after a turn by 120 deg", "[mechanism]") {
  const Machine mechanism = machine_of(paper_mechanism());
  for (const WorkspaceCell& cell : workspace(mechanism, {500, 50, rad_from_deg(5)})) {
    const Reach other = reach(mechanism, turned_by_120(cell.pose));
    REQUIRE(other.status == cell.reach.status);
    if (!other.ok()) continue;
    CHECK_THAT(other.stroke_left_mm, WithinAbs(cell.reach.stroke_left_mm, 1e-9));
    CHECK_THAT(other.singularity.margin(), WithinAbs(cell.reach.singularity.margin(), 1e-9));
  }
}

TEST_CASE("a pose beyond a limit, out of reach or not finite says which chain", "[mechanism]") {
  Machine mechanism = machine_of(paper_mechanism());
  const Pose up{0, 100, 0};
  mechanism.drives[0].limits.l_min_mm = drives_at(mechanism, up).q_mm[0] + 0.5;
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

TEST_CASE("a pose beyond a singularity is not ok, though its drives are within the stroke",
          "[mechanism]") {
  const Machine machine = machine_of(paper_mechanism());
  const Reach at = reach(machine, {0, 0, rad_from_deg(60)});
  CHECK(at.status == Reach::Status::singular);
  CHECK(at.assembly == 0);
  CHECK(at.stroke_left_mm > 0);
  CHECK(reach(machine, {0, 0, rad_from_deg(59)}).ok());
  const Reach beyond = reach(machine, {0, 0, rad_from_deg(61)});
  CHECK(beyond.status == Reach::Status::other_assembly);
  CHECK(beyond.assembly == -1);
  int reachable = 0;
  const auto map = workspace(machine, {150, 10, rad_from_deg(70)});
  for (const WorkspaceCell& cell : map) reachable += cell.reach.ok() ? 1 : 0;
  CHECK(reachable < 30);
  Machine lost = machine;
  lost.home = {5000, 0, 0};  // no assembly of home is known: none is called the other
  CHECK(reach(lost, {0, 0, rad_from_deg(61)}).ok());
}

TEST_CASE("the grid of an axis is a line, and an XY stage does not turn", "[mechanism]") {
  const auto line = workspace(starting_machine("X"), {20, 10, 0.3});
  REQUIRE(line.size() == 5);
  CHECK(line.back().pose == Pose{20, 0, 0});
  const auto square = workspace(starting_machine("XY"), {160, 20, 0.3});
  REQUIRE(square.size() == 17 * 17);
  for (const WorkspaceCell& cell : square) {
    CHECK(cell.pose.phi_rad == 0);
    const double farthest = std::max(std::abs(cell.pose.x_mm), std::abs(cell.pose.y_mm));
    CHECK(cell.reach.ok() == (farthest <= 150));
    CHECK_THAT(cell.reach.singularity.margin(), WithinAbs(1, 1e-12));
    CHECK_THAT(cell.reach.stroke_left_mm, WithinAbs(150 - farthest, 1e-9));
  }
}

TEST_CASE("a workspace grid holds every cell once, and refuses what is no grid", "[mechanism]") {
  const auto map = workspace(machine_of(paper_mechanism()), {20, 10, 0.1});
  REQUIRE(map.size() == 25);
  CHECK(map.front().pose == Pose{-20, -20, 0.1});
  CHECK(map[1].pose == Pose{-10, -20, 0.1});
  CHECK(map.back().pose == Pose{20, 20, 0.1});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(workspace(machine_of(paper_mechanism()), {100, 0, 0}), InputError);
  CHECK_THROWS_AS(workspace(machine_of(paper_mechanism()), {nan, 10, 0}), InputError);
  CHECK_THROWS_AS(workspace(machine_of(paper_mechanism()), {100, 10, nan}), InputError);
  CHECK_THROWS_AS(workspace(machine_of(paper_mechanism()), {1e6, 1, 0}), InputError);
}

}  // namespace trammel
