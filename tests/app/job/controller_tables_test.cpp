#include "app/job/controller_tables.hpp"

#include <cmath>
#include <sstream>

#include "app/job/plane_table.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;

namespace {

/// Drives alone are wrong: what each needs depends on its own position and direction.
RobotModel wrong_drives() {
  RobotModel robot = nominal_model(paper_mechanism());
  robot.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(0.0003, -0.0002, 0)},
                   {&find_effect("backlash"), Eigen::Vector3d(0.08, 0, 0.02)}};
  return robot;
}

ControllerTables tables_for(const RobotModel& robot) {
  return controller_tables(ModelCorrection{robot}, robot.mechanism(), {}, 5);
}

}  // namespace

TEST_CASE("errors of the drives alone are carried whole, backlash by the two directions", "[job]") {
  const ControllerTables tables = tables_for(wrong_drives());
  CHECK(tables.n_unreachable == 0);
  CHECK(tables.n_targets == 441);
  for (const DriveTables& d : tables.drives) {
    CHECK(d.left.max_mm < 1e-5);
    CHECK(d.grid.max_mm < 1e-5);
  }
  CHECK(tables.drives[0].before.max_mm > 0.04);
  // Lost motion of w: a rail that arrives upwards stands w lower than one that arrives downwards.
  for (const auto& [rail, w_mm] : {std::pair{0, 0.08}, {1, 0.0}, {2, 0.02}}) {
    const DriveTables& d = tables.drives[static_cast<std::size_t>(rail)];
    for (std::size_t k = 0; k < d.forward.values_mm.size(); ++k) {
      CHECK_THAT(d.forward.values_mm[k] - d.reverse.values_mm[k], WithinAbs(w_mm, 1e-4));
    }
  }
}

TEST_CASE("the tables bring a robot of wrong drives to its targets", "[job]") {
  const RobotModel robot = wrong_drives();
  const ControllerTables tables = tables_for(robot);
  for (const int direction : {1, -1}) {
    const Pose target{37, -61, rad_from_deg(0)};
    Conditions conditions;
    const Displacements l_mm = inverse(geometry_of(robot.nominal), target).l_mm;
    for (int i = 0; i < kChains; ++i) {
      const DriveTables& d = tables.drives[static_cast<std::size_t>(i)];
      conditions.cmd_mm[i] = l_mm[i] + (direction > 0 ? d.forward : d.reverse).at(l_mm[i]);
      conditions.from_mm[i] = conditions.cmd_mm[i] - direction;
    }
    const Prediction at = predict(robot, conditions);
    REQUIRE(at.ok());
    CHECK(std::hypot(at.pose.x_mm - target.x_mm, at.pose.y_mm - target.y_mm) < 1e-4);
  }
}

TEST_CASE("what depends on other rails is left, and said", "[job]") {
  RobotModel robot = wrong_drives();
  robot.machine.chains[1][0] += rad_from_deg(0.02);
  const ControllerTables tables = tables_for(robot);
  CHECK(tables.drives[1].left.max_mm > 0.01);
  CHECK(tables.drives[1].grid.max_mm < tables.drives[1].left.max_mm);
  const auto both = table_words(tables, true), one = table_words(tables, false);
  CHECK(one.size() == both.size() + 2);  // drives 1 and 3 have backlash
  CHECK_THAT(one[1], Contains("differ by up to 80.0 um") && Contains("can't carry"));
}

TEST_CASE(
    "LinuxCNC's files are three numbers a line, rising, and Aerotech's the mean of both sides",
    "[job]") {
  const ControllerTables tables = tables_for(wrong_drives());
  const auto files = linuxcnc_files(tables, "cnc");
  REQUIRE(files.size() == 3);
  CHECK(files[2].name == "cnc.2.comp");
  CHECK_THAT(linuxcnc_ini(files),
             Contains("[JOINT_1]\nCOMP_FILE = cnc.1.comp\nCOMP_FILE_TYPE = 1"));
  std::istringstream lines(files[0].text);
  std::size_t n = 0;
  double last_mm = -1e9;
  for (double at_mm = 0, up_mm = 0, down_mm = 0; lines >> at_mm >> up_mm >> down_mm; ++n) {
    CHECK(at_mm > last_mm);
    CHECK_THAT(up_mm, WithinAbs(tables.drives[0].forward.at(at_mm), 1e-6));
    CHECK_THAT(down_mm, WithinAbs(tables.drives[0].reverse.at(at_mm), 1e-6));
    last_mm = at_mm;
  }
  CHECK(lines.eof());
  CHECK(n == tables.drives[0].forward.values_mm.size());
  CHECK(n <= kLinuxCncKnots);
  const std::string cal = aerotech_file(tables, "a.cal").text;
  const DriveTables& d = tables.drives[0];
  CHECK_THAT(cal, Contains(":START1D INAXIS=1 OUTAXIS=1") && Contains(":START1D INAXIS=3"));
  std::ostringstream first;
  first.setf(std::ios::fixed);
  first.precision(6);
  first << "\n" << (d.forward.values_mm[0] + d.reverse.values_mm[0]) / 2 << "\n";
  CHECK_THAT(cal, Contains(first.str()));
}

