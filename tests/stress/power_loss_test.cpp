// Power lost at any operation, and the control: a part of what scripts/stress measures.

#include "tests/stress/power_loss.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

TEST_CASE("power lost at any operation loses no acknowledged point and corrupts nothing",
          "[stress][release]") {
  const TempFolder folder;
  const PowerLossCount count =
      lose_power(folder.path(), {.n_points = 6, .every = 4, .resume_every = 150});
  INFO(count.first_problem);
  CHECK(count.images > 300);
  CHECK(count.lost_images == 0);
  CHECK(count.corrupt == 0);
  CHECK(count.resumed > 0);
  CHECK(count.wrong_resumes == 0);
}

TEST_CASE("with synchronous=NORMAL or on a disk that lies power loss does lose points",
          "[stress][release]") {
  // The control: else the test above proved nothing.
  const TempFolder a, b;
  CHECK(lose_power(a.path(), {.n_points = 6,
                              .every = 9,
                              .resume_every = 0,
                              .first_loss = true,
                              .durability = Durability::normal})
            .lost_images > 0);
  CHECK(lose_power(b.path(),
                   {.n_points = 6, .every = 9, .resume_every = 0, .lies = true, .first_loss = true})
            .lost_images > 0);
}
