#include "app/job/run.hpp"
#include "app/job/points.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include "app/job/points.hpp"
#include "app/job/text.hpp"
#include "core/units.hpp"
#include "store/migrate.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/store/fixtures.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

const store::Statistic& statistic(const store::Job& job, const std::string& set,
                                  const std::string& metric) {
  for (const store::Statistic& s : job.data.statistics) {
    if (s.set == set && s.metric == metric) return s;
  }
  throw std::runtime_error("no statistic " + set + " " + metric);
}

}  // namespace

TEST_CASE("each calibration stores its figures, in-sample and held-out apart", "[job]") {
  PaperStore paper;
  for (const std::string stage : {"lsq", "idw", "rbf"}) {
    INFO(stage);
    const Outcome outcome = run(paper.db, {.campaign = "paper", .stage = stage});
    CHECK_FALSE(outcome.reused);
    const auto& fitted = statistic(outcome.job, "identify", "position_mm");
    const auto& unseen = statistic(outcome.job, "validate", "position_mm");
    CHECK(fitted.in_sample);
    CHECK_FALSE(unseen.in_sample);
    CHECK(fitted.before->n == 80);
    CHECK(unseen.before->n == 48);
    CHECK(unseen.after->mean < unseen.before->mean / 2);
    CHECK(points_of(paper.db, outcome.job).size() == 128);
    CHECK(outcome.job.data.sessions.size() == 1);
  }
  const auto idw = run(paper.db, {.campaign = "paper", .stage = "idw"});
  CHECK(statistic(idw.job, "identify", "position_mm").after->max < 1e-9);
  CHECK(statistic(idw.job, "validate", "position_mm").after->mean > 1e-3);
}

TEST_CASE("the same readings, parameters and version reuse the job, --force adds a run", "[job]") {
  PaperStore paper;
  const Request request{.campaign = "paper", .stage = "rbf"};
  const Outcome first = run(paper.db, request);
  const Outcome again = run(paper.db, request);
  CHECK(again.reused);
  CHECK(again.job.id == first.job.id);
  Request spelled = request;  // a default given in words is the same job
  spelled.parameters = {{"neurons", 50}};
  CHECK(run(paper.db, spelled).reused);
  Request forced = request;
  forced.force = true;
  const Outcome second = run(paper.db, forced);
  CHECK_FALSE(second.reused);
  CHECK(second.job.run == 2);
  CHECK(second.job.data.result_json == first.job.data.result_json);
  Request other = request;
  other.parameters = {{"seed", 2}};
  CHECK_FALSE(run(paper.db, other).reused);
}

TEST_CASE("a campaign with the same readings has a job of its own", "[job]") {
  PaperStore paper;
  const store::Id other = store::import_campaign(paper.db, paper_campaign("twin")).campaign_id;
  const Outcome first = run(paper.db, {.campaign = "paper", .stage = "idw"});
  const Outcome twin = run(paper.db, {.campaign = "twin", .stage = "idw"});
  CHECK_FALSE(twin.reused);
  CHECK(twin.job.data.campaign_id == other);
  CHECK(twin.job.data.key.key == first.job.data.key.key);
  CHECK(run(paper.db, {.campaign = "paper", .stage = "idw"}).job.id == first.job.id);
}

TEST_CASE("processes that ask for the same at once store it once, and all get it", "[job]") {
  PaperStore paper;
  std::vector<pid_t> children;
  for (int k = 0; k < 4; ++k) {
    const pid_t pid = fork();
    if (pid == 0) {
      int code = 99;
      try {
        store::Connection db = store::open(paper.folder.file("t.db"), store::Access::write);
        code = run(db, {.campaign = "paper", .stage = "rbf"}).job.id == 1 ? 0 : 1;
      } catch (...) {
      }
      _exit(code);
    }
    children.push_back(pid);
  }
  for (const pid_t pid : children) {
    int status = -1;
    waitpid(pid, &status, 0);
    CHECK(status == 0);
  }
  CHECK(store::list_jobs(paper.db).size() == 1);
}

TEST_CASE("an excluded reading changes the job and is not fitted", "[job]") {
  PaperStore paper;
  const Request request{.campaign = "paper", .stage = "idw"};
  const Outcome before = run(paper.db, request);
  store::exclude_reading(paper.db, paper.campaign, 7, "bumped");
  CHECK(inputs_of(paper.db, request).key.key != before.job.data.key.key);
  const Outcome after = run(paper.db, request);
  CHECK_FALSE(after.reused);
  CHECK(after.job.data.n_readings == 127);
  CHECK(after.job.data.exclusions.size() == 1);
}

