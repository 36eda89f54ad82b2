#include "app/files/points_file.hpp"

#include "app/files/points_text.hpp"
#include "core/error.hpp"
#include "core/statistics/random.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;

namespace {

PointsFile points_of(const std::string& text, const PointsOptions& options = {}) {
  return parse_points(text, "p.txt", options);
}

const std::string kSa =
    "// SpatialAnalyzer SA 2024.2.0923.4 ( x64 )  \n"
    "// Points Relative to Coordinate Frame 'A::WORLD'\n"
    "// AXES = CARTESIAN: X,  Y,  Z (mm)\n"
    "Job,  Pose1,  1,  2296.361958,  -2416.231503,  -442.642166,  02/13/25 16:40:57\n"
    "Job,  Pose1,  2,  2296.361154,  -2416.232313,  -442.641916,  02/13/25 16:40:57";

}  // namespace

TEST_CASE("SpatialAnalyzer's points come with frame, unit, group and time", "[points]") {
  const PointsFile file = points_of(kSa);
  CHECK(file.format == "sa");
  CHECK(file.frame == "A::WORLD");
  CHECK_THAT(file.program, Contains("2024.2.0923.4"));
  CHECK((file.unit == "mm" && file.unit_stated));
  REQUIRE(file.rows.size() == 2);  // the last line has no newline
  CHECK(file.rows[1].line == 5);
  CHECK(file.rows[1].group == "Pose1");
  CHECK(file.rows[1].name == "2");
  CHECK(file.rows[1].at_mm == Eigen::Vector3d(2296.361154, -2416.232313, -442.641916));
  CHECK(file.rows[0].clock->of_day_s == file.rows[1].clock->of_day_s);  // two samples in a second
  CHECK(file.dates.order == DateOrder::month_first);
  CHECK_THAT(file.rows[0].raw, Contains("Job,  Pose1,  1,  2296.361958"));
}

TEST_CASE("each format is recognised by its first full line", "[points]") {
  struct Case {
    const char* text;
    const char* format;
    const char* name;
  };
  for (const Case& c :
       std::vector<Case>{{"1,  2296.497861,  -2416.256713,  -442.566334\n", "sa-short", "1"},
                         {"P5;-274.556;-3189.212;-248.113;;;;\n", "delimited", "P5"},
                         {"P5\t-274.556\t-3189.212\t-248.113\n", "delimited", "P5"},
                         {"# a comment\n\nP5  -274.556 -3189.212  -248.113\r\n", "delimited", "P5"},
                         {"2.641549556999999822e+03 1.622e+02 -7.85e+00\n", "matrix", ""},
                         {"0 0 0\n2641.5 162.2 -7.85\n", "matrix", ""},
                         {",,\n2641.5,162.2,-7.85\n", "matrix", ""},
                         {"\xEF\xBB\xBF"
                          "a;1;2;3\n",
                          "delimited", "a"}}) {
    CAPTURE(c.text);
    const PointsFile file = points_of(c.text);
    CHECK(file.format == c.format);
    CHECK(file.rows.back().name == c.name);
    CHECK_FALSE(file.unit_stated);
  }
}

TEST_CASE("Leica's CSV: code page 1252, apostrophe, empty last column, temperature, U(95)",
          "[points]") {
  const PointsFile file =
      read_points(tests::source_folder() + "/examples/tracker-files/leica.csv", {});
  CHECK(file.format == "leica-csv");
  CHECK(file.code_page_1252);
  CHECK(file.dates.order == DateOrder::day_first);
  REQUIRE(file.rows.size() == 151);
  CHECK(file.rows[0].line == 2);
  CHECK(file.rows[0].u95_mm == 0.012);
  CHECK(file.rows[0].temp_degc == 20.0);
  CHECK_THAT(file.rows[0].clock->of_day_s, WithinAbs(9 * 3600 + 3.62, 1e-9));
  CHECK(file.rows[0].name.empty());  // Target names the reflector, not the point
  CHECK(file.rows[0].raw.find('\r') == std::string::npos);
  int deleted = 0, without_u95 = 0;
  for (const PointRow& row : file.rows) {
    deleted += row.miss == Miss::deleted ? 1 : 0;
    without_u95 += row.u95_mm == 0.0 ? 1 : 0;
  }
  CHECK(deleted == 1);
  CHECK(without_u95 == 3);
}

TEST_CASE("misses are what the options say they are", "[points]") {
  const std::string text = "a,1,2,3\nb,0,0,0\nc,,,\nd,0.0,0e5,-0\n";
  const PointsFile all = points_of(text);
  REQUIRE(all.rows.size() == 4);
  CHECK_FALSE(all.rows[0].miss);
  CHECK(all.rows[1].miss == Miss::zero);
  CHECK(all.rows[2].miss == Miss::empty);
  CHECK(all.rows[3].miss == Miss::zero);
  CHECK_FALSE(points_of(text, {.misses = {Miss::empty}}).rows[1].miss);  // in the robot's frame
  CHECK_THROWS_WITH(points_of(text, {.misses = {Miss::zero}}), Contains("p.txt:3"));
}

