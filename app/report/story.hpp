#pragma once
// The discrepancy story of a campaign: what was named, round by round, and how the gap shrank.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "store/job.hpp"

namespace trammel::report {

struct Measured;

/// A named effect with its values, as fitted in this round.
struct EffectRow {
  struct Value {
    std::string name, unit;
    double value = 0, std = 0;
  };
  std::string name = {};
  std::vector<Value> values = {};
  double p = 0;                // that chance alone shows as much
  double share_of_gap = 0;     // of what was explained
  std::vector<int> seqs = {};  // outlier_readings only
};

/// Another set of effects that explains the readings about as well.
struct RivalRow {
  std::string names = {};   // "lead_scale + backlash"
  double odds = 1;          // for the named set
  bool structural = false;  // these points can't carry the difference
};

/// rms of measured - simulated per coordinate.
struct GapRow {
  std::string model = {};                      // "nominal", "geometry", "+backlash"
  std::optional<double> identify_rms_mm = {};  // in-sample
  std::optional<double> validate_rms_mm = {};  // held-out
  bool tried = false;                          // unexplained: not added to the model
};

struct PointsOf {
  std::string session = {};
  int n = 0;
};

/// One diagnosis.
struct StoryRound {
  long long job_id = 0;
  std::string job_key = {};
  std::string verdict = {};
  std::vector<PointsOf> fitted = {};  // sessions whose readings the round before had not
  std::vector<PointsOf> judged = {};  // sessions whose readings only judge
  std::vector<EffectRow> effects = {};
  std::vector<std::string> tried = {};  // unexplained: what the catalogue could do, not added
  std::vector<RivalRow> rivals = {};
  std::vector<std::pair<std::string, double>> may_also_hold = {};  // with their probability
  std::vector<GapRow> gap = {};
  double noise_floor_mm = 0;
  int n_next_points = 0;
  std::vector<std::string> next_why = {};  // what those points are for, each once
};

/// What a diagnosis found; its points are not counted. Throws nlohmann's exceptions for a result of
/// another form.
StoryRound round_of(const store::Job& job);

/// The diagnoses that led to `last`: of the same parameters, on some of its sessions, each key
/// once, in order; those whose result can't be read are passed over. Proof: the demo's story
/// (demo_test.cpp).
std::vector<StoryRound> story_of(store::Connection& connection, const Measured& measured,
                                 const store::Job& last);

nlohmann::ordered_json story_json(const std::vector<StoryRound>& story);
/// `decimals` of what is left, in mm.
std::string story_text(const std::vector<StoryRound>& story, int decimals);

}  // namespace trammel::report
