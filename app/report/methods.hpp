#pragma once
// A campaign's calibrations as a report compares them.

#include <map>
#include <string>
#include <vector>

#include "app/report/measured.hpp"

namespace trammel::report {

using Jobs = std::map<std::string, store::Job>;  // by stage; "lsq (by name)"

/// Per stage the job a session was compensated by, else the newest; of those whose result can be
/// read (why_not_shown); and the corrections of sessions whose job is not in this database.
/// `left_out` gets a sentence for each that can't.
Jobs chosen_jobs(store::Connection& connection, store::Id campaign_id, const Measured& measured,
                 std::vector<std::string>* left_out = nullptr);

/// Methods in the paper's order, then the others by name. The pointers live as long as `jobs`.
std::vector<const store::Job*> in_order(const Jobs& jobs);

/// What tables call the method: its stage, or kModel for a diagnosis.
std::string method_of(const store::Job& job);
/// "least squares on the geometry"
std::string method_words(const std::string& method);

/// One method on one group of baseline readings, as far as they stand alike to its fit.
struct Comparison {
  const Group* group = nullptr;
  const store::Job* job = nullptr;
  Standing standing = Standing::unseen;
  Paired paired = {};

  [[nodiscard]] bool in_sample() const { return standing == Standing::fitted; }
};

/// The group under the job, whose fit has `seen` (seen_by): a comparison for each standing that it
/// has points of.
std::vector<Comparison> judged(const Measured& measured, const Group& group, const store::Job& job,
                               const Seen& seen);

/// Each method on each group that a table compares, in the report's order: circles and the points
/// that a diagnosis asked for are apart, and a map's own samples say something only where they were
/// measured again.
std::vector<Comparison> comparisons(const Measured& measured, const std::vector<Group>& groups,
                                    const std::vector<const store::Job*>& methods);

/// Circles under the job they were measured again with; else predicted by the last method. One
/// comparison for each standing; none where there are no circles.
std::vector<Comparison> circle_comparison(const Measured& measured,
                                          const std::vector<Group>& groups,
                                          const std::vector<const store::Job*>& methods);

}  // namespace trammel::report
