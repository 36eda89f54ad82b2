// Many at once, and a server that dies.

#include <atomic>
#include <thread>

#include "app/archive/pull.hpp"
#include "store/open.hpp"
#include "tests/app/archive/postgres.hpp"
#include "tests/app/archive/stations.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using tests::asked;

namespace {

std::string uuid_of(char digit) {
  std::string uuid = tests::kStationA;
  std::fill_n(uuid.begin(), 8, digit);
  return uuid;
}

std::unique_ptr<archive::Link> link_to(const std::string& uri) {
  return std::make_unique<archive::Link>(archive::LinkOptions{.uri = uri, .who = "tests"});
}

}  // namespace

TEST_CASE("5 stations and 3 workers at once: 0 rows lost, 0 doubled, 0 altered", "[archive]") {
  tests::Postgres* server = tests::Postgres::shared();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const std::string station = server->uri(archive, "robot_a"),
                    worker = server->uri(archive, "worker");
  constexpr int kStations = 5, kCampaigns = 4;
  const test::TempFolder folder;
  const auto file = [&](int k) { return folder.file("station" + std::to_string(k) + ".db"); };
  for (int k = 0; k < kStations; ++k) {
    store::Connection db = store::open(file(k), store::Access::create);
    tests::add_full_campaign(db, "rail");
    tests::add_small_campaigns(db, "c", kCampaigns);
  }
  std::atomic<int> pushing = kStations;
  std::vector<std::string> broken(kStations + 3);
  {
    std::vector<std::jthread> all;
    for (int k = 0; k < kStations; ++k) {
      all.emplace_back([&, k] {
        try {
          tests::push_all(station, file(k), uuid_of(static_cast<char>('1' + k)));
          link_to(station)->ask(
              tests::queue_of("lsq", "station = '" + uuid_of(static_cast<char>('1' + k)) + "'"));
        } catch (const Error& error) {
          broken[static_cast<std::size_t>(k)] = describe(error.text());
        }
        --pushing;
      });
    }
    for (int k = 0; k < 3; ++k) {
      all.emplace_back([&, k] {
        try {
          while (pushing > 0) tests::work_at(worker, uuid_of(static_cast<char>('a' + k)));
          tests::work_at(worker, uuid_of(static_cast<char>('a' + k)));
        } catch (const Error& error) {
          broken[static_cast<std::size_t>(kStations + k)] = describe(error.text());
        }
      });
    }
  }
  for (const std::string& text : broken) CHECK(text == "");
  for (int k = 0; k < kStations; ++k) {
    const auto again = folder.file("again" + std::to_string(k) + ".db");
    archive::pull(*link_to(station), {.station = uuid_of(static_cast<char>('1' + k))}, again);
    CHECK(tests::content(again) == tests::content(file(k)));
  }
  // "rail" can't be fitted: it has fewer points than unknowns.
  CHECK(asked(station, "SELECT count(*) FROM trammel.work WHERE state = 'done'") ==
        std::to_string(kStations * kCampaigns));
  CHECK(asked(station,
              "SELECT count(*) FROM trammel.work WHERE state = 'failed' AND error NOT "
              "LIKE '%scratch.db%'") == std::to_string(kStations));
  CHECK(asked(station, "SELECT count(*) || ' ' || count(DISTINCT campaign) FROM trammel.result") ==
        std::to_string(kStations * kCampaigns) + " " + std::to_string(kStations * kCampaigns));
  CHECK(asked(station, "SELECT count(*) FROM trammel.findings()") == "0");
}

TEST_CASE("a server that is killed has every campaign it acknowledged, and no other", "[archive]") {
  const auto server = tests::Postgres::durable();
  if (server == nullptr) return;
  const std::string archive = server->new_archive();
  const std::string uri = server->uri(archive, "robot_a");
  const test::TempFolder folder;
  const auto file = folder.file("lab.db");
  constexpr int kCampaigns = 40;
  {
    store::Connection db = store::open(file, store::Access::create);
    tests::add_small_campaigns(db, "c", kCampaigns);
  }
  int n_acknowledged = 0, n_cut = 0;
  for (const int after : {3, 7, 12}) {  // campaigns of each push, before the server dies
    int reached = 0;
    try {
      store::Connection db = store::open_as_it_is(file);
      const auto link = link_to(uri);
      archive::push(*link, db, tests::kStationA, archive::campaigns_of(db),
                    [&](int done, const archive::Pushed&) {
                      reached = done;
                      if (done == n_acknowledged + after) server->kill();
                    });
    } catch (const DeviceError&) {
      ++n_cut;
    }
    n_acknowledged = reached;
    server->start();
    const int stored = std::stoi(asked(uri, "SELECT count(*) FROM trammel.campaign"));
    CHECK(stored >= n_acknowledged);
    CHECK(stored <= n_acknowledged + 1);  // committed, and the answer was lost
    CHECK(asked(uri, "SELECT count(*) FROM trammel.findings()") == "0");
  }
  CHECK(n_cut == 3);
  tests::push_all(uri, file, tests::kStationA);

  // A worker sits it out.
  link_to(uri)->ask(tests::queue_of("lsq"));
  archive::WorkDone done;
  {
    std::jthread worker(
        [&] { done = tests::work_at(server->uri(archive, "worker"), tests::kWorker, 1, 2); });
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    server->kill();
    server->start();
  }
  CHECK(asked(uri, "SELECT count(*) FROM trammel.work WHERE state = 'done'") ==
        std::to_string(kCampaigns));
  CHECK(asked(uri, "SELECT count(*) || ' ' || count(DISTINCT campaign) FROM trammel.result") ==
        std::to_string(kCampaigns) + " " + std::to_string(kCampaigns));
  CHECK(asked(uri, "SELECT count(*) FROM trammel.findings()") == "0");
  archive::pull(*link_to(uri), {.station = tests::kStationA}, folder.file("again.db"));
  CHECK(tests::content(folder.file("again.db")) == tests::content(file));
}
