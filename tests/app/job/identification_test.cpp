#include "core/mechanism/inverse.hpp"
// What a calibration says of its parameters, in words, JSON and the table of `trammel calibrate`.

#include "app/job/run.hpp"
#include "app/job/stages.hpp"
#include "app/job/text.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;
using job::Json;

namespace {

job::StageResult ran(const char* stage, const Campaign& campaign,
                     const Json& parameters = Json::object()) {
  const job::Stage& of = job::find_stage(stage);
  return of.run(campaign, of.complete(parameters));
}

/// Every rail stretched by `gain` of its displacement from home: no constant parameter does that.
void stretch(Campaign& campaign, double gain) {
  const Geometry& g = mechanism_of(campaign.machine).geometry;
  const Displacements home = inverse(g, Pose{}).l_mm;
  for (Reading& r : campaign.readings) {
    const Displacements l = inverse(g, *r.measured).l_mm;
    r.measured = forward(g, l + gain * (l - home).cwiseAbs(), *r.measured).pose;
  }
}

}  // namespace

TEST_CASE("no number stands beside a parameter that is not identified by itself", "[job]") {
  for (const char* stage : {"lsq", "geometry"}) {
    const auto result = ran(stage, paper_campaign());
    int identified = 0;
    for (const Json& p : result.details["parameters"]) {
      INFO(p.dump());
      CHECK(p.contains("change") == p["identified"].get<bool>());
      CHECK(p.contains("standard_uncertainty") == p["identified"].get<bool>());
      CHECK(p.contains("why") != p["identified"].get<bool>());
      identified += p["identified"].get<bool>() ? 1 : 0;
    }
    CHECK(identified < 12);
    CHECK(result.details["identified"].size() == result.details["rank"].get<std::size_t>());
    for (const Json& b : result.details["identified"]) CHECK(b["standard_uncertainty"] > 0);
  }
}

TEST_CASE("what repeated identification dropped is not told as identified", "[job]") {
  Campaign campaign = paper_campaign();
  stretch(campaign, 0.02);
  const auto result = ran("lsq", campaign, {{"drop_below", 20}});
  REQUIRE(result.details["rounds"].size() > 1);
  CHECK(result.details["identified"].size() < result.details["rank"].get<std::size_t>());
  for (const Json& b : result.details["identified"]) CHECK(b["standard_uncertainty"] > 0);
  CHECK_THAT(said(result), Contains("dropped as small") && !Contains("+- 0.0000"));
}

TEST_CASE("what acts together is identified with its uncertainty, in words and in the table",
          "[job]") {
  PaperStore paper;
  const auto outcome = job::run(paper.db, {.campaign = "paper", .stage = "geometry"});
  const std::string text = job::job_text(outcome.job, job::campaign_of(paper.db, outcome.job.data));
  CHECK_THAT(text, Contains("identified of these: l_1 - R_1") && Contains("mm (k = 2)"));
  CHECK_THAT(text, Contains("identified, change from nominal") && Contains("U (k = 2)"));
}

TEST_CASE("uncertainties are widened by what the model cannot explain, and it says so", "[job]") {
  Campaign campaign = paper_campaign();
  const auto clean = ran("geometry", campaign);
  CHECK(clean.details["explained"] == true);
  CHECK_THAT(said(clean), Contains("the model explains these readings"));
  stretch(campaign, 0.003);
  for (const char* stage : {"geometry", "lsq"}) {
    const auto bent = ran(stage, campaign);
    INFO(said(bent));
    CHECK(bent.details["explained"] == false);
    CHECK(bent.details["uncertainty_scale"].get<double>() > 2);
    CHECK_THAT(said(bent), Contains("uncertainties are widened"));
  }
}

TEST_CASE("a parameter far outside its tolerance is an absorption alarm of both methods", "[job]") {
  Campaign campaign = paper_campaign();
  for (const char* stage : {"geometry", "lsq"}) {
    CHECK(ran(stage, campaign).details["beyond_tolerance"].empty());
  }
  stretch(campaign, 0.02);
  for (const char* stage : {"geometry", "lsq"}) {
    const auto bent = ran(stage, campaign);
    INFO(said(bent));
    CHECK_FALSE(bent.details["beyond_tolerance"].empty());
    CHECK_THAT(said(bent), Contains("tolerances from nominal: probably soaking up"));
  }
}

TEST_CASE("outliers are named by seq in words, and none is dropped", "[job]") {
  Campaign campaign = paper_campaign();
  CHECK(ran("geometry", campaign).details["outliers"].empty());
  campaign.readings[11].measured->x_mm += 0.3;
  campaign.readings[52].measured->y_mm += 0.3;
  const auto plain = ran("geometry", campaign);
  CHECK_THAT(said(plain), Contains("2 of 80 readings do not belong to the rest: seq 12 (") &&
                              Contains("seq 53 (") && Contains("none is dropped"));
  const auto robust = ran("geometry", campaign, {{"robust", true}});
  CHECK(robust.details["outliers"].size() == 2);
  CHECK(robust.details["outliers"][0]["weight"].get<double>() < 0.3);
  CHECK(robust.details["uncertainty_scale"].get<double>() <
        plain.details["uncertainty_scale"].get<double>());
}

TEST_CASE("an effect is shown by its value and in its own unit", "[job]") {
  const auto result = ran("geometry", paper_campaign(), {{"effects", {"lead_curvature"}}});
  bool found = false;
  for (const Json& p : result.details["parameters"]) {
    if (p["name"] != "lead_curvature q_1") continue;
    found = true;
    CHECK(p["unit"] == "1/mm");
    REQUIRE(p["identified"] == true);
    CHECK(std::abs(p["change"].get<double>()) < 5 * p["standard_uncertainty"].get<double>());
  }
  CHECK(found);
}

TEST_CASE("a hybrid uses its map where that helps on held-out blocks, and leaves it out elsewhere",
          "[job]") {
  Campaign campaign = paper_campaign();
  const auto clean = ran("hybrid", campaign);
  CHECK(kind_of(clean.correction) == "model");
  CHECK_THAT(said(clean), Contains("the map does not help beyond chance, and is left out"));
  CHECK(kind_of(ran("hybrid", campaign, {{"map", "always"}}).correction) == "hybrid");
  for (Reading& r : campaign.readings) {  // a smooth error of place that no geometry makes
    r.measured->x_mm += 0.3 * std::sin(r.target.x_mm / 40) * std::cos(r.target.y_mm / 50);
  }
  const auto bent = ran("hybrid", campaign);
  INFO(said(bent));
  CHECK(kind_of(bent.correction) == "hybrid");
  CHECK_THAT(said(bent), Contains("the map helps, and is used"));
}
