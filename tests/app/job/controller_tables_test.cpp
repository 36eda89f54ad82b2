#include "app/job/controller_tables.hpp"

#include <cmath>
#include <sstream>

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
