#include "store/backup.hpp"

#include "store/campaign.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::TempFolder;

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
