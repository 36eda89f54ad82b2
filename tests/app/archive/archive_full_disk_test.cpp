// The server's disk is full: what was acknowledged is there, and with room the push goes on.

#include <pwd.h>
#include <unistd.h>

#include "app/archive/pull.hpp"
#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/small_disk.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"
#include "tests/support/skip.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using tests::asked;
using tests::kStationA;

namespace {

constexpr int kCampaigns = 60;

/// An archive whose server has its `part`, data or wal, on a disk of its own.
class OnSmallDisk {
 public:
  explicit OnSmallDisk(const std::string& part) {
    try {
      server_ = tests::Postgres::durable(
          [&](const std::filesystem::path& folder) {
            const passwd* user = getpwnam("postgres");
            disk_.emplace(folder / part,
                          geteuid() == 0 && user != nullptr ? user->pw_uid : geteuid());
          },
          // What is not waited for stays in memory until it must go.
          " -c synchronous_commit=off -c wal_writer_delay=10s -c wal_writer_flush_after=0");
    } catch (const std::runtime_error& error) {
      if (disk_) throw;
      tests::skip("a small disk needs the right to mount one");
      return;
    }
    if (!server_) return;
    name_ = server_->new_archive();
    store::Connection db = store::open(file(), store::Access::create);
    tests::add_small_campaigns(db, "c", kCampaigns);
  }

  [[nodiscard]] bool is_there() const { return !name_.empty(); }
  [[nodiscard]] std::string uri() const { return server_->uri(name_, "robot_a"); }
  [[nodiscard]] std::filesystem::path file() const { return folder_.file("lab.db"); }
  [[nodiscard]] std::filesystem::path beside(const char* name) const { return folder_.file(name); }

  struct Outcome {
    int acknowledged = 0;
    std::string said;
  };
  /// Pushes with so much room, until the disk is full.
  [[nodiscard]] Outcome fill(long room_kb, bool wait_for_the_disk) const {
    disk_->leave_kb(room_kb);
    Outcome outcome;
    try {
      store::Connection db = store::open_as_it_is(file());
      archive::Link link({.uri = uri(), .who = "tests"});
      if (!wait_for_the_disk) link.run("SET synchronous_commit = off");
      archive::push(link, db, kStationA, archive::campaigns_of(db),
                    [&](int done, const archive::Pushed&) { outcome.acknowledged = done; });
    } catch (const Error& error) {
      outcome.said = describe(error.text());
    }
    return outcome;
  }
  /// With room again; started again, since a server that can't write its log ends.
  [[nodiscard]] int stored_with_room() const {
    disk_->leave_kb(200000);
    server_->kill();
    server_->start();
    return std::stoi(asked(uri(), "SELECT count(*) FROM trammel.campaign"));
  }

 private:
  std::optional<tests::SmallDisk> disk_;  // goes last
  std::unique_ptr<tests::Postgres> server_;
  std::string name_;
  test::TempFolder folder_;
};

}  // namespace

TEST_CASE(
    "a full disk under the server: 0 campaigns lost, doubled or altered, and with room the push "
    "goes on",
    "[archive][release]") {
  for (const auto& [part, room_kb] : {std::pair("data", 500), std::pair("wal", 1000)}) {
    CAPTURE(part);
    const OnSmallDisk archive(part);
    if (!archive.is_there()) return;
    const auto full = archive.fill(room_kb, true);
    CHECK(full.acknowledged > 0);
    REQUIRE(full.acknowledged < kCampaigns);
    if (part == std::string("data")) {
      CHECK_THAT(full.said, Contains("(53100)"));  // disk_full, as PostgreSQL calls it
    }
    const int stored = archive.stored_with_room();
    CHECK(stored >= full.acknowledged);
    CHECK(stored <= full.acknowledged + 1);  // committed, and the answer was lost
    CHECK(asked(archive.uri(), "SELECT count(*) FROM trammel.findings()") == "0");
    tests::push_all(archive.uri(), archive.file(), kStationA);
    CHECK(tests::run_program({"archive", "verify", "--archive", archive.uri()},
                             archive.file().parent_path())
              .exit_code == 0);
    archive::Link link({.uri = archive.uri(), .who = "tests"});
    archive::pull(link, {.station = kStationA}, archive.beside("again.db"));
    CHECK(tests::content(archive.beside("again.db")) == tests::content(archive.file()));
  }
}

// The control: a commit that is acknowledged before it is on the disk.
TEST_CASE("without waiting for the disk, what was acknowledged is found to be lost",
          "[archive][release]") {
  const OnSmallDisk archive("wal");
  if (!archive.is_there()) return;
  const auto full = archive.fill(1000, false);
  CHECK(archive.stored_with_room() < full.acknowledged);
}
