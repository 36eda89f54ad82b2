#include "app/report/methods.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/job/next_points_plan.hpp"
#include "app/report/from_job.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

namespace {

/// A map meets its own samples by construction: only "measured again" says something there.
bool worth_showing(const Comparison& c) {
  const bool map = c.job->data.stage == "idw" || c.job->data.stage == "rbf";
  return !(map && c.in_sample() && c.paired.predicted);
}

/// The points of a diagnosis were chosen to be hard.
bool asked_for(const Group& group) { return group.walk->session.plan_name == job::kNextPoints; }

}  // namespace

Jobs chosen_jobs(store::Connection& connection, store::Id campaign_id, const Measured& measured,
                 std::vector<std::string>* left_out) {
  Jobs jobs;
  const auto is_used = [&measured](store::Id id) {
    return std::ranges::any_of(
        measured.walks, [id](const Walk& walk) { return walk.counts && walk.compensation == id; });
  };
  for (const store::JobRow& row : store::list_jobs(connection, campaign_id)) {
    const auto known = jobs.find(row.stage);
    if (known != jobs.end()) {
      const bool used = is_used(row.id), known_used = is_used(known->second.id);
      if (known_used && !used) continue;
      if (known_used == used && known->second.id > row.id) continue;
    }
    store::Job job = store::get_job(connection, row.id);
    if (const std::string why = why_not_shown(job); !why.empty()) {
      if (left_out != nullptr) {
        left_out->push_back(fmt::format(
            "Job {} ({}, version {}) is left out: its result is not of a form that this program "
            "reads ({}). `trammel job rerun {}` computes it anew.",
            row.id, row.stage, job.data.algorithm_version, why, row.id));
      }
      continue;
    }
    jobs.insert_or_assign(row.stage, std::move(job));
  }
  for (store::Job& job : corrections_by_name(measured, campaign_id)) {
    if (!is_used(job.id)) continue;
    jobs.emplace(job.data.stage + " (by name)", std::move(job));
  }
  return jobs;
}

std::vector<const store::Job*> in_order(const Jobs& jobs) {
  std::vector<const store::Job*> order;
  const std::vector<std::string> first = {"lsq", "idw", "rbf"};
  for (const std::string& stage : first) {
    for (const auto& [key, job] : jobs) {
      if (job.data.stage == stage) order.push_back(&job);
    }
  }
  for (const auto& [key, job] : jobs) {
    if (std::ranges::find(first, job.data.stage) == first.end()) order.push_back(&job);
  }
  return order;
}

std::string method_of(const store::Job& job) {
  return job.data.stage == "diagnose" ? kModel : job.data.stage;
}

std::string method_words(const std::string& method) {
  if (method == "lsq") return "least squares on the geometry";
  if (method == "idw") return "inverse distance weighting";
  if (method == "rbf") return "the radial basis network";
  if (method == kModel) return "the geometry with the named effects";
  return method;
}

std::vector<Comparison> judged(const Measured& measured, const Group& group, const store::Job& job,
                               const Seen& seen) {
  const Paired all = paired(measured, group, job);
  std::vector<Comparison> found;
  for (const Standing standing : {Standing::fitted, Standing::unseen, Standing::unknown_epoch}) {
    Paired some = of_standing(all, seen, standing);
    if (some.pairs.empty()) continue;
    found.push_back(
        {.group = &group, .job = &job, .standing = standing, .paired = std::move(some)});
  }
  return found;
}

std::vector<Comparison> comparisons(const Measured& measured, const std::vector<Group>& groups,
                                    const std::vector<const store::Job*>& methods) {
  std::vector<Comparison> all;
  std::vector<Seen> seen;
  for (const store::Job* job : methods) seen.push_back(seen_by(measured, *job));
  for (const Group& group : groups) {
    if (group.circles || asked_for(group)) continue;
    for (std::size_t k = 0; k < methods.size(); ++k) {
      for (Comparison& c : judged(measured, group, *methods[k], seen[k])) {
        if (worth_showing(c)) all.push_back(std::move(c));
      }
    }
  }
  return all;
}

std::vector<Comparison> circle_comparison(const Measured& measured,
                                          const std::vector<Group>& groups,
                                          const std::vector<const store::Job*>& methods) {
  constexpr std::size_t kLeastOfACircle = 3;  // points
  std::vector<Comparison> chosen;
  for (const Group& group : groups) {
    if (!group.circles || asked_for(group)) continue;
    for (const store::Job* job : methods) {
      std::vector<Comparison> found = judged(measured, group, *job, seen_by(measured, *job));
      std::size_t n = 0;
      for (const Comparison& c : found) n += c.paired.pairs.size();
      if (n < kLeastOfACircle) continue;
      if (!chosen.empty() && found.front().paired.predicted) continue;
      chosen = std::move(found);
    }
  }
  return chosen;
}

}  // namespace trammel::report
