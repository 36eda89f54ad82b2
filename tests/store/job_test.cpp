#include "store/job.hpp"

#include <set>

#include "store/model.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::store;
using trammel::test::small_campaign;
using trammel::test::TempFolder;

TEST_CASE("every input of a job changes its key, and nothing else does", "[store]") {
  const Campaign base = small_campaign();
  const JobKey key = job_key({.stage = "lsq", .campaign = base});
  CHECK(key.key.size() == 64);
  std::vector<Campaign> changed(10, base);
  changed[0].readings[1].measured->x_mm = std::nextafter(base.readings[1].measured->x_mm, 1e9);
  changed[1].readings[1].conditions.cmd_mm[2] += 1e-9;
  changed[2].readings[1].conditions.from_mm[0] += 1e-9;
  changed[3].readings[1].conditions.temp_degc.reset();
  changed[4].readings[0].conditions.time_s = 0;
  changed[5].readings[0].set = ReadingSet::validate;
  changed[6].readings[0].conditions.epoch = 2;
  changed[7].machine.chains[2][6] = 1e-9;  // h_3
  changed[8].tracker.reset();
  std::swap(changed[9].readings[0], changed[9].readings[1]);
  std::set<std::string> keys = {key.key};
  for (const Campaign& c : changed) keys.insert(job_key({.stage = "lsq", .campaign = c}).key);
  keys.insert(job_key({.stage = "idw", .campaign = base}).key);
  keys.insert(job_key({.stage = "lsq", .algorithm_version = 2, .campaign = base}).key);
  keys.insert(job_key({.stage = "lsq", .parameters_json = R"({"a":1})", .campaign = base}).key);
  keys.insert(job_key({.stage = "lsq", .model_json = R"({"a":1})", .campaign = base}).key);
  keys.insert(job_key({.stage = "lsq", .campaign = base, .excluded_seqs = {7}}).key);
  keys.insert(job_key({.stage = "lsq", .campaign = base, .parent_keys = {"x"}}).key);
  CHECK(keys.size() == changed.size() + 7);

  Campaign same = base;
  same.name = "another";
  same.facts.clear();
  CHECK(job_key({.stage = "lsq", .campaign = same}).key == key.key);
  const JobKey a =
      job_key({.stage = "x", .parameters_json = R"({"b":1.50,"a":2})", .campaign = base});
  const JobKey b =
      job_key({.stage = "x", .parameters_json = R"({"a":2, "b":1.5})", .campaign = base});
  CHECK(a.key == b.key);
  CHECK_THROWS_AS(job_key({.stage = "x", .parameters_json = "{", .campaign = base}), InputError);
}

TEST_CASE("the key of a stored campaign is the key of the campaign that was stored", "[store]") {
  // The sign of zero is lost in SQLite: it must not count.
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Campaign c = small_campaign();
  REQUIRE(std::signbit(c.readings[0].measured->y_mm));
  const Id id = import_campaign(db, c).campaign_id;
  const Campaign back = load_campaign(db, id).campaign;
  CHECK(job_key({.stage = "s", .campaign = back}).key ==
        job_key({.stage = "s", .campaign = c}).key);
}

TEST_CASE("a job comes back whole by its key", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = import_campaign(db, small_campaign()).campaign_id;
  const LoadedCampaign loaded = load_campaign(db, campaign);
  NewJob job{.campaign_id = campaign,
             .key = job_key({.stage = "lsq", .campaign = loaded.campaign}),
             .stage = "lsq",
             .parameters_json = R"({"b":0.1,"a":[1]})",
             .result_json = R"({"rank":12})",
             .n_readings = 6,
             .sessions = loaded.sessions};
  job.statistics = {{.set = "identify",
                     .metric = "position_mm",
                     .in_sample = true,
                     .before = Summary{0.2, 0.6, 0.01, 0.5, 80},
                     .after = Summary{0.02, 0.05, 0, 0.04, 80}},
                    {.set = "validate", .metric = "position_mm", .after = Summary{1, 2, 0, 2, 3}}};
  CHECK_FALSE(find_job(db, campaign, job.key.key));
  const Id id = add_job(db, job);
  const auto found = find_job(db, campaign, job.key.key);
  REQUIRE(found);
  CHECK((found->id == id && found->run == 1));
  CHECK(found->data.parameters_json == R"({"a":[1],"b":0.1})");
  CHECK(found->data.result_json == R"({"rank":12})");
  CHECK(found->data.key.parts == job.key.parts);
  CHECK(found->data.sessions == loaded.sessions);
  REQUIRE(found->data.statistics.size() == 2);
  CHECK(found->data.statistics[0].before->p95 == 0.5);
  CHECK(found->data.statistics[0].after->n == 80);
  CHECK_FALSE(found->data.statistics[1].before);
  CHECK_FALSE(found->provenance.git_revision.empty());
  // Forced: a row more, the first one stays.
  add_job(db, job);
  CHECK(find_job(db, campaign, job.key.key)->run == 2);
  CHECK(get_job(db, id).run == 1);
  CHECK_FALSE(find_job(db, campaign + 1, job.key.key));
  CHECK(list_jobs(db, campaign).size() == 2);
  CHECK(list_jobs(db, campaign + 1).empty());
  CHECK_THROWS_AS(get_job(db, 99), NotFoundError);
}

TEST_CASE("a job with a number that is not finite is not stored at all", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = import_campaign(db, small_campaign()).campaign_id;
  NewJob job{.campaign_id = campaign, .key = {std::string(64, 'a'), {}}, .stage = "lsq"};
  job.statistics = {{.set = "identify", .metric = "position_mm", .before = Summary{.mean = NAN}}};
  CHECK_THROWS_AS(add_job(db, job), StoreError);
  CHECK(list_jobs(db).empty());
}

TEST_CASE("models of a campaign are numbered and know their parents and their jobs", "[store]") {
  const TempFolder folder;
  Connection db = store::open(folder.file("lab.db"), Access::create);
  const Id campaign = import_campaign(db, small_campaign()).campaign_id;
  const Id job = add_job(
      db, {.campaign_id = campaign, .key = {std::string(64, 'f'), {}}, .stage = "diagnose"});
  CHECK(add_model(db, {.campaign_id = campaign, .name = "nominal", .identify_rms_mm = 0.2}) == 1);
  CHECK(add_model(db, {.campaign_id = campaign,
                       .name = "+lead_scale",
                       .parent = 1,
                       .job_id = job,
                       .parameters_json = R"([{"name":"k_1","value":0.1}])",
                       .validate_rms_mm = 0.01}) == 2);
  const auto all = list_models(db, campaign);
  REQUIRE(all.size() == 2);
  CHECK_FALSE(all[0].data.parent);
  CHECK(all[1].data.parent == 1);
  CHECK(all[1].job_key == std::string(64, 'f'));
  CHECK(all[1].data.validate_rms_mm == 0.01);
  CHECK_FALSE(all[1].data.identify_rms_mm);
  CHECK_THROWS_AS(get_model(db, campaign, 3), NotFoundError);
  CHECK_THROWS_AS(add_model(db, {.campaign_id = campaign, .name = "x", .parent = 7}),
                  NotFoundError);
}
