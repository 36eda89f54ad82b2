#include "store/backup.hpp"

#include <fstream>

#include "store/job.hpp"
#include "store/model.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::number;
using trammel::test::TempFolder;

namespace {

const std::filesystem::path kVersions =
    std::filesystem::path(tests::source_folder()) / "tests/store/versions";

std::filesystem::path copy_of_version(const TempFolder& folder, int version) {
  const std::string name = "version_" + std::to_string(version) + ".sqlite3";
  std::filesystem::copy_file(kVersions / name, folder.file("old.db"));
  return folder.file("old.db");
}

}  // namespace

TEST_CASE("a backup holds everything, verifies, and overwrites nothing", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = import_campaign(db, test::small_campaign()).campaign_id;
  const CheckReport report = backup(folder.file("lab.db"), folder.file("it's a copy.db"));
  CHECK(report.n_readings == 6);
  Connection copy = store::open(folder.file("it's a copy.db"), Access::read_only);
  CHECK(chain_head(copy, campaign) == chain_head(db, campaign));
  CHECK_THROWS_AS(backup(folder.file("lab.db"), folder.file("it's a copy.db")), InputError);
  CHECK_FALSE(std::filesystem::exists(folder.file("it's a copy.db.part")));
}

TEST_CASE("a damaged database gives no backup", "[store]") {
  const TempFolder folder;
  {
    Connection db = store::open(folder.file("lab.db"), Access::create);
    import_campaign(db, test::small_campaign());
  }
  Connection other(folder.file("lab.db"), Access::write);
  std::string guard;
  {
    Statement row(other, "SELECT sql FROM sqlite_schema WHERE name = 'reading_update'");
    REQUIRE(row.step());
    guard = row.text(0);
  }
  other.execute("DROP TRIGGER reading_update; UPDATE reading SET y_mm = 1 WHERE seq = 2");
  other.execute(guard);
  CHECK_THROWS_WITH(backup(folder.file("lab.db"), folder.file("copy.db")), Contains("seq 2"));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) <=
        3);  // db, wal, shm
}

TEST_CASE("every past version opens read-only, is refused for writing, and migrates whole",
          "[store]") {
  for (int version = 1; version < newest_version(); ++version) {
    const TempFolder folder;
    const auto file = copy_of_version(folder, version);
    Sha256 head{};
    {
      Connection old = store::open(file, Access::read_only);
      CHECK(version_of(old) == version);
      CHECK(list_campaigns(old).size() == 1);
      head = chain_head(old, 1);
    }
    CHECK_THROWS_WITH(store::open(file, Access::write), Contains("db migrate"));
    const Migration done = migrate(file);
    CHECK((done.from == version && done.to == newest_version()));
    Connection db = store::open(file, Access::write);
    CHECK(verify(db).findings.empty());
    CHECK(chain_head(db, 1) == head);
    CHECK(load_campaign(db, 1).campaign.readings.size() == 8);
    CHECK(list_models(db, 1).size() == 1);
    CHECK_FALSE(find_job(db, 1, list_jobs(db)[0].key)->data.statistics.empty());
    // And it goes on.
    test::measured_session(db, 1, "after", 2);
    CHECK(verify(db).findings.empty());
    // What was is still there.
    Connection before = store::open(done.copy, Access::read_only);
    CHECK(version_of(before) == version);
    CHECK(migrate(file).copy.empty());
  }
}

TEST_CASE("a version's job keys still hold for the readings it stored", "[store]") {
  const TempFolder folder;
  Connection old = store::open(copy_of_version(folder, 1), Access::read_only);
  const LoadedCampaign loaded = load_campaign(old, 1);
  const JobKey key = job_key({.stage = "lsq", .campaign = loaded.campaign, .excluded_seqs = {2}});
  CHECK(key.parts == get_job(old, 1).data.key.parts);
}

TEST_CASE("every version there was has its fixture", "[store]") {
  for (int version = 1; version < newest_version(); ++version) {
    CHECK(std::filesystem::exists(kVersions / ("version_" + std::to_string(version) + ".sqlite3")));
  }
}

TEST_CASE("a migration of which a step fails changes nothing, and its copy is whole", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 1);
  // The user's own table has the name that a step wants.
  Connection(file, Access::write).execute("CREATE TABLE v_job (mine TEXT)");
  CHECK_THROWS_WITH(migrate(file), Contains("v_job"));
  Connection old = store::open(file, Access::read_only);
  CHECK(version_of(old) == 1);
  CHECK(verify(old).findings.empty());
  CHECK(number(old, "SELECT count(*) FROM sqlite_schema WHERE name = 'v_point_status'") == 0);
  Connection copy = store::open(file.string() + ".v1-backup", Access::read_only);
  CHECK(verify(copy).findings.empty());
}

TEST_CASE("a migration makes a copy of its own where another one stands", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 1);
  std::ofstream(file.string() + ".v1-backup") << "of another day";
  const Migration done = migrate(file);
  CHECK(done.copy == file.string() + ".v1-backup2");
  CHECK(std::filesystem::file_size(file.string() + ".v1-backup") == 14);
  Connection copy = store::open(done.copy, Access::read_only);
  CHECK(version_of(copy) == 1);
}
