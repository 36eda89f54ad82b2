// `trammel archive …` as it is typed: a program of its own, that alone is linked with libpq.

#include <nlohmann/json.hpp>

#include <sstream>

#include "app/archive/install.hpp"
#include "app/terminal/columns.hpp"
#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using tests::Finished;
using tests::run_command;
using tests::run_program;

TEST_CASE("trammel is not linked with libpq, trammel-archive is", "[archive]") {
  const auto needs = [](const std::string& program) {
    return run_command({"readelf", "-d", tests::build_folder() + "/" + program}, "/").out;
  };
  CHECK_THAT(needs("trammel"), Contains("libc.so") && !Contains("libpq"));
  CHECK_THAT(needs("trammel-archive"), Contains("libpq"));
}

TEST_CASE("trammel archive runs trammel-archive with the same words", "[archive]") {
  const test::TempFolder folder;
  const Finished by_noun = run_program({"archive", "push", "--help"}, folder.path());
  const Finished own =
      run_command({tests::build_folder() + "/trammel-archive", "push", "--help"}, folder.path());
  CHECK(by_noun.exit_code == 0);
  CHECK(by_noun.out == own.out);
  CHECK_THAT(own.out, Contains("Send what the archive does not have yet"));
  for (const char* verb :
       {"init", "push", "pull", "list", "verify", "status", "rerun", "work", "query"}) {
    const Finished help = run_program({"archive", verb, "--help"}, folder.path());
    CHECK(help.exit_code == 0);
    std::istringstream in(help.out);
    for (std::string line; std::getline(in, line);) CHECK(terminal::columns_of(line) <= 100);
  }
  // trammel itself knows the verbs: for its page and at TAB, whether that program is there or not.
  CHECK_THAT(run_program({"man"}, folder.path()).out, Contains("archive rerun"));
  CHECK_THAT(run_program({"complete", "--", "archive", "wo"}, folder.path()).out,
             Contains("work\t"));
  const Finished none = run_program({"--db", "lab.db", "archive", "push"}, folder.path());
  CHECK(none.exit_code == 3);
  CHECK_THAT(none.err, Contains("trammel archive init URI"));
  CHECK(run_program({"archive", "psuh"}, folder.path()).exit_code == 2);
}

TEST_CASE("init, push, list, status, verify and pull as a person types them", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  {
    store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
    tests::add_full_campaign(db, "rail");
  }
  const auto run = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "archive");
    words.insert(words.end(), {"--db", "lab.db", "--json"});
    const Finished done = run_program(words, folder.path());
    CAPTURE(words, done.err);
    REQUIRE(done.exit_code == 0);
    const auto answer = nlohmann::json::parse(done.out);
    const std::string schema = "archive-" + words[1] + ".schema.json";
    CHECK(tests::schema_errors(answer, schema) == "");
    return answer;
  };
  const auto made = run({"init", server->uri(archive, "robot_a")});
  CHECK(made["made"] == false);
  CHECK(run({"init", server->uri(archive, "robot_a")})["station"] == made["station"]);
  const auto pushed = run({"push"});
  CHECK(pushed["campaigns"][0]["n_readings_sent"] == 12);
  CHECK(run({"push"})["campaigns"][0]["n_readings_sent"] == 0);
  const auto listed = run({"list", "--newest", "5"})["campaigns"];
  CHECK(listed.size() == 1);
  CHECK(listed[0]["name"] == "rail");
  CHECK(listed[0]["machine"] == "3-PRR");
  CHECK(listed[0]["head"] == pushed["campaigns"][0]["head"]);
  CHECK(run({"status"})["stations"][0]["n_readings"] == 12);
  CHECK(run({"rerun", "--stage", "lsq", "--campaign", "rail", "--newest", "3"})["queued"] == 1);
  const auto queued = [&](const char* where) {
    return run({"rerun", "--stage", "idw", "--where", where})["queued"];
  };
  CHECK(queued("n_readings > 12 OR kind = 'other'") == 0);
  CHECK(queued("n_readings >= 12 AND name LIKE 'r%'") == 1);
  CHECK(run({"verify"})["ok"] == true);
  CHECK(run({"pull", "--out", "again.db"})["n_readings"] == 12);
  CHECK(tests::content(folder.file("again.db")) == tests::content(folder.file("lab.db")));
  const Finished taken =
      run_program({"archive", "pull", "--db", "lab.db", "--out", "lab.db"}, folder.path());
  CHECK(taken.exit_code == 4);
}

TEST_CASE("an archive of a newer program is refused with both versions, and left alone",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  archive::Link(archive::LinkOptions{.uri = server->uri(archive, "owner"), .who = "tests"})
      .run("INSERT INTO trammel.archive (version) VALUES (99)");
  const Finished done = run_program(
      {"archive", "init", server->uri(archive, "owner"), "--db", "lab.db"}, folder.path());
  CHECK(done.exit_code == 8);
  CHECK_THAT(done.err, Contains("99") && Contains("version 8"));
}

TEST_CASE("an archive of an older program is refused until its owner has brought it up to date",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_full_campaign(db, "rail");
  }
  {
    archive::Link owner({.uri = server->uri(archive, "owner"), .who = "tests"});
    archive::Link::Transaction older(owner);
    owner.run("DROP SCHEMA trammel CASCADE");
    for (std::size_t k = 0; k < 3; ++k) owner.run(std::string(archive::archive_schema()[k]));
    older.commit();
  }
  tests::push_all(server->uri(archive, "robot_a"), file, tests::kStationA);
  REQUIRE(run_program({"archive", "init", server->uri(archive, "robot_a"), "--db", file},
                      folder.path())
              .exit_code == 8);  // only its owner may
  REQUIRE(run_program({"archive", "init", server->uri(archive, "owner"), "--db", "owner.db"},
                      folder.path())
              .exit_code == 0);
  REQUIRE(run_program({"archive", "init", server->uri(archive, "robot_a"), "--station",
                       tests::kStationA, "--db", file},
                      folder.path())
              .exit_code == 0);
  CHECK(run_program({"archive", "push", "--db", file}, folder.path()).exit_code == 0);
  CHECK(tests::asked(server->uri(archive, "visitor"), "SELECT count(*) FROM trammel.model") == "2");
  CHECK(tests::asked(server->uri(archive, "visitor"), "SELECT count(*) FROM trammel.findings()") ==
        "0");
}
