// The database is moved, removed or replaced while a campaign is measured.

#include <cstdio>

#include "app/files/files.hpp"
#include "app/session/side_file.hpp"
#include "tests/app/session/faulty_devices.hpp"
#include "tests/app/session/session_fixture.hpp"
#include "tests/support/catch.hpp"

namespace trammel::session {

using namespace tests;
namespace fs = std::filesystem;

namespace {

struct Lived {
  ExitCode code = ExitCode::ok;
  std::string error = {};
  int stored = 0;  // acknowledged
  std::string uuid = {};
};

/// One session of 16 points; `deed` is done when so many are stored.
Lived live_with(const fs::path& file, int when, const std::function<void()>& deed,
                const std::shared_ptr<Faults>& faults) {
  Lived lived;
  store::Connection db = store::open(file, store::Access::create);
  Surroundings around;
  around.open = opening(faults);
  around.stored = [&](int n) {
    lived.stored = n;
    if (n == when) deed();
  };
  try {
    lived.code = run(db, request_for(small_plan()), around).exit_code();
  } catch (const Error& error) {
    lived.code = error.code();
    lived.error = error.what();
  }
  return lived;
}

int n_readings(const fs::path& file) {
  store::Connection db = store::open(file, store::Access::read_only);
  const auto campaign = store::find_campaign(db, "c");
  return campaign ? campaign->n_readings : 0;
}

std::vector<fs::path> side_files(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().string().ends_with(".unsaved.jsonl")) all.push_back(entry.path());
  }
  return all;
}

}  // namespace

TEST_CASE("no reading is acknowledged that is not in the database of this name", "[session]") {
  const TemporaryFolder others;
  const fs::path other = others.path() / "other.db";
  {
    store::Connection db = store::open(other, store::Access::create);
    REQUIRE(run(db, request_for(small_plan()), {}).state == State::done);
  }
  using Deed = std::function<void(const fs::path&)>;
  const std::vector<std::pair<std::string, Deed>> deeds = {
      {"mv", [](const fs::path& lab) { fs::rename(lab, lab.string() + ".left"); }},
      {"rm",
       [](const fs::path& lab) {
         fs::create_hard_link(lab, lab.string() + ".left");  // a look at what was removed
         fs::remove(lab);
       }},
      {"mv another.db over it",
       [&](const fs::path& lab) {
         fs::create_hard_link(lab, lab.string() + ".left");
         fs::copy_file(other, lab.string() + ".new");
         fs::rename(lab.string() + ".new", lab);
       }},
      {"rm -wal", [](const fs::path& lab) {
         fs::create_hard_link(lab, lab.string() + ".left");
         fs::remove(lab.string() + "-wal");
       }}};
  for (const int when : {1, 4, 15}) {
    for (const auto& [name, deed] : deeds) {
      CAPTURE(name, when);
      const TemporaryFolder folder;
      const fs::path lab = folder.path() / "lab.db";
      const auto faults = std::make_shared<Faults>();
      const Lived lived = live_with(
          lab, when, [&, d = deed] { d(lab); }, faults);
      CHECK(lived.code == ExitCode::storage);
      CHECK(lived.stored == when);
      CHECK(faults->stops >= 1);
      CHECK_THAT(lived.error,
                 Contains("no longer the one that was opened") && Contains("session recover"));
      // All that was acknowledged is in the file that was opened; the reading in hand is aside.
      CHECK(n_readings(lab.string() + ".left") >= when);
      const auto aside = side_files(folder.path());
      REQUIRE(aside.size() == 1);
      CHECK(std::ranges::count(read_file(aside[0], 1'000'000), '\n') == 1);
      if (name == "mv another.db over it") CHECK(n_readings(lab) == 16);
      // Put back, it is taken in and gone on with.
      fs::remove(lab);  // where it is the same file, a rename is none
      fs::rename(lab.string() + ".left", lab);
      for (const char* log : {"-wal", "-shm"}) fs::remove(lab.string() + log);
      store::Connection db = store::open(lab, store::Access::write);
      CHECK(resume(db, "c", "s", {}).state == State::done);
      CHECK(by_point(db, "c", "s").size() == 16);
      CHECK(side_files(folder.path()).empty());
    }
  }
}

TEST_CASE("a restore over the open database is no session that is done", "[session]") {
  for (const bool restored : {true, false}) {
    const TemporaryFolder folder;
    const fs::path lab = folder.path() / "lab.db", old = folder.path() / "old.db";
    { store::open(old, store::Access::create); }
    const auto restore = [&] {  // as cp does: the same file, other bytes
      const std::string bytes = read_text(restored ? old : lab);
      std::FILE* to = std::fopen(lab.c_str(), "r+");
      REQUIRE(std::fwrite(bytes.data(), 1, bytes.size(), to) == bytes.size());
      REQUIRE(std::fclose(to) == 0);
      if (restored) fs::resize_file(lab, bytes.size());
    };
    const Lived lived = live_with(lab, 16, restore, std::make_shared<Faults>());
    CHECK(lived.code == (restored ? ExitCode::storage : ExitCode::ok));  // the control
  }
}

TEST_CASE("a copy of the main file alone holds the session, once it is measured", "[session]") {
  const TemporaryFolder folder;
  const fs::path lab = folder.path() / "lab.db", copy = folder.path() / "copy.db";
  store::Connection db = store::open(lab, store::Access::create);
  Surroundings around;
  around.stored = [&](int n) {
    if (n == 1) fs::copy_file(lab, copy);
  };
  REQUIRE(run(db, request_for(small_plan()), around).state == State::done);
  {
    store::Connection planned = store::open(copy, store::Access::read_only);
    const auto campaign = store::require_campaign(planned, "c");
    CHECK(store::find_session(planned, campaign.id, "s")->n_points == 16);
  }
  fs::copy_file(lab, copy, fs::copy_options::overwrite_existing);
  CHECK(n_readings(copy) == 16);
}

}  // namespace trammel::session
