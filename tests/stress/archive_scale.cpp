// What an archive of many campaigns answers, and how fast: app/archive/README.md has the figures.
// Hidden, since they take half an hour: trammel_tests "[archive-scale]".

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point began) {
  return std::chrono::duration<double>(Clock::now() - began).count();
}

/// Milliseconds of `what`, each time it is done, in order.
template <class What>
std::vector<double> times_ms(int n, What what) {
  std::vector<double> all;
  for (int k = 0; k < n; ++k) {
    const auto began = Clock::now();
    what();
    all.push_back(1e3 * seconds_since(began));
  }
  std::ranges::sort(all);
  return all;
}

double printed_median(const char* what, const std::vector<double>& sorted_ms) {
  const double median = sorted_ms[sorted_ms.size() / 2];
  std::printf("%-52s median %8.2f ms, longest %8.2f ms\n", what, median, sorted_ms.back());
  std::fflush(stdout);
  return median;
}

/// An archive that stations push to.
struct Fleet {
  explicit Fleet(tests::Postgres& of) : server(of), name(of.new_archive()) {}
  [[nodiscard]] archive::Link as(const std::string& role) const {
    return archive::Link({.uri = server.uri(name, role), .who = "tests"});
  }
  /// Seconds to push `n` campaigns of a new station, 20 readings each.
  double push(const std::string& station, int n) const {
    const test::TempFolder folder;
    {
      store::Connection db = store::open(folder.file("lab.db"), store::Access::create);
      tests::add_small_campaigns(db, "of " + station, n);
    }
    const auto began = Clock::now();
    tests::push_all(server.uri(name, "robot_a"), folder.file("lab.db"), station);
    return seconds_since(began);
  }
  tests::Postgres& server;
  std::string name;
};

/// A station with `n` campaigns that have no readings: what its first campaign was pushed as, under
/// other names. By the archive's own doors, with all of its checks.
void add_idle_campaigns(archive::Link& link, const std::string& station, int n) {
  link.run(
      "CREATE TEMP TABLE one AS SELECT bytes, n_rows, 10 + 45 + 9 + octet_length(c.name) AS rest "
      "FROM trammel.archive_row JOIN trammel.campaign AS c USING (campaign) "
      "WHERE table_name = 'campaign' LIMIT 1");
  constexpr int kAtOnce = 50'000;
  for (int first = 1; first <= n; first += kAtOnce) {
    const std::string numbers = "generate_series(" + std::to_string(first) + ", " +
                                std::to_string(std::min(n, first + kAtOnce - 1)) + ") AS n";
    const std::string uuid = "md5('idle ' || n)::uuid::text";
    link.ask("SELECT count((trammel.begin_push(" + uuid + ", '" + station + "')).campaign) FROM " +
             numbers);
    link.run(
        "INSERT INTO trammel.archive_row (campaign, table_name, row_key, row_ids, n_rows, bytes, "
        "sha256) SELECT campaign, 'campaign', key, ARRAY[n + 10], n_rows, bytes, sha256(bytes) "
        "FROM (SELECT campaign, n, n_rows, key, trammel.canonical(0::bigint) || key || "
        "trammel.canonical('idle ' || n) || substr(bytes, rest) AS bytes FROM (SELECT n, n_rows, "
        "bytes, rest, " +
        uuid + " AS campaign, trammel.canonical(" + uuid + ") AS key FROM one, " + numbers +
        ") AS named) AS made");
  }
}

constexpr const char* kClaim =
    "SELECT id FROM trammel.claim('eeeeeeee-eeee-4eee-8eee-eeeeeeeeeeee', 'm', 600)";

}  // namespace

