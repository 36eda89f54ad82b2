#include "app/terminal/text.hpp"

#include "app/terminal/typable.hpp"

#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::terminal;

TEST_CASE("a word for a shell is quoted where it must be, and where it begins with -",
          "[terminal]") {
  CHECK(shell_word("plan.json") == "plan.json");
  CHECK(shell_word("a b") == "'a b'");
  CHECK(shell_word("it's") == "'it'\\''s'");
  CHECK(shell_word("-x") == "'-x'");
  CHECK(shell_word("") == "''");
}

TEST_CASE("values that begin with - are typed so that they are taken for values", "[terminal]") {
  CHECK(typable("trammel report paper --db a.db") == "trammel report paper --db a.db");
  CHECK(typable("trammel report '-x' --db a.db") == "trammel report --db a.db -- '-x'");
  CHECK(typable("trammel model show '-x y' 3 --db 'b c'") ==
        "trammel model show --db 'b c' -- '-x y' 3");
  CHECK(typable("trammel session resume '-x' --session '-1'") ==
        "trammel session resume --session='-1' -- '-x'");
  CHECK(typable("trammel compare a '-b' --json") == "trammel compare a --json -- '-b'");
}
