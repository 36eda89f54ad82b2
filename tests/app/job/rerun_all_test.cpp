#include "app/job/rerun_all.hpp"

#include "store/reading.hpp"
#include "store/transaction.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/json_schema.hpp"
#include "tests/support/program.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

constexpr int kCampaigns = 140;  // more than a batch

/// Campaigns that differ, of ten readings each.
struct Archive {
  test::TempFolder folder;
  store::Connection db = store::open(folder.file("a.db"), store::Access::create);
  Archive() {
    const Campaign paper = paper_campaign();
    store::Transaction all(db);
    for (int k = 0; k < kCampaigns; ++k) {
      Campaign c = paper;
      c.name = "campaign " + std::to_string(k);
      c.readings.assign(paper.readings.begin() + k % 60, paper.readings.begin() + k % 60 + 10);
      c.readings[0].measured->x_mm += 1e-3 * k;
      int seq = 0;
      for (Reading& r : c.readings) r.seq = ++seq;
      store::import_campaign(db, c);
    }
    all.commit();
  }
};

}  // namespace

TEST_CASE("a sweep stores for each campaign the job that a run of its own stores", "[job]") {
  Archive archive;
  const SweepResult result = rerun_all(archive.db, {.stage = "lsq", .threads = 3});
  CHECK(result.campaigns == kCampaigns);
  CHECK(result.computed == kCampaigns);
  CHECK(result.failed.empty());
  CHECK(store::list_jobs(archive.db).size() == kCampaigns);
  for (const int k : {0, 33, 69}) {
    const std::string name = "campaign " + std::to_string(k);
    const Outcome again = run(archive.db, {.campaign = name, .stage = "lsq"});
    CHECK(again.reused);
    const auto alone = compute(archive.db, {.campaign = name, .stage = "lsq"});
    CHECK(same_result(alone.result_json, again.job.data.result_json));
  }
}

TEST_CASE("a sweep goes on where an earlier one was stopped", "[job]") {
  Archive archive;
  const SweepResult first =
      rerun_all(archive.db, {.stage = "lsq", .threads = 1, .stop = [] { return true; }});
  CHECK(first.stopped);
  CHECK(first.computed > 0);
  const SweepResult second = rerun_all(archive.db, {.stage = "lsq", .threads = 2});
  CHECK(second.reused == first.computed);
  CHECK(second.computed == kCampaigns - first.computed);
  CHECK(rerun_all(archive.db, {.stage = "lsq"}).reused == kCampaigns);
}

TEST_CASE("a sweep keeps to its condition and to each campaign's newest parameters", "[job]") {
  Archive archive;
  run(archive.db, {.campaign = "campaign 3", .stage = "lsq", .parameters = {{"steps", 2}}});
  const Sweep sweep{.stage = "lsq", .where = "name IN ('campaign 3', 'campaign 4')"};
  const SweepResult result = rerun_all(archive.db, sweep);
  CHECK(result.campaigns == 2);
  CHECK(result.reused == 1);  // with two steps, as stored
  CHECK(result.computed == 1);
  Sweep dry = sweep;
  dry.force = dry.dry_run = true;
  CHECK(rerun_all(archive.db, dry).computed == 2);
  CHECK(store::list_jobs(archive.db).size() == 2);
  CHECK_THROWS_AS(rerun_all(archive.db, {.stage = "lsq", .where = "no_such_column = 1"}),
                  InputError);
  CHECK_THROWS_AS(rerun_all(archive.db, {.stage = "lsq", .where = "1); DELETE FROM reading; --"}),
                  Error);
}

TEST_CASE("a campaign that cannot be calibrated is named and the others go on", "[job]") {
  Archive archive;
  for (int seq = 1; seq <= 10; ++seq) {
    const store::Id id = store::require_campaign(archive.db, "campaign 7").id;
    store::exclude_reading(archive.db, id, seq, "all of them");
  }
  const SweepResult result = rerun_all(archive.db, {.stage = "lsq"});
  CHECK(result.computed == kCampaigns - 1);
  REQUIRE(result.failed.size() == 1);
  CHECK(result.failed[0].campaign == "campaign 7");
}

TEST_CASE("job rerun --all says what it did as JSON of its schema, and what it needs", "[job]") {
  Archive archive;
  const std::string db = archive.folder.file("a.db").string();
  const auto program = [&](const std::vector<std::string>& words) {
    return run_program(words, archive.folder.path());
  };
  const Finished done = program({"job", "rerun", "--all", "--stage", "lsq", "--threads", "2",
                                 "--where", "campaign_id <= 5", "--json", "--db", db});
  INFO(done.err);
  REQUIRE(done.exit_code == 0);
  const auto json = nlohmann::json::parse(done.out);
  CHECK(schema_errors(json, "job-rerun-all.schema.json").empty());
  CHECK(json["computed"] == 5);
  CHECK(program({"job", "rerun", "--all", "--db", db}).exit_code == 2);
  CHECK(program({"job", "rerun", "--db", db}).exit_code == 2);
  CHECK(program({"job", "rerun", "--all", "--stage", "lsp", "--db", db}).exit_code == 3);
}
