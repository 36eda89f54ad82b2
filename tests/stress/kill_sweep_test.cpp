// The program killed again and again, and the control: a part of what scripts/stress measures.

#include "tests/store/fixtures.hpp"
#include "tests/stress/kills.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

TEST_CASE("killed again and again, the program loses and repeats no point it told of",
          "[stress][release]") {
  const TempFolder folder;
  const KillCount count = sweep_kills(folder.path(), {.kills = 12, .seed = 7});
  INFO(count.first_problem);
  CHECK(count.kills >= 12);
  CHECK(count.with_points > 0);
  CHECK(count.lost + count.corrupt + count.repeated + count.different == 0);
}

TEST_CASE("the sweep of kills sees a log that does not outlive one", "[stress][release]") {
  const TempFolder folder;
  CHECK(sweep_kills(folder.path(), {.kills = 30, .seed = 7, .loses_log = true}).lost > 0);
}
