#include "app/terminal/columns.hpp"

#include <sstream>

#include "app/terminal/table.hpp"
#include "tests/support/catch.hpp"

using namespace trammel::terminal;

namespace {

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

TEST_CASE("text takes as many columns as it has characters, bold or not", "[cli]") {
  CHECK(columns_of("") == 0);
  CHECK(columns_of("0.1234 mm") == 9);
  CHECK(columns_of("▁█ – ψ") == 6);
  CHECK(columns_of("\x1b[1mbold\x1b[0m") == 4);
}

TEST_CASE("a long line goes on in the next, broken at blanks alone", "[cli]") {
  const std::string text =
      "  lsq             in-sample      80   0.2063  0.6487  0.0097\nshort\n\n    far right 1 2 3 "
      "4\n";
  for (const std::size_t columns : {12U, 20U, 33U, 40U, 61U}) {
    const std::string narrow = folded(text, columns);
    CAPTURE(columns, narrow);
    CHECK(words_of(narrow) == words_of(text));
    for (const std::string& line : lines_of(narrow)) CHECK(columns_of(line) <= columns);
  }
  CHECK(folded(text, 62) == text);
  CHECK(folded("  a bb ccc dddd", 9) == "  a bb\n  ccc\n  dddd");
  // What has no blank stays whole.
  CHECK(folded("SHA-256: 0123456789abcdef0123456789abcdef", 20) ==
        "SHA-256:\n    0123456789abcdef0123456789abcdef");
}

TEST_CASE("a table fits its terminal: text is shortened, numbers never", "[cli]") {
  Table table({"name", "error mm", "readings", "made"});
  table.add({"a campaign with a rather long name", "0.123456", "152", "2024-05-06T07:08:09Z"});
  table.add({"b", "-12.000001", "99999", "yesterday"});
  const std::string wide = table.text(std::nullopt);
  const std::string mark = utf8_wanted() ? "…" : "~";
  CHECK(wide.find(mark) == std::string::npos);
  for (const std::size_t columns : {40U, 50U, 60U, 70U}) {
    const std::string narrow = table.text(columns);
    CAPTURE(columns, narrow);
    for (const std::string& line : lines_of(narrow)) CHECK(columns_of(line) <= columns);
    CHECK(narrow.find(mark) != std::string::npos);
    for (const char* number : {"0.123456", "152", "-12.000001", "99999"}) {
      CHECK_THAT(narrow, Contains(number));
    }
  }
  CHECK(table.text(200) == wide);
  // Narrower than the numbers alone: these stay whole all the same.
  CHECK_THAT(table.text(20), Contains("-12.000001"));
}