TEST_CASE("units are converted, and a stated unit is not overruled", "[points]") {
  CHECK(points_of("a,1,2,3\n", {.unit = "m"}).rows[0].at_mm == Eigen::Vector3d(1000, 2000, 3000));
  CHECK(points_of("a,1,2,3\n", {.unit = "in"}).rows[0].at_mm.x() == 25.4);
  std::string inches = kSa;
  inches.replace(inches.find("(mm)"), 4, "(Inches)");
  CHECK_THAT(points_of(inches).rows[0].at_mm.x(), WithinRel(25.4 * 2296.361958, 1e-12));
  inches.replace(inches.find("(Inches)"), 8, "(ells)");
  CHECK_THROWS_WITH(points_of(inches), Contains("unknown unit") && Contains("ells"));
  CHECK_THROWS_WITH(points_of(kSa, {.unit = "m"}), Contains("states its unit as mm"));
  std::string polar = kSa;
  polar.replace(polar.find("CARTESIAN"), 9, "SPHERICAL");
  CHECK_THROWS_WITH(points_of(polar), Contains("not cartesian"));
}

TEST_CASE("a decimal comma is read when it is asked for, and hinted at when not", "[points]") {
  CHECK(points_of("P5;-274,556;-3189,2;-248,1\n", {.decimal = ','}).rows[0].at_mm.x() == -274.556);
  CHECK_THROWS_WITH(points_of("P5;-274,556;-3189,2;-248,1\n"), Contains("comma the decimal sign"));
  const std::string leica = "SEP=;\r\n\"X [mm]\";\"Y [mm]\";\"Z [mm]\"\r\n\"1,5\";2;3\r\n\r\n";
  CHECK(points_of(leica, {.decimal = ','}).rows[0].at_mm.x() == 1.5);
  CHECK_THROWS_WITH(points_of(leica), Contains("comma the decimal sign"));
  CHECK(points_of("\"X [mm]\",Y [mm],Z [mm]\n\"1,5\",\"2,0\",3\n", {.decimal = ','})
            .rows[0]
            .at_mm.y() == 2);
}

TEST_CASE("what is no point is refused with file, line, column and field", "[points]") {
  CHECK_THROWS_WITH(points_of("a,1,2,3\nb,1,x,3\n"),
                    Contains("p.txt:2:5") && Contains("y") && Contains("'x'"));
  CHECK_THROWS_WITH(points_of("a,1,2,3\nb,1,nan,3\n"), Contains("'nan'"));
  CHECK_THROWS_WITH(points_of("a,1,2,3\nb,1,2,3,4\n"), Contains("more fields"));
  CHECK_THROWS_WITH(points_of(kSa + "x\n"), Contains("p.txt:5") && Contains("no time"));
  CHECK_THROWS_WITH(points_of("name,x,y,z\na,1,2,3\n"), Contains("p.txt:1"));
  CHECK_THROWS_WITH(points_of("2641.5 162.2 -785.3 0.01\n"), Contains("no known format"));
  CHECK_THROWS_WITH(points_of("a,1,2,3\n", {.format = "sa"}), Contains("not in the format sa"));
  CHECK_THROWS_WITH(points_of("hello\n"), Contains("no known format") && Contains("leica-csv"));
  CHECK_THROWS_WITH(points_of("// nothing\n"), Contains("no points"));
  CHECK_THROWS_WITH(points_of(std::string("a\0b", 3)), Contains("UTF-16"));
  CHECK_THROWS_AS(points_of(std::string(30'000, '1')), InputError);
  CHECK_THROWS_AS(read_points("nowhere.txt", {}), NotFoundError);
}

TEST_CASE("a Leica row that is cut short is no point", "[points]") {
  const std::string text =
      "X  [mm],Y  [mm],Z  [mm],Target,Time Stamp,Delete\n"
      "1.5,2.5,3.5,CCR,'13.02.2025 09:00:03.620,\n";
  CHECK(points_of(text).rows.size() == 1);
  CHECK_THROWS_WITH(points_of(text + "1.5,2.5,3"), Contains("p.txt:3") && Contains("missing"));
}

TEST_CASE("code page 1252 becomes UTF-8 and UTF-8 stays", "[points]") {
  CHECK(from_code_page_1252("\xB0 \x80 a") == "\xC2\xB0 \xE2\x82\xAC a");
  CHECK(is_utf8("\xC2\xB0 \xE2\x82\xAC a"));
  CHECK_FALSE(is_utf8("\xB0"));
  CHECK_FALSE(is_utf8("\xE2\x82"));
  CHECK(points_of("\xDC"
                  "1;1;2;3\n")
            .rows[0]
            .name ==
        "\xC3\x9C"
        "1");
}

TEST_CASE("text changed anywhere is read or refused, and nothing else", "[points]") {
  const std::string leica =
      tests::read_text(tests::source_folder() + "/examples/tracker-files/leica.csv").substr(0, 900);
  Random random(17);
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string text = trial % 2 == 0 ? kSa : leica;
    for (int k = 0; k < 3; ++k) {
      const auto at = static_cast<std::size_t>(random.below(text.size()));
      if (k == 0) text[at] = static_cast<char>(random.below(256));
      if (k == 1) text.erase(at, random.below(4));
      if (k == 2) text.insert(at, 1, ",;\n \t'-"[random.below(7)]);
    }
    try {
      for (const PointRow& row : points_of(text).rows) CHECK(row.at_mm.allFinite());
    } catch (const Error& error) {
      refused += error.code() == ExitCode::invalid_data ? 1 : 0;
    }
  }
  CHECK((refused > 200 && refused < 1990));
}
