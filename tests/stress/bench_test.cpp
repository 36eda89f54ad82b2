// The hostile bench, a run of each kind: a part of what scripts/stress measures.

#include "tests/stress/bench.hpp"

#include "tests/stress/kills.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel::test;

TEST_CASE("no lie of the bench becomes a reading, and its control does", "[stress][sockets]") {
  for (const BenchRow& row : lying_bench(1, 7)) {
    INFO(row.figure << ": " << row.first_problem);
    CHECK(row.reached());
  }
}

TEST_CASE("whatever is done to the database's file, no acknowledged reading is lost unreported",
          "[stress]") {
  for (const BenchRow& row : file_bench(1, 7)) {
    INFO(row.figure << ": " << row.first_problem);
    CHECK(row.reached());
  }
}

TEST_CASE("killed again and again over sockets, a campaign comes to its end as it was",
          "[stress][sockets][release]") {
  const trammel::tests::TemporaryFolder folder;
  const KillCount count = sweep_socket_kills(folder.path(), 80, 4, 7);
  INFO(count.first_problem);
  CHECK(count.points == 80);
  CHECK(count.lost + count.corrupt + count.repeated + count.different == 0);
}
