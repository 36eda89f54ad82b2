// Power lost at any operation, and the controls: a part of what scripts/stress measures.

#include "tests/stress/power_loss.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::test;

namespace {

PowerLossCount lost_with(const PowerLossOptions& options) {
  const TempFolder folder;
  return lose_power(folder.path(), options);
}

/// The log is written back under points that are acknowledged, every few pages.
constexpr RecordOptions kWrittenBack{.n_points = 6, .checkpoint_pages = 5};

}  // namespace

TEST_CASE("power lost at any operation loses no acknowledged point and corrupts nothing",
          "[stress][release]") {
  const PowerLossCount count =
      lost_with({.record = kWrittenBack, .every = 11, .resume_every = 100});
  INFO(count.first_problem);
  CHECK(count.images > 100);
  CHECK(count.written_back > 20);
  CHECK(count.lost_images == 0);
  CHECK(count.corrupt == 0);
  CHECK(count.resumed > 0);
  CHECK(count.wrong_resumes == 0);
}

TEST_CASE("power lost while a reading is kept aside loses none that was said to be kept",
          "[stress][release]") {
  const RecordOptions full{.n_points = 3, .full_after = 1};
  const PowerLossCount count = lost_with({.record = full, .from_told = 1, .resume_every = 50});
  INFO(count.first_problem);
  CHECK(count.images > 50);
  CHECK(count.lost_images + count.corrupt + count.wrong_resumes == 0);
  CHECK(lost_with({.record = full,
                   .from_told = 1,
                   .resume_every = 0,
                   .lie = Lie::sync,
                   .until = PowerLossOptions::Until::loss})
            .lost_images > 0);
}

TEST_CASE("what is not synced, or on a disk that lies, power loss does lose or corrupt",
          "[stress][release]") {
  // The control: else the tests above proved nothing.
  using Until = PowerLossOptions::Until;
  const auto worst = [](Durability durability, Lie lie, Until until) {
    RecordOptions record = kWrittenBack;
    record.durability = durability;
    if (durability == Durability::normal) record.checkpoint_pages = 0;  // to write back is to sync
    return lost_with({.record = record,
                      .every = 3,
                      .from_told = 1,
                      .resume_every = 0,
                      .lie = lie,
                      .until = until});
  };
  CHECK(worst(Durability::normal, Lie::none, Until::loss).lost_images > 0);
  CHECK(worst(Durability::full, Lie::sync, Until::loss).lost_images > 0);
  CHECK(worst(Durability::full, Lie::names, Until::loss).lost_images > 0);
  CHECK(worst(Durability::off, Lie::none, Until::corruption).corrupt > 0);
}
