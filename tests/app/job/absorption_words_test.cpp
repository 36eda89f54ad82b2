#include "app/job/stages.hpp"
#include "core/mechanism/inverse.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

job::StageResult geometry(const Campaign& campaign) {
  const job::Stage& stage = job::find_stage("geometry");
  return stage.run(campaign, stage.complete(job::Json::object()));
}

}  // namespace

TEST_CASE("calibrate geometry calls a shift between halves what it is", "[job]") {
  Campaign campaign = paper_campaign();
  const job::StageResult clean = geometry(campaign);
  CHECK_THAT(said(clean), Contains("absorption: first and second half of the readings agree"));
  CHECK_THAT(said(clean), Contains("family-wise false alarm 1 %"));
  CHECK(clean.details["absorption"]["in_time"]["tests"].get<int>() > 0);
  for (Reading& r : campaign.readings) {  // a rail that grows by 60 um while it is measured
    const Pose& at = *r.measured;
    const Displacements l = inverse(mechanism_of(campaign.machine).geometry, at).l_mm;
    r.measured = forward(mechanism_of(campaign.machine).geometry,
                         l + Displacements(0, 0.06 * r.seq / 80, 0), at)
                     .pose;
  }
  const job::StageResult warm = geometry(campaign);
  CHECK_THAT(said(warm), Contains("absorption alarm: between the first and the second half"));
  CHECK_THAT(said(warm), Contains("probably soaking up an unmodelled effect"));
  CHECK_FALSE(warm.details["absorption"]["in_time"]["shifts"].empty());
}

TEST_CASE("too few readings to halve are said so, and the fit goes on", "[job]") {
  Campaign campaign = paper_campaign();
  campaign.readings.resize(9);
  CHECK_THAT(said(geometry(campaign)), Contains("absorption by halves not tested"));
}
