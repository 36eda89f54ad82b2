// The queue: each work is done once, whatever becomes of its worker.

#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "app/archive/pull.hpp"
#include "app/job/diff.hpp"
#include "app/job/run.hpp"
#include "store/canonical.hpp"
#include "store/session.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"

using Catch::Matchers::Contains;
using namespace trammel;
using tests::asked;
using tests::kStationA;
using tests::kWorker;

namespace {

/// An archive with a station's campaigns.
struct Queued {
  explicit Queued(tests::Postgres& of, int n) : server(of), name(of.new_archive()) {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_small_campaigns(db, "c", n);
    tests::push_all(as("robot_a"), file, kStationA);
  }
  [[nodiscard]] std::string as(const std::string& role) const { return server.uri(name, role); }
  std::string ask(const std::string& role, const std::string& sql) const {
    return asked(as(role), sql);
  }
  int queue(const std::string& stage = "lsq", bool force = false) const {
    return std::stoi(ask("robot_a", tests::queue_of(stage, "true", force)));
  }
  /// "ID TOKEN" of a claim that a worker never finishes.
  [[nodiscard]] std::string claim(double lease_s) const {
    return ask("worker", "SELECT id || ', ''' || token || '''' FROM trammel.claim('" + kWorker +
                             "', 'stopped', " + std::to_string(lease_s) + ")");
  }
  /// What `finish` says of it.
  [[nodiscard]] std::string finish(const std::string& claimed) const {
    return ask("worker", "SELECT trammel.finish(" + claimed + ", '" + kWorker +
                             "', 'stopped', 'key', NULL, NULL, NULL, NULL, NULL)");
  }
  /// The function with a text of its own replaced: what it would do without.
  void mutate(const std::string& function, const std::string& from, const std::string& to) const {
    archive::Link link({.uri = as("owner"), .who = "tests"});
    std::string text =
        link.ask("SELECT pg_get_functiondef('trammel." + function + "'::regproc)").at(0)[0].value();
    REQUIRE(text.find(from) != std::string::npos);
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
      text.replace(at, from.size(), to);
    }
    link.run(text);
  }
  tests::Postgres& server;
  std::string name;
  test::TempFolder folder;
  std::filesystem::path file = folder.file("lab.db");
};

void wait_s(double s) { std::this_thread::sleep_for(std::chrono::duration<double>(s)); }

}  // namespace

TEST_CASE("workers compute the jobs that the station would, bit for bit, and know them afterwards",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 5);
  CHECK(archive.queue() == 5);
  CHECK(archive.queue() == 0);  // it is queued already
  const auto done = tests::work_at(archive.as("worker"), kWorker, 2);
  CHECK(done.computed == 5);
  CHECK(done.failed + done.known + done.late == 0);
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.v_job WHERE station = '" + kWorker +
                                   "' AND stage = 'lsq' AND job_id IS NULL") == "5");
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.v_accuracy WHERE station = '" +
                                   kWorker + "'") != "0");
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.findings()") == "0");

  // The station computes them, too; its keys and outcomes are the workers'.
  const auto pulled = archive.folder.file("with.db");
  archive::Link link({.uri = archive.as("visitor"), .who = "tests"});
  archive::pull(link, {.station = kStationA, .campaign = {}, .with_results = true}, pulled);
  store::Connection own = store::open(archive.file, store::Access::write);
  store::Connection theirs = store::open(pulled, store::Access::read_only);
  CHECK(store::list_jobs(theirs).size() == 5);
  for (const store::JobRow& row : store::list_jobs(theirs)) {
    const auto mine = job::run(own, {.campaign = row.campaign, .stage = "lsq"});
    CHECK(mine.job.data.key.key == row.key);
    CHECK(job::same_outcome(mine.job.data, store::get_job(theirs, row.id).data));
  }
  // Now they are known: to the next worker, and to a pull once the station has pushed its own.
  CHECK(archive.queue() == 5);
  CHECK(tests::work_at(archive.as("worker"), kWorker).known == 5);
  tests::push_all(archive.as("robot_a"), archive.file, kStationA);
  const auto again = archive.folder.file("again.db");
  archive::pull(link, {.station = kStationA, .campaign = {}, .with_results = true}, again);
  CHECK(tests::content(again) == tests::content(archive.file));
}

