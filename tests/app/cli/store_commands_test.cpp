// The commands on the database, as a person gives them: words in, data on stdout, an exit code.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "store/job.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/in_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using trammel::test::TempFolder;

namespace {

struct Answer : tests::Finished {
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
};

Answer run(const TempFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--db", folder.file("lab.db").string()});
  return {tests::run_here(words)};
}

void fill(const TempFolder& folder) {
  store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
  Campaign campaign = test::small_campaign();
  campaign.facts["operator"] = "=HYPERLINK(\"x\")\x1b[31m";
  store::import_campaign(db, campaign);
}

}  // namespace

TEST_CASE("campaign list and show name the campaigns, their kind and their parts", "[cli]") {
  const TempFolder folder;
  CHECK(run(folder, {"campaign", "list"}).exit_code == 3);
  fill(folder);
  const auto list = run(folder, {"campaign", "list", "--json"});
  CHECK(list.exit_code == 0);
  CHECK(list.json()["schema"] == "trammel/campaign-list/1");
  CHECK(list.json()["campaigns"][0]["name"] == "rail-test");
  CHECK(list.json()["campaigns"][0]["n_readings"] == 6);
  CHECK_THAT(run(folder, {"campaign", "list"}).out, Contains("rail-test  real"));
  CHECK(run(folder, {"campaign", "show", "nobody"}).exit_code == 3);
  const auto show = run(folder, {"campaign", "show", "rail-test", "--json"});
  CHECK(show.json()["sessions"][0]["name"] == "import");
  CHECK(show.json()["chain_head"].get<std::string>().size() == 64);
  const auto text = run(folder, {"campaign", "show", "rail-test"});
  CHECK_THAT(text.out, Contains("chain head") && !Contains("\x1b[31m"));
}

TEST_CASE("reading exclude adds a reason and removes nothing", "[cli]") {
  const TempFolder folder;
  fill(folder);
  const std::vector<std::string> words = {"reading", "exclude",  "rail-test", "--seq",
                                          "2",       "--reason", "bumped"};
  CHECK(run(folder, words).exit_code == 0);
  CHECK(run(folder, words).exit_code == 4);  // already
  CHECK(
      run(folder, {"reading", "exclude", "rail-test", "--seq", "99", "--reason", "x"}).exit_code ==
      3);
  CHECK(run(folder, {"reading", "exclude", "rail-test", "--seq", "3", "--reason", " "}).exit_code ==
        4);
  const auto show = run(folder, {"campaign", "show", "rail-test", "--json"}).json();
  CHECK(show["exclusions"][0]["reason"] == "bumped");
  CHECK(show["n_readings"] == 6);
}

TEST_CASE("query answers as text, CSV, JSON and NDJSON, and changes nothing", "[cli]") {
  const TempFolder folder;
  fill(folder);
  const std::string sql = "SELECT seq, x_mm, x_mm FROM reading WHERE seq <= 2 ORDER BY seq";
  CHECK(run(folder, {"query", sql}).out ==
        "seq   x_mm   x_mm\n  1   10.1   10.1\n  2  20.05  20.05\n");
  CHECK(run(folder, {"query", sql, "--csv"}).out == "seq,x_mm,x_mm\n1,10.1,10.1\n2,20.05,20.05\n");
  const auto json = run(folder, {"query", sql, "--json"}).json();
  CHECK(json["rows"][1]["x_mm_2"] == 20.05);
  CHECK(run(folder, {"query", sql, "--ndjson"}).out ==
        "{\"seq\":1,\"x_mm\":10.1,\"x_mm_2\":10.1}\n{\"seq\":2,\"x_mm\":20.05,\"x_mm_2\":20.05}\n");
  CHECK(run(folder, {"query", "campaign_fact", "--csv"}).out ==
        run(folder, {"query", "SELECT * FROM campaign_fact", "--csv"}).out);
  CHECK(run(folder, {"query", "DELETE FROM reading"}).exit_code == 4);
  CHECK(run(folder, {"query", "SELEKT"}).exit_code == 4);
  CHECK(run(folder, {"query", sql, "--csv", "--ndjson"}).exit_code == 2);
  CHECK(run(folder, {"query",
                     "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
                     "SELECT count(*) FROM n",
                     "--timeout-s", "0.1"})
            .exit_code == 8);
}

