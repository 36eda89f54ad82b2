// A person's own question to the archive.

#include <chrono>

#include "tests/app/archive/postgres.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/program.hpp"

using Catch::Matchers::Contains;
using namespace trammel;

namespace {

/// Asks an empty archive as its visitor.
struct Asked {
  explicit Asked(tests::Postgres& server)
      : archive(server.new_archive()), uri(server.uri(archive, "visitor")) {}
  [[nodiscard]] tests::Finished operator()(const std::string& sql,
                                           const std::string& form = "--csv",
                                           const std::string& timeout_s = "30") const {
    return tests::run_program({"query", sql, "--archive", uri, "--timeout-s", timeout_s, form},
                              here.path());
  }
  std::string archive, uri;
  tests::TemporaryFolder here;
};

}  // namespace

TEST_CASE("a question to the archive can only read, and ends in time", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Asked ask(*server);
  CHECK(ask("v_job").exit_code == 0);
  CHECK(ask("SELECT trammel.queue('lsq', NULL, false, '{}')").exit_code == 8);
  for (const char* no_question : {"COMMIT", "SET TRANSACTION READ WRITE",
                                  "COPY trammel.work TO STDOUT", "SELECT 1; SELECT 2"}) {
    CHECK(ask(no_question).exit_code == 4);
  }
  const auto began = std::chrono::steady_clock::now();
  const auto late = ask("SELECT pg_sleep(20)", "--csv", "0.5");
  CHECK(late.exit_code == 8);
  CHECK_THAT(late.err, Contains("too long") && Contains("--timeout-s"));
  CHECK(std::chrono::steady_clock::now() - began < std::chrono::seconds(10));
  const auto long_value = ask("SELECT repeat('x', 17000000) AS words");
  CHECK(long_value.exit_code == 8);
  CHECK_THAT(long_value.err, Contains("words") && Contains("17000000 bytes"));
}

TEST_CASE("a wrong question names what can be asked, a role that may not its owner", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Asked ask(*server);
  for (const char* wrong : {"v_nonsense", "SELEC 1", "SELECT colour FROM v_job", "SELECT 1/0",
                            "SELECT 'x'::int", "DELETE FROM work WHERE id = 'x'"}) {
    CAPTURE(wrong);
    const auto answer = ask(wrong);
    CHECK(answer.exit_code == 4);
    CHECK_THAT(answer.err, Contains("v_accuracy, v_alarm, v_drift, v_job") && Contains("SQL"));
    CHECK_THAT(answer.err, !Contains("next:"));
  }
  const auto run = [&](std::vector<std::string> words, const std::string& role) {
    words.insert(words.end(), {"--archive", server->uri(ask.archive, role)});
    return tests::run_program(words, ask.here.path());
  };
  const auto where =
      run({"archive", "rerun", "--stage", "lsq", "--where", "colour = 3"}, "robot_a");
  CHECK(where.exit_code == 4);
  CHECK_THAT(where.err, Contains("--where") && Contains("colour") && Contains("campaign_head"));
  const auto refused = run({"archive", "rerun", "--stage", "lsq"}, "visitor");
  CHECK(refused.exit_code == 8);
  CHECK_THAT(refused.err, Contains("permission denied") && Contains("GRANT"));
  CHECK(run({"archive", "status"}, "stranger").exit_code == 8);
  const auto unknown = run({"archive", "status"}, "nobody_known");
  CHECK(unknown.exit_code == 7);
  CHECK_THAT(unknown.err, Contains("nobody_known") && Contains("pgpass") && !Contains("cable"));
}

TEST_CASE("numbers of the archive are printed as they are, however small or large", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Asked ask(*server);
  CHECK(ask("SELECT 5e-324::float8 AS least, 1e400::numeric AS beyond, 'NaN'::float8 AS none, "
            "9007199254740993 AS whole, true AS yes, NULL AS nothing")
            .out == "least,beyond,none,whole,yes,nothing\n5e-324,1" + std::string(400, '0') +
                        ",NaN,9007199254740993,1,\n");
}

// 300 MB in 400 MB of address space, of which the program's own libraries take half. The control:
// --json is one object, and can't be printed before it is whole.
TEST_CASE("an answer that is longer than the memory streams through", "[archive][release]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Asked ask(*server);
  const auto within = [&](const std::string& form) {
    return tests::run_command(
        {"bash", "-c",
         "set -o pipefail; ulimit -v 400000; '" + tests::build_folder() +
             "/trammel-archive' query --archive '" + ask.uri +
             "' \"SELECT repeat('x', 1000) FROM generate_series(1, 300000)\" " + form + " | wc -c"},
        ask.here.path());
  };
  const auto streamed = within("--csv");
  CAPTURE(streamed.err);
  CHECK(streamed.exit_code == 0);
  CHECK(streamed.out == "300300007\n");
  CHECK(within("--json").exit_code != 0);
}
