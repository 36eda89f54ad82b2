#pragma once
// A campaign's readings, sorted for comparing: by session and by planned point.

#include <map>
#include <string>
#include <vector>

#include "store/campaign.hpp"
#include "store/job.hpp"
#include "store/session.hpp"

namespace trammel::report {

/// One measured point. `point` pairs the same target of two sessions that walked one plan.
struct Visit {
  int point = 0;
  std::string role;  // "circle 1"
  Reading reading;
};

/// The visits of one session, less excluded readings and those without a pose.
struct Walk {
  store::SessionRow session;
  int n_epochs = 0;
  std::vector<Visit> visits;
};

struct Measured {
  Campaign campaign;
  std::vector<Walk> walks;  // in the order of measurement
  std::vector<store::Exclusion> exclusions;
};

Measured load_measured(store::Connection& connection, const store::CampaignRow& campaign);

/// Points of a baseline session that belong together: all of one set, circles apart.
struct Group {
  const Walk* walk = nullptr;
  ReadingSet set = ReadingSet::identify;
  bool circles = false;
  std::vector<const Visit*> visits;
};
std::vector<Group> baseline_groups(const Measured& measured);

/// One point before and after a correction.
struct Pair {
  const Visit* before = nullptr;
  Pose after = {};
};

/// The group's points under the correction of `job`: measured again where a session did so.
struct Paired {
  bool predicted = false;
  std::vector<Pair> pairs;
};
Paired paired(const Measured& measured, const Group& group, const store::Job& job);

}  // namespace trammel::report
