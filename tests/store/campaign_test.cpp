#include "store/campaign.hpp"

#include <chrono>

#include "store/session.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::number;
using trammel::test::small_campaign;
using trammel::test::TempFolder;

TEST_CASE("an imported campaign comes back bit for bit", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  Campaign c = small_campaign();
  c.simulated = true;
  c.readings[2].conditions.epoch = 2;
  c.readings[4].set = ReadingSet::predict;
  c.readings[4].measured.reset();
  c.machine.chains[1][6] = 0.1 + 0.2;  // h_2
  const ImportResult result = import_campaign(db, c, {{3, R"({"x_operator":"=1+1"})"}});
  CHECK_FALSE(result.already_stored);
  const LoadedCampaign loaded = load_campaign(db, result.campaign_id);
  CHECK(loaded.campaign.name == c.name);
  CHECK(loaded.campaign.simulated);
  CHECK(loaded.campaign.facts == c.facts);
  CHECK(to_vector(mechanism_of(loaded.campaign.machine).geometry) ==
        to_vector(mechanism_of(c.machine).geometry));
  CHECK(loaded.campaign.tracker->phi_rad == c.tracker->phi_rad);
  REQUIRE(loaded.campaign.readings.size() == c.readings.size());
  for (std::size_t i = 0; i < c.readings.size(); ++i) {
    const Reading& in = c.readings[i];
    const Reading& out = loaded.campaign.readings[i];
    CHECK((out.seq == in.seq && out.set == in.set && out.target == in.target));
    CHECK(out.measured == in.measured);
    CHECK(out.conditions.cmd_mm == in.conditions.cmd_mm);
    CHECK(out.conditions.from_mm == in.conditions.from_mm);
    CHECK(out.conditions.epoch == in.conditions.epoch);
    CHECK(out.conditions.time_s == in.conditions.time_s);
    CHECK(out.conditions.temp_degc == in.conditions.temp_degc);
  }
  CHECK(readings(db, result.campaign_id)[2].data.extra_json == R"({"x_operator":"=1+1"})");
}

TEST_CASE("the same campaign again stores nothing twice, another of its name is refused",
          "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const ImportResult first = import_campaign(db, small_campaign());
  const auto n = number(db, "SELECT count(*) FROM reading");
  const ImportResult again = import_campaign(db, small_campaign());
  CHECK(again.already_stored);
  CHECK(again.campaign_id == first.campaign_id);
  CHECK(number(db, "SELECT count(*) FROM reading") == n);
  Campaign other = small_campaign();
  other.readings[3].measured->y_mm += 1e-12;
  CHECK_THROWS_AS(import_campaign(db, other), InputError);
  CHECK_THROWS_AS(import_campaign(db, small_campaign(), {{1, "{}"}}), InputError);
  CHECK(number(db, "SELECT count(*) FROM reading") == n);
  other.name = "second";
  CHECK_FALSE(import_campaign(db, other).already_stored);
}

TEST_CASE("an import with one bad number stores nothing and names the reading", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  Campaign c = small_campaign();
  c.readings[4].conditions.cmd_mm[0] = NAN;
  CHECK_THROWS_WITH(import_campaign(db, c), Contains("seq 5"));
  CHECK(list_campaigns(db).empty());
  CHECK(number(db, "SELECT count(*) FROM session") == 0);
}

TEST_CASE("an excluded reading is left out by loads, listed, and still stored", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id id = import_campaign(db, small_campaign()).campaign_id;
  exclude_reading(db, id, 2, "the table was bumped");
  const LoadedCampaign loaded = load_campaign(db, id);
  CHECK(loaded.campaign.readings.size() == 5);
  CHECK(loaded.campaign.readings[1].seq == 3);
  REQUIRE(loaded.exclusions.size() == 1);
  CHECK(loaded.exclusions[0].reason == "the table was bumped");
  CHECK(load_campaign(db, id, {.with_excluded = true}).campaign.readings.size() == 6);
  CHECK_THROWS_AS(exclude_reading(db, id, 2, "again"), InputError);
  CHECK_THROWS_AS(exclude_reading(db, id, 3, "  "), InputError);
  CHECK_THROWS_AS(exclude_reading(db, id, 99, "no such"), NotFoundError);
}

TEST_CASE("a campaign is found by name and by uuid, and a wrong name lists the right ones",
          "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  import_campaign(db, small_campaign());
  const CampaignRow row = require_campaign(db, "rail-test");
  CHECK(row.n_readings == 6);
  CHECK(row.n_sessions == 1);
  CHECK(require_campaign(db, row.uuid).id == row.id);
  CHECK_THROWS_WITH(require_campaign(db, "rail"), Contains("rail-test"));
}

TEST_CASE("the text a reading was made of is kept, and counts when it is brought again",
          "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const std::map<int, std::string> raw = {{2, "P1, 1.0, 2.0\nP2, 3.0, 4.0"}};
  const std::string settings = R"({"points":{"file":"a.txt"}})";
  const ImportResult first = import_campaign(db, small_campaign(), {}, settings, raw);
  const auto stored = readings(db, first.campaign_id);
  CHECK(stored[1].data.raw_reply == raw.at(2));
  CHECK_FALSE(stored[0].data.raw_reply);
  CHECK(list_sessions(db, first.campaign_id).front().settings_json == settings);
  CHECK(import_campaign(db, small_campaign(), {}, settings, raw).already_stored);
  CHECK_THROWS_AS(import_campaign(db, small_campaign(), {}, settings, {{2, "another"}}),
                  InputError);
  CHECK(import_campaign(db, small_campaign()).already_stored);  // an export has no raw text
}

TEST_CASE("a campaign grows older by itself, from 0", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id id = add_campaign(db, small_campaign());
  const double age_s = campaign_age_s(db, id);
  CHECK(age_s >= 0);
  CHECK(age_s < 60);
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (campaign_age_s(db, id) <= age_s && std::chrono::steady_clock::now() < until) {
  }
  CHECK(campaign_age_s(db, id) > age_s);
}
