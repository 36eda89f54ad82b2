#pragma once
// What differs between two jobs, and what made one stale.

#include <string>
#include <vector>

#include "app/job/stages.hpp"
#include "store/job.hpp"

namespace trammel::job {

/// The places where two JSON values differ, as [{"path", "a", "b"}, …]: objects by key, arrays of
/// equal length by index, all else whole. A side that has nothing there is null. Equal: empty.
/// Proof: diff_test.cpp.
Json json_differences(const Json& a, const Json& b);

/// Parts of the key that differ, as [{"part", "then", "now"}, …].
Json changed_parts(const store::JobKey& then, const store::JobKey& now);

/// Only what differs between two stored jobs: parts of the key, parameters by path, exclusions that
/// one of them honoured, figures of the statistics, and the readings whose pose error after the
/// correction differs (position in mm, attitude in deg). Proof: diff_test.cpp.
Json job_differences(store::Connection& connection, const store::Job& a, const store::Job& b);
std::string job_differences_text(const Json& differences);

/// One sentence for each changed input of `job`: which readings came, which exclusions, which
/// parameter or version. Empty: running it again reuses it.
std::vector<std::string> stale_words(store::Connection& connection, const store::Job& job,
                                     const store::NewJob& now);

/// What a computation must repeat bit for bit: the result (times that were taken aside) with every
/// point, and every statistic.
std::string outcome_text(const store::NewJob& job);
/// Equal outcome_text.
bool same_outcome(const store::NewJob& a, const store::NewJob& b);

}  // namespace trammel::job
