// Answers lost on sockets, each with its control: a part of what scripts/stress measures.

#include "tests/stress/soak.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

TEST_CASE("whichever line over a socket is dropped, the campaign becomes whole",
          "[stress][sockets]") {
  const WireCount count = sweep_wires(emulate::FaultKind::dropped, 23);
  INFO(count.first_problem);
  CHECK(count.runs > 5);
  CHECK(count.wrong == 0);
}

TEST_CASE(
    "a short soak over sockets loses, repeats and invents nothing, and finds the parameters of a "
    "calm run",
    "[stress][sockets]") {
  const SoakCount count = soak_over_sockets({.n_points = 80, .share = 0.25, .seed = 7});
  INFO(count.first_problem);
  CHECK(count.points == 80);
  CHECK(count.faults > 8);
  CHECK(count.failed_tries > 5);
  CHECK(count.lives > 2);
  CHECK(count.lost == 0);
  CHECK(count.early > 0);  // the control: who acknowledges too early is seen to lose
  CHECK(count.wrong == 0);
  CHECK(count.parameters > 10);
  CHECK(count.worst_sigma < 4.5);  // one false alarm in some 10,000 runs
}
