#include "app/job/run.hpp"
#include "app/job/text.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::job;
using namespace trammel::tests;

namespace {

const Json& row(const Json& table, const std::string& method) {
  for (const Json& r : table) {
    if (r["method"] == method) return r;
  }
  throw std::runtime_error("no row " + method);
}

}  // namespace

TEST_CASE("the contest judges every method on the same held-out points and picks no map of noise",
          "[job]") {
  PaperStore paper;  // a robot with errors of geometry alone
  const Outcome outcome = run(paper.db, {.campaign = "paper", .stage = "contest"});
  const Json details = job_json(outcome.job, campaign_of(paper.db, outcome.job.data))["details"];
  for (const Json& r : details["table"]) CHECK(r["n"] == 80);
  const double nominal = row(details["table"], "nominal")["mean_mm"].get<double>();
  const double geometry = row(details["table"], "geometry")["mean_mm"].get<double>();
  CHECK(geometry < nominal / 5);
  CHECK(geometry < row(details["table"], "idw")["mean_mm"].get<double>());
  CHECK(details["picked"] != "nominal");
  CHECK(details["picked"] != "hybrid");
  const std::string text = job_text(outcome.job, campaign_of(paper.db, outcome.job.data));
  CHECK_THAT(text, Contains("rule: ") && Contains("at the floor"));
  CHECK_THAT(text, Contains("each of 80 fitted readings as predicted without its spatial block"));
  CHECK_THAT(text, Contains("held-out, mm") && Contains("time, s") && Contains("> lsq"));
  CHECK(run(paper.db, {.campaign = "paper", .stage = "contest"}).reused);
  const store::NewJob again = compute(paper.db, request_of(paper.db, outcome.job));
  CHECK(same_result(again.result_json, outcome.job.data.result_json));
}

TEST_CASE("what a map cannot see is named: the direction of approach", "[job]") {
  Campaign campaign = paper_campaign("backlash");
  const RobotModel truth = [] {
    RobotModel m = nominal_model(paper_mechanism());
    m.effects = {{&find_effect("backlash"), Eigen::Vector3d(0.08, 0.08, 0.08)}};
    return m;
  }();
  Random random(75);
  for (Reading& r : campaign.readings) {
    r.conditions.from_mm = r.conditions.cmd_mm;
    for (int i = 0; i < kChains; ++i) r.conditions.from_mm[i] += random.uniform() < 0.5 ? 5 : -5;
    Pose pose = predict(truth, r.conditions).pose;
    pose.x_mm += kSigma.xy_mm * random.normal();
    pose.y_mm += kSigma.xy_mm * random.normal();
    pose.phi_rad += kSigma.phi_rad * random.normal();
    r.measured = pose;
  }
  PaperStore paper;
  store::import_campaign(paper.db, campaign);
  const Outcome outcome = run(paper.db, {.campaign = "backlash", .stage = "contest"});
  INFO(job_text(outcome.job, campaign_of(paper.db, outcome.job.data)));
  const Json details = job_json(outcome.job, campaign_of(paper.db, outcome.job.data))["details"];
  for (const std::string map : {"idw", "rbf", "gp"}) {
    const Json& depends = row(details["table"], map)["depends_on"];
    REQUIRE(depends.contains("the direction of approach"));
    CHECK(depends["the direction of approach"].get<double>() > 0.3);
  }
  CHECK(details["picked"] == "geometry + effects");
}

TEST_CASE("a contest of a handful of readings is refused", "[job]") {
  Campaign few = paper_campaign("few");
  few.readings.resize(6);
  PaperStore paper;
  store::import_campaign(paper.db, few);
  CHECK_THROWS_WITH(run(paper.db, {.campaign = "few", .stage = "contest"}), Contains("too few"));
}