TEST_CASE("a job can be computed again from what is stored of it, bit for bit", "[job]") {
  PaperStore paper;
  for (const std::string stage : {"lsq", "idw", "rbf"}) {
    const Outcome outcome = run(paper.db, {.campaign = "paper", .stage = stage});
    const store::NewJob again = compute(paper.db, request_of(paper.db, outcome.job));
    CHECK(again.key.key == outcome.job.data.key.key);
    CHECK(store::canonical_json(again.result_json, "result") == outcome.job.data.result_json);
    CHECK(find(paper.db, outcome.job.data.key.key.substr(0, 8)).id == outcome.job.id);
  }
}

TEST_CASE("a job is computed again from what it saw, whatever was added since", "[job]") {
  PaperStore paper;
  const auto plan = test::line_plan(12);
  const store::Id walk = store::create_session(
      paper.db, {.campaign_id = paper.campaign, .name = "walk", .points = plan});
  const store::Epoch epoch = store::open_epoch(paper.db, walk, store::SetUp::fresh, "start");
  const auto measure = [&](std::size_t from, std::size_t to) {
    for (std::size_t k = from; k < to; ++k) {
      store::finish_attempt(paper.db, store::begin_attempt(paper.db, walk, plan[k].seq, epoch.id),
                            {test::reading_at(plan[k])});
    }
  };
  measure(0, 8);
  store::exclude_reading(paper.db, paper.campaign, 130, "a miss");
  const store::Job job =
      run(paper.db,
          {.campaign = "paper", .stage = "idw", .sessions = {"walk"}, .despite_screen = true})
          .job;
  CHECK(job.data.n_readings == 7);
  measure(8, 12);
  store::exclude_reading(paper.db, paper.campaign, 129, "bumped");
  CHECK(compute(paper.db, request_of(paper.db, job)).key.key != job.data.key.key);
  const store::NewJob again = recompute(paper.db, job);
  CHECK(again.key.key == job.data.key.key);
  CHECK(store::canonical_json(again.result_json, "result") == job.data.result_json);
}

TEST_CASE("the stored correction commands what the computed one did", "[job]") {
  PaperStore paper;
  const Outcome outcome = run(paper.db, {.campaign = "paper", .stage = "lsq"});
  const Correction stored = correction_of(paper.db, outcome.job.id);
  const Campaign campaign = paper_campaign();
  const auto after = predicted_after(stored, mechanism_of(campaign.machine), campaign.readings[90]);
  const store::JobPoint point = points_of(paper.db, outcome.job)[90];
  REQUIRE(after);
  CHECK(after->x_mm - campaign.readings[90].target.x_mm == point.after.x_mm);
}

TEST_CASE("lsq says its rank in words and gives no number for what it cannot know", "[job]") {
  PaperStore paper;
  const Outcome outcome = run(paper.db, {.campaign = "paper", .stage = "lsq"});
  CHECK_THAT(job_text(outcome.job, campaign_of(paper.db, outcome.job.data)),
             Contains("rank 12 of 18"));
  const Json details = job_json(outcome.job, campaign_of(paper.db, outcome.job.data))["details"];
  CHECK(details["rank"] == 12);
  for (const Json& p : details["parameters"]) {
    CHECK(p["identified"].get<bool>() == p.contains("change"));
    CHECK(p["identified"].get<bool>() != p.contains("why"));
  }
}

TEST_CASE("a stale reading is named by every method, and left out when asked", "[job]") {
  PaperStore paper;
  Campaign campaign = store::load_campaign(paper.db, 1).campaign;
  campaign.name = "stale";
  campaign.readings[40].measured = campaign.readings[39].measured;
  const int seq = campaign.readings[40].seq;
  (void)store::import_campaign(paper.db, campaign);
  for (const std::string stage : {"lsq", "rbf", "gp"}) {
    CAPTURE(stage);
    const auto details = [](const Outcome& o) {
      return Json::parse(o.job.data.result_json)["details"];
    };
    const Outcome with = run(paper.db, {.campaign = "stale", .stage = stage});
    REQUIRE(details(with).contains("suspect_readings"));
    CHECK(details(with)["suspect_readings"].size() == 1);
    CHECK(details(with)["suspect_readings"][0]["seqs"] == Json::array({seq}));
    const Outcome without =
        run(paper.db,
            {.campaign = "stale", .stage = stage, .parameters = {{"without_suspects", true}}});
    CHECK_FALSE(details(without).contains("suspect_readings"));
    CHECK(statistic(without.job, "validate", "position_mm").after->mean <
          statistic(with.job, "validate", "position_mm").after->mean / 2);
    CHECK(same_result(recompute(paper.db, without.job).result_json, without.job.data.result_json));
  }
}