TEST_CASE("an archive of 10^6 campaigns lists, claims and takes a push as an empty one",
          "[.][archive-scale]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Fleet fleet(*server);
  constexpr int kPushed = 200, kIdle = 1'000'000;
  const double empty_s = fleet.push(tests::kStationA, kPushed);
  {
    archive::Link station = fleet.as("robot_a");
    add_idle_campaigns(station, tests::kStationA, kIdle);
  }
  fleet.server.kill();  // nothing of it is in the server's memory
  fleet.server.start();
  fleet.as("postgres").run("ANALYZE");
  const double full_s = fleet.push(tests::kStationB, kPushed);
  std::printf("push of %d campaigns: %.2f s into an empty archive, %.2f s into this one\n", kPushed,
              empty_s, full_s);
  CHECK(full_s < 2 * empty_s);
  CHECK(fleet.as("robot_a").ask(tests::queue_of("lsq"))[0][0] ==
        std::to_string(2 * kPushed + kIdle));

  archive::Link reader = fleet.as("visitor");
  CHECK(
      printed_median(
          "list --newest 50", times_ms(50, [&] {
            reader.ask(
                "SELECT c.name, h.head FROM (SELECT * FROM trammel.campaign_head ORDER BY moved_at "
                "DESC LIMIT 50) AS h LEFT JOIN trammel.campaign AS c USING (campaign)");
          })) <= 20);
  std::vector<double> firsts;
  for (int k = 0; k < 50; ++k) {
    archive::Link worker = fleet.as("worker");
    firsts.push_back(times_ms(1, [&] { worker.ask(kClaim); })[0]);
  }
  std::ranges::sort(firsts);
  CHECK(printed_median("claim, the first of a connection", firsts) <= 20);
  archive::Link worker = fleet.as("worker");
  CHECK(printed_median("claim", times_ms(200, [&] { worker.ask(kClaim); })) <= 20);
  printed_median("status: what it counts", times_ms(3, [&] {
                   reader.ask("SELECT state, count(*) FROM trammel.work GROUP BY state");
                 }));
}

TEST_CASE("a claim costs the same after 20,000 works that an old state of the archive still sees",
          "[.][archive-scale]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Fleet fleet(*server);
  fleet.push(tests::kStationA, 1);
  fleet.as("owner").run(
      "INSERT INTO trammel.work (stage, force, campaign, station, parameters_json) SELECT 'lsq', "
      "false, campaign, station, '{\"n\":' || n || '}' FROM trammel.campaign_head, "
      "generate_series(1, 30000) AS n");
  archive::Link backup = fleet.as("visitor");
  const archive::Link::Transaction old_state(backup);
  backup.run("SET TRANSACTION ISOLATION LEVEL REPEATABLE READ");
  backup.ask("SELECT 1 FROM trammel.archive");
  archive::Link worker = fleet.as("worker");
  const auto done = [&](int n) {
    return times_ms(n, [&] {
      worker.ask(
          "SELECT trammel.finish(id, token, 'eeeeeeee-eeee-4eee-8eee-eeeeeeeeeeee', 'm', 'key', "
          "NULL, NULL, NULL, NULL, NULL) FROM "
          "trammel.claim('eeeeeeee-eeee-4eee-8eee-eeeeeeeeeeee', "
          "'m', 600)");
    });
  };
  const double begun = printed_median("claim and finish, the first 1,000", done(1000));
  done(20000);
  CHECK(printed_median("claim and finish, behind 21,000", done(1000)) < 2 * begun);
}

TEST_CASE("a rerun of 10,000 campaigns takes ten times that of 1,000", "[.][archive-scale]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Fleet fleet(*server);
  std::vector<double> per_campaign_ms;  // of the processor, the server's and ours
  std::string station = tests::kStationA;
  const auto processor_s = [&] {
    return fleet.server.processor_s() + static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  };
  for (const int n : {1000, 3000, 10000}) {
    ++station[0];
    const double push_s = fleet.push(station, n);
    fleet.as("robot_a").ask(tests::queue_of("lsq", "station = '" + station + "'"));
    const auto began = Clock::now();
    const double used_s = processor_s();
    const auto done = tests::work_at(fleet.server.uri(fleet.name, "worker"), tests::kWorker, 2);
    const double took_s = seconds_since(began);
    CHECK(done.computed == n);
    std::this_thread::sleep_for(std::chrono::seconds(1));  // until its connections have ended
    per_campaign_ms.push_back(1e3 * (processor_s() - used_s) / n);
    std::printf(
        "rerun of %5d by two at once: %.1f a second, %.1f ms of the processor each; pushed "
        "at %.0f a second\n",
        n, n / took_s, per_campaign_ms.back(), n / push_s);
    std::fflush(stdout);
  }
  CHECK(per_campaign_ms.back() < 1.2 * per_campaign_ms.front());
}
