// Pictures of a report whose errors are known.

#include "app/report/picture.hpp"

#include "app/terminal/columns.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

#include <sstream>

using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using namespace trammel;
using namespace trammel::report;

namespace {

/// Errors on a lattice of 20 mm that grow with x: 0.1, 0.2, 0.3, 0.4 mm; after: an eighth of it.
ErrorTable growing() {
  ErrorTable table{.id = "lsq-12-position", .method = "lsq", .figure = "position", .unit = "mm"};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      const double before = 0.1 * (column + 1);
      table.points.push_back({20.0 * column - 30, 20.0 * row - 20, before, before / 8});
    }
  }
  table.before = {.n = 12, .mean = 0.25, .max = 0.4};
  table.after = {.n = 12, .mean = 0.03125, .max = 0.05};
  return table;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) {
    ++n;
  }
  return n;
}

}  // namespace

TEST_CASE("the map shows each point where it is, before and after on one scale", "[report]") {
  const std::string map = error_map(growing(), Glyphs::blocks);
  CAPTURE(map);
  CHECK(map ==
        "  y mm  before      after\n"
        "    20  ▂ ▄ ▆ █     ▁ ▁ ▁ ▁\n"
        "        ▂ ▄ ▆ █     ▁ ▁ ▁ ▁\n"
        "   -20  ▂ ▄ ▆ █     ▁ ▁ ▁ ▁\n"
        "  x mm  -30  30     -30  30\n"
        "▁ to 0.0500, ▄ to 0.2000, █ to 0.4000 mm; a cell is 20 mm\n");
  const std::string ascii = error_map(growing(), Glyphs::ascii);
  CHECK_THAT(ascii, Contains("    20  : = * @     . . . .\n"));
  for (const char byte : ascii) CHECK(static_cast<unsigned char>(byte) < 0x80);
}

TEST_CASE("points nearer than a column of the map share a cell, which shows their mean",
          "[report]") {
  ErrorTable table = growing();
  table.points.clear();
  for (int k = 0; k <= 400; ++k) {  // a line of 400 mm, one point a millimetre
    table.points.push_back({k - 200.0, 0, k < 200 ? 0.0 : 1.0, 0});
  }
  const std::string map = error_map(table, Glyphs::ascii);
  CAPTURE(map);
  for (const std::string& line : lines_of(map)) CHECK(terminal::columns_of(line) <= 100);
  CHECK_THAT(map, Contains("a cell is 25 mm"));
  CHECK(count(lines_of(map)[1], "@") == 8);
  CHECK_THAT(lines_of(map)[1],
             StartsWith("     0  . . . . . . . . + @"));  // half of the middle cell
  CHECK(error_map(ErrorTable{}, Glyphs::ascii).empty());
  table.points = {{1, 2, 0.1, 0.2}, {1, 2, 0.2, 0.1}};
  CHECK(error_map(table, Glyphs::ascii).empty());  // one place is no map
}

TEST_CASE("bars are as long as the errors, and each carries the noise floor", "[report]") {
  Report report;
  report.floor_mean_mm = 0.0125;
  report.tables = {growing(), growing()};
  report.tables[1].method = "model";
  report.tables[1].after.mean = 0.0125;
  report.tables[1].after_predicted = true;
  report.tables.push_back(growing());
  report.tables.back().standing = Standing::fitted;  // other points: no bar beside these
  const std::string bars = method_bars(report, report.tables[0], Glyphs::ascii);
  const auto lines = lines_of(bars);
  CAPTURE(bars);
  REQUIRE(lines.size() == 5);
  CHECK(count(lines[1], "#") == 59);  // 60 columns less the mark
  CHECK(count(lines[2], "#") == 7);   // 60 / 8 = 7.5
  CHECK(count(lines[3], "#") == 3);   // 60 / 20
  for (std::size_t k = 1; k < 4; ++k) CHECK(lines[k].find('|') == 13 + 3);
  CHECK_THAT(lines[1], StartsWith("before") && EndsWith(" 0.2500"));
  CHECK_THAT(lines[3], StartsWith("model *"));
  CHECK_THAT(lines[4], Contains("0.0125"));
}

TEST_CASE("in few columns bars shrink, and a map that has no room says so", "[report]") {
  Report report;
  report.tables = {growing()};
  for (const int columns : {20, 24, 40, 80}) {
    CAPTURE(columns);
    const std::string bars = method_bars(report, report.tables[0], Glyphs::ascii, columns);
    CHECK(count(bars, "#") ==
          2 * static_cast<std::size_t>(std::clamp(columns - 22, 0, 60)) * 9 / 16);
    for (const std::string& line : lines_of(bars)) {
      if (line.starts_with("mean")) continue;  // prose: folded where it is printed
      CHECK(terminal::columns_of(line) <= static_cast<std::size_t>(columns));
    }
  }
  CHECK(error_map(growing(), Glyphs::ascii, 28) == error_map(growing(), Glyphs::ascii));
  CHECK(error_map(growing(), Glyphs::ascii, 27) == "the map needs 28 columns, here are 27\n");
}

TEST_CASE("a report draws blocks where the locale has them, else letters of ASCII", "[report]") {
  const tests::TemporaryFolder folder;
  REQUIRE(tests::run_program({"campaign", "import", tests::kDriveError}, folder.path()).exit_code ==
          0);
  REQUIRE(tests::run_program({"calibrate", "idw", "drive-error"}, folder.path()).exit_code == 0);
  const auto report = [&folder](const std::string& locale, const std::string& terminal) {
    return tests::run_command({"env", "LC_ALL=" + locale, "TERM=" + terminal,
                               tests::build_folder() + "/trammel", "report", "drive-error"},
                              folder.path())
        .out;
  };
  CHECK_THAT(report("C.UTF-8", "xterm"), Contains("█") && Contains("Where the error is"));
  for (const auto& [locale, terminal] :
       {std::pair{"C.UTF-8", "dumb"}, std::pair{"C", "xterm"}, std::pair{"POSIX", "xterm"}}) {
    const std::string ascii = report(locale, terminal);
    CAPTURE(locale, terminal);
    CHECK_THAT(ascii, Contains("Where the error is"));
    CHECK(std::none_of(ascii.begin(), ascii.end(),
                       [](char c) { return static_cast<unsigned char>(c) >= 0x80; }));
  }
}
