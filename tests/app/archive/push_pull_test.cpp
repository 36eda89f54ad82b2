// What a station pushes is what it gets again; what is not the station's own is refused.

#include "app/archive/pull.hpp"
#include "store/open.hpp"
#include "store/reading.hpp"
#include "store/session.hpp"
#include "store/verify.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using store::Access;
using store::Connection;
using tests::kStationA;
using tests::kStationB;
using tests::push_all;

namespace {

struct Sent {
  std::int64_t rows = 0, readings = 0;
};
Sent sent(const std::vector<archive::Pushed>& pushed) {
  Sent sum;
  for (const archive::Pushed& one : pushed) {
    sum.rows += one.n_rows;
    sum.readings += one.n_readings;
  }
  return sum;
}

void pull_to(const std::string& uri, const std::string& station, const std::filesystem::path& to) {
  archive::Link link({.uri = uri, .who = "tests"});
  static_cast<void>(archive::pull(link, {.station = station}, to));
}

/// What a push says when it is refused.
std::string refusal(const std::string& uri, const std::filesystem::path& file,
                    const std::string& station) {
  try {
    push_all(uri, file, station);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

std::string head_of(const std::filesystem::path& file, const char* campaign) {
  Connection db = store::open_as_it_is(file);
  return store::hex(store::chain_head(db, store::require_campaign_id(db, campaign)));
}

}  // namespace

TEST_CASE("a pulled file has every row, number and bit of the one that was pushed", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    Connection db = store::open(file, Access::create);
    tests::add_full_campaign(db, "first");
    tests::add_full_campaign(db, "second");
  }
  const Sent all = sent(push_all(uri, file, kStationA));
  CHECK(all.readings == 2 * (6 + 3 + 3));
  CHECK(all.rows > 40);
  pull_to(uri, kStationA, folder.file("again.db"));
  CHECK(tests::content(folder.file("again.db")) == tests::content(file));
  CHECK(head_of(folder.file("again.db"), "first") == head_of(file, "first"));
  Connection again = store::open(folder.file("again.db"), Access::write);  // its guards are on
  CHECK_THROWS_AS(again.execute("UPDATE reading SET x_mm = 0"), StoreError);
  CHECK(store::verify(again).ok());
}

TEST_CASE("a push sends what is new, and that alone", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  Connection db = store::open(file, Access::create);
  tests::add_full_campaign(db, "rail");
  push_all(uri, file, kStationA);
  const Sent nothing = sent(push_all(uri, file, kStationA));
  CHECK(nothing.rows == 0);
  CHECK(nothing.readings == 0);
  const store::Id campaign = store::require_campaign_id(db, "rail");
  // An attempt that was open when its neighbours were pushed is closed, and a walk is added.
  CHECK(store::interrupt_open_attempts(db, store::find_session(db, campaign, "baseline")->id,
                                       "recovered") == 1);
  test::measured_session(db, campaign, "later", 3);
  const Sent more = sent(push_all(uri, file, kStationA));
  CHECK(more.readings == 3);
  CHECK(more.rows == 1 + 1 + 1 + 3);  // that attempt; session, epoch and attempts of the walk
  pull_to(uri, kStationA, folder.file("again.db"));
  CHECK(tests::content(folder.file("again.db")) == tests::content(file));
}

TEST_CASE("a copied database that went its own way is refused with both heads", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db"), copy = folder.file("copy.db");
  {
    Connection db = store::open(file, Access::create);
    tests::add_full_campaign(db, "rail");
  }
  push_all(uri, file, kStationA);
  std::filesystem::copy_file(file, copy);
  const auto go_on = [](const std::filesystem::path& which, const std::string& name) {
    Connection db = store::open(which, Access::write);
    test::measured_session(db, store::require_campaign_id(db, "rail"), name, 3);
  };
  go_on(file, "mine");
  go_on(copy, "theirs");
  push_all(uri, file, kStationA);
  const std::string archived =
      tests::asked(uri, "SELECT encode(head, 'hex') FROM trammel.campaign_head");
  REQUIRE(archived == head_of(file, "rail"));
  const std::string said = refusal(uri, copy, kStationA);
  CHECK_THAT(said, Contains(archived));
  CHECK_THAT(said, Contains(head_of(copy, "rail")));
  // As another station: whose it is, and both heads.
  const std::string other = refusal(uri, copy, kStationB);
  CHECK_THAT(other, Contains(kStationA) && Contains(kStationB) && Contains(archived));
  CHECK(tests::asked(uri, "SELECT encode(head, 'hex') FROM trammel.campaign_head") == archived);
  CHECK(tests::asked(uri, "SELECT count(*) FROM trammel.findings()") == "0");
}

TEST_CASE("a copy that differs in other rows than readings, and an older backup, are refused",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db"), copy = folder.file("copy.db"),
             old = folder.file("old.db");
  {
    Connection db = store::open(file, Access::create);
    tests::add_full_campaign(db, "rail");
  }
  std::filesystem::copy_file(file, copy);
  std::filesystem::copy_file(file, old);
  const auto exclude = [](const std::filesystem::path& which, const char* reason) {
    Connection db = store::open(which, Access::write);
    store::exclude_reading(db, store::require_campaign_id(db, "rail"), 5, reason);
  };
  exclude(file, "the door was open");
  exclude(copy, "the lamp was on");
  push_all(uri, file, kStationA);
  CHECK_THAT(refusal(uri, copy, kStationA), Contains("rows that this file does not have"));
  CHECK_THAT(refusal(uri, old, kStationA), Contains("rows that this file does not have"));
  CHECK(tests::asked(uri, "SELECT count(*) FROM trammel.findings()") == "0");
}

TEST_CASE("a file that was edited is not sent", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "robot_a");
  const test::TempFolder folder;
  for (const char* edit : {"UPDATE reading SET x_mm = x_mm + 1e-9 WHERE seq = 4",
                           "UPDATE session SET plan_name = 'other' WHERE name = 'baseline'"}) {
    const auto file = folder.file(std::to_string(std::string_view(edit).size()) + ".db");
    {
      Connection db = store::open(file, Access::create);
      tests::add_full_campaign(db, "rail");
    }
    {
      Connection db(file, Access::write);
      std::string guard;
      const std::string trigger = std::string(edit).substr(7, 7) + "_update";
      {
        store::Statement text(db, "SELECT sql FROM sqlite_schema WHERE name = ?");
        text << trigger;
        REQUIRE(text.step());
        guard = text.text(0);
      }
      db.execute("DROP TRIGGER " + trigger);
      db.execute(edit);
      db.execute(guard);
    }
    CHECK_THAT(refusal(uri, file, kStationA), Contains("not what was stored, and is not sent"));
    CHECK(tests::asked(uri, "SELECT count(*) FROM trammel.campaign_head") == "0");
  }
}