TEST_CASE("a question's time holds inside a single step of SQLite too", "[cli]") {
  const TempFolder folder;
  fill(folder);
  struct Question {
    const char* sql;
    const char* limit_s;
    const char* says;
  };
  for (const Question& question :
       {Question{"SELECT printf('%.120000000c', 'a') LIKE '%a%a%a%a%b'", "3", ""},  // NULL
        {"SELECT 'a' LIKE printf('%.20000c', '%a')", "3", "too complex"},
        {"SELECT instr(zeroblob(16000000), CAST(zeroblob(8000000) || x'01' AS BLOB))", "0.3",
         "too long"}}) {
    CAPTURE(question.sql);
    const auto begun = std::chrono::steady_clock::now();
    const auto answer = tests::run_program({"query", question.sql, "--timeout-s", question.limit_s,
                                            "--db", folder.file("lab.db").string()},
                                           folder.path());
    CHECK_THAT(answer.err, Contains(question.says));
    CHECK(answer.exit_code == (*question.says == '\0' ? 0 : 8));
    CHECK(std::chrono::steady_clock::now() - begun < std::chrono::seconds(10));
  }
}

TEST_CASE("text that a spreadsheet or a terminal would act on is made harmless in a query",
          "[cli]") {
  const TempFolder folder;
  fill(folder);
  const std::string sql = "SELECT value, -1.5 AS n FROM campaign_fact WHERE key = 'operator'";
  CHECK_THAT(run(folder, {"query", sql, "--csv"}).out,
             Contains("\"'=HYPERLINK") && Contains(",-1.5"));
  CHECK_THAT(run(folder, {"query", sql}).out, !Contains("\x1b"));
}

TEST_CASE("every table and view is exported by its name, and sqlite3 reads the file as it is",
          "[cli]") {
  const TempFolder folder;
  fill(folder);
  const auto names = run(folder, {"query",
                                  "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') "
                                  "AND name NOT LIKE 'sqlite_%'",
                                  "--json"})
                         .json();
  REQUIRE(names["rows"].size() == 22 + 6);
  for (const auto& row : names["rows"]) {
    const std::string name = row["name"];
    INFO(name);
    const Answer csv = run(folder, {"query", name, "--csv"});
    CHECK(csv.exit_code == 0);
    const auto n = run(folder, {"query", "SELECT count(*) AS n FROM " + name, "--json"}).json();
    const Answer lines = run(folder, {"query", name, "--ndjson"});
    CHECK(std::count(lines.out.begin(), lines.out.end(), '\n') ==
          std::max(n["rows"][0]["n"].get<int>(), 0));
    const std::string shell = "sqlite3 -readonly '" + folder.file("lab.db").string() +
                              "' 'SELECT count(*) FROM " + name + "' > " +
                              folder.file("sqlite3.txt").string();
    REQUIRE(std::system(shell.c_str()) == 0);
    std::ifstream in(folder.file("sqlite3.txt"));
    int seen = -1;
    in >> seen;
    CHECK(seen == n["rows"][0]["n"]);
  }
}

