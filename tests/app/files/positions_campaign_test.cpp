#include "app/files/positions_campaign.hpp"

#include <algorithm>
#include <string>

#include "core/error.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

/// n x n nodes at 10 mm from `from` on, each 1 um further in x.
PositionsFile grid(int n, double from_mm) {
  PositionsFile file{.name = "stage.csv", .format = "table"};
  file.targeted = file.measured = {true, true, false};
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const Pose target{from_mm + 10 * i, from_mm + 10 * j, 0};
      file.rows.push_back({.line = static_cast<int>(file.rows.size()) + 2,
                           .target = target,
                           .measured = {target.x_mm + 0.001, target.y_mm, 0}});
    }
  }
  return file;
}

PositionsFile runs() {
  PositionsFile file{.name = "axis.csv", .format = "table"};
  file.targeted = file.measured = {true, false, false};
  for (const double target : {10.0, 30.0, 35.0}) {
    for (const int direction : {1, -1}) {
      file.rows.push_back({.target = {target, 0, 0},
                           .measured = {target - 0.002 * direction, 0, 0},
                           .direction = direction,
                           .run = 1});
    }
  }
  return file;
}

}  // namespace

TEST_CASE("a grid becomes a campaign of an XY stage, what was assumed in its facts", "[files]") {
  const Campaign c = campaign_of_positions(grid(6, -20), {});
  CHECK(c.name == "stage");
  CHECK(c.machine.kind->name == "XY");
  CHECK(c.machine.measured == Coordinates{true, true, false});
  CHECK(c.machine.home == Pose{});
  REQUIRE(c.readings.size() == 36);
  const Reading& r = c.readings[7];
  CHECK(r.seq == 8);
  CHECK((r.conditions.cmd_mm - Displacements(r.target.x_mm, r.target.y_mm, 0)).norm() < 1e-12);
  CHECK(r.conditions.from_mm == r.conditions.cmd_mm);  // no direction is invented
  CHECK(c.facts.at("machine").find("assumed") == 0);
  CHECK(c.facts.at("approach").find("not known") == 0);
  CHECK(campaign_of_positions(grid(3, 100), {}).machine.home == Pose{110, 110, 0});
  const Campaign walked = campaign_of_positions(grid(6, -20), {.in_order = true});
  CHECK(walked.readings[7].conditions.from_mm == walked.readings[6].conditions.cmd_mm);
}

TEST_CASE("every third line of a grid is fitted, all other nodes validate", "[files]") {
  const Campaign c = campaign_of_positions(grid(6, 0), {.fit_every = 3});
  const auto fitted = std::ranges::count(c.readings, ReadingSet::identify, &Reading::set);
  CHECK(fitted == 4);
  CHECK(c.readings[0].set == ReadingSet::identify);
  CHECK(c.readings[21].set == ReadingSet::identify);  // (3, 3)
  CHECK(c.readings[3 * 6 + 4].set == ReadingSet::validate);
}

TEST_CASE("an axis arrives from the nearest other target's distance", "[files]") {
  const Campaign c = campaign_of_positions(runs(), {.kind = "X", .name = "carriage"});
  CHECK(c.name == "carriage");
  CHECK(c.machine.kind->name == "X");
  CHECK(c.readings[0].conditions.from_mm[0] == 5);
  CHECK(c.readings[1].conditions.from_mm[0] == 15);
  CHECK(c.readings[1].conditions.cmd_mm[1] == 0);
  CHECK(c.machine.home.x_mm == 22.5);
}

TEST_CASE("a file of another machine is refused by what is wrong", "[files]") {
  const auto with = [](const char* kind) {
    return PositionsUse{.kind = "XY", .machine = starting_machine(kind)};
  };
  CHECK_THROWS_WITH(campaign_of_positions(grid(3, 0), with("3-PRR")), Contains("another machine"));
  CHECK_THROWS_WITH(campaign_of_positions(grid(3, 0), with("X")), Contains("XY"));
  CHECK_THROWS_WITH(campaign_of_positions(runs(), {}), Contains("y") && Contains("--axis"));
  CHECK_THROWS_WITH(campaign_of_positions(grid(3, 0), {.kind = "X"}), Contains("x alone"));
  PositionsUse turned = with("XY");
  turned.machine->measured = {true, true, true};
  CHECK_THROWS_WITH(campaign_of_positions(grid(3, 0), turned),
                    Contains("phi") && Contains("column"));
  PositionsFile with_phi = runs();
  with_phi.measured[2] = true;
  CHECK_THROWS_WITH(campaign_of_positions(with_phi, {.kind = "X"}),
                    Contains("phi cannot be measured"));
  PositionsFile directed = grid(3, 0);
  directed.rows[0].direction = 1;
  CHECK_THROWS_WITH(campaign_of_positions(directed, {}), Contains("--in-order"));
}
