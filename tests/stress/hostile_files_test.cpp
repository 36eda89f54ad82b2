// Files from strangers: a part of what scripts/stress measures.

#include "tests/store/fixtures.hpp"
#include "tests/stress/mutate.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

TEST_CASE("mutated files and databases are refused or taken, and nothing else", "[stress]") {
  const TempFolder folder;
  for (const Importer& importer : importers(folder.path())) {
    const MutationCount count = mutate(importer, folder.path(), 20, 100, 3);
    INFO(importer.name << ": " << count.first_problem);
    CHECK(count.tried == 100);
    CHECK(count.refused > 10);  // the control: they are changed
    CHECK(count.crashes + count.hangs == 0);
  }
}
