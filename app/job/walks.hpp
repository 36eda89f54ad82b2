#pragma once
// The walks of a campaign's sessions, and which of them figures are made of.

#include <set>
#include <vector>

#include "core/judge/walk.hpp"
#include "store/campaign.hpp"
#include "store/reading.hpp"
#include "store/session.hpp"

namespace trammel::job {

/// A session's walk: visits less excluded readings, those without a pose and reference points.
struct SessionWalk : Walk {
  store::SessionRow session = {};
  int n_epochs = 0;
  bool counts = false;                       // it stands (core/judge/walk.hpp)
  std::optional<std::size_t> baseline = {};  // of a compensated walk: what it is compared with
};

/// In the order of measurement, from all readings of the campaign (or those until some moment).
std::vector<SessionWalk> walks_of(store::Connection& connection, store::Id campaign,
                                  std::vector<store::StoredReading> stored,
                                  const std::vector<store::Exclusion>& exclusions);

/// Readings of the loaded sessions that no figure is made of: of walks that do not stand (stopped,
/// and walked anew). `as_then`: when the last of the loaded readings was the newest.
/// Proof: speakers_agree_test.cpp.
std::set<int> seqs_of_no_walk(store::Connection& connection, store::Id campaign,
                              const store::LoadedCampaign& loaded, bool as_then);

}  // namespace trammel::job
