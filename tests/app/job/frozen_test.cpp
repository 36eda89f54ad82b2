// The result of every algorithm_version, frozen. When one of these fails a result has changed: bump
// the stage's algorithm_version, freeze the new figures beside it, and say so in the CHANGELOG.

#include <algorithm>
#include <cmath>

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
  double all;      // fingerprint of every number and name of the result
  const char* parameters = "{}";
};

// Wide enough for another compiler's rounding, far below any change of method.
constexpr double kRoundingMm = 1e-8;
constexpr double kRounding = 1e-4;

const Frozen kFrozen[] = {
    {"lsq", 6, {316.6481647604, 259.0159208467, 215.6748243755}, 601.6254315667},
    {"idw", 4, {316.6497086569, 259.0482848407, 215.6578321233}, 53.8545862762},
    {"rbf", 4, {316.6476937259, 259.0132938579, 215.6762105687}, 950.6114507991},
    {"geometry", 6, {316.6481629193, 259.0158940620, 215.6748333435}, 594.6248942509},
    {"gp", 3, {316.6473912873, 259.0143978659, 215.6759127095}, 178.9638605697},
    {"diagnose", 7, {316.6481629193, 259.0158940620, 215.6748333435}, 2172.7862570807},
    {"contest", 8, {316.6481647604, 259.0159208467, 215.6748243755}, 541.656534343},
    {"hybrid", 6, {316.6481629193, 259.0158940620, 215.6748333435}, 613.7318314108},
    {"hybrid",
     6,
     {316.6481956485, 259.0161184217, 215.6757733936},
     594.6248942509,
     R"({"map": "always"})"},
};

/// FNV-1a, to [0.5, 1.5): the same everywhere.
double weight(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  return 0.5 + static_cast<double>(hash >> 11U) * 0x1p-53;
}

/// A sum over all leaves of a result. A number counts by its path and by the logarithm of its size
/// above 1e-6; a name by its letters. Sentences may be put better without another result.
double fingerprint(const job::Json& result) {
  double sum = 0;
  const job::Json leaves = result.flatten();
  for (const auto& [path, value] : leaves.items()) {
    if (value.is_number()) {
      const double x = value.get<double>();
      sum += weight(path) * std::copysign(std::log1p(std::abs(x) / 1e-6), x);
    } else if (!value.is_string() || value.get<std::string>().find(' ') == std::string::npos) {
      sum += weight(path + value.dump());
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("no stage's result has changed without a new algorithm version", "[job]") {
  const Campaign campaign = paper_campaign();
  for (const job::Stage& stage : job::stages()) {
    INFO(stage.name);
    CHECK(std::ranges::any_of(kFrozen, [&](const Frozen& f) { return stage.name == f.stage; }));
  }
  for (const Frozen& frozen : kFrozen) {
    INFO(frozen.stage << " " << frozen.parameters);
    const job::Stage& stage = job::find_stage(frozen.stage);
    CHECK(stage.algorithm_version == frozen.algorithm_version);
    const auto result = stage.run(campaign, stage.complete(job::Json::parse(frozen.parameters)));
    const auto cmd = commanded(result.correction, campaign.mechanism, {.target = {33, -47, 0}});
    for (int i = 0; i < kChains; ++i) {
      CHECK_THAT(cmd.l_mm[i], WithinAbs(frozen.l_mm[i], kRoundingMm));
    }
    CHECK_THAT(fingerprint(result.details), WithinAbs(frozen.all, kRounding));
  }
}

TEST_CASE("a number of a result that changes by one in a thousand changes its fingerprint",
          "[job]") {
  const job::Stage& stage = job::find_stage("geometry");
  const job::Json result = stage.run(paper_campaign(), stage.complete(job::Json::object())).details;
  const job::Json flat = result.flatten();
  int n_numbers = 0;
  for (const auto& [path, value] : flat.items()) {
    if (!value.is_number() || std::abs(value.get<double>()) < 1e-6) continue;
    job::Json changed = flat;
    changed[path] = value.get<double>() * 1.001;
    INFO(path);
    CHECK(std::abs(fingerprint(changed.unflatten()) - fingerprint(result)) > 2 * kRounding);
    ++n_numbers;
  }
  CHECK(n_numbers > 50);
}
