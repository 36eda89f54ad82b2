#pragma once
// The discrepancy workflow: where simulation and measurement part, and why.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/calibrate/geometry_fit.hpp"
#include "core/diagnose/audit.hpp"
#include "core/diagnose/by_target.hpp"
#include "core/diagnose/next_points.hpp"
#include "core/diagnose/noise.hpp"
#include "core/diagnose/plausible.hpp"
#include "core/diagnose/structure.hpp"
#include "core/diagnose/ties.hpp"
#include "core/measure/noise.hpp"
#include "core/measure/reading.hpp"
#include "core/measure/screen.hpp"

namespace trammel {

enum class Verdict { nothing_missing, explained, ambiguous, unexplained };
std::string to_string(Verdict verdict);

struct DiagnoseOptions {
  double false_alarm = 0.005;  // of the structure test over everything, family-wise
  double inadequate = 0.002;   // of the same test once the effects are in
  std::uint64_t seed = 1;
  int replicates = 2000;
  int threads = 2;
  bool new_epoch_next = true;           // points measured next get a homing and frame of their own
  std::vector<Place> next_within = {};  // convex hull of these points; none: what was measured
};

/// Replicates whose smallest p, 1 / (n + 1), reaches the lower of two levels: with fewer a test can
/// never fail.
int fewest_replicates(double false_alarm, double inadequate);

enum class NoiseSource { tracker, repeats, residuals };
std::string to_string(NoiseSource source);

struct NoiseFloor {
  NoiseSource source = NoiseSource::tracker;
  TrackerSigma stated;         // 0 when none was stated
  TrackerSigma used;           // one reading, one standard deviation
  TrackerSigma first;          // before the residuals had a say
  int degrees_of_freedom = 0;  // of the repeats that `used` comes from; 0: not from repeats
  double y_over_x = 1;         // of `used`: two axes with an instrument each
  bool rescaled = false;       // the readings say another size than was stated
  bool robust = false;         // heavy tails: far readings are drawn in
  std::optional<PooledNoise> repeats;
  double correlation = 0;  // of successive readings, 0 when it is not significant

  [[nodiscard]] PoseSigma sigma() const { return {used, y_over_x}; }
};

struct NamedParameter {
  std::string name;
  std::string unit;
  double value = 0;
  double std = 0;        // noise, and the choice of the set and its rails (Average)
  bool unusual = false;  // outside the effect's usual range
};

struct NamedEffect {
  std::string name;
  std::vector<int> rails;  // from 1
  std::vector<NamedParameter> parameters;
  std::vector<int> seqs;    // outlier_readings only
  double share_of_gap = 0;  // of chi^2 that the exact fit loses without it, of the sum over effects
  double p = 1;             // of that loss
  std::string sentence;     // what it does on these rails, in the machine's words
};

/// An effect outside the named set, or rails of a named one outside those it was named on, that the
/// average over sets does not rule out.
struct Possible {
  std::string name;
  double probability = 0;                       // weight of the sets that hold it
  std::vector<NamedParameter> parameters = {};  // as the model has it: 0 +- what the average adds
};
inline constexpr double kPossible = 0.02;
/// By open_weight. An effect that is told apart and is not there has some 0.1; one whose signal the
/// named set can imitate has 0.4 and more.
inline constexpr double kOpenPossible = 0.3;
inline constexpr double kSure = 0.95;  // probability below which a named effect is not `explained`

/// A far reading that the noise's own heavy tails explain.
struct FarReading {
  int seq = 0;
  double sigmas = 0;
  std::string why;
};

struct Rival {
  std::vector<std::string> names;
  int parameters = 0;
  double evidence = 0;      // odds for the named set against this one
  bool structural = false;  // these points can't carry the difference
};

/// rms of measured - predicted over x and y per coordinate; nothing when the set has no readings.
struct GapStep {
  std::string model;  // "nominal", "geometry", "+backlash", …
  RobotModel robot;
  std::vector<FreeParameter> parameters;   // fitted in this step; none: nominal
  std::vector<std::optional<double>> std;  // of each (rad, mm, or its own unit); none where the
                                           // readings know only combinations with others
  std::optional<double> identify_rms_mm, validate_rms_mm;
  std::optional<double> identify_rms_deg, validate_rms_deg;
  std::optional<Eigen::Vector3d> identify_rms, validate_rms;  // x, y [mm], phi [rad]; 0: unmeasured
  std::optional<double>
      closed_share;  // of the nominal gap on unseen readings (fitted ones when there are none)
  std::optional<double> closed_low, closed_high;  // 95 %, bootstrap over readings
};

struct PredictedRow {
  int seq = 0;
  Pose pose;
  Eigen::Vector3d std;  // of the model, without a reading's noise
};

struct Diagnosis {
  Verdict verdict = Verdict::unexplained;
  NoiseFloor noise;
  std::vector<AuditRow> audit;
  StructureTest before, after;  // residuals of the base; of base and named effects
  std::vector<NamedEffect> effects;
  std::vector<NamedEffect>
      tried;  // unexplained: the best the catalogue could do, not added to the model
  std::vector<Suspicion> suspect;  // gross mistakes, found before any fit: nothing else is tried
  std::vector<FarReading> suspicious;
  std::vector<Rival> rivals;
  std::vector<Possible> may_also_hold;
  std::vector<Considered> considered;  // sets that lost by more than a rival may
  std::vector<Finding> structure;      // what is left when the verdict is `unexplained`
  std::vector<GapStep> gap;
  RobotModel tried_model;  // unexplained: geometry and `tried`
  std::vector<GapStep>
      gap_tried;  // unexplained: what `tried` closes all the same, from geometry on
  std::vector<AtTarget> by_target;  // of runs from both sides
  NextPoints next;
  std::vector<PredictedRow> predictions;
  GeometryFit fit;    // of the last model of the chain
  BaseDistance base;  // of the geometry, fitted with whatever effects explain the readings best
  std::vector<std::string> notes;  // what could not be tested, what was assumed
};

/// Less the measured readings without a time or a temperature where at least half have one: an
/// empty cell is no reason to leave an effect unseen. Proof: tests/core/diagnose/diagnose_test.cpp.
Campaign with_full_records(Campaign campaign);

/// Runs the workflow on the readings of `campaign`; validation readings enter the gap only.
/// @throws InputError when there are too few readings to identify the base (says how many), or too
/// few replicates to reach the levels
Diagnosis diagnose(const Campaign& campaign, const DiagnoseOptions& options = {});

}  // namespace trammel
