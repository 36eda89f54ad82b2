#include "app/job/run.hpp"
#include "app/report/assess/assessment.hpp"
#include "core/plan/build.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/program.hpp"
#include "tests/support/temporary.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

assess::Assessment assessed(store::Connection& db, const std::string& job = "",
                            const std::string& session = "") {
  return assess::gather(db, store::require_campaign(db, "paper"), session, job);
}

std::string calibrated(store::Connection& db, const std::string& stage,
                       const job::Json& parameters = job::Json::object()) {
  return std::to_string(
      job::run(db, {.campaign = "paper", .stage = stage, .parameters = parameters}).job.id);
}

const assess::Judged& judged(const assess::Assessment& a, bool in_sample) {
  for (const assess::Judged& j : a.job->sets) {
    if (j.in_sample() == in_sample) return j;
  }
  throw std::runtime_error("no such set");
}

store::Connection stored(const test::TempFolder& folder, const Campaign& campaign) {
  store::Connection db = store::open(folder.file("t.db"), store::Access::create);
  store::import_campaign(db, campaign);
  return db;
}

}  // namespace

TEST_CASE("one visit a pose: the assessment gives a mean deviation, no ISO symbol", "[assess]") {
  PaperStore paper;
  const auto found = assessed(paper.db);
  REQUIRE(found.sessions.size() == 1);
  for (const IsoSymbol& s : found.sessions[0].poses.symbols) CHECK_FALSE(s.value);
  for (const IsoSymbol& s : found.sessions[0].rails.at(0).symbols) CHECK_FALSE(s.value);
  const std::string text = assess::to_text(found);
  CHECK_THAT(text, Contains("mean positional deviation") && Contains("n = 1 visit a pose"));
  CHECK_THAT(text, Contains("refused: AP_p") && Contains("refused: B, Bm"));
  CHECK_THAT(text, Contains("um unexplained beyond the floor"));
  CHECK_THAT(text, Contains("before anyone certifies"));
}

TEST_CASE("a rail walked five times both ways carries every ISO 230-2 symbol", "[assess]") {
  Random random(401);
  Campaign campaign = paper_campaign();
  const Plan plan = rail_plan(mechanism_of(campaign.machine), {.half_travel_mm = 40});
  std::vector<Pose> targets;
  for (const PlannedPoint& p : plan.points) targets.push_back(p.target);
  campaign.readings = measure(random_geometry(random), targets, random);
  for (std::size_t k = 0; k < plan.points.size(); ++k) {
    Conditions& c = campaign.readings[k].conditions;
    for (int i = 0; i < kChains; ++i) {
      c.from_mm[i] = c.cmd_mm[i] - 5.0 * plan.points[k].approach[static_cast<std::size_t>(i)];
    }
  }
  const test::TempFolder folder;
  store::Connection db = stored(folder, campaign);
  const auto found = assessed(db);
  REQUIRE(found.sessions[0].rails.size() == 3);
  for (const Iso230& rail : found.sessions[0].rails) {
    for (const IsoSymbol& s : rail.symbols) CHECK(s.value);
  }
  CHECK_THAT(assess::to_text(found),
             Contains("ISO 230-2, rail 3: 11 targets over 80.0 mm, 5 runs"));
}

TEST_CASE(
    "U of a corrected point comes from the model, the process or the held-out points, and says "
    "which",
    "[assess]") {
  PaperStore paper;
  struct Row {
    const char* stage;
    const char* from;
    job::Json parameters = job::Json::object();
  };
  for (const Row& row :
       {Row{"geometry", "covariance of the fitted model"}, Row{"gp", "what the map misses"},
        Row{"hybrid", "what the map misses of what it leaves", {{"map", "always"}}},
        Row{"lsq", "covariance of the fitted model"}, Row{"idw", "what the map misses"},
        Row{"rbf", "what the map misses"}}) {
    INFO(row.stage);
    const auto found = assessed(paper.db, calibrated(paper.db, row.stage, row.parameters));
    CHECK_THAT(found.job->uncertainty_from, Contains(row.from));
    for (const assess::Judged& j : found.job->sets) {
      for (const assess::Point& p : j.points) {
        if (!p.U) continue;  // out of range
        CHECK(p.U->U_mm > 0);
        CHECK(p.U->U_mm < 0.2);
      }
    }
  }
}

TEST_CASE("a complete model's U covers where the corrected robot goes", "[assess]") {
  PaperStore paper;
  const auto found = assessed(paper.db, calibrated(paper.db, "geometry"));
  const assess::Judged& unseen = judged(found, false);
  CHECK(unseen.points.size() == 48);
  // what is read: U and the reading's noise (10 um a coordinate); 2 sigmas in each of two
  // coordinates: 86 % of points, sd 5 %
  int covered = 0;
  for (const assess::Point& p : unseen.points) {
    const double u = std::hypot(p.U->U_mm / 2, kSigma.xy_mm);
    covered += p.after_mm <= 2 * u ? 1 : 0;
  }
  CHECK(covered >= 48 * 0.66);
  CHECK_THAT(unseen.verdict, Contains("at the floor"));
  REQUIRE(unseen.improvement_95_pct);
  CHECK(unseen.improvement_95_pct->low < *unseen.improvement_pct);
  CHECK(unseen.improvement_95_pct->high > *unseen.improvement_pct);
}