TEST_CASE("job diff, why and verify say what differs, what made it stale, and whether it repeats",
          "[cli]") {
  const TempFolder folder;
  {
    store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
    store::import_campaign(db, tests::paper_campaign());
  }
  REQUIRE(run(folder, {"calibrate", "idw", "paper"}).exit_code == 0);
  CHECK_THAT(run(folder, {"job", "show", "1"}).out, Contains("paper (SIMULATED)"));
  CHECK(run(folder, {"job", "show", "1", "--json"}).json()["kind"] == "simulated");
  CHECK_THAT(run(folder, {"job", "why", "1"}).out, Contains("nothing of it has changed"));
  CHECK(run(folder, {"job", "verify", "1"}).exit_code == 0);
  REQUIRE(
      run(folder, {"reading", "exclude", "paper", "--seq", "7", "--reason", "bumped"}).exit_code ==
      0);
  CHECK_THAT(run(folder, {"job", "why", "1"}).out,
             Contains("changed since: exclusions: seq 7 is left out now: bumped") &&
                 Contains("readings: 127 now, 128 then"));
  const Answer verified = run(folder, {"job", "verify", "1"});
  CHECK(verified.exit_code == 0);
  CHECK_THAT(verified.out, Contains("bit for bit; there are other inputs now"));
  REQUIRE(run(folder, {"job", "rerun", "1"}).exit_code == 0);
  CHECK_THAT(run(folder, {"job", "show", "2"}).out, Contains("left out: seq 7: bumped"));
  const Answer text = run(folder, {"job", "diff", "1", "2"});
  CHECK_THAT(text.out, Contains("inputs that differ: exclusions, readings") &&
                           Contains("only job 2 leaves out seq 7: bumped") &&
                           Contains("1 reading only in job 1") &&
                           !Contains("attitude_deg (held-out).before"));
  const auto diff = run(folder, {"job", "diff", "1", "2", "--json"}).json();
  CHECK(diff["parameters"].empty());
  CHECK(diff["settings"].empty());
  CHECK(diff["readings_only_in"]["a"].dump() == "[7]");
  CHECK(diff["common_readings"] == 127);
  CHECK(diff["points"].size() < 127);  // IDW is local, and exact where it was fitted
  REQUIRE_FALSE(diff["points"].empty());
  const auto same = run(folder, {"job", "diff", "2", "2", "--json"}).json();
  CHECK(same["same_result"] == true);
  CHECK((same["points"].empty() && same["statistics"].empty() && same["changed"].empty()));
}

TEST_CASE("db verify says ok of a whole file, names the row of a changed one and exits with 5",
          "[cli]") {
  const TempFolder folder;
  fill(folder);
  CHECK(run(folder, {"db", "check"}).exit_code == 0);
  CHECK(run(folder, {"db", "verify", "--json"}).json()["n_readings"] == 6);
  CHECK(run(folder, {"db", "backup", "--out", folder.file("copy.db").string()}).exit_code == 0);
  CHECK(run(folder, {"db", "backup", "--out", folder.file("copy.db").string()}).exit_code == 4);
  CHECK_THAT(run(folder, {"db", "migrate"}).out, Contains("nothing to do"));
  {
    store::Connection other(folder.file("lab.db"), store::Access::write);
    std::string guard;
    {
      store::Statement row(other, "SELECT sql FROM sqlite_schema WHERE name = 'reading_update'");
      REQUIRE(row.step());
      guard = row.text(0);
    }
    other.execute("DROP TRIGGER reading_update; UPDATE reading SET y_mm = 1 WHERE seq = 2");
    other.execute(guard);
  }
  const Answer answer = run(folder, {"db", "verify"});
  CHECK(answer.exit_code == 5);
  CHECK_THAT(answer.out, Contains("seq 2"));
  CHECK(run(folder, {"db", "backup", "--out", folder.file("bad.db").string()}).exit_code == 8);
}

TEST_CASE("db migrate takes a database of version 1 to this version", "[cli]") {
  const TempFolder folder;
  std::filesystem::copy_file(
      std::filesystem::path(tests::source_folder()) / "tests/store/versions/version_1.sqlite3",
      folder.file("lab.db"));
  CHECK(run(folder, {"campaign", "list"}).exit_code == 0);  // read-only
  CHECK(run(folder, {"reading", "exclude", "rail-test", "--seq", "1", "--reason", "x"}).exit_code ==
        8);
  const auto done = run(folder, {"db", "migrate", "--json"}).json();
  CHECK(done["from_version"] == 1);
  CHECK(std::filesystem::exists(done["copy"].get<std::string>()));
  CHECK(run(folder, {"db", "verify"}).exit_code == 0);
}
