// Each role tries what it must not; the archive itself refuses, whatever program asks.

#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using tests::kStationA;
using tests::kStationB;

namespace {

/// An archive with one campaign of robot_a.
struct Filled {
  explicit Filled(tests::Postgres& of) : server(of), name(of.new_archive()) {
    const test::TempFolder folder;
    {
      store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
      tests::add_full_campaign(db, "rail");
    }
    tests::push_all(as("robot_a"), folder.file("lab.db"), kStationA);
  }
  [[nodiscard]] std::string as(const std::string& role) const { return server.uri(name, role); }
  /// What the archive says to it; "done" where it does it.
  [[nodiscard]] std::string tried(const std::string& role, const std::string& sql) const {
    archive::Link link({.uri = as(role), .who = "tests"});
    try {
      link.run(sql);
      return "done";
    } catch (const Error& error) {
      return error.text().got;
    }
  }
  tests::Postgres& server;
  std::string name;
};

const std::string kStays = "what is stored can not be changed or deleted";

}  // namespace

TEST_CASE("what is stored is neither changed nor deleted, by its owner either", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Filled archive(*server);
  for (const char* table :
       {"archive_row", "reading", "campaign", "session", "point", "job", "result", "station"}) {
    const std::string of = std::string("trammel.") + table;
    const char* column = table == std::string("station") ? "uuid" : "campaign";
    CAPTURE(table);
    CHECK_THAT(archive.tried("owner", "UPDATE " + of + " SET " + column + " = " + column),
               Contains(kStays));
    CHECK_THAT(archive.tried("owner", "DELETE FROM " + of), Contains(kStays));
    CHECK_THAT(archive.tried("owner", "TRUNCATE " + of + " CASCADE"), Contains(kStays));
    for (const char* role : {"robot_a", "worker", "visitor"}) {
      CHECK_THAT(archive.tried(role, "UPDATE " + of + " SET " + column + " = " + column),
                 Contains("42501"));
      CHECK_THAT(archive.tried(role, "DELETE FROM " + of), Contains("42501"));
      CHECK_THAT(archive.tried(role, "TRUNCATE " + of + " CASCADE"), Contains("42501"));
    }
  }
  CHECK_THAT(archive.tried("owner", "UPDATE trammel.campaign_head SET n_readings = 0"),
             Contains("never back"));
  CHECK_THAT(archive.tried("owner", "UPDATE trammel.campaign_head SET head = sha256('')"),
             Contains("never back"));
  CHECK_THAT(archive.tried("owner", "DELETE FROM trammel.campaign_head"), Contains(kStays));
}

TEST_CASE("each role may what it is for and nothing else", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Filled archive(*server);
  struct Try {
    const char* role;
    std::string sql;
    bool may;
  };
  const std::vector<Try> tries = {
      {"visitor", "SELECT count(*) FROM trammel.reading", true},
      {"visitor", "SELECT trammel.findings()", true},
      {"stranger", "SELECT count(*) FROM trammel.reading", false},
      {"visitor", "SELECT trammel.begin_push('x', 'y')", false},
      {"visitor", "INSERT INTO trammel.archive_row (campaign) VALUES ('x')", false},
      {"visitor", "CREATE TABLE trammel.mine (n int)", false},
      {"robot_a", "CREATE TABLE trammel.mine (n int)", false},
      {"robot_a", "INSERT INTO trammel.campaign_head (campaign) VALUES ('x')", false},
      {"robot_a", "UPDATE trammel.campaign_head SET n_rows = n_rows + 1", false},
      {"robot_a", "INSERT INTO trammel.campaign (campaign, name) VALUES ('x', 'y')", false},
      {"robot_a", "INSERT INTO trammel.station (uuid, role) VALUES ('x', 'robot_b')", false},
      {"robot_a", "INSERT INTO trammel.reading (received_at) VALUES (now())", false},
      {"robot_a", "INSERT INTO trammel.archive_row (received_at) VALUES (now())", false},
      {"robot_a", "ALTER TABLE trammel.reading DISABLE TRIGGER ALL", false},
      {"robot_a", "DROP TRIGGER stays ON trammel.reading", false},
      {"robot_a", "SET session_replication_role = replica", false},
      {"owner", "SET session_replication_role = replica", false},
      {"robot_a", "SELECT trammel.rows_arrived()", false},
      {"visitor", "SELECT count(*) FROM trammel.work", true},
      {"visitor", tests::queue_of("lsq"), false},
      {"robot_a", tests::queue_of("lsq"), true},
      {"robot_a", "INSERT INTO trammel.work (stage, force, campaign) VALUES ('lsq', false, 'x')",
       false},
      {"visitor", "SELECT * FROM trammel.claim('x', 'y', 1)", false},
      {"robot_a", "SELECT * FROM trammel.claim('x', 'y', 1)", false},
      {"robot_a", "SELECT trammel.heartbeat(1, gen_random_uuid(), 1)", false},
      {"robot_a", "SELECT trammel.give_back(1, gen_random_uuid(), '')", false},
      {"robot_a",
       "SELECT trammel.finish(1, gen_random_uuid(), 'x', 'y', 'z', NULL, NULL, NULL, NULL, NULL)",
       false},
      {"worker", "SELECT * FROM trammel.claim('" + kStationB + "', 'y', 1)", true},
      {"worker", "SELECT * FROM trammel.claim('" + kStationA + "', 'y', 1)", false},  // robot_a's
      {"worker", "UPDATE trammel.work SET state = 'done'", false},
      {"worker", "DELETE FROM trammel.work", false},
      {"worker", "INSERT INTO trammel.result (machine) VALUES ('y')", false},
      {"worker", "SELECT trammel.result_filled()", false},
      {"robot_a", "CREATE FUNCTION trammel.sha256(bytea) RETURNS bytea LANGUAGE sql AS 'SELECT $1'",
       false},
  };
  for (const Try& one : tries) {
    CAPTURE(one.role, one.sql);
    CHECK((archive.tried(one.role, one.sql) == "done") == one.may);
  }
}

