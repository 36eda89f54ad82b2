#pragma once
// What a correction does to the readings of its campaign, point by point: figures and words.

#include <set>
#include <string>
#include <vector>

#include "app/job/json.hpp"
#include "core/calibrate/correction.hpp"
#include "core/judge/before_after.hpp"
#include "core/judge/seen.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// A reading before, and as predicted after the correction.
struct Judged {
  int seq = 0;
  ReadingSet set = ReadingSet::identify;
  int epoch = 0;
  Standing standing = Standing::unseen;
  BeforeAfter point;
};

/// By what readings are judged.
struct JudgedBy {
  const Seen& seen;
  std::set<int> of_no_walk = {};  // seqs that judge nothing
  bool leaves_out = false;        // the stage names readings that can't be, and goes on without
};

/// Every measured reading of the walks that stand, with its place in the judgement. Throws
/// InputError as predicted_after, and where the corrected robot can't reach a target.
/// Proof for all of this file: speakers_agree_test.cpp, run_test.cpp.
std::vector<Judged> judge(const Campaign& campaign, const JudgedBy& by,
                          const Correction& correction);

std::vector<store::Statistic> statistics(const Machine& machine, const std::vector<Judged>& judged);

/// Interval of each improvement.
Json improvements(const std::vector<Judged>& judged);
std::vector<std::string> improvement_words(const Json& improvements);

/// A warning where the correction is judged beyond the points it was fitted to.
std::vector<std::string> range_words(const std::vector<Judged>& judged);

/// Where validation points stand on fitted ones or in epochs of their own, where nothing is held
/// out, and how many readings are of no walk.
std::vector<std::string> held_out_words(const std::vector<Judged>& judged, std::size_t of_no_walk);

/// "in-sample 0.2063 -> 0.0943 mm, held-out …": means of the position error.
std::string gains_in_words(const std::vector<Judged>& judged);

/// Set of the statistics over validation readings in epochs that the fit knows nothing of.
inline constexpr const char* kNewEpoch = "new epoch";
/// "were measured in epoch 2, of which no reading was fitted: …", to follow what was.
std::string new_epoch_words(const std::vector<int>& epochs);

}  // namespace trammel::job
