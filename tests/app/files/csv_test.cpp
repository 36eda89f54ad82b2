#include "app/files/csv.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;

TEST_CASE("quoted cells, CRLF, a byte order mark and a missing last newline are read",
          "[exchange]") {
  const CsvTable table = parse_csv(
      "\xEF\xBB\xBF"
      "a,b\r\n\"1,\"\"2\"\"\",\"x\ny\"\r\n,3",
      "t.csv");
  REQUIRE(table.rows.size() == 2);
  CHECK(table.header.cells[0].text == "a");
  CHECK(table.header.cells[0].column == 1);
  CHECK(table.rows[0].cells[0].text == "1,\"2\"");
  CHECK(table.rows[0].cells[1].text == "x\ny");
  CHECK(table.rows[1].cells[0].text.empty());
  CHECK(table.rows[1].cells[1].text == "3");
  CHECK(table.rows[1].line == 4);
  CHECK(table.rows[1].cells[1].column == 2);
}

TEST_CASE("a broken table is refused with line and column", "[exchange]") {
  struct Bad {
    std::string text;
    int line, column;
    const char* what;
  };
  const std::vector<Bad> all = {
      {"", 1, 1, "header line is missing"},
      {"a,,b\n", 1, 3, "without a name"},
      {"a,b,a\n", 1, 5, "duplicate column"},
      {"a,b\n1,2\n1\n", 3, 1, "a field is missing"},
      {"a,b\n1,2,3\n", 2, 5, "more fields"},
      {"a,b\n1,2\n\n1,2\n", 3, 1, "an empty line"},
      {"a,b\n1,\"2\n", 3, 1, "does not close"},
      {"a,b\n1,\"2\"x\n", 2, 6, "after a closing quote"},
      {"a,b\n1,2\"3\"\n", 2, 4, "a quote inside"},
      {std::string("a,b\n1,\0002\n", 9), 2, 3, "NUL"},
      {"a,b\r1,2\n", 1, 4, "carriage return"},
  };
  for (const Bad& bad : all) {
    CAPTURE(bad.text);
    try {
      (void)parse_csv(bad.text, "t.csv");
      FAIL("not refused");
    } catch (const InputError& error) {
      CHECK_THAT(error.text().what, Contains(bad.what));
      CHECK(error.text().where.file == "t.csv");
      CHECK(error.text().where.line == bad.line);
      CHECK(error.text().where.column == bad.column);
    }
  }
}

TEST_CASE("tables as people have them are read where they have one reading", "[exchange]") {
  for (const char* text : {
           "a,b\n1.5,2\n\n \n",         // empty last lines
           " a , b\t\n 1.5 ,\t2 \r\n",  // blanks around cells
           "a;b\n1,5;2\n",              // semicolons and decimal commas
           "a;b\n1.5;2\n;\n",           // and with points, an empty row at the end
           "a\tb\n1,5\t2\n",            // tabs
           "\xEF\xBB\xBF\"a\";\"b\"\r\n\"1,5\" ; 2\r\n",
           "a,b,,\n1.5,2,,\n",  // separators behind the last column
           "sep=;\r\na;b\r\n1,5;2\r\n",
           "SEP=;\r\na;b\r\n1,5;2\r\n\r\n",
           "\xEF\xBB\xBF\"Sep=;\" \na;b\n1,5;2\n",
           "a,b\n\"1,5\",2\n",  // a decimal comma in quotes, where commas separate
           "a,b\n\"1,5\",\"2\"\n,\n\n",
           "# made by a scale, in mm, \"raw\"\na,b\n#\n1.5,2\n# the end\n",
       }) {
    CAPTURE(text);
    const CsvTable table = parse_csv(text, "t.csv");
    REQUIRE(table.header.cells.size() == 2);
    CHECK(table.header.cells[0].text == "a");
    REQUIRE(table.rows.size() == 1);
    CHECK(table.rows[0].cells[0].text == "1.5");
    CHECK(table.rows[0].cells[1].text == "2");
  }
  const std::pair<const char*, const char*> two_readings[] = {
      {"sep=x\naxb\n1x2\n", "names no comma"},
      {"a,b;c\n1,2;3\n", "more than one of comma, semicolon and tab"},
      {"a;b\n1,234;5.5\n", "has two readings"},
      {"\xFF\xFE"
       "a",
       "UTF-16"},
  };
  for (const auto& [text, what] : two_readings) {
    CAPTURE(text);
    CHECK_THROWS_WITH(parse_csv(text, "t.csv"), Contains(what));
  }
}

TEST_CASE(
    "a comma in quotes stays one beside decimal points, and one column may end in empty lines",
    "[exchange]") {
  const CsvTable table = parse_csv("a,b\n\"1,234\",2.5\n", "t.csv");
  CHECK(table.rows[0].cells[0].text == "1,234");  // thousands, text or a decimal: readers refuse it
  const CsvTable column = parse_csv("a\n1\n\n2\n\n \n", "t.csv");
  REQUIRE(column.rows.size() == 3);
  CHECK(column.rows[1].cells[0].text.empty());
}

TEST_CASE("text that begins with # is no comment where it is a cell", "[exchange]") {
  const CsvTable table = parse_csv("#,b\n# 1 of 2,3\n#2,4\n", "t.csv");
  REQUIRE(table.rows.size() == 2);
  CHECK(table.header.cells[0].text == "#");
  CHECK(table.rows[0].cells[0].text == "# 1 of 2");
}

TEST_CASE("text that a spreadsheet would run is defused, numbers are not, and nothing is lost",
          "[exchange]") {
  for (const char* active : {"=1+1", "+1+1", "-1+1", "@SUM(A1)", "\t=1", "\r=1", "'=1", "''+x",
                             "\uFF1D1+1", "-", "+49 30 12", "--1", "=HYPERLINK(\"x\")"}) {
    CAPTURE(active);
    CHECK(defused(active) == "'" + std::string(active));
    CHECK(undefused(defused(active)) == active);
  }
  for (const char* harmless : {"", "a", "0.1", "-1.5", "-1e-9", "1+1", "'", "'a", "''", " =1"}) {
    CAPTURE(harmless);
    CHECK(defused(harmless) == harmless);
    CHECK(undefused(harmless) == harmless);
  }
}

TEST_CASE("columns, rows and cells are capped", "[exchange]") {
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      (void)parse_csv(text, "t.csv");
    } catch (const InputError& error) {
      return error.text().what;
    }
    return "";
  };
  CHECK_THAT(error_of(std::string(100'000'000, ',')), Contains("more than 1000 columns"));
  CHECK_THAT(error_of("a\n" + std::string(kMaxCsvCellBytes + 1, 'x')), Contains("a cell of more"));
  CHECK_THAT(error_of("a\n\"" + std::string(kMaxCsvCellBytes + 1, 'x') + "\""),
             Contains("a cell of more"));
  std::string rows = "a\n";
  for (std::size_t k = 0; k <= kMaxCsvRows; ++k) rows += "1\n";
  CHECK_THAT(error_of(rows), Contains("more than 2000000 rows"));
}
