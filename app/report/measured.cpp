#include "app/report/measured.hpp"

#include <algorithm>

#include "app/job/correction_json.hpp"
#include "store/transaction.hpp"

namespace trammel::report {

namespace {

bool is_circle(const Visit& visit) { return visit.role.starts_with("circle"); }

/// Planned point of each attempt of a session.
std::map<store::Id, store::Point> points_by_attempt(store::Connection& connection,
                                                    store::Id session_id) {
  std::map<int, store::Point> by_seq;
  for (store::Point& point : store::points(connection, session_id)) by_seq[point.seq] = point;
  std::map<store::Id, store::Point> by_attempt;
  for (const store::Attempt& attempt : store::attempts(connection, session_id)) {
    if (attempt.status == "ok") by_attempt[attempt.id] = by_seq[attempt.point_seq];
  }
  return by_attempt;
}

Walk make_walk(store::Connection& connection, const store::SessionRow& session,
               const std::vector<store::StoredReading>& stored) {
  Walk walk{.session = session,
            .n_epochs = static_cast<int>(store::epochs(connection, session.id).size()),
            .visits = {}};
  const auto points = points_by_attempt(connection, session.id);
  for (const store::StoredReading& reading : stored) {
    if (reading.session_id != session.id || !reading.data.reading.measured) continue;
    Visit visit{.point = reading.data.reading.seq, .role = {}, .reading = reading.data.reading};
    if (reading.attempt_id) {
      const auto point = points.find(*reading.attempt_id);
      if (point == points.end()) continue;
      visit.point = point->second.seq;
      visit.role = point->second.role;
      if (visit.role.starts_with("reference")) continue;  // a resume's check, no result
    }
    walk.visits.push_back(std::move(visit));
  }
  return walk;
}

const Walk* walk_under(const Measured& measured, const Group& group, store::Id job_id) {
  const Walk* last = nullptr;
  for (const Walk& walk : measured.walks) {
    const bool same_plan = walk.session.plan_name == group.walk->session.plan_name &&
                           walk.session.n_points == group.walk->session.n_points;
    if (same_plan && walk.session.compensation_job == job_id) last = &walk;
  }
  return last;
}

/// Pairs by planned point; empty when the session has not measured them all yet.
std::vector<Pair> measured_pairs(const Group& group, const Walk& walk) {
  std::vector<Pair> pairs;
  for (const Visit* before : group.visits) {
    const auto after =
        std::find_if(walk.visits.begin(), walk.visits.end(), [before](const Visit& visit) {
          return visit.point == before->point && visit.reading.target == before->reading.target;
        });
    if (after != walk.visits.end()) pairs.push_back({before, *after->reading.measured});
  }
  return pairs;
}

std::vector<Pair> predicted_pairs(const Measured& measured, const Group& group,
                                  const Correction& correction) {
  std::vector<Pair> pairs;
  for (const Visit* before : group.visits) {
    const auto after = predicted_after(correction, measured.campaign.mechanism, before->reading);
    if (after) pairs.push_back({before, *after});
  }
  return pairs;
}

}  // namespace

Measured load_measured(store::Connection& connection, const store::CampaignRow& campaign) {
  Measured measured;
  const store::Snapshot snapshot(connection);
  store::LoadedCampaign loaded = store::load_campaign(connection, campaign.id);
  std::vector<store::StoredReading> stored = store::readings(connection, campaign.id);
  std::erase_if(stored, [&](const store::StoredReading& reading) {
    return std::ranges::find(loaded.exclusions, reading.data.reading.seq, &store::Exclusion::seq) !=
           loaded.exclusions.end();
  });
  for (const store::SessionRow& session : store::list_sessions(connection, campaign.id)) {
    measured.walks.push_back(make_walk(connection, session, stored));
  }
  measured.campaign = std::move(loaded.campaign);
  measured.exclusions = std::move(loaded.exclusions);
  return measured;
}

std::vector<Group> baseline_groups(const Measured& measured) {
  std::vector<Group> groups;
  for (const Walk& walk : measured.walks) {
    if (walk.session.compensation_job) continue;
    const std::size_t first = groups.size();
    for (const Visit& visit : walk.visits) {
      const auto same = [&visit](const Group& group) {
        return group.set == visit.reading.set && group.circles == is_circle(visit);
      };
      auto group =
          std::find_if(groups.begin() + static_cast<std::ptrdiff_t>(first), groups.end(), same);
      if (group == groups.end()) {
        groups.push_back(
            {.walk = &walk, .set = visit.reading.set, .circles = is_circle(visit), .visits = {}});
        group = groups.end() - 1;
      }
      group->visits.push_back(&visit);
    }
  }
  return groups;
}

Paired paired(const Measured& measured, const Group& group, const store::Job& job) {
  if (const Walk* walk = walk_under(measured, group, job.id)) {
    std::vector<Pair> pairs = measured_pairs(group, *walk);
    if (!pairs.empty()) return {.predicted = false, .pairs = std::move(pairs)};
  }
  return {.predicted = true,
          .pairs = predicted_pairs(measured, group, job::correction_of(job.data.result_json))};
}

}  // namespace trammel::report
