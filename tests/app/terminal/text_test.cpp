#include "app/terminal/text.hpp"

#include <nlohmann/json.hpp>

#include "app/terminal/counted.hpp"
#include "app/terminal/decimals.hpp"
#include "tests/support/catch.hpp"

using namespace trammel::terminal;

TEST_CASE("what a terminal or a page would act on is shown as a question mark", "[terminal]") {
  struct Text {
    const char* given;
    const char* shown;
  };
  for (const Text& text :
       {Text{"plain, 3 µm, –5 °C, 机器人, 🙂", "plain, 3 µm, –5 °C, 机器人, 🙂"},
        {"\x1b[2J\x07\r\n\x7f", "?[2J????"},
        {"\xc2\x9b"
         "2J \xc2\x85 \xc2\xa0",
         "?2J ? \xc2\xa0"},  // CSI, NEL; a wide blank
        {"\x9b"
         "2J \x80\xff",
         "?2J ??"},  // CSI of eight bits
        {"a\u202Eb\u202Ac\u2066d\u2069e\u200Ef\u200Fg\u061Ch", "a?b?c?d?e?f?g?h"},
        {"a\u2028b\u2029c", "a?b?c"},
        {"\xc0\x9b \xe0\x82\x9b \xed\xa0\x80 \xf4\x90\x80\x80", "?? ??? ??? ????"},
        {"cut \xe2\x80", "cut ??"}}) {
    CAPTURE(text.given);
    CHECK(printable(text.given) == text.shown);
    CHECK(printable(printable(text.given)) == text.shown);
  }
  CHECK(printable("two\nlines\tand \x1b", "\n\t") == "two\nlines\tand ?");
}

TEST_CASE("JSON loses nothing where it is shown safely", "[terminal]") {
  const nlohmann::json given = {{"name",
                                 "a\u202Eb\xc2\x9b"
                                 "c\x7f\x1b \u2028 µ \\u202e"}};
  const std::string shown = printable_json(given.dump());
  CHECK(shown == R"({"name":"a\u202eb\u009bc\u007f\u001b \u2028 µ \\u202e"})");
  CHECK(nlohmann::json::parse(shown) == given);
}

TEST_CASE("errors have four decimals, or as many as show two digits of a perfect reading",
          "[terminal]") {
  for (const auto& [least, decimals] : {std::pair{0.0125, 4},
                                        {0.001, 4},
                                        {0.00099, 5},
                                        {0.0004, 5},
                                        {0.00006, 6},
                                        {1e-12, 9},
                                        {0.0, 4}}) {
    CAPTURE(least);
    CHECK(decimals_of(least) == decimals);
  }
}

TEST_CASE("one of a thing is not many", "[terminal]") {
  CHECK(counted(1, "point") == "1 point");
  CHECK(counted(std::size_t{0}, "point") == "0 points");
  CHECK(counted(48, "reading") == "48 readings");
}
