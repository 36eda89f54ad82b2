// The result of every algorithm_version, frozen. When one of these fails a result has changed: bump
// the stage's algorithm_version, freeze the new figures beside it, and say so in the CHANGELOG.

#include "app/job/stages.hpp"
#include "core/assess/deviation.hpp"
#include "core/calibrate/correction.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

struct Frozen {
  const char* stage;
  int algorithm_version;
  double l_mm[3];  // commanded for the pose (33, -47, 0)
};

// Wide enough for another compiler's rounding, far below any change of method.
constexpr double kRoundingMm = 1e-8;

const Frozen kFrozen[] = {
    {"lsq", 4, {316.6481647327, 259.0159208467, 215.6748243755}},
    {"idw", 1, {316.6497086569, 259.0482848407, 215.6578321233}},
    {"rbf", 2, {316.6476937259, 259.0132938579, 215.6762105687}},
    {"geometry", 3, {316.6481629193, 259.0158940620, 215.6748333435}},
    {"gp", 1, {316.6473912873, 259.0143978659, 215.6759127095}},
    {"diagnose", 2, {316.6481629193, 259.0158940620, 215.6748333435}},
    {"contest", 5, {316.6481647327, 259.0159208467, 215.6748243755}},
    {"hybrid", 3, {316.6481629193, 259.0158940620, 215.6748333435}},
};

}  // namespace

TEST_CASE("no stage's result has changed without a new algorithm version", "[job]") {
  const Campaign campaign = paper_campaign();
  CHECK(std::size(kFrozen) == job::stages().size());
  for (const Frozen& frozen : kFrozen) {
    INFO(frozen.stage);
    const job::Stage& stage = job::find_stage(frozen.stage);
    CHECK(stage.algorithm_version == frozen.algorithm_version);
    const auto result = stage.run(campaign, stage.complete(job::Json::object()));
    const auto cmd = commanded(result.correction, campaign.mechanism, {.target = {33, -47, 0}});
    for (int i = 0; i < kChains; ++i) {
      CHECK_THAT(cmd.l_mm[i], WithinAbs(frozen.l_mm[i], kRoundingMm));
    }
  }
}
