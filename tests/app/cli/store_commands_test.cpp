// The commands on the database, as a person gives them: words in, data on stdout, an exit code.
#include <unistd.h>

#include <cstdio>
#include <fstream>

#include "app/cli/cli.hpp"
#include "app/cli/commands.hpp"
#include "store/job.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

using namespace trammel;
using trammel::test::TempFolder;

namespace {

struct Answer {
  int code = 0;
  std::string out;
  [[nodiscard]] nlohmann::json json() const { return nlohmann::json::parse(out); }
};

// Runs the command line with stdout and stderr in files.
Answer run(const TempFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--db", folder.file("lab.db").string()});
  std::fflush(stdout);
  std::fflush(stderr);
  const int out = dup(STDOUT_FILENO);
  const int err = dup(STDERR_FILENO);
  const auto open = [&](const char* name, std::FILE* stream) {
    REQUIRE(std::freopen(folder.file(name).c_str(), "w", stream) != nullptr);
  };
  open("stdout.txt", stdout);
  open("stderr.txt", stderr);
  Answer answer{.code = cli::run_cli(words, cli::commands()), .out = {}};
  std::fflush(stdout);
  std::fflush(stderr);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  close(out);
  close(err);
  std::ifstream in(folder.file("stdout.txt"));
  answer.out.assign(std::istreambuf_iterator<char>(in), {});
  return answer;
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
  CHECK(run(folder, {"campaign", "list"}).code == 3);
  fill(folder);
  const auto list = run(folder, {"campaign", "list", "--json"});
  CHECK(list.code == 0);
  CHECK(list.json()["schema"] == "trammel/campaign-list/1");
  CHECK(list.json()["campaigns"][0]["name"] == "rail-test");
  CHECK(list.json()["campaigns"][0]["n_readings"] == 6);
  CHECK_THAT(run(folder, {"campaign", "list"}).out, Contains("rail-test  real"));
  CHECK(run(folder, {"campaign", "show", "nobody"}).code == 3);
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
  CHECK(run(folder, words).code == 0);
  CHECK(run(folder, words).code == 4);  // already
  CHECK(run(folder, {"reading", "exclude", "rail-test", "--seq", "99", "--reason", "x"}).code == 3);
  CHECK(run(folder, {"reading", "exclude", "rail-test", "--seq", "3", "--reason", " "}).code == 4);
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
  CHECK(run(folder, {"query", "DELETE FROM reading"}).code == 4);
  CHECK(run(folder, {"query", "SELEKT"}).code == 4);
  CHECK(run(folder, {"query", sql, "--csv", "--ndjson"}).code == 2);
  CHECK(run(folder, {"query",
                     "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
                     "SELECT count(*) FROM n",
                     "--timeout_s", "0.1"})
            .code == 8);
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

TEST_CASE("db verify says ok of a whole file, names the row of a changed one and exits with 5",
          "[cli]") {
  const TempFolder folder;
  fill(folder);
  CHECK(run(folder, {"db", "check"}).code == 0);
  CHECK(run(folder, {"db", "verify", "--json"}).json()["n_readings"] == 6);
  CHECK(run(folder, {"db", "backup", folder.file("copy.db").string()}).code == 0);
  CHECK(run(folder, {"db", "backup", folder.file("copy.db").string()}).code == 4);
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
  CHECK(answer.code == 5);
  CHECK_THAT(answer.out, Contains("seq 2"));
  CHECK(run(folder, {"db", "backup", folder.file("bad.db").string()}).code == 8);
}

TEST_CASE("db migrate takes a database of version 1 to this version", "[cli]") {
  const TempFolder folder;
  std::filesystem::copy_file(
      std::filesystem::path(tests::source_folder()) / "tests/store/versions/version_1.sqlite3",
      folder.file("lab.db"));
  CHECK(run(folder, {"campaign", "list"}).code == 0);  // read-only
  CHECK(run(folder, {"reading", "exclude", "rail-test", "--seq", "1", "--reason", "x"}).code == 8);
  const auto done = run(folder, {"db", "migrate", "--json"}).json();
  CHECK(done["from_version"] == 1);
  CHECK(run(folder, {"db", "verify"}).code == 0);
}