namespace {

/// An XY stage out of square, its x screw long and its y guide bent.
RobotModel wrong_stage() {
  RobotModel robot = nominal_model(starting_machine("XY"));
  robot.machine.chains[0][0] += 2e-4;  // the direction of an axis, rad
  robot.effects = {{&find_effect("lead_scale"), Eigen::Vector3d(0.0004, 0, 0)},
                   {&find_effect("guide_bow"), Eigen::Vector3d(0, 2e-6, 0)},
                   {&find_effect("backlash"), Eigen::Vector3d(0.004, 0, 0)}};
  return robot;
}

}  // namespace

TEST_CASE("a table over the plane carries what depends on both axes, to half the reversal",
          "[job]") {
  const RobotModel robot = wrong_stage();
  const PlaneTable table =
      plane_table(ModelCorrection{robot}, robot.nominal, {.half_width_mm = 80}, 10);
  CHECK(table.side == 17);
  CHECK_THAT(table.directions_mm, WithinAbs(0.004, 1e-5));
  for (const std::size_t axis : {0U, 1U}) {
    CHECK(table.before[axis].max_mm > 0.01);
    CHECK(table.grid[axis].max_mm < 1e-4);  // a parabola of 2e-6 / mm between nodes: 5e-5 mm
    CHECK(table.left[axis].max_mm < 0.0021);
  }
  // Tables of each axis alone leave what the other axis does.
  const ControllerTables alone =
      controller_tables(ModelCorrection{robot}, robot.nominal, {.half_width_mm = 80}, 10);
  CHECK(alone.drives[1].left.max_mm + alone.drives[0].left.max_mm >
        2 * (table.left[0].max_mm + table.left[1].max_mm));
  // The stage under the table stands on its targets, from either side to half the reversal.
  for (const int direction : {1, -1}) {
    Conditions c;
    c.cmd_mm = drives_of(robot.nominal, {37, -61, 0});
    c.cmd_mm.head<2>() += table.at(37, -61);
    c.from_mm = c.cmd_mm - Displacements::Constant(direction);
    const Prediction at = predict(robot, c);
    REQUIRE(at.ok());
    CHECK(std::hypot(at.pose.x_mm - 37, at.pose.y_mm + 61) < 0.0021);
  }
}

TEST_CASE("Aerotech's 2D file is rows of pairs, and only an XY stage has one", "[job]") {
  const RobotModel robot = wrong_stage();
  const PlaneTable table =
      plane_table(ModelCorrection{robot}, robot.nominal, {.half_width_mm = 20}, 10);
  std::istringstream text(aerotech_file(table, "stage.cal").text);
  std::string line;
  int rows = 0;
  while (std::getline(text, line)) {
    if (line.starts_with("'") || line.starts_with(":")) continue;
    std::istringstream numbers(line);
    Eigen::Vector2d v;
    for (int column = 0; column < table.side; ++column) {
      REQUIRE((numbers >> v[0] >> v[1]));
      CHECK((v - table.values_mm[static_cast<std::size_t>(rows * 5 + column)]).norm() < 1e-6);
    }
    ++rows;
  }
  CHECK(rows == 5);
  CHECK_THROWS_AS(plane_table(ModelCorrection{wrong_drives()}, paper_mechanism(), {}, 10),
                  InputError);
  CHECK_THROWS_AS(plane_table(ModelCorrection{robot}, robot.nominal, {.half_width_mm = 4000}, 10),
                  InputError);  // too many nodes
  CHECK_THROWS_AS(plane_table(ModelCorrection{robot}, robot.nominal, {.half_width_mm = 1500}, 10),
                  InputError);  // beyond the stroke
}
