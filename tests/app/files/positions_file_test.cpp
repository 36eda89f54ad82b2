#include "app/files/positions_file.hpp"

#include <cmath>
#include <string>

#include "core/error.hpp"
#include "core/units.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

PositionsFile grid(const std::string& text, const std::string& unit = "") {
  return parse_positions(text, "grid.csv", {.unit = unit});
}

PositionsFile axis(const std::string& text, PositionsOptions options = {}) {
  options.one_axis = true;
  return parse_positions(text, "axis.csv", options);
}

const std::string kAerotech =
    "%SerialNumber: 1-2\r\n"
    "%Ax1Name: Y; Ax1Num: 1; Ax1Sign: 1\r\n"
    "%Ax2Name: X; Ax2Num: 3; Ax2Sign: 1\r\n"
    "%UserUnits: MM\r\n"
    "% Ax1TestLoc Ax2TestLoc Ax1CmdPos Ax2CmdPos Ax1RelErr Ax2RelErr\r\n"
    "%\r\n"
    "1.0\t1.0\t-250.000000\t-240.000000\t-0.000780\t0.003340\r\n"
    "2.0\t1.0\t-240.000000\t-240.000000\t-0.000800\t0.003170\r\n";

/// Two runs over two targets; `second` is the order of the second.
std::string rtl(const std::string& second) {
  return "HEADER::\r\nFile type: LINEAR\r\nTARGET DATA::\r\nFiletype: LINEAR\r\nTarget-count: 3\r\n"
         "Targets :\r\n  0.0000  10.0000\r\n  25.0000\r\nFlags: 1 0\r\nUSER-TEXT::\r\nMachine: "
         "lathe\r\n"
         "Axis: X\r\nRUNS::\r\nRun-count: 2\r\nDEVIATIONS::\r\nRun Target Data:\r\n"
         "  1  1  0.5\r\n  1  2  -1.5\r\n  1  3  2\r\n" +
         second + "EQUIPMENT::\r\n";
}

}  // namespace

TEST_CASE("columns are known by role, coordinate and unit in any order of words", "[files]") {
  for (const char* header : {"nominal_x_mm,nominal_y_mm,measured_x_mm,measured_y_mm",
                             "Target X [mm];Target Y [mm];Actual X [mm];Actual Y [mm]",
                             "target_x_mm\ttarget_y_mm\tx_mm\ty_mm"}) {
    INFO(header);
    std::string text = header;
    const char between = text.find(';') != std::string::npos    ? ';'
                         : text.find('\t') != std::string::npos ? '\t'
                                                                : ',';
    text += "\n10 20 10.001 19.998\n";
    for (char& c : text) {
      if (c == ' ' && &c - text.data() > static_cast<long>(std::string(header).size())) c = between;
    }
    const PositionsFile file = grid(text);
    REQUIRE(file.rows.size() == 1);
    CHECK(file.measured == Coordinates{true, true, false});
    CHECK(file.rows[0].target == Pose{10, 20, 0});
    CHECK(file.rows[0].measured == Pose{10.001, 19.998, 0});
    CHECK(file.rows[0].line == 2);
  }
}

TEST_CASE("deviations are added to their targets, each in its unit", "[files]") {
  const PositionsFile file =
      grid("x_mm,y_mm,dx_um,dy_um,phi_urad,target_phi_deg\n100,-50,1.5,-2,30,0\n");
  CHECK_THAT(file.rows[0].measured.x_mm, WithinAbs(100.0015, 1e-12));
  CHECK_THAT(file.rows[0].measured.y_mm, WithinAbs(-50.002, 1e-12));
  CHECK_THAT(file.rows[0].measured.phi_rad, WithinAbs(30e-6, 1e-15));
  CHECK(grid("x,y,dx_um,dy_um\n1,2,3,4\n", "in").rows[0].target.x_mm == 25.4);
}

TEST_CASE("a grid that has two readings or none is refused by its columns", "[files]") {
  CHECK_THROWS_WITH(grid("x,y,dx_um,dy_um\n1,2,3,4\n"), Contains("unit") && Contains("--unit"));
  CHECK_THROWS_WITH(grid("x_mm,y_mm\n1,2\n"), Contains("commanded"));
  CHECK_THROWS_WITH(grid("target_x_mm,target_y_mm\n1,2\n"), Contains("measured"));
  CHECK_THROWS_WITH(grid("target_x_mm,target_y_mm,x_mm\n1,2,3\n"),
                    Contains("y is commanded and not measured"));
  CHECK_THROWS_WITH(grid("target_x_mm,nominal_x_mm,x_mm\n1,2,3\n"), Contains("two columns"));
  CHECK_THROWS_WITH(grid("target_x_mm,target_y_mm,x_mm,y_mm,dx_um\n1,2,3,4,5\n"),
                    Contains("measured position and a deviation"));
  CHECK_THROWS_WITH(grid("target_x_mm,target_y_mm,x_mm,y_mm\n1,2,3,four\n"),
                    Contains("grid.csv:2") && Contains("four"));
  CHECK_THROWS_WITH(grid("target_x_mm,target_y_mm,x_mm,y_mm,phi_mm\n1,2,3,4,5\n"),
                    Contains("unit of angles"));
}