TEST_CASE("U is widened by what held-out points show beyond it, and then covers them", "[assess]") {
  Campaign campaign = paper_campaign();
  for (std::size_t k = 80; k < 128; ++k) {  // an error that only the unseen places have
    campaign.readings[k].measured->x_mm += k % 2 == 0 ? 0.06 : -0.06;
  }
  const test::TempFolder folder;
  store::Connection db = stored(folder, campaign);
  const auto found = assessed(db, calibrated(db, "geometry"));
  CHECK_THAT(found.job->uncertainty_from, Contains("by 48 held-out points"));
  const assess::Judged& unseen = judged(found, false);
  CHECK(unseen.points[0].U->U_mm > 0.08);
  REQUIRE(unseen.covered_pct);
  CHECK(*unseen.covered_pct > 90);
  CHECK_FALSE(judged(found, true).covered_pct);
}

TEST_CASE("a fit of the noise is not called at the floor", "[assess]") {
  PaperStore paper;
  const auto found = assessed(paper.db, calibrated(paper.db, "idw"));
  CHECK_THAT(judged(found, true).verdict, Contains("below the floor"));
}

TEST_CASE("without held-out points the job is judged by spatial blocks, in-sample kept apart",
          "[assess]") {
  Campaign campaign = paper_campaign();
  campaign.readings.resize(80);
  const test::TempFolder folder;
  store::Connection db = stored(folder, campaign);
  const auto found = assessed(db, calibrated(db, "idw"));
  REQUIRE(found.job->sets.size() == 2);
  CHECK(judged(found, true).after_mm.mean < 1e-9);
  CHECK(judged(found, false).cross_validated);
  CHECK(judged(found, false).after_mm.mean > 0.01);
  CHECK_THAT(found.job->uncertainty_from, Contains("a random field like its samples"));
}

TEST_CASE("poses beyond the measured ones are warned of", "[assess]") {
  Campaign campaign = paper_campaign();
  campaign.readings[100].target.phi_rad = rad_from_deg(5);
  for (std::size_t k = 0; k < 80; ++k) {  // fitted: the inner half alone
    Reading& r = campaign.readings[k];
    if (std::max(std::abs(r.target.x_mm), std::abs(r.target.y_mm)) > 50) {
      r.set = ReadingSet::validate;
    }
  }
  const test::TempFolder folder;
  store::Connection db = stored(folder, campaign);
  const auto found = assessed(db, calibrated(db, "geometry"));
  for (const assess::Point& p : judged(found, false).points) {
    CHECK(p.U.has_value() == p.why_no_U.empty());
    const bool outside = std::max(std::abs(p.target.x_mm), std::abs(p.target.y_mm)) > 50.001;
    CHECK((outside || p.target.phi_rad != 0) == !p.U.has_value());
  }
  CHECK_THAT(assess::to_text(found), Contains("no U at") && Contains("outside the convex hull"));
  REQUIRE(found.job->warnings.size() == 2);
  CHECK_THAT(found.job->warnings[0], Contains("outside the convex hull"));
  CHECK_THAT(found.job->warnings[1], Contains("beyond the measured orientations"));
}

TEST_CASE("an unknown session or job, or one of another campaign, is answered in words",
          "[assess]") {
  PaperStore paper;
  CHECK_THROWS_AS(assessed(paper.db, "", "nowhere"), NotFoundError);
  CHECK_THROWS_AS(assessed(paper.db, "99"), NotFoundError);
  store::import_campaign(paper.db, paper_campaign("other"));
  const auto other = job::run(paper.db, {.campaign = "other", .stage = "idw"});
  CHECK_THROWS_AS(assessed(paper.db, std::to_string(other.job.id)), InputError);
}

TEST_CASE("trammel assess prints text and JSON of its schema", "[assess][cli]") {
  const TemporaryFolder folder;
  const std::string source = tests::source_folder() + "/tests/support/campaigns/drive-error";
  REQUIRE(run_program({"campaign", "import", source}, folder.path()).exit_code == 0);
  REQUIRE(run_program({"calibrate", "geometry", "drive-error"}, folder.path()).exit_code == 0);
  const Finished text = run_program({"assess", "drive-error", "--job", "1"}, folder.path());
  CHECK(text.exit_code == 0);
  CHECK_THAT(text.out, Contains("U from the covariance") && Contains("t of the log ratio"));
  const Finished json =
      run_program({"assess", "drive-error", "--job", "1", "--json"}, folder.path());
  const auto fields = nlohmann::json::parse(json.out);
  CHECK(fields.at("schema") == "trammel/assess/1");
  CHECK(fields.at("job").at("sets").size() == 2);
  CHECK(fields.at("sessions").at(0).at("iso_9283").at("symbols").at(0).at("refused") == true);
  CHECK(run_program({"assess", "nobody"}, folder.path()).exit_code == 3);
  CHECK(run_program({"assess", "drive-error", "--session", "x"}, folder.path()).exit_code == 3);
}
