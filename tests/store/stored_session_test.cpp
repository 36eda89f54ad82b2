#include "store/session.hpp"

#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::line_plan;
using trammel::test::number;
using trammel::test::reading_at;
using trammel::test::TempFolder;

TEST_CASE("a plan comes back as it was stored", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = add_campaign(db, test::small_campaign());
  std::vector<Point> plan = line_plan(2);
  plan[1].set = ReadingSet::validate;
  plan[1].reference = true;
  plan[1].repeat = 3;
  const Id session = create_session(
      db, {.campaign_id = campaign, .name = "s", .plan_name = "paper-80", .points = plan});
  const std::vector<Point> back = points(db, session);
  REQUIRE(back.size() == 2);
  CHECK(back[1].target == plan[1].target);
  CHECK(back[1].planned_mm == plan[1].planned_mm);
  CHECK((back[1].set == ReadingSet::validate && back[1].reference && back[1].repeat == 3));
  CHECK(back[0].approach == std::array{1, -1, 0});
  CHECK(back[0].role == "grid");
  CHECK_THROWS_AS(create_session(db, {.campaign_id = campaign, .name = "s"}), InputError);
  CHECK_THROWS_AS(db.execute("INSERT INTO point SELECT 99, session_id, 99, reading_set, 1, 1, 0, "
                             "0, 0, 0, 1, 0, '', 1, 1, 1 FROM point LIMIT 1"),
                  StoreError);
}

TEST_CASE("a resume has exactly the points without an ok attempt to do", "[store]") {
  const TempFolder folder;
  const auto file = folder.file("lab.db");
  Id session = 0;
  {
    Connection db = store::open(file, Access::create);
    const Id campaign = add_campaign(db, test::small_campaign());
    session = create_session(db, {.campaign_id = campaign, .name = "s", .points = line_plan(4)});
    const Epoch epoch = open_epoch(db, session, SetUp::fresh, "start");
    CHECK(epoch.number == 1);
    const Point first = open_points(db, session)[0];
    finish_attempt(db, begin_attempt(db, session, 1, epoch.id), {reading_at(first)});
    fail_attempt(db, begin_attempt(db, session, 2, epoch.id), "beam lost");
    begin_attempt(db, session, 3, epoch.id);  // and the runner dies
  }
  Connection db = store::open(file, Access::write);
  CHECK(interrupt_open_attempts(db, session, "the runner died") == 1);
  CHECK(interrupt_open_attempts(db, session, "again") == 0);
  const auto left = open_points(db, session);
  REQUIRE(left.size() == 3);
  CHECK(left[0].seq == 2);
  const Epoch epoch = open_epoch(db, session, SetUp::fresh, "resume");
  CHECK(epoch.number == 2);
  for (const Point& point : left) {
    finish_attempt(db, begin_attempt(db, session, point.seq, epoch.id), {reading_at(point)});
  }
  CHECK(open_points(db, session).empty());
  const auto all = attempts(db, session);
  REQUIRE(all.size() == 6);
  CHECK((all[1].status == "failed" && all[1].detail == "beam lost"));
  CHECK(all[2].status == "interrupted");
  CHECK((all[4].point_seq == 3 && all[4].number == 2 && all[4].epoch == 2));
  const SessionRow row = get_session(db, session);
  CHECK((row.n_points == 4 && row.n_ok == 4 && row.n_readings == 4));
  CHECK(readings(db, row.campaign_id)[3].data.reading.conditions.epoch == 2);
}

TEST_CASE("a point that is stored is never measured again", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = add_campaign(db, test::small_campaign());
  const Id session = test::measured_session(db, campaign, "s", 2);
  const Epoch epoch = epochs(db, session)[0];
  CHECK_THROWS_AS(begin_attempt(db, session, 1, epoch.id), StoreError);
  CHECK_THROWS_AS(begin_attempt(db, session, 9, epoch.id), NotFoundError);
  const Id attempt = attempts(db, session)[0].id;
  CHECK_THROWS_AS(finish_attempt(db, attempt, {reading_at(line_plan(1)[0])}), Error);
  CHECK_THROWS_AS(fail_attempt(db, attempt, "late"), StoreError);
  CHECK(number(db, "SELECT count(*) FROM reading") == 2);
}

TEST_CASE("a session goes on under the set-up of the one before, or under its own", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = add_campaign(db, test::small_campaign());
  test::measured_session(db, campaign, "one", 1);
  const Id two = create_session(db, {.campaign_id = campaign, .name = "two"});
  CHECK(open_epoch(db, two, SetUp::as_before, "same homing").number == 1);
  CHECK(open_epoch(db, two, SetUp::fresh, "homed").number == 2);
}

TEST_CASE("only the readings of the sessions asked for are loaded", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = add_campaign(db, test::small_campaign());
  test::measured_session(db, campaign, "one", 3);
  const Id two = test::measured_session(db, campaign, "two", 2);
  CHECK(load_campaign(db, campaign).campaign.readings.size() == 5);
  const LoadedCampaign loaded = load_campaign(db, campaign, {.sessions = {two}});
  REQUIRE(loaded.campaign.readings.size() == 2);
  CHECK(loaded.campaign.readings[0].seq == 4);  // seq counts through the campaign
  CHECK(loaded.sessions == std::vector{two});
  const StoredReading stored = readings(db, campaign, {two}).front();
  CHECK(stored.data.reading.seq == 4);
  CHECK(stored.data.raw_reply == "AP 1 2 3");
  CHECK(stored.data.encoder_mm->x() == 201);
}
