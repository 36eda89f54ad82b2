#include "app/files/commands_csv.hpp"

#include "core/error.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;

TEST_CASE("a command moves from where the one before ended, the first from home", "[exchange]") {
  const tests::TemporaryFolder folder;
  const auto file = folder.write("c.csv",
                                 "cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,epoch,temp_degc,x_note\n"
                                 "260,261,262,2,21.5,mine\n263,264,265,,,\n");
  const Machine robot = machine_of(paper_mechanism());
  const std::vector<CommandRow> rows = read_commands_csv(file, robot);
  REQUIRE(rows.size() == 2);
  CHECK(rows[0].conditions.from_mm == drives_of(robot, robot.home));
  CHECK(rows[0].conditions.epoch == 2);
  CHECK(rows[0].conditions.temp_degc == 21.5);
  CHECK(rows[1].conditions.from_mm == Displacements(260, 261, 262));
  CHECK(rows[1].conditions.epoch == 1);
  CHECK_FALSE(rows[1].conditions.temp_degc);
  CHECK(rows[1].seq == 2);
}

TEST_CASE("a readings.csv serves as commands", "[exchange]") {
  const auto rows = read_commands_csv(
      tests::source_folder() + "/tests/support/campaigns/drive-error/readings.csv",
      machine_of(paper_mechanism()));
  CHECK(rows.size() > 80);
}

TEST_CASE("commands that cannot be meant are refused with line and field", "[exchange]") {
  struct Bad {
    const char* text;
    int line;
    const char* field;
  };
  const std::vector<Bad> all = {{"cmd_l1_mm,cmd_l2_mm\n1,2\n", 1, "cmd_l3_mm"},
                                {"cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,speed\n1,2,3,4\n", 1, "speed"},
                                {"cmd_l1_mm,cmd_l2_mm,cmd_l3_mm\n1,2,3\n1,nan,3\n", 3, "cmd_l2_mm"},
                                {"cmd_l1_mm,cmd_l2_mm,cmd_l3_mm\n1,,3\n", 2, "cmd_l2_mm"},
                                {"cmd_l1_mm,cmd_l2_mm,cmd_l3_mm,epoch\n1,2,3,1.5\n", 2, "epoch"}};
  const tests::TemporaryFolder folder;
  for (const Bad& bad : all) {
    CAPTURE(bad.text);
    try {
      static_cast<void>(
          read_commands_csv(folder.write("c.csv", bad.text), machine_of(paper_mechanism())));
      FAIL("accepted");
    } catch (const InputError& error) {
      CHECK(error.text().where.line == bad.line);
      CHECK(error.text().where.field == bad.field);
    }
  }
}

TEST_CASE("commands of an XY stage have two drives, and a third is refused by its column",
          "[exchange]") {
  const tests::TemporaryFolder folder;
  const Machine stage = starting_machine("XY");
  const auto rows = read_commands_csv(
      folder.write("c.csv", "cmd_l1_mm,cmd_l2_mm,from_l1_mm,from_l2_mm\n5,-6,4,-7\n"), stage);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].conditions.cmd_mm == Displacements(5, -6, 0));
  CHECK(rows[0].conditions.from_mm == Displacements(4, -7, 0));
  CHECK_THROWS_WITH(
      read_commands_csv(folder.write("c.csv", "cmd_l1_mm,cmd_l2_mm,cmd_l3_mm\n1,2,3\n"), stage),
      Contains("c.csv:1:21") && Contains("a drive that the machine has not"));
}
