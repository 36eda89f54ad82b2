#pragma once

#include <vector>

#include "app/report/methods.hpp"
#include "app/report/report.hpp"
#include "store/campaign.hpp"

namespace trammel::report {

/// A report and what it was made of: comparisons point into groups and jobs, groups into walks.
struct Gathered {
  Measured measured;
  Jobs jobs;
  std::vector<Group> groups;
  std::vector<Comparison> comparisons;
  std::vector<Comparison> circles;  // one for each standing
  Report report;

  Gathered() = default;
  Gathered(Gathered&&) = default;
  Gathered& operator=(Gathered&&) = default;  // a copy would point into the original
};

/// The report of a stored campaign, from its sessions and jobs as they are now.
///
/// Per method the job is the one a session was compensated by, else the newest. "before" are the
/// readings of a baseline session; "after" those of the complete session under the method's job
/// that is compared with it (core/judge/walk.hpp), point by point. Where there is none (an imported
/// campaign), after is predicted from the readings before, and says so. In-sample: the fit was made
/// at these targets (core/judge/seen.hpp). All methods are judged on the same baseline. Proof:
/// report_test.cpp, speakers_agree_test.cpp.
Gathered gather(store::Connection& connection, const store::CampaignRow& campaign);

}  // namespace trammel::report
