// What is stored stays: through our connection and through any other program's.
#include "store/guard.hpp"

#include "store/job.hpp"
#include "store/model.hpp"
#include "store/seal.hpp"
#include "store/transaction.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::number;
using trammel::test::TempFolder;

namespace {

const std::vector<std::string> kTables = {
    "campaign",      "machine",   "machine_chain", "drive",         "taken_over", "campaign_fact",
    "job",           "session",   "session_event", "epoch",         "point",      "attempt",
    "reading",       "exclusion", "job_session",   "job_exclusion", "job_parent", "job_key_part",
    "job_statistic", "job_point", "model",         "seal"};

// At least one row in every table.
void fill(Connection& db) {
  const Id campaign = import_campaign(db, test::small_campaign()).campaign_id;
  const Id session = test::measured_session(db, campaign, "baseline", 3);
  add_event(db, session, "done");
  const Id exclusion = exclude_reading(db, campaign, 2, "bumped");
  NewJob job{.campaign_id = campaign, .stage = "lsq"};
  job.key = {std::string(64, 'a'), {{"stage", std::string(64, 'b')}}};
  const Id parent = add_job(db, job);
  job.key.key = std::string(64, 'c');
  job.sessions = {session};
  job.exclusions = {exclusion};
  job.parents = {parent};
  job.statistics = {{.set = "identify", .metric = "position_mm", .before = Summary{1, 2, 3, 4, 5}}};
  {
    // As until version 3: written with the job, before its seal.
    Transaction transaction(db);
    db.execute(
        "INSERT INTO job (campaign_id, key, run, stage, algorithm_version, parameters_json, "
        "model_json, result_json, n_readings, tool_version, git_revision, compiler, libraries, "
        "cpu_level, created_utc, duration_s) SELECT campaign_id, key, 9, stage, 1, '{}', '{}', "
        "'{}', 6, '', '', '', '', '', created_utc, 0 FROM job LIMIT 1; INSERT INTO job_point "
        "SELECT max(job_id), 1, 1, 0, 0, 0, 0.5, 0, 0 FROM job");
    seal(db, "job", number(db, "SELECT max(job_id) FROM job"));
    transaction.commit();
  }
  add_model(db, {.campaign_id = campaign, .name = "nominal", .job_id = add_job(db, job)});
}

}  // namespace

TEST_CASE("UPDATE, DELETE and INSERT OR REPLACE are refused in every table", "[store]") {
  const TempFolder folder;
  Connection ours = store::open(folder.file("lab.db"), Access::create);
  fill(ours);
  // As any other program opens it: no foreign keys, no recursive triggers, no authorizer.
  Connection other(folder.file("lab.db"), Access::write);
  other.execute("PRAGMA foreign_keys = OFF; PRAGMA recursive_triggers = OFF");
  for (const std::string& table : kTables) {
    INFO(table);
    const auto n = number(ours, "SELECT count(*) FROM " + table);
    REQUIRE(n > 0);
    std::string column;
    {
      Statement info(other,
                     "SELECT name FROM pragma_table_info('" + table + "') ORDER BY cid DESC");
      REQUIRE(info.step());
      column = info.text(0);
    }
    for (Connection* db : {&ours, &other}) {
      CHECK_THROWS_AS(db->execute("UPDATE " + table + " SET " + column + " = " + column),
                      StoreError);
      CHECK_THROWS_AS(db->execute("UPDATE OR REPLACE " + table + " SET " + column + " = 1"),
                      StoreError);
      CHECK_THROWS_AS(db->execute("DELETE FROM " + table), StoreError);
      CHECK_THROWS_AS(
          db->execute("INSERT OR REPLACE INTO " + table + " SELECT * FROM " + table + " LIMIT 1"),
          StoreError);
      CHECK_THROWS_AS(db->execute("INSERT INTO " + table + " SELECT * FROM " + table +
                                  " LIMIT 1 ON CONFLICT DO UPDATE SET " + column + " = " + column),
                      StoreError);
    }
    CHECK(number(ours, "SELECT count(*) FROM " + table) == n);
  }
}

TEST_CASE("a stored seq can not be taken by a row of another id", "[store]") {
  const TempFolder folder;
  {
    Connection db = store::open(folder.file("lab.db"), Access::create);
    fill(db);
  }
  Connection other(folder.file("lab.db"), Access::write);
  other.execute("PRAGMA foreign_keys = OFF");
  const std::string replace =
      "INSERT OR REPLACE INTO reading SELECT 9999, campaign_id, seq, session_id, epoch, NULL, "
      "reading_set, target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, "
      "from_l1_mm, from_l2_mm, from_l3_mm, x_mm + 1, y_mm, phi_rad, NULL, NULL, NULL, time_s, "
      "temp_degc, raw_reply, extra_json, sha256 FROM reading WHERE seq = ";
  CHECK_THROWS_AS(other.execute(replace + "1"), StoreError);
  CHECK_THROWS_AS(other.execute(replace + "9"), StoreError);
}

