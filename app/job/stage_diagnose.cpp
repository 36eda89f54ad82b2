#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "app/job/diagnosis_json.hpp"
#include "app/job/model_chain.hpp"
#include "app/job/stages.hpp"
#include "core/plane/extent.hpp"
#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr int kMostReplicates = 100000;

Json complete_diagnosis(const Json& given) {
  const JsonFile file = parse_json(given.dump(), "parameters of diagnose");
  Fields f(file);
  const DiagnoseOptions defaults;
  Json all = {{"seed", f.integer("seed", 1)},
              {"replicates", f.integer("replicates", defaults.replicates)},
              {"false_alarm", f.number("false_alarm", defaults.false_alarm)},
              {"epochs", f.choice("epochs", {"own", "shared"}, "own")},
              {"inadequate", f.number("inadequate", defaults.inadequate)}};
  if (f.has("within_mm")) {  // absent when not asked for: the key of earlier jobs stays
    const std::vector<double> within = f.numbers("within_mm");
    if (within.size() != 2 || !(within[0] < within[1])) {
      f.refuse("within_mm", "no bounds", "two numbers, the lower first");
    }
    all["within_mm"] = within;
  }
  f.done();
  for (const char* level : {"false_alarm", "inadequate"}) {
    const double value = all[level].get<double>();
    if (!(value > 0 && value < 0.5))
      f.refuse(level, "a false-alarm rate", "more than 0, less than 0.5");
  }
  const auto replicates = all["replicates"].get<long long>();
  const int fewest = std::max(
      100, fewest_replicates(all["false_alarm"].get<double>(), all["inadequate"].get<double>()));
  if (replicates < fewest || replicates > kMostReplicates) {
    f.refuse("replicates",
             "the smallest p of n replicates is 1 / (n + 1), and has to reach the test's level",
             fmt::format("{} to {}", fewest, kMostReplicates));
  }
  return all;
}

/// All readings as of one homing and frame set-up: for a stage that homes exactly.
Campaign in_one_epoch(Campaign campaign) {
  for (Reading& reading : campaign.readings) reading.conditions.epoch = 1;
  return campaign;
}

/// Turned by less than this all readings have one orientation: the rail offsets stay unknown.
constexpr double kOneOrientationRad = rad_from_deg(0.2);

/// What a person should know of the readings as such, before any result.
std::vector<std::string> notes_on(const Campaign& campaign) {
  constexpr int kOwnOfAnEpoch = 2;  // readings that joint zeros and frame of an epoch use up
  std::vector<std::string> notes;
  std::map<int, int> of_epoch;
  int unseen = 0;
  double low_rad = INFINITY, high_rad = -INFINITY;
  for (const Reading& r : campaign.readings) {
    if (!r.measured) continue;
    if (r.set == ReadingSet::validate) ++unseen;
    if (r.set != ReadingSet::identify) continue;
    ++of_epoch[r.conditions.epoch];
    low_rad = std::min(low_rad, r.target.phi_rad);
    high_rad = std::max(high_rad, r.target.phi_rad);
  }
  if (unseen == 0) {
    notes.emplace_back(
        "there are no validation readings: the gap is judged in-sample only, on the readings that "
        "were fitted");
  }
  const bool turns = !campaign.machine.kind->has_point_platform();
  if (turns && high_rad - low_rad < kOneOrientationRad) {
    notes.emplace_back(
        "all readings have one orientation: rail offsets, frame and reflector can't be told apart, "
        "and what turns the platform hardly shows");
  }
  for (const auto& [epoch, n] : of_epoch) {
    if (of_epoch.size() < 2 || n > 2 * kOwnOfAnEpoch) continue;
    notes.push_back(
        fmt::format("epoch {} has {} readings to identify from: they tell little beyond its own "
                    "joint zeros and "
                    "frame",
                    epoch, n));
  }
  return notes;
}

std::vector<Place> bounds_in(const Json& p) {
  if (!p.contains("within_mm")) return {};
  return square_hull(p["within_mm"][0], p["within_mm"][1]);
}

StageResult run_diagnosis(const Campaign& measured, const Json& p) {
  const bool shared = p["epochs"] == "shared";
  const Campaign campaign = shared ? in_one_epoch(measured) : measured;
  Diagnosis d = diagnose(campaign, {.false_alarm = p["false_alarm"].get<double>(),
                                    .inadequate = p["inadequate"].get<double>(),
                                    .seed = p["seed"].get<std::uint64_t>(),
                                    .replicates = p["replicates"].get<int>(),
                                    .new_epoch_next = !shared,
                                    .next_within = bounds_in(p)});
  const std::vector<std::string> notes = notes_on(campaign);
  d.notes.insert(d.notes.begin(), notes.begin(), notes.end());
  StageResult out;
  out.correction = ModelCorrection{d.fit.model};
  out.details = diagnosis_json(d, with_full_records(campaign));
  out.details["models"] = model_chain_json(d);
  return out;
}

}  // namespace

Stage diagnose_stage() {
  return {.name = "diagnose",
          .algorithm_version = 12,
          .what = "the discrepancy workflow: which physical effect the model is missing",
          .complete = complete_diagnosis,
          .run = run_diagnosis};
}

}  // namespace trammel::job
