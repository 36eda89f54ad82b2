#include "app/report/methods.hpp"

#include <algorithm>

#include "app/job/next_points_plan.hpp"
#include "app/report/report.hpp"

namespace trammel::report {

namespace {

/// A map meets its own samples by construction: only "measured again" says something there.
bool worth_showing(const Comparison& c) {
  const bool map = c.job->data.stage == "idw" || c.job->data.stage == "rbf";
  return !c.paired.pairs.empty() && !(map && c.in_sample && c.paired.predicted);
}

/// The points of a diagnosis were chosen to be hard.
bool asked_for(const Group& group) { return group.walk->session.plan_name == job::kNextPoints; }

}  // namespace

Jobs chosen_jobs(store::Connection& connection, store::Id campaign_id, const Measured& measured) {
  Jobs jobs;
  const auto is_used = [&measured](store::Id id) {
    return std::any_of(measured.walks.begin(), measured.walks.end(),
                       [id](const Walk& walk) { return walk.session.compensation_job == id; });
  };
  for (const store::JobRow& row : store::list_jobs(connection, campaign_id)) {
    const auto known = jobs.find(row.stage);
    if (known != jobs.end()) {
      const bool used = is_used(row.id), known_used = is_used(known->second.id);
      if (known_used && !used) continue;
      if (known_used == used && known->second.id > row.id) continue;
    }
    jobs.insert_or_assign(row.stage, store::get_job(connection, row.id));
  }
  return jobs;
}

std::vector<const store::Job*> in_order(const Jobs& jobs) {
  std::vector<const store::Job*> order;
  const std::vector<std::string> first = {"lsq", "idw", "rbf"};
  for (const std::string& stage : first) {
    if (const auto job = jobs.find(stage); job != jobs.end()) order.push_back(&job->second);
  }
  for (const auto& [stage, job] : jobs) {
    if (std::find(first.begin(), first.end(), stage) == first.end()) order.push_back(&job);
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

bool fitted(const store::Job& job, const Group& group) {
  const auto& sessions = job.data.sessions;
  return group.set == ReadingSet::identify &&
         std::find(sessions.begin(), sessions.end(), group.walk->session.id) != sessions.end();
}

std::vector<Comparison> comparisons(const Measured& measured, const std::vector<Group>& groups,
                                    const std::vector<const store::Job*>& methods) {
  std::vector<Comparison> all;
  for (const Group& group : groups) {
    if (group.circles || asked_for(group)) continue;
    for (const store::Job* job : methods) {
      Comparison c{.group = &group,
                   .job = job,
                   .in_sample = fitted(*job, group),
                   .paired = paired(measured, group, *job)};
      if (worth_showing(c)) all.push_back(std::move(c));
    }
  }
  return all;
}

std::optional<Comparison> circle_comparison(const Measured& measured,
                                            const std::vector<Group>& groups,
                                            const std::vector<const store::Job*>& methods) {
  std::optional<Comparison> chosen;
  for (const Group& group : groups) {
    if (!group.circles || asked_for(group)) continue;
    for (const store::Job* job : methods) {
      Paired pairs = paired(measured, group, *job);
      if (pairs.pairs.size() < 3 || (chosen && pairs.predicted)) continue;
      chosen = {.group = &group, .job = job, .in_sample = false, .paired = std::move(pairs)};
    }
  }
  return chosen;
}

}  // namespace trammel::report
