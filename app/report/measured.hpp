#pragma once
// A campaign's readings, sorted for comparing: by session and by planned point.

#include <vector>

#include "app/job/walks.hpp"
#include "core/judge/before_after.hpp"
#include "core/judge/seen.hpp"
#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/session.hpp"

namespace trammel::report {

using Walk = job::SessionWalk;

struct Measured {
  Campaign campaign;
  std::vector<Walk> walks;  // in the order of measurement
  std::vector<store::Exclusion> exclusions;
  HeldEpochs held;
  std::vector<store::SessionReading> stored;  // all readings by seq, excluded ones too
};

Measured load_measured(store::Connection& connection, const store::CampaignRow& campaign);

/// Corrections that sessions had whose job is not in this database (they were imported): a job by
/// name, with a number below 0 (Walk::compensation) and no result. Its fit is taken to have seen
/// the identify readings of the baselines, as the exchange format has it: validate rows are never
/// fitted.
std::vector<store::Job> corrections_by_name(const Measured& measured, store::Id campaign_id);
inline bool is_by_name(const store::Job& job) { return job.id < 0; }

/// What the fit of a job of this campaign has seen: the readings that it took, as they were then.
Seen seen_by(const Measured& measured, const store::Job& job);

/// Points of a baseline session that belong together: all of one set, circles apart.
struct Group {
  const Walk* walk = nullptr;
  ReadingSet set = ReadingSet::identify;
  bool circles = false;
  std::vector<const Visit*> visits;
};
/// Of the sessions that stand.
std::vector<Group> baseline_groups(const Measured& measured);

/// One point before and after a correction.
struct Pair {
  const Visit* before = nullptr;
  Pose after = {};
};

/// The group's points under the correction of `job`: measured again where a complete session did so
/// (that which shares most of them, of equals the last), else predicted.
struct Paired {
  bool predicted = false;
  std::vector<Pair> pairs;
};
Paired paired(const Measured& measured, const Group& group, const store::Job& job);

/// Its pairs that stand alike.
Paired of_standing(const Paired& paired, const Seen& seen, Standing standing);

/// Errors of the pairs. Throws InputError where there are none.
Errors errors_of(const Paired& paired, Figure figure);

}  // namespace trammel::report