TEST_CASE("our connection neither drops nor alters nor attaches nor unlocks", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  for (const char* sql :
       {"DROP TABLE reading", "DROP TRIGGER reading_update", "ALTER TABLE reading ADD COLUMN z",
        "ALTER TABLE reading RENAME TO r", "ATTACH ':memory:' AS m", "PRAGMA writable_schema = ON",
        "PRAGMA recursive_triggers = OFF", "PRAGMA foreign_keys = OFF", "PRAGMA user_version = 9",
        "PRAGMA application_id = 1", "PRAGMA ignore_check_constraints = ON",
        "PRAGMA journal_mode = OFF", "CREATE TABLE t (x)",
        "CREATE TRIGGER t AFTER INSERT ON point "
        "BEGIN SELECT 1; END",
        "DELETE FROM sqlite_schema", "SELECT load_extension('x')"}) {
    INFO(sql);
    CHECK_THROWS_AS(db.execute(sql), StoreError);
  }
}

TEST_CASE("a migration adds, and neither drops nor alters nor rewrites what is raw", "[store]") {
  const TempFolder folder;
  {
    Connection db = store::open(folder.file("lab.db"), Access::create);
    fill(db);
  }
  Connection db(folder.file("lab.db"), Access::write);
  guard_migration(db);
  for (const std::string& table : kTables) {
    INFO(table);
    CHECK_THROWS_AS(db.execute("DROP TABLE " + table), StoreError);
    CHECK_THROWS_AS(db.execute("ALTER TABLE " + table + " ADD COLUMN z"), StoreError);
    CHECK_THROWS_AS(db.execute("ALTER TABLE " + table + " RENAME TO z"), StoreError);
    CHECK_THROWS_AS(db.execute("DROP TRIGGER " + table + "_update"), StoreError);
    CHECK_THROWS_AS(db.execute("DELETE FROM " + table), StoreError);
    CHECK_THROWS_AS(db.execute("UPDATE " + table + " SET rowid = 77"), StoreError);
  }
  CHECK_THROWS_AS(db.execute("DROP INDEX attempt_ok_once"), StoreError);
  CHECK_THROWS_AS(db.execute("ATTACH ':memory:' AS m"), StoreError);
  CHECK_NOTHROW(
      db.execute("CREATE TABLE later (x REAL) STRICT; CREATE INDEX later_x ON later (x); "
                 "INSERT INTO later VALUES (1); DROP VIEW v_drift; "
                 "CREATE VIEW v_drift AS SELECT 1; CREATE TRIGGER later_update BEFORE UPDATE ON "
                 "later BEGIN SELECT RAISE(ABORT, 'no'); END; PRAGMA user_version = 99"));
}

TEST_CASE("a reading's numbers are finite and within bounds, or nothing is stored", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = add_campaign(db, test::small_campaign());
  const Id session =
      create_session(db, {.campaign_id = campaign, .name = "s", .points = test::line_plan(1)});
  const Epoch epoch = open_epoch(db, session, SetUp::fresh, "start");
  const Id attempt = begin_attempt(db, session, 1, epoch.id);
  const NewReading good = test::reading_at(test::line_plan(1)[0]);
  std::vector<NewReading> bad(9, good);
  bad[0].reading.measured->x_mm = NAN;
  bad[1].reading.measured->phi_rad = INFINITY;
  bad[2].reading.conditions.cmd_mm[1] = NAN;
  bad[3].reading.conditions.from_mm[2] = -INFINITY;
  bad[4].reading.target.y_mm = 1e9;
  bad[5].reading.conditions.temp_degc = -300;
  bad[6].reading.measured.reset();  // only a predict row has no pose
  bad[7].encoder_mm = Displacements{1, NAN, 3};
  bad[8].extra_json = "{not json";
  for (const NewReading& reading : bad) {
    CHECK_THROWS_AS(finish_attempt(db, attempt, {good, reading}), Error);
    CHECK(number(db, "SELECT count(*) FROM reading") == 0);
    CHECK(attempts(db, session)[0].status == "open");
  }
  CHECK(finish_attempt(db, attempt, {good}) == std::vector{1});
}
