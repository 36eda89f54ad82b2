#include "store/open.hpp"

#include <fstream>

#include "store/migrations.hpp"
#include "store/transaction.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::number;
using trammel::test::TempFolder;

namespace {

Connection raw(const std::filesystem::path& file) { return Connection(file, Access::create); }

}  // namespace

TEST_CASE("a new database has its identity, WAL, FULL and every guard switched on", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  CHECK(number(db, "PRAGMA application_id") == kApplicationId);
  CHECK(version_of(db) == newest_version());
  CHECK(number(db, "PRAGMA foreign_key_check") == -1);
  Connection other = raw(folder.file("lab.db"));
  Statement mode(other, "PRAGMA journal_mode");
  REQUIRE(mode.step());
  CHECK(mode.text(0) == "wal");
}

TEST_CASE("a database that is not there is not made by reading it", "[store]") {
  const TempFolder folder;
  CHECK_THROWS_AS(store::open(folder.file("none.db"), Access::read_only), NotFoundError);
  CHECK_THROWS_AS(store::open(folder.file("none.db"), Access::write), NotFoundError);
  CHECK_FALSE(std::filesystem::exists(folder.file("none.db")));
  CHECK_THROWS_AS(store::open(folder.path(), Access::write), StoreError);
  CHECK_THROWS_AS(store::open(folder.file("no/such/folder.db"), Access::create), StoreError);
  for (const char* nothing : {"", ":memory:", "file:lab.db?mode=memory"}) {
    CHECK_THROWS_AS(store::open(nothing, Access::create), StoreError);
  }
}

TEST_CASE("a file that is no database is refused and left as it is", "[store]") {
  const TempFolder folder;
  const std::string text(5000, 'x');
  std::ofstream(folder.file("notes.txt")) << text;
  for (const Access access : {Access::read_only, Access::write, Access::create}) {
    CHECK_THROWS_WITH(store::open(folder.file("notes.txt"), access),
                      Contains("not a database of trammel"));
  }
  std::ifstream after(folder.file("notes.txt"));
  CHECK(std::string(std::istreambuf_iterator<char>(after), {}) == text);
}

TEST_CASE("a database of another program is refused and left as it is", "[store]") {
  const TempFolder folder;
  raw(folder.file("other.db")).execute("CREATE TABLE recipes (name TEXT)");
  for (const Access access : {Access::read_only, Access::write, Access::create}) {
    CHECK_THROWS_WITH(store::open(folder.file("other.db"), access),
                      Contains("not a database of trammel"));
  }
  Connection db = raw(folder.file("other.db"));
  CHECK(number(db, "SELECT count(*) FROM sqlite_schema") == 1);
}

TEST_CASE("a newer database is refused naming both versions", "[store]") {
  const TempFolder folder;
  { store::open(folder.file("lab.db"), Access::create); }
  const int newer = newest_version() + 1;
  raw(folder.file("lab.db")).execute("PRAGMA user_version = " + std::to_string(newer));
  CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::read_only),
                    Contains("version " + std::to_string(newer)) &&
                        Contains("version " + std::to_string(newest_version())));
}

TEST_CASE("a stranger's trigger or view in a database is refused by its name", "[store]") {
  const TempFolder folder;
  { store::open(folder.file("lab.db"), Access::create); }
  SECTION("a trigger") {
    raw(folder.file("lab.db"))
        .execute("CREATE TRIGGER trap AFTER INSERT ON campaign BEGIN SELECT 1; END");
    CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::write), Contains("trap"));
  }
  SECTION("a view") {
    raw(folder.file("lab.db")).execute("CREATE VIEW trap AS SELECT 1");
    CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::read_only), Contains("trap"));
  }
  SECTION("a guard that was taken away") {
    raw(folder.file("lab.db")).execute("DROP TRIGGER reading_update");
    CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::read_only),
                      Contains("reading_update"));
  }
  SECTION("an index of a table of ours, which hides rows from whoever asks by it") {
    raw(folder.file("lab.db")).execute("CREATE INDEX trap ON reading (seq) WHERE seq < 2");
    CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::write), Contains("index trap"));
    CHECK_THROWS_WITH(store::open(folder.file("lab.db"), Access::read_only),
                      Contains("index trap"));
  }
  SECTION("a table and an index of the user's own do no harm") {
    raw(folder.file("lab.db")).execute("CREATE TABLE notes (t TEXT); CREATE INDEX n ON notes (t)");
    CHECK_NOTHROW(store::open(folder.file("lab.db"), Access::read_only));
  }
}

TEST_CASE("a damaged database is refused for writing and left byte for byte", "[store]") {
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    Connection db = store::open(file, Access::create);
    import_campaign(db, test::small_campaign());
  }
  std::string bytes = tests::read_text(file);
  Connection db(file, Access::read_only);
  const auto page =
      number(db, "SELECT rootpage FROM sqlite_schema WHERE name = 'sqlite_autoindex_reading_1'");
  bytes[static_cast<std::size_t>(page - 1) * 4096 + 9] ^= 0x55;  // where a cell should begin
  std::ofstream(file, std::ios::binary) << bytes;
  CHECK_THROWS_WITH(store::open(file, Access::write), Contains("damaged"));
  CHECK(tests::read_text(file) == bytes);
}

TEST_CASE("a writer that waits too long says who is in the way, and what it had is undone",
          "[store]") {
  const TempFolder folder;
  Connection first = store::open(folder.file("lab.db"), Access::create);
  Connection second = store::open(folder.file("lab.db"), Access::write);
  Connection impatient = raw(folder.file("lab.db"));
  impatient.execute("PRAGMA busy_timeout = 50");
  {
    Transaction transaction(first);
    add_campaign(first, test::small_campaign());
    CHECK_THROWS_WITH(Transaction(impatient), Contains("in use by another process"));
    // A reader is never in the way, and sees nothing that is not committed.
    CHECK(list_campaigns(second).empty());
  }
  CHECK(list_campaigns(first).empty());
  add_campaign(second, test::small_campaign());
  CHECK(list_campaigns(first).size() == 1);
}

TEST_CASE("what a snapshot reads is one state of the database, whatever others write", "[store]") {
  const TempFolder folder;
  Connection writer = store::open(folder.file("lab.db"), Access::create);
  import_campaign(writer, test::small_campaign(6, "first"));
  Connection reader = store::open(folder.file("lab.db"), Access::read_only);
  const auto campaigns = [&] { return number(reader, "SELECT count(*) FROM campaign"); };
  {
    const Snapshot snapshot(reader);
    CHECK(campaigns() == 1);
    import_campaign(writer, test::small_campaign(7, "second"));
    {
      const Snapshot part(reader);
      CHECK(campaigns() == 1);
    }
    CHECK(campaigns() == 1);
  }
  CHECK(campaigns() == 2);
}