TEST_CASE("the archive refuses rows that are not what their digests say, whoever sends them",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Filled archive(*server);
  const std::string campaign =
      tests::asked(archive.as("visitor"), "SELECT campaign FROM trammel.campaign_head");
  const auto forged_row = [&](const std::string& uuid, const std::string& bytes,
                              const std::string& sha) {
    return "INSERT INTO trammel.archive_row (campaign, table_name, row_key, row_ids, n_rows, "
           "bytes, sha256) "
           "SELECT '" +
           uuid + "', 'exclusion', key, '{9}', '{1}', " + bytes + ", " + sha +
           " FROM (SELECT trammel.canonical('" + uuid +
           "') || trammel.canonical(77::bigint) AS key) AS k";
  };
  const std::string whole =
      "trammel.canonical(0::bigint) || key || trammel.canonical('why') || "
      "trammel.canonical('when')";
  const std::string honest_sha = "sha256(" + whole + ")";
  const std::string part = "trammel.canonical(0::bigint)";
  CHECK_THAT(archive.tried("robot_a", forged_row(campaign, whole, "sha256('')")),
             Contains("digest"));
  CHECK_THAT(archive.tried("robot_a", forged_row(campaign, part, "sha256(" + part + ")")),
             Contains("key say"));
  CHECK_THAT(archive.tried("robot_b", forged_row(campaign, whole, honest_sha)),
             Contains("not of a station"));
  CHECK_THAT(archive.tried("robot_a", forged_row(kStationB, whole, honest_sha)),
             Contains("not of a station") || Contains("23503"));
  // As it should be: taken, and the head moves. So those above were refused for their own reasons.
  CHECK(archive.tried("robot_a", forged_row(campaign, whole, honest_sha)) == "done");
  CHECK_THAT(archive.tried("robot_b",
                           "SELECT trammel.begin_push('" + campaign + "', '" + kStationA + "')"),
             Contains("another role's"));
  const auto reading = [&](const std::string& seq, const std::string& x, const std::string& sha) {
    return "INSERT INTO trammel.reading (campaign, row_id, seq, session, epoch, reading_set, "
           "target_x_mm, cmd_l1_mm, "
           "from_l1_mm, x_mm, sha256) SELECT campaign, 99, " +
           seq + ", 's', 1, 'identify', 1, 2, 3, " + x + ", " + sha +
           " FROM trammel.campaign_head AS h";
  };
  const auto honest = [](const std::string& seq) {
    return "trammel.link(h.head, trammel.bytes_of(ROW(campaign, 99, " + seq +
           ", 's', 1, NULL, NULL, 'identify', 1, NULL, NULL, 2, NULL, NULL, 3, NULL, NULL, 4.5, "
           "NULL, NULL, NULL, NULL, "
           "NULL, NULL, NULL, NULL, NULL, ''::bytea, now())::trammel.reading))";
  };
  CHECK_THAT(archive.tried("robot_a", reading("1000", "4.5", "sha256('')")), Contains("chain"));
  CHECK_THAT(archive.tried("robot_a", reading("1000", "4.500001", honest("1000"))),
             Contains("chain"));
  CHECK_THAT(archive.tried("robot_b", reading("1000", "4.5", honest("1000"))),
             Contains("not of a station"));
  CHECK(archive.tried("robot_a", reading("1000", "4.5", honest("1000"))) == "done");
  CHECK_THAT(archive.tried("robot_a", reading("999", "4.5", honest("999"))),
             Contains("not behind"));
  CHECK(tests::asked(archive.as("visitor"), "SELECT count(*) FROM trammel.findings()") == "0");
}

// Whose chain is right, too: the numbers are looked at first. The control is a number like others.
TEST_CASE("a reading that is no number is refused, in every column", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Filled archive(*server);
  const auto insert = [&archive](const std::string& column, const std::string& number) {
    const std::string columns = column == "target_x_mm" ? "" : ", target_x_mm";
    const std::string cmd = column == "cmd_l1_mm" ? "" : ", cmd_l1_mm";
    return archive.tried(
        "robot_a",
        "INSERT INTO trammel.reading (campaign, row_id, seq, session, epoch, "
        "reading_set, from_l1_mm, sha256, " +
            column + columns + cmd +
            ") SELECT campaign, 1000, last_seq + 1, 's', 1, 'identify', 0, head, '" + number + "'" +
            (columns.empty() ? "" : ", 0") + (cmd.empty() ? "" : ", 0") +
            " FROM trammel.campaign_head");
  };
  for (const char* column :
       {"target_x_mm", "target_y_mm", "target_phi_rad", "cmd_l1_mm", "cmd_l2_mm", "from_l3_mm",
        "x_mm", "y_mm", "phi_rad", "encoder_l2_mm", "time_s", "temp_degc"}) {
    for (const char* none : {"NaN", "Infinity", "-Infinity"}) {
      CAPTURE(column, none);
      CHECK_THAT(insert(column, none), Contains("reading_has_numbers"));
    }
    CHECK_THAT(insert(column, "1"), Contains("not what its chain says"));
  }
}
