#pragma once
// A campaign's calibrations as a report compares them.

#include <map>
#include <string>
#include <vector>

#include "app/report/measured.hpp"

namespace trammel::report {

using Jobs = std::map<std::string, store::Job>;  // by stage

/// Per stage the job a session was compensated by, else the newest.
Jobs chosen_jobs(store::Connection& connection, store::Id campaign_id, const Measured& measured);

/// Methods in the paper's order, then the others by name. The pointers live as long as `jobs`.
std::vector<const store::Job*> in_order(const Jobs& jobs);

/// What tables call the method: its stage, or kModel for a diagnosis.
std::string method_of(const store::Job& job);
/// "least squares on the geometry"
std::string method_words(const std::string& method);

/// The job fitted these very readings: figures of them are in-sample.
bool fitted(const store::Job& job, const Group& group);

/// One method on one group of baseline readings.
struct Comparison {
  const Group* group = nullptr;
  const store::Job* job = nullptr;
  bool in_sample = false;
  Paired paired = {};
};

/// Each method on each group that a table compares, in the report's order: circles and the points
/// that a diagnosis asked for are apart, and a map's own samples say something only where they were
/// measured again.
std::vector<Comparison> comparisons(const Measured& measured, const std::vector<Group>& groups,
                                    const std::vector<const store::Job*>& methods);

/// Circles under the job they were measured again with; else predicted by the last method.
std::optional<Comparison> circle_comparison(const Measured& measured,
                                            const std::vector<Group>& groups,
                                            const std::vector<const store::Job*>& methods);

}  // namespace trammel::report
