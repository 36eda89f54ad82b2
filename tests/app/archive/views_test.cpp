// The archive answers as the station's own file does.

#include <algorithm>

#include "app/files/numbers.hpp"
#include "app/job/run.hpp"
#include "store/open.hpp"
#include "store/query.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using tests::read_text;
using tests::run_program;

TEST_CASE("the questions of examples/queries have the same answers in the archive", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::filesystem::path queries =
      std::filesystem::path(tests::source_folder()) / "examples/queries";
  const std::string archive = server->new_archive();
  const tests::TemporaryFolder lab;
  std::filesystem::copy_file(queries / "laboratory.sqlite3", lab.path() / "lab.db");
  REQUIRE(run_program({"db", "migrate", "--db", "lab.db"}, lab.path()).exit_code == 0);
  tests::push_all(server->uri(archive, "robot_a"), lab.path() / "lab.db", tests::kStationA);
  int n_same = 0;
  for (const auto& entry : std::filesystem::directory_iterator(queries)) {
    if (entry.path().extension() != ".sql") continue;
    const std::string sql = read_text(entry.path());
    CAPTURE(entry.path().stem());
    const auto answer = run_program(
        {"query", "--archive", server->uri(archive, "visitor"), sql, "--csv"}, lab.path());
    CAPTURE(answer.err);
    CHECK(answer.out == read_text(queries / (entry.path().stem().string() + ".csv")));
    ++n_same;
  }
  CHECK(n_same == 10);
}

// Row by row and column by column: numbers to the last bit but where sums are taken in another
// order. Of a campaign with every kind of row.
TEST_CASE("the views have the columns and rows of a station's, and its station", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_full_campaign(db, "rail");
    tests::add_full_campaign(db, "other rail");
    Campaign visits = tests::paper_campaign("visits");
    for (std::size_t k = 7; k < 21; ++k) {  // seven of the points again, twice
      Reading again = visits.readings[k % 7];
      again.seq = visits.readings[k].seq;
      again.measured->x_mm += 1e-3 * static_cast<double>(k);
      visits.readings[k] = again;
    }
    store::import_campaign(db, visits);
    job::run(db, {.campaign = "visits", .stage = "lsq"});
  }
  tests::push_all(server->uri(archive, "robot_a"), file, tests::kStationA);
  for (const std::string view :
       {"v_accuracy", "v_point_error", "v_job", "v_drift", "v_point_status", "model"}) {
    CAPTURE(view);
    std::vector<std::string> columns;
    std::vector<std::string> own;
    {
      store::Connection db = store::open(file, store::Access::read_only);
      // The file's own view. Open attempts are not sent.
      const std::string sent = view == "v_point_status" ? " WHERE status <> 'open'" : "";
      store::Query rows(db, "SELECT * FROM " + view + sent, std::chrono::seconds(10));
      columns = rows.columns();
      while (const auto row = rows.next()) {
        std::string line;
        for (const store::Cell& cell : *row) {
          const auto* text = std::get_if<std::string>(&cell);
          const auto* integer = std::get_if<std::int64_t>(&cell);
          const auto* real = std::get_if<double>(&cell);
          line += "|" + (text      ? *text
                         : integer ? std::to_string(*integer)
                         : real    ? number_text(*real)
                                   : "");
        }
        own.push_back(line);
      }
    }
    std::string list;
    for (const std::string& column : columns) list += (list.empty() ? "" : ", ") + column;
    archive::Link link({.uri = server->uri(archive, "visitor"), .who = "tests"});
    const std::string sent = view == "v_point_status" ? " WHERE status <> 'planned'" : "";
    std::vector<std::string> theirs;
    for (const auto& row : link.ask("SELECT " + list + ", station FROM trammel." + view + sent)) {
      CHECK(row.back() == tests::kStationA);
      std::string line;
      for (std::size_t k = 0; k + 1 < row.size(); ++k) line += "|" + row[k].value_or("");
      theirs.push_back(line);
    }
    CHECK(!own.empty());
    REQUIRE(own.size() == theirs.size());
    std::ranges::sort(own);
    std::ranges::sort(theirs);
    for (std::size_t k = 0; k < own.size(); ++k) {
      CAPTURE(own[k], theirs[k]);
      std::size_t a = 0, b = 0;
      while (a < own[k].size() && b < theirs[k].size()) {
        const auto take = [](const std::string& line, std::size_t& at) {
          const std::size_t end = std::min(line.find('|', at + 1), line.size());
          const std::string cell = line.substr(at + 1, end - at - 1);
          at = end;
          return cell;
        };
        const std::string left = take(own[k], a), right = take(theirs[k], b);
        if (left == right) continue;
        CHECK(std::stod(left) == Approx(std::stod(right)).epsilon(1e-12).margin(1e-300));
      }
    }
  }
}