TEST_CASE("a campaign comes with the one whose job it is built on, and with no other",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 3);
  {
    store::Connection db = store::open(archive.file, store::Access::write);
    const auto found = job::run(db, {.campaign = "c 2", .stage = "lsq"});
    store::create_session(db, {.campaign_id = store::require_campaign_id(db, "c 1"),
                               .name = "compensated",
                               .compensation_job = found.job.id,
                               .points = test::line_plan(5)});
  }
  tests::push_all(archive.as("robot_a"), archive.file, kStationA);
  const std::string uuid =
      archive.ask("visitor", "SELECT campaign FROM trammel.campaign WHERE name = 'c 1'");
  archive::Link link({.uri = archive.as("visitor"), .who = "tests"});
  const auto to = archive.folder.file("one.db");
  archive::pull(link, {.station = kStationA, .campaign = uuid}, to);
  store::Connection one = store::open(to, store::Access::read_only);
  std::vector<std::string> names;
  for (const auto& row : store::list_campaigns(one)) names.push_back(row.name);
  std::ranges::sort(names);
  CHECK(names == std::vector<std::string>{"c 1", "c 2"});
}

TEST_CASE("a lost worker's work is taken over, and what it brings too late is dropped",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 2);
  archive.queue();
  const auto let_the_first_lease_end = [&archive] {
    archive::Link(archive::LinkOptions{.uri = archive.as("owner"), .who = "tests"})
        .run("UPDATE trammel.work SET lease_until = now() - interval '1 s' WHERE id = 1");
  };
  const std::string lost = archive.claim(600);
  CHECK(archive.claim(600) != lost);
  CHECK(archive.claim(600).empty());  // both are held
  let_the_first_lease_end();
  CHECK(archive.ask("worker", "SELECT trammel.heartbeat(" + lost + ", 600)") == "t");
  CHECK(archive.claim(600).empty());  // it lives after all
  let_the_first_lease_end();
  const std::string taken = archive.claim(600);
  CHECK(taken.substr(0, taken.find(',')) == lost.substr(0, lost.find(',')));
  CHECK(archive.ask("worker", "SELECT trammel.heartbeat(" + lost + ", 30)") == "f");
  CHECK(archive.finish(lost) == "f");
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.work WHERE state = 'done'") == "0");
  CHECK(archive.finish(taken) == "t");
  CHECK(archive.finish(taken) == "f");  // once
}

TEST_CASE("work behind the furthest that was claimed is not forgotten", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 4);
  REQUIRE(archive.queue() == 4);
  const auto id_of = [](const std::string& claimed) {
    return claimed.substr(0, claimed.find(','));
  };
  const std::string first = archive.claim(600);
  CHECK(id_of(first) == "1");
  {
    // Another worker's claim, which its server forgets, while the next one goes further.
    archive::Link forgotten({.uri = archive.as("worker"), .who = "tests"});
    const archive::Link::Transaction undone(forgotten);
    CHECK(forgotten.ask("SELECT id FROM trammel.claim('" + kWorker + "', 'm', 60)")[0][0] == "2");
    CHECK(id_of(archive.claim(600)) == "3");
  }
  CHECK(id_of(archive.claim(600)) == "4");
  CHECK(id_of(archive.claim(600)) == "2");
  CHECK(archive.claim(600).empty());
  CHECK(archive.ask("worker", "SELECT trammel.give_back(" + first + ", '')") == "t");
  CHECK(id_of(archive.claim(600)) == "1");
  archive::Link(archive::LinkOptions{.uri = archive.as("owner"), .who = "tests"})
      .run("UPDATE trammel.work SET lease_until = now() - interval '1 h' WHERE id = 3");
  CHECK(id_of(archive.claim(600)) == "3");
  CHECK(archive.claim(600).empty());
}

// The control: without the token in `finish`, the lost worker ends what another one is computing.
TEST_CASE("a finish without the token is found to end another worker's work", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 1);
  archive.queue();
  archive.mutate("finish", "held.token = by_token", "true");
  const std::string lost = archive.claim(0.1);
  wait_s(0.2);
  const std::string taken = archive.claim(30);
  REQUIRE(!taken.empty());
  CHECK(archive.finish(lost) == "t");
  CHECK(archive.finish(taken) == "f");
}

