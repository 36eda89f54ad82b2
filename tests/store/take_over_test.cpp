#include "store/take_over.hpp"

#include <sys/stat.h>

#include <fstream>

#include "store/job.hpp"
#include "store/migrate.hpp"
#include "store/model.hpp"
#include "store/open.hpp"
#include "store/verify.hpp"
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

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Head of the chain as the file's own version has it.
std::string last_sha256(const std::filesystem::path& file, Id campaign) {
  Connection db = open_as_it_is(file);
  Statement row(db, "SELECT sha256 FROM reading WHERE campaign_id = ? ORDER BY seq DESC LIMIT 1");
  row << campaign;
  return row.step() ? hex(row.blob(0)) : "";
}

}  // namespace

TEST_CASE("every past version is read as this one, refused for writing, and taken over whole",
          "[store]") {
  for (int version = 1; version < newest_version(); ++version) {
    INFO("version " << version);
    const TempFolder folder;
    const auto file = copy_of_version(folder, version);
    const std::string was = bytes_of(file), old_head = last_sha256(file, 1);
    std::vector<Reading> readings;
    {
      Connection old = store::open(file, Access::read_only);
      CHECK(version_of(old) == newest_version());
      CHECK(verify(old).findings.empty());
      readings = load_campaign(old, 1, {.with_excluded = true}).campaign.readings;
    }
    CHECK(readings.size() == 9);
    CHECK_THROWS_WITH(store::open(file, Access::write), Contains("db migrate"));
    const Migration done = migrate(file);
    CHECK((done.from == version && done.to == newest_version()));
    CHECK(bytes_of(done.original) == was);
    Connection db = store::open(file, Access::write);
    CHECK(verify(db).findings.empty());
    const auto taken = load_campaign(db, 1, {.with_excluded = true}).campaign.readings;
    REQUIRE(taken.size() == readings.size());
    for (std::size_t k = 0; k < taken.size(); ++k) {
      CHECK(taken[k].target.vector() == readings[k].target.vector());
      CHECK(taken[k].conditions.cmd_mm == readings[k].conditions.cmd_mm);
    }
    CHECK(list_models(db, 1).size() == 1);
    const auto job = find_job(db, 1, list_jobs(db)[0].key);
    REQUIRE(job);
    CHECK_FALSE(job->data.statistics.empty());
    CHECK(job->data.key.scheme == 1);
    // Both heads are known, the old one as a fact.
    CHECK(had_head(db, old_head));
    CHECK(had_head(db, hex(chain_head(db, 1))));
    CHECK_FALSE(had_head(db, std::string(64, '0')));
    CHECK(taken_head(db, 1)->head == old_head);
    // And it goes on.
    test::measured_session(db, 1, "after", 2);
    CHECK(verify(db).findings.empty());
    CHECK(migrate(file).original.empty());
    // The original says what it always said.
    Connection before = open_as_it_is(done.original);
    CHECK(version_of(before) == version);
    CHECK(verify(before).findings.empty());
  }
}

TEST_CASE("every table of the old schema is taken over, every row with its number", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 4);
  Connection old = open_as_it_is(file);
  Connection now = store::open(file, Access::read_only);
  std::vector<std::string> tables;
  {
    Statement rows(old,
                   "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT IN "
                   "('campaign_chain', 'seal')");
    while (rows.step()) tables.push_back(rows.text(0));
  }
  CHECK(tables.size() == 17);
  for (const std::string& table : tables) {
    INFO(table);
    const std::string sql = "SELECT count(*), sum(rowid) FROM " + table;
    Statement a(old, sql), b(now, sql);
    REQUIRE((a.step() && b.step()));
    if (table != "job_parent") CHECK(a.integer(0) > 0);
    CHECK(a.text(0) == b.text(0));
    if (table != "job_session" && table != "job_exclusion" && table != "job_parent") {
      CHECK(a.text(1) == b.text(1));
    }
  }
  CHECK(number(now, "SELECT count(*) FROM machine_chain") ==
        7 * number(old, "SELECT count(*) FROM campaign_chain"));
}

TEST_CASE("a row has the same digest whatever its number in the file", "[store]") {
  const TempFolder folder;
  const auto build = [&](const char* name, bool shifted) {
    Connection db = store::open(folder.file(name), Access::create);
    if (shifted) {  // another campaign takes the first numbers
      Campaign other = test::small_campaign();
      other.name = "before";
      import_campaign(db, other);
    }
    return import_campaign(db, test::small_campaign()).campaign_id;
  };
  const Id a = build("a.db", false), b = build("b.db", true);
  REQUIRE(a != b);
  Connection first = store::open(folder.file("a.db"), Access::read_only);
  Connection second = store::open(folder.file("b.db"), Access::read_only);
  const auto digests = [](Connection& db, Id campaign) {
    std::vector<std::string> all;
    Sha256 head = {};
    Statement rows(db, kChainedReadings);
    while (rows.step()) {
      if (rows.integer(1) != campaign) continue;
      head = (Digest() << Bytes(head)).row(rows, kFirstChained, kEndChained).finish();
      all.push_back(hex(head));
    }
    return all;
  };
  CHECK(digests(first, a) == digests(second, b));
  CHECK(chain_head(first, a) == chain_head(second, b));
}

TEST_CASE("a version's job keys still hold for the readings it stored", "[store]") {
  const TempFolder folder;
  Connection old = store::open(copy_of_version(folder, 1), Access::read_only);
  const LoadedCampaign loaded = load_campaign(old, 1);
  const JobKeyInput input{.stage = "lsq", .campaign = loaded.campaign, .excluded_seqs = {2}};
  CHECK(job_key(input, 1).parts == get_job(old, 1).data.key.parts);
  CHECK(job_key(input).parts != get_job(old, 1).data.key.parts);
}

TEST_CASE("every version there was has its fixture", "[store]") {
  for (int version = 1; version < newest_version(); ++version) {
    CHECK(std::filesystem::exists(kVersions / ("version_" + std::to_string(version) + ".sqlite3")));
  }
}

TEST_CASE("a damaged original is not taken over, and nothing is left beside it", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 2);
  Connection(file, Access::write)
      .execute(
          "DROP TRIGGER reading_update; UPDATE reading SET y_mm = 1 WHERE seq = 2; "
          "CREATE TRIGGER reading_update BEFORE UPDATE ON reading\nBEGIN SELECT "
          "RAISE(ABORT, 'reading: what is stored can not be changed'); END");
  const std::string was = bytes_of(file);
  CHECK_THROWS_WITH(migrate(file), Contains("seq 2"));
  CHECK(bytes_of(file) == was);
  CHECK_FALSE(std::filesystem::exists(file.string() + ".part"));
  CHECK_FALSE(std::filesystem::exists(file.string() + ".v2"));
}

TEST_CASE("a database that is being written is not taken over", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 3);
  Connection busy(file, Access::write);
  busy.execute("PRAGMA journal_mode = WAL; BEGIN IMMEDIATE");
  CHECK_THROWS_AS(migrate(file), StoreError);
  busy.execute("ROLLBACK");
  CHECK(version_of(busy) == 3);
}

TEST_CASE("the original keeps its place where its new name is taken", "[store]") {
  const TempFolder folder;
  const auto file = copy_of_version(folder, 1);
  std::ofstream(file.string() + ".v1") << "of another day";
  const Migration done = migrate(file);
  CHECK(done.original == file.string() + ".v1-2");
  CHECK(std::filesystem::file_size(file.string() + ".v1") == 14);
  Connection original = open_as_it_is(done.original);
  CHECK(version_of(original) == 1);
}