TEST_CASE("an Aerotech calibration file says which of its axes is X", "[files]") {
  const PositionsFile file = grid(kAerotech);
  REQUIRE(file.rows.size() == 2);
  CHECK(file.rows[1].target == Pose{-240, -240, 0});
  CHECK_THAT(file.rows[0].measured.x_mm, WithinAbs(-240 + 0.00334, 1e-12));
  CHECK_THAT(file.rows[0].measured.y_mm, WithinAbs(-250 - 0.00078, 1e-12));
  CHECK(file.facts.at("SerialNumber") == "1-2");
  std::string other = kAerotech;
  other.replace(other.find("Ax2Name: X"), 10, "Ax2Name: Z");
  CHECK_THROWS_WITH(grid(other), Contains("Ax2Name") && Contains("Z"));
  CHECK_THROWS_WITH(grid(kAerotech + "1.0\t2.0\r\n"), Contains("number of columns"));
}

TEST_CASE("runs of an axis carry their directions; one of several axes is asked for", "[files]") {
  const std::string table =
      "axis,target_mm,run,direction,external_mm,resolver_mm\n"
      "one,15.0,1,1,15.042,15.0006\none,15.0,1,-1,15.0349,14.9997\n";
  const PositionsFile file = axis(table);
  REQUIRE(file.rows.size() == 2);
  CHECK(file.rows[0].direction == 1);
  CHECK(file.rows[1].direction == -1);
  CHECK(file.rows[1].measured.x_mm == 15.0349);
  CHECK(file.unused == std::vector<std::string>{"resolver_mm"});
  const std::string two = table + "two,1,1,up,1.001,1\n";
  CHECK_THROWS_WITH(axis(two), Contains("one, two") && Contains("--only"));
  CHECK(axis(two, {.axis = "two"}).rows.size() == 1);
  CHECK_THROWS_WITH(axis("target_mm,direction,position_mm\n1,sideways,1\n"), Contains("direction"));
}

TEST_CASE("an RTL file comes back where its targets do, and where it is said", "[files]") {
  const std::string back = "  2  3  3\r\n  2  2  0.5\r\n  2  1  1\r\n";
  const std::string up = "  2  1  1\r\n  2  2  0.5\r\n  2  3  3\r\n";
  CHECK_THROWS_WITH(axis(rtl(back)), Contains("--unit"));
  const PositionsFile file = axis(rtl(back), {.unit = "um"});
  REQUIRE(file.rows.size() == 6);
  CHECK(file.rows[2].target.x_mm == 25);
  CHECK_THAT(file.rows[1].measured.x_mm, WithinAbs(9.9985, 1e-12));
  CHECK(file.rows[0].direction == 1);
  CHECK(file.rows[3].direction == -1);
  CHECK(file.rows[3].run == 2);
  CHECK(file.facts.at("Machine") == "lathe");
  CHECK_THROWS_WITH(axis(rtl(up), {.unit = "um"}), Contains("--runs"));
  CHECK(axis(rtl(up), {.unit = "um", .runs = "both-ways"}).rows[3].direction == -1);
  CHECK(axis(rtl(up), {.unit = "um", .runs = "one-way"}).rows[3].direction == 1);
  CHECK_THROWS_WITH(axis(rtl("  2  4  1\r\n"), {.unit = "um"}), Contains("target 4"));
  std::string otherwise = rtl(back);  // as other versions head the two lists
  otherwise.replace(otherwise.find("Targets :"), 9, "Target positions (mm):");
  otherwise.replace(otherwise.find("Run Target Data:"), 16, "Run No. Target No. Data:");
  CHECK(axis(otherwise, {.unit = "um"}).rows.size() == 6);
}

TEST_CASE("a bare coordinate is what the other column of it is not", "[files]") {
  for (const char* header :
       {"x_mm,y_mm,measured_x_mm,measured_y_mm",
        "x_mm,y_mm,actual x position mm,actual y position mm", "target_x_mm,target_y_mm,x_mm,y_mm",
        "X axis command mm,Y axis command mm,X real mm,Y real mm",
        "target position x mm,target position y mm,position x mm,position y mm"}) {
    INFO(header);
    const PositionsFile file = grid(std::string(header) + "\n10,20,10.001,19.998\n");
    CHECK(file.rows[0].target == Pose{10, 20, 0});
    CHECK(file.rows[0].measured == Pose{10.001, 19.998, 0});
  }
  CHECK_THROWS_WITH(grid("x_mm,y_mm\n1,2\n"), Contains("commanded"));  // the control
}

TEST_CASE("a node without a measured position is missed, a half of one is refused", "[files]") {
  const std::string header = "x_mm,y_mm,measured_x_mm,measured_y_mm\n";
  const PositionsFile file = grid(header + "0,0,0.001,0.002\n10,0,,\n20,0,20.001,0.001\n");
  CHECK(file.rows.size() == 2);
  CHECK(file.missed == 1);
  CHECK_THROWS_WITH(grid(header + "0,0,0.001,\n"), Contains("grid.csv:2") && Contains("number"));
}

TEST_CASE("a comma is the decimal sign where it parts no columns", "[files]") {
  const PositionsFile file =
      grid("x_mm;y_mm;measured_x_mm;measured_y_mm\n-10;20,5;-10,0015;20,502\n");
  CHECK(file.rows[0].target == Pose{-10, 20.5, 0});
  CHECK(file.rows[0].measured == Pose{-10.0015, 20.502, 0});
  CHECK_THROWS_WITH(grid("x_mm;y_mm;measured_x_mm;measured_y_mm\n1;2;1,0,5;2\n"),
                    Contains("1,0,5"));
}

TEST_CASE("a table without names, and an axis that it has not, are refused by what is there",
          "[files]") {
  CHECK_THROWS_WITH(grid("5,7,5.001,7.002\n10,0,10.001,0\n"), Contains("names the columns"));
  CHECK_THROWS_WITH(axis("axis,target_mm,position_mm\none,1,1\ntwo,1,1\n", {.axis = "three"}),
                    Contains("three") && Contains("one, two"));
}
