// Operations that fail, and the control: a part of what scripts/stress measures.

#include "tests/store/fixtures.hpp"
#include "tests/stress/faults.hpp"
#include "tests/stress/recorder.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

TEST_CASE("an operation that fails once or for good loses nothing, and a lasting fault is reported",
          "[stress]") {
  struct Case {
    Fault fault;
    std::int64_t every;
  };
  for (const Case& c :
       {Case{Fault::io_error, 23}, Case{Fault::disk_full, 11}, Case{Fault::out_of_memory, 1999}}) {
    for (const bool for_good : {false, true}) {
      const TempFolder folder;
      const FaultCount count = sweep_faults(
          folder.path(), {.fault = c.fault, .for_good = for_good, .every = c.every, .n_points = 2});
      INFO("fault " << static_cast<int>(c.fault) << ", for good " << for_good << ": "
                    << count.first_problem);
      CHECK(count.runs > 5);
      CHECK(count.reported > 0);  // the control: faults do arrive
      CHECK(count.violations() == 0);
    }
  }
}

TEST_CASE("the sweep of faults sees what a recorder loses that looks at no answer", "[stress]") {
  const TempFolder folder;
  for (const bool for_good : {false, true}) {
    const FaultCount count = sweep_faults(
        folder.path(),
        {.fault = Fault::disk_full, .for_good = for_good, .recorder = careless_recorder()});
    CHECK(count.lost > 0);
    CHECK((count.unreported > 0) == for_good);
  }
}
