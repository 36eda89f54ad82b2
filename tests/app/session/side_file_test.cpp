// A database that can't be written while a campaign is measured.

#include "app/session/side_file.hpp"

#include <sqlite3.h>
#include <sys/mount.h>

#include <cmath>
#include <fstream>

#include "app/files/files.hpp"
#include "store/verify.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/stress/disk.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/skip.hpp"

namespace trammel::session {

using namespace tests;

namespace {

Plan few_points() {
  Plan plan = small_plan();
  plan.points.resize(4);
  return plan;
}

struct Life {
  bool threw = false;
  std::string error = {};
  int stored = 0;
  std::int64_t operations = 0;  // of the disk, until the last point
};

/// One life on a disk whose writes all fail from the n-th operation on.
Life live(const std::filesystem::path& file, const std::shared_ptr<Faults>& faults,
          std::int64_t fails_from) {
  Life life;
  std::int64_t n = 0;
  const test::WatchedDisk disk([&](const test::DiskOperation& operation) {
    using Kind = test::DiskOperation::Kind;
    const bool writes = operation.kind == Kind::write || operation.kind == Kind::sync ||
                        operation.kind == Kind::truncate;
    return writes && ++n >= fails_from ? SQLITE_IOERR_WRITE : SQLITE_OK;
  });
  try {
    store::Connection db = store::open(file, store::Access::create);
    Surroundings around;
    around.open = opening(faults);
    around.stored = [&](int stored) {
      life.stored = stored;
      life.operations = n;
    };
    static_cast<void>(run_or_resume(db, request_for(few_points()), around));
  } catch (const StoreError& error) {
    life.threw = true;
    life.error = error.what();
  }
  return life;
}

std::string lines_of(const std::filesystem::path& file) {
  return std::filesystem::exists(file) ? read_file(file, 1'000'000) : "";
}

}  // namespace

TEST_CASE(
    "whenever the database fails, the stage stops, the reading is kept, and recover takes it "
    "in once",
    "[session]") {
  const TemporaryFolder folder;
  const auto calm = std::make_shared<Faults>();
  const Life whole = live(folder.path() / "whole.db", calm, 1'000'000'000);
  REQUIRE_FALSE(whole.threw);
  store::Connection undisturbed = store::open(folder.path() / "whole.db", store::Access::read_only);
  const auto expected = by_point(undisturbed, "c", "s");
  int kept = 0, taken = 0, was_there = 0;
  for (std::int64_t nth = 1; nth <= whole.operations; nth += 7) {
    CAPTURE(nth);
    const auto file = folder.path() / (std::to_string(nth) + ".db");
    const auto faults = std::make_shared<Faults>();
    const Life life = live(file, faults, nth);
    CHECK(life.threw);
    store::Connection db = store::open(file, store::Access::create);
    const auto campaign = store::find_campaign(db, "c");
    if (campaign) {
      if (faults->moves > 0) CHECK(faults->stops >= 1);
      const auto aside = side_file(db.file(), campaign->uuid);
      const std::string lines = lines_of(aside);
      if (!lines.empty()) {
        ++kept;
        CHECK_THAT(life.error, Contains("session recover"));
        CHECK(recover(db, *campaign, true).n_lines == 1);  // dry: the file stays
        CHECK(lines_of(aside) == lines);
        const Recovery recovery = recover(db, *campaign);
        CHECK(recovery.problems.empty());
        CHECK(recovery.n_taken + recovery.n_there == 1);
        taken += recovery.n_taken;
        was_there += recovery.n_there;
        CHECK_FALSE(std::filesystem::exists(aside));
        // A crash before the file was removed: the second time it is there already.
        std::ofstream(aside) << lines;
        CHECK(recover(db, *campaign).n_there == 1);
        CHECK(by_point(db, "c", "s").size() == static_cast<std::size_t>(life.stored) + 1);
      }
    }
    CHECK(run_or_resume(db, request_for(few_points()), {}).state == State::done);
    const auto readings = by_point(db, "c", "s");
    REQUIRE(readings.size() == 4);
    for (const auto& [seq, reading] : readings) CHECK(same_bits(reading, expected.at(seq)));
    CHECK(store::verify(db).ok());
  }
  CHECK(kept >= 2);  // the control: faults do hit what stores a reading
  CHECK(taken + was_there == kept);
  CHECK(taken > 0);
}

TEST_CASE(
    "what was kept aside reads back bit for bit; a changed or foreign line is refused and "
    "stays",
    "[session]") {
  const TemporaryFolder folder;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  Surroundings around;
  around.stop_signals = [n = 0]() mutable { return ++n > 3 ? 1 : 0; };
  REQUIRE(run(db, request_for(few_points()), around).state == State::stopped);
  const auto campaign = store::require_campaign(db, "c");
  const auto session = store::find_session(db, campaign.id, "s");
  const int next = store::open_points(db, session->id).front().seq;
  UnsavedReading unsaved{
      .campaign_uuid = campaign.uuid, .session = "s", .point_seq = next, .epoch = 1, .reading = {}};
  Reading& r = unsaved.reading.reading;
  r.target = {1.0 / 3, -1e-300, std::nextafter(0.1, 1)};
  r.conditions.cmd_mm = {260.1234567890123, 1e-17, 3};
  r.conditions.from_mm = {255, 1, 2};
  r.conditions.time_s = 0.1 + 0.2;
  r.conditions.temp_degc = 21.3;
  r.measured = Pose{0.1, 0.7, 1e-9};
  unsaved.reading.encoder_mm = Displacements(1, 2, 3);
  unsaved.reading.raw_reply = "a \"reply\"\r\n\xff";
  const auto aside = side_file(db.file(), campaign.uuid);

  keep_aside(aside, unsaved);
  const std::string good = lines_of(aside);
  std::string changed = good;
  changed.replace(changed.find("21.3"), 4, "21.4");
  std::string foreign = good;
  foreign.replace(foreign.find(campaign.uuid), 4, "0000");
  for (const std::string& bad :
       {changed, foreign, std::string("nonsense\n"), std::string("{}\n")}) {
    std::ofstream(aside, std::ios::trunc) << bad;
    const Recovery refused = recover(db, campaign);
    REQUIRE(refused.problems.size() == 1);
    CHECK_THAT(refused.problems[0], Contains(":1:"));
    CHECK(refused.n_taken == 0);
    CHECK(lines_of(aside) == bad);
    CHECK_THROWS_AS(resume(db, "c", "s", {}), InputError);  // it is not passed over
  }
  std::ofstream(aside, std::ios::trunc) << good << good.substr(0, 40);  // the next was cut off
  const Recovery recovery = recover(db, campaign);
  CHECK(recovery.problems.empty());
  CHECK(recovery.n_taken == 1);
  const Reading stored = by_point(db, "c", "s").at(next);
  CHECK(same_bits(stored, r));
  CHECK(store::verify(db).ok());
}

namespace {

/// A disk of two MB of its own.
struct SmallDisk {
  explicit SmallDisk(const std::filesystem::path& at) : path(at) {
    mounted = ::mount("tmpfs", path.c_str(), "tmpfs", 0, "size=4m") == 0;
  }
  ~SmallDisk() {
    if (mounted) ::umount2(path.c_str(), MNT_DETACH);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  /// Up to this many pages.
  void fill(std::uintmax_t pages_left) const {
    {
      std::ofstream to(path / "filling", std::ios::binary);
      while (to.write(std::string(4096, 'x').data(), 4096).flush()) {
      }
    }
    const auto size = std::filesystem::file_size(path / "filling");
    std::filesystem::resize_file(path / "filling", size - pages_left * 4096);
  }
  std::filesystem::path path;
  bool mounted = false;
};

}  // namespace

TEST_CASE("on a disk that has become full the reading in hand is kept aside", "[session]") {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path());
  if (!disk.mounted) return skip("mounting a small disk needs more rights");
  Surroundings around;
  int stored = 0;
  around.stored = [&](int n) {
    stored = n;
    if (n == 2) disk.fill(5);  // the next attempt goes in, its reading does not
  };
  std::string error;
  store::Connection db = store::open(folder.path() / "t.db", store::Access::create);
  try {
    static_cast<void>(run(db, request_for(small_plan()), around));
  } catch (const StoreError& full) {
    error = full.what();
  }
  CHECK_THAT(error, Contains("disk is full") && Contains("session recover"));
  const auto campaign = store::require_campaign(db, "c");
  CHECK(lines_of(side_file(db.file(), campaign.uuid)).ends_with("}\n"));
  // The control: a file for which no room was kept.
  CHECK_THROWS_AS(keep_aside(folder.path() / "late.jsonl", UnsavedReading{}), StoreError);
  CHECK_THROWS_AS(SideRoom(folder.path() / "late.jsonl"), StoreError);
  std::filesystem::remove(folder.path() / "filling");
  CHECK(resume(db, "c", "s", {}).state == State::done);
  CHECK(by_point(db, "c", "s").size() == 16);
  CHECK_FALSE(std::filesystem::exists(side_file(db.file(), campaign.uuid)));
}

TEST_CASE("a side file that can't be written either is said", "[session]") {
  CHECK_THROWS_AS(keep_aside("/no/such/folder/x.jsonl", UnsavedReading{}), StoreError);
}

}  // namespace trammel::session
