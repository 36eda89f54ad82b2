#include "tests/app/archive/stations.hpp"

#include <algorithm>
#include <cmath>

#include "store/campaign.hpp"
#include "store/canonical.hpp"
#include "store/job.hpp"
#include "store/model.hpp"
#include "store/open.hpp"
#include "store/session.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/store/fixtures.hpp"

namespace trammel::tests {

namespace {

using store::Connection;
using store::Id;

Id job_of(Connection& db, Id campaign, char digit, std::vector<Id> parents,
          const std::string& result) {
  store::NewJob job{.campaign_id = campaign,
                    .key = {std::string(64, digit), {{"readings", std::string(64, '1')}}},
                    .stage = "lsq",
                    .parameters_json = R"({"a":[1],"b":0.1})",
                    .result_json = result,
                    .n_readings = 5,
                    .parents = std::move(parents),
                    .duration_s = 0.1};
  const store::LoadedCampaign loaded = store::load_campaign(db, campaign);
  job.sessions = loaded.sessions;
  for (const store::Exclusion& exclusion : loaded.exclusions)
    job.exclusions.push_back(exclusion.id);
  job.statistics = {{.set = "identify",
                     .metric = "position_mm",
                     .in_sample = true,
                     .before = store::Summary{0.2, 0.6, 0.01, 0.5, 80},
                     .after = store::Summary{1e-320, 5e-324, 0, 2.2250738585072014e-308, 80}}};
  return store::add_job(db, job);
}

void walk(Connection& db, Id campaign, const std::string& name, std::optional<Id> compensation) {
  const Id session = store::create_session(db, {.campaign_id = campaign,
                                                .name = name,
                                                .compensation_job = compensation,
                                                .points = test::line_plan(5)});
  store::add_event(db, session, "started", "with ümlauts and a 'quote'");
  const auto epoch = store::open_epoch(db, session, store::SetUp::fresh, "start");
  for (const store::Point& point : store::open_points(db, session)) {
    if (point.seq == 2) {
      store::fail_attempt(db, store::begin_attempt(db, session, 2, epoch.id), "beam lost");
    }
    const Id attempt = store::begin_attempt(db, session, point.seq, epoch.id);
    if (point.seq == 4) {
      store::interrupt_open_attempts(db, session, "power lost");
    } else if (point.seq < 5) {
      store::NewReading reading = test::reading_at(point);
      reading.raw_reply = std::string("AP\t\\N \0 \x01", 9);  // what text formats would change
      if (point.seq == 1) reading.reading.measured->y_mm = std::nextafter(0.1, 1.0);
      if (point.seq == 3) reading.reading.measured->y_mm = -5e-324;
      store::finish_attempt(db, attempt, {reading});
    }  // the last one stays open
  }
}

}  // namespace

void add_full_campaign(Connection& db, const std::string& name) {
  const Id campaign = store::import_campaign(db, test::small_campaign(6, name)).campaign_id;
  walk(db, campaign, "baseline", {});
  store::exclude_reading(db, campaign, 2, "a truck passed");
  const Id first = job_of(db, campaign, 'a', {}, R"({"rank":12})");
  job_of(db, campaign, 'a', {}, R"({"rank":12})");  // forced: run 2
  const Id second = job_of(db, campaign, 'b', {first}, R"({"rank":13})");
  walk(db, campaign, "compensated", second);
  store::add_model(db, {.campaign_id = campaign, .name = "nominal", .identify_rms_mm = 0.2});
  store::add_model(db,
                   {.campaign_id = campaign, .name = "geometry", .parent = 1, .job_id = second});
}

void add_small_campaigns(Connection& db, const std::string& prefix, int n) {
  static const Campaign paper = paper_campaign();
  for (int k = 0; k < n; ++k) {
    Campaign campaign = paper;
    campaign.name = prefix + " " + std::to_string(k);
    campaign.readings.assign(paper.readings.begin() + k % 60, paper.readings.begin() + k % 60 + 20);
    campaign.readings[0].measured->x_mm +=
        1e-3 * (k % 1000);  // 10 mm is where no such robot can be
    int seq = 0;
    for (Reading& reading : campaign.readings) reading.seq = ++seq;
    store::import_campaign(db, campaign);
  }
}

archive::WorkDone work_at(const std::string& uri, const std::string& station, unsigned jobs,
                          double lease_s) {
  return archive::work({.station = station,
                        .machine = "machine of " + station.substr(0, 1),
                        .jobs = jobs,
                        .until_empty = true,
                        .lease_s = lease_s,
                        .connect = [&uri] {
                          return std::make_unique<archive::Link>(
                              archive::LinkOptions{.uri = uri, .who = "tests"});
                        }});
}

std::map<std::string, std::vector<std::string>> content(const std::filesystem::path& file) {
  Connection db = store::open_as_it_is(file);
  std::vector<std::string> tables;
  {
    store::Statement rows(db, "SELECT name FROM sqlite_schema WHERE type = 'table'");
    while (rows.step()) tables.push_back(rows.text(0));
  }
  std::map<std::string, std::vector<std::string>> all;
  for (const std::string& table : tables) {
    store::Statement rows(
        db, "SELECT * FROM " + table + (table == "attempt" ? " WHERE status <> 'open'" : ""));
    auto& to = all[table];
    while (rows.step()) to.push_back(store::canonical_bytes(rows, 0, rows.columns()));
    std::sort(to.begin(), to.end());
  }
  return all;
}

std::vector<archive::Pushed> push_all(const std::string& uri, const std::filesystem::path& file,
                                      const std::string& station) {
  Connection db = store::open_as_it_is(file);
  archive::Link link({.uri = uri, .who = "tests"});
  return archive::push(link, db, station, archive::campaigns_of(db), {});
}

std::string asked(const std::string& uri, const std::string& sql) {
  archive::Link link({.uri = uri, .who = "tests"});
  const auto rows = link.ask(sql);
  return rows.empty() ? "" : rows[0].at(0).value_or("NULL");
}

}  // namespace trammel::tests
