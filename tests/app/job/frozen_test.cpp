// The result of every algorithm_version, frozen. When one of these fails a result has changed: bump
// the stage's algorithm_version, freeze the new figures beside it, and say so in the CHANGELOG.

#include <algorithm>
#include <cmath>

#include "app/job/run.hpp"
#include "app/job/stages.hpp"
#include "core/calibrate/correction.hpp"
#include "core/judge/deviation.hpp"
#include "tests/app/job/campaign_fixture.hpp"
#include "tests/support/catch.hpp"

using namespace trammel;
using namespace trammel::tests;

namespace {

struct Frozen {
  const char* stage;
  int algorithm_version;
  double l_mm[3];  // commanded for the pose (33, -47, 0)
  double all;      // fingerprint of every number and name of what is stored
  const char* parameters = "{}";
};

// Wide enough for another compiler's rounding, far below any change of method.
constexpr double kRoundingMm = 1e-8;
constexpr double kRounding = 1e-4;

const Frozen kFrozen[] = {
    {"lsq", 9, {316.6481647604, 259.0159208467, 215.6748243755}, 4492.2080020796},
    {"idw", 7, {316.6498621144, 259.0486300299, 215.6577462129}, 3379.9733985913},
    {"rbf", 7, {316.6479217088, 259.0138069216, 215.6759756822}, 5883.3256679468},
    {"geometry", 11, {316.6481629193, 259.0158940620, 215.6748333435}, 4868.4412380376},
    {"gp", 6, {316.6476192053, 259.0149119552, 215.6756799670}, 4116.1724034165},
    {"diagnose", 12, {316.6481629193, 259.0158940620, 215.6748333435}, 6558.5187062322},
    {"contest", 13, {316.6481647604, 259.0159208467, 215.6748243755}, 4489.7260764179},
    {"hybrid", 11, {316.6481629193, 259.0158940620, 215.6748333435}, 4891.8571600563},
    {"hybrid",
     11,
     {316.6481958057, 259.0161187314, 215.6757944277},
     5032.9398502731,
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
  for (const job::Stage& stage : job::stages()) {
    INFO(stage.name);
    CHECK(std::ranges::any_of(kFrozen, [&](const Frozen& f) { return stage.name == f.stage; }));
  }
  PaperStore paper;
  const Mechanism mechanism = mechanism_of(paper_campaign().machine);
  for (const Frozen& frozen : kFrozen) {
    INFO(frozen.stage << " " << frozen.parameters);
    const store::NewJob job =
        job::compute(paper.db, {.campaign = "paper",
                                .stage = frozen.stage,
                                .parameters = job::Json::parse(frozen.parameters)});
    CHECK(job.algorithm_version == frozen.algorithm_version);
    const Correction correction = job::correction_of(job.result_json);
    const auto cmd = commanded(correction, mechanism, {.target = {33, -47, 0}});
    for (int i = 0; i < kChains; ++i) {
      CHECK_THAT(cmd.l_mm[i], WithinAbs(frozen.l_mm[i], kRoundingMm));
    }
    job::Json stored = job::Json::parse(job.result_json);
    stored.erase("words");
    stored.erase("timing");
    CHECK_THAT(fingerprint(stored), WithinAbs(frozen.all, kRounding));
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
