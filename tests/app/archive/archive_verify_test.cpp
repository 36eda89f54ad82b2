// What was changed in the server, behind its guards, is found; numbers come back with their bits.

#include <algorithm>

#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using Catch::Matchers::Contains;
using namespace trammel;

TEST_CASE("what was changed behind the guards is found", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_full_campaign(db, "rail");
  }
  const std::string name = server->new_archive();
  tests::push_all(server->uri(name, "robot_a"), file, tests::kStationA);
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"UPDATE trammel.reading SET x_mm = x_mm + 1e-12 WHERE seq = 3", "reading 3"},
      {"UPDATE trammel.reading SET raw_reply = raw_reply || '\\x00' WHERE seq = 8", "reading 8"},
      {"DELETE FROM trammel.reading WHERE seq = (SELECT max(seq) FROM trammel.reading)",
       "its head says"},
      {"UPDATE trammel.archive_row SET bytes = set_byte(bytes, length(bytes) - 1, 1) WHERE "
       "table_name = 'job'",
       "a row of job is not"},
      {"DELETE FROM trammel.archive_row WHERE table_name = 'exclusion'", "other rows"},
      {"DELETE FROM trammel.job_statistic", "a row of job_statistic differs"},
      {"UPDATE trammel.attempt SET status = 'ok'", "a row of attempt differs"},
      {"UPDATE trammel.campaign SET name = 'other'", "a row of campaign differs"},
      {"UPDATE trammel.job SET duration_s = duration_s + 1e-9", "a row of job differs"},
      {"DELETE FROM trammel.session WHERE name = 'baseline'", "a row of session differs"},
      {"UPDATE trammel.campaign_head SET head = sha256('')", "its head says"},
  };
  for (const auto& [sql, finding] : changes) {
    CAPTURE(sql);
    archive::Link link({.uri = server->uri(name, "postgres"), .who = "tests"});
    const archive::Link::Transaction undone(link);
    CHECK(link.ask("SELECT trammel.findings()").empty());
    link.run("SET LOCAL session_replication_role = replica");
    link.run(sql);
    std::string all;
    for (const auto& row : link.ask("SELECT trammel.findings()")) all += row[0].value_or("") + "\n";
    CHECK_THAT(all, Contains(finding));
  }
}

// Of all bit patterns of finite doubles, 20 000 by a seeded generator, and those at the ends.
TEST_CASE("doubles come out of canonical bytes with their bits", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string uri = server->uri(server->new_archive(), "visitor");
  CHECK(tests::asked(uri,
                     "SELECT count(*) FROM (SELECT substr(sha256(int4send(n)), 1, 8) AS b FROM "
                     "generate_series(1, 20000) AS n "
                     "UNION ALL SELECT unnest(ARRAY['\\x0000000000000000', '\\x0000000000000001', "
                     "'\\x800fffffffffffff', "
                     "'\\x0010000000000000', '\\x7fefffffffffffff', '\\xffefffffffffffff', "
                     "'\\x3ff0000000000001']::bytea[])) AS s "
                     "WHERE (get_byte(b, 0) & 127) * 16 + (get_byte(b, 1) >> 4) < 2047 "
                     "AND (float8send(trammel.real_of(b)) <> b OR "
                     "float8send((trammel.real_of(b)::text)::float8) <> b)") == "0");
  archive::Link link({.uri = uri, .who = "tests"});
  CHECK_THROWS_AS(link.ask("SELECT trammel.real_of('\\x7ff0000000000000')"), StoreError);
  CHECK_THROWS_AS(link.ask("SELECT trammel.part_of('exclusion', '\\x6900', '{1}', 1)"), StoreError);
  CHECK_THROWS_AS(link.ask("SELECT trammel.part_of('exclusion', "
                           "'\\x69000000000000000074ffffffffffffffff61', '{1}', 1)"),
                  StoreError);
}

TEST_CASE("an archive that is restored from a backup is what was backed up, and goes on",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_full_campaign(db, "rail");
    tests::add_small_campaigns(db, "c", 3);
  }
  const std::string name = server->new_archive(), restored = name + "_restored";
  tests::push_all(server->uri(name, "robot_a"), file, tests::kStationA);
  tests::asked(server->uri(name, "robot_a"), tests::queue_of("lsq", "name = 'c 1'"));
  tests::work_at(server->uri(name, "worker"), tests::kWorker);
  const std::string dump = server->socket_folder() / (name + ".dump");
  server->run("pg_dump", {"-Fc", "-f", dump, name});
  server->run("createdb", {"-O", "owner", restored});
  server->run("pg_restore", {"-d", restored, dump});
  for (const std::string& archive : {name, restored}) {
    const auto verified = tests::run_program(
        {"archive", "verify", "--archive", server->uri(archive, "visitor")}, folder.path());
    CAPTURE(archive, verified.err);
    CHECK(verified.exit_code == 0);
  }
  // Nothing is new to it; its guards are on; work goes on.
  const auto pushed = tests::push_all(server->uri(restored, "robot_a"), file, tests::kStationA);
  CHECK(std::ranges::all_of(
      pushed, [](const archive::Pushed& one) { return one.n_rows + one.n_readings == 0; }));
  CHECK_THROWS_WITH(tests::asked(server->uri(restored, "owner"), "DELETE FROM trammel.reading"),
                    Contains("can not be changed or deleted"));
  CHECK(tests::asked(server->uri(restored, "robot_a"), tests::queue_of("lsq")) == "4");
  CHECK(tests::work_at(server->uri(restored, "worker"), tests::kWorker, 2).known == 1);
}