TEST_CASE("four workers at once claim each work once; without SKIP LOCKED they do not",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  constexpr int kWorks = 300;
  const auto claimed_twice = [&](const Queued& archive) {
    std::vector<std::multiset<std::string>> each(4);
    {
      std::vector<std::jthread> workers;
      for (auto& claimed : each) {
        workers.emplace_back([&archive, &claimed] {
          archive::Link link({.uri = archive.as("worker"), .who = "tests"});
          while (true) {
            const auto row = link.ask("SELECT id FROM trammel.claim('" + kWorker + "', 'm', 60)");
            if (row.empty() || !row[0][0]) return;
            claimed.insert(row[0][0].value());
          }
        });
      }
    }
    std::multiset<std::string> all;
    for (const auto& claimed : each) all.insert(claimed.begin(), claimed.end());
    const std::set<std::string> once(all.begin(), all.end());
    CHECK(once.size() == kWorks);
    return all.size() - once.size();
  };
  const auto filled = [&](const Queued& archive) {
    archive::Link(archive::LinkOptions{.uri = archive.as("owner"), .who = "tests"})
        .run(
            "INSERT INTO trammel.work (stage, force, campaign, station, parameters_json) SELECT "
            "'lsq', "
            "false, campaign, station, '{\"n\":' || n || '}' FROM trammel.campaign_head, "
            "generate_series(1, " +
            std::to_string(kWorks) + ") AS n");
  };
  const Queued archive(*server, 1);
  filled(archive);
  CHECK(claimed_twice(archive) == 0);
  const Queued control(*server, 1);
  filled(control);
  control.mutate("claim", "FOR UPDATE SKIP LOCKED", "");
  CHECK(claimed_twice(control) > 0);
}

TEST_CASE("another outcome under the same key and CPU level is an alarm with both machines",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 1);
  // Forced, so that the second one computes it as well.
  CHECK(archive.queue("lsq", true) == 1);
  CHECK(tests::work_at(archive.as("worker"), kWorker).computed == 1);
  CHECK(archive.queue("lsq", true) == 1);
  CHECK(tests::work_at(archive.as("worker"), kWorker).computed == 1);
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.result") == "1");  // the same: welcome
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.v_alarm") == "0");
  // A machine that computes otherwise: the same job row, another outcome; its lease is over.
  CHECK(archive.queue("lsq", true) == 1);
  const std::string lost = archive.claim(0.1);
  wait_s(0.2);
  REQUIRE(tests::work_at(archive.as("worker"), kWorker).computed == 1);
  CHECK(archive.ask("worker", "SELECT trammel.finish(" + lost + ", '" + kWorker +
                                  "', 'broken', job_key, sha256('other'), row_key, n_rows, bytes, "
                                  "sha256) FROM trammel.result") == "f");
  CHECK(archive.ask("visitor", "SELECT machine || ', ' || other_machine FROM trammel.v_alarm") ==
        "machine of e, broken");
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.findings()") == "0");
  const auto status = tests::run_program(
      {"archive", "status", "--json", "--archive", archive.as("visitor")}, archive.folder.path());
  CHECK(status.exit_code == 5);
  const auto answer = nlohmann::json::parse(status.out);
  CHECK(tests::schema_errors(answer, "archive-status.schema.json") == "");
  CHECK(answer["alarms"][0]["other_machine"] == "broken");
  // What a worker brings is looked through: another work's job, bytes that are not the digest's.
  CHECK_THROWS_AS(archive.ask("worker", "SELECT trammel.finish(" + lost + ", '" + kWorker +
                                            "', 'm', 'key', outcome, row_key, n_rows, bytes, "
                                            "sha256) FROM trammel.result"),
                  StoreError);
  CHECK_THROWS_AS(archive.ask("worker", "SELECT trammel.finish(" + lost + ", '" + kWorker +
                                            "', 'm', job_key, sha256('third'), row_key, n_rows, "
                                            "bytes, sha256('')) FROM trammel.result LIMIT 1"),
                  StoreError);
}

TEST_CASE("what fails three times is left with its reason and stops nothing", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 3);
  archive.ask("robot_a", tests::queue_of("lsq", "name = 'c 1'", false, R"('{"no_such":1}')"));
  archive.queue();
  const auto done = tests::work_at(archive.as("worker"), kWorker, 2);
  CHECK(done.computed == 3);
  CHECK(done.failed == 3);
  CHECK_THAT(archive.ask("visitor",
                         "SELECT attempts || error FROM trammel.work WHERE state = "
                         "'failed'"),
             Contains("3") && Contains("no_such"));
  // And what takes its worker down with it, each time.
  archive.queue("idw");
  for (int k = 0; k < 3 * 3; ++k) {
    CHECK(!archive.claim(0.01).empty());
    wait_s(0.02);
  }
  CHECK(archive.claim(1).empty());
  CHECK(archive.ask("visitor",
                    "SELECT count(*) FROM trammel.work WHERE error LIKE '%was lost%' "
                    "AND stage = 'idw' AND state = 'failed'") == "3");
}