TEST_CASE("nothing but a diagnosis is made of what the screen refuses", "[job]") {
  PaperStore paper;
  Campaign campaign = store::load_campaign(paper.db, 1).campaign;
  campaign.name = "mirrored";
  for (Reading& r : campaign.readings) {
    if (r.measured) r.measured->x_mm = -r.measured->x_mm;
  }
  (void)store::import_campaign(paper.db, campaign);
  CHECK_THROWS_WITH(run(paper.db, {.campaign = "mirrored", .stage = "idw"}),
                    Contains("x has the wrong sign"));
  CHECK_NOTHROW(run(paper.db, {.campaign = "mirrored", .stage = "gp", .despite_screen = true}));
}

TEST_CASE("unknown campaigns, sessions, stages and parameters are refused in words", "[job]") {
  PaperStore paper;
  CHECK_THROWS_AS(run(paper.db, {.campaign = "none", .stage = "lsq"}), NotFoundError);
  CHECK_THROWS_WITH(run(paper.db, {.campaign = "paper", .stage = "magic"}),
                    Contains("lsq, geometry, idw"));
  CHECK_THROWS_WITH(run(paper.db, {.campaign = "paper", .stage = "idw", .sessions = {"night"}}),
                    Contains("night"));
  CHECK_THROWS_WITH(
      run(paper.db, {.campaign = "paper", .stage = "idw", .parameters = {{"powr", 2}}}),
      Contains("powr"));
  CHECK_THROWS_WITH(
      run(paper.db, {.campaign = "paper", .stage = "idw", .parameters = {{"neighbours", 500}}}),
      Contains("neighbours"));
  CHECK_THROWS_AS(find(paper.db, "99"), NotFoundError);
  CHECK(store::list_jobs(paper.db).empty());
}

TEST_CASE("the view of a job's points shows what the job holds, whatever version stored it",
          "[job]") {
  PaperStore paper;
  const store::Job job = run(paper.db, {.campaign = "paper", .stage = "lsq"}).job;
  const Campaign campaign = paper_campaign();
  store::Statement rows(paper.db,
                        "SELECT seq, in_sample, before_x_mm, after_x_mm, after_phi_deg FROM "
                        "v_job_point WHERE job_id = ? ORDER BY seq");
  rows << job.id;
  for (const store::JobPoint& point : points_of(paper.db, job)) {
    REQUIRE(rows.step());
    CHECK(rows.integer(0) == point.seq);
    CHECK((rows.integer(1) == 1) == point.in_sample);
    const auto& reading = *std::ranges::find(campaign.readings, point.seq, &Reading::seq);
    CHECK(rows.real(2) == reading.measured->x_mm - reading.target.x_mm);
    CHECK_THAT(rows.real(3), WithinRel(point.after.x_mm, 1e-14));
    CHECK_THAT(rows.real(4), WithinRel(deg_from_rad(point.after.phi_rad), 1e-14));
  }
  CHECK_FALSE(rows.step());

  const test::TempFolder folder;  // rows of job_point, stored by a program of version 3
  const auto old = folder.file("old.db");
  std::filesystem::copy_file(
      std::filesystem::path(tests::source_folder()) / "tests/store/versions/version_3.sqlite3",
      old);
  store::migrate(old);
  store::Connection db = store::open(old, store::Access::write);
  const auto points = points_of(db, store::get_job(db, 2));
  REQUIRE(points.size() == 8);
  store::Statement last(db,
                        "SELECT seq, in_sample, after_x_mm FROM v_job_point WHERE job_id = 2 ORDER "
                        "BY seq DESC LIMIT 1");
  REQUIRE(last.step());
  CHECK(last.integer(0) == points.back().seq);
  CHECK(last.real(2) == points.back().after.x_mm);
}