TEST_CASE("work that a worker was killed over is done by the next one, 0 lost, 0 doubled",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 8);
  CHECK(archive.queue() == 8);
  const std::string db = archive.folder.file("worker.db");
  REQUIRE(tests::run_program({"archive", "init", archive.as("worker"), "--db", db},
                             archive.folder.path())
              .exit_code == 0);
  const auto nobody =
      tests::run_program({"archive", "rerun", "--stage", "idw", "--campaign", "nobody", "--db", db},
                         archive.folder.path());
  CHECK(nobody.exit_code == 3);
  CHECK_THAT(nobody.err, Catch::Contains("no such campaign (--campaign): got nobody"));
  bool killed = false;
  for (const int after_ms : {30, 60, 90, 120}) {
    killed |= tests::run_program({"archive", "work", "--lease-s", "1", "--db", db},
                                 archive.folder.path(), after_ms)
                  .exit_code == -1;
  }
  CHECK(killed);
  const auto rest = tests::run_program(
      {"archive", "work", "--until-empty", "--lease-s", "1", "--json", "--db", db},
      archive.folder.path());
  CAPTURE(rest.err);
  CHECK(rest.exit_code == 0);
  CHECK(tests::schema_errors(nlohmann::json::parse(rest.out), "archive-work.schema.json") == "");
  CHECK(archive.ask("visitor",
                    "SELECT count(*) FILTER (WHERE state = 'done') || ' ' || count(*) "
                    "FROM trammel.work") == "8 8");
  CHECK(archive.ask("visitor",
                    "SELECT count(*) || ' ' || count(DISTINCT campaign) FROM "
                    "trammel.result") == "8 8");
  CHECK(archive.ask("visitor", "SELECT count(*) FROM trammel.findings()") == "0");
}

// Three works in 4 s of computing (two of them side by side), in nine minutes.
TEST_CASE("the rate is of the time in which somebody computed, and nobody has no time left",
          "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const Queued archive(*server, 5);
  CHECK(archive.queue() == 5);
  const auto status = [&](const std::string& form) {
    return tests::run_program({"archive", "status", "--archive", archive.as("visitor"), form},
                              archive.folder.path())
        .out;
  };
  CHECK_THAT(status("--quiet"), Contains("5 waiting") && Contains("nobody computes"));
  for (int k = 0; k < 3; ++k) CHECK(archive.finish(archive.claim(60)) == "t");
  archive.ask("owner",
              "UPDATE trammel.work SET claimed_at = now() - at, finished_at = now() - at + took "
              "FROM (VALUES (1, interval '540 s', interval '2 s'), (2, '539 s', '2 s'), "
              "(3, '10 s', '1 s')) AS t (nth, at, took) WHERE nth = id RETURNING 1");
  auto work = nlohmann::json::parse(status("--json"))["work"];
  CHECK(work["rate_per_s"].get<double>() == Approx(0.75));
  CHECK(work["time_left_s"].is_null());
  CHECK_THAT(status("--quiet"),
             Contains("2 waiting") && Contains("0.75 a second") && Contains("nobody computes"));
  // One is being computed, the other lost: two are open, and somebody works.
  CHECK(archive.claim(60) != "");
  CHECK(archive.claim(0.1) != "");
  wait_s(0.2);
  const auto answer = nlohmann::json::parse(status("--json"));
  CHECK(tests::schema_errors(answer, "archive-status.schema.json") == "");
  work = answer["work"];
  CHECK((work["waiting"] == 0 && work["claimed"] == 1 && work["lost"] == 1 && work["done"] == 3));
  const double left_s = work["time_left_s"].get<double>();
  CHECK((left_s > 2 / 0.75 && left_s < 2 / 0.3));
  const auto& worker = answer["workers"][0];
  CHECK((worker["n_claimed"] == 1 && worker["n_lost"] == 1 && worker["n_done"] == 3));
  CHECK_THAT(status("--quiet"),
             !Contains("nobody") && Contains("1 lost by their workers") && Contains("left"));
}
