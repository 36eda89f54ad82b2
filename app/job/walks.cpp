#include "app/job/walks.hpp"

#include <algorithm>
#include <map>

namespace trammel::job {

namespace {

/// A check in between, no result.
bool is_reference(const std::string& role) { return role.starts_with("reference"); }

/// Planned point of each attempt of a session.
std::map<store::Id, store::Point> points_by_attempt(store::Connection& connection,
                                                    const store::Id session_id,
                                                    const std::vector<store::Point>& points) {
  std::map<int, const store::Point*> by_seq;
  for (const store::Point& point : points) by_seq[point.seq] = &point;
  std::map<store::Id, store::Point> by_attempt;
  for (const store::Attempt& attempt : store::attempts(connection, session_id)) {
    if (attempt.status == "ok") by_attempt[attempt.id] = *by_seq[attempt.point_seq];
  }
  return by_attempt;
}

SessionWalk make_walk(store::Connection& connection, const store::SessionRow& session,
                      const std::vector<store::StoredReading>& stored,
                      const std::set<int>& excluded) {
  SessionWalk walk;
  walk.session = session;
  walk.n_epochs = static_cast<int>(store::epochs(connection, session.id).size());
  walk.compensation = session.compensation_job;
  const std::vector<store::Point> plan = store::points(connection, session.id);
  for (const store::Point& point : plan) walk.plan.push_back(point.target);
  const auto points = points_by_attempt(connection, session.id, plan);
  const store::ImportedWalk imported = store::imported_walk(session);
  std::set<int> done;
  for (const store::StoredReading& reading : stored) {
    if (reading.session_id != session.id || !reading.data.reading.measured) continue;
    const bool counts = !excluded.contains(reading.data.reading.seq);
    Visit visit{.point = reading.data.reading.seq, .role = {}, .reading = reading.data.reading};
    if (reading.attempt_id) {
      const auto point = points.find(*reading.attempt_id);
      if (point == points.end()) continue;
      visit.point = point->second.seq;
      visit.role = point->second.role;
    } else if (const auto role = imported.roles.find(visit.point); role != imported.roles.end()) {
      visit.role = role->second;
    }
    done.insert(visit.point);
    if (is_reference(visit.role) || !counts) continue;
    walk.visits.push_back(std::move(visit));
  }
  walk.n_done = static_cast<int>(done.size());
  return walk;
}

/// Of an imported walk the targets are known as far as it went.
void plan_as_walked(SessionWalk& walk, const std::vector<store::StoredReading>& stored) {
  walk.n_asked = walk.session.n_asked;
  std::map<int, int> point_of;
  for (const store::StoredReading& reading : stored) {
    if (reading.session_id != walk.session.id) continue;
    walk.plan.push_back(reading.data.reading.target);
    point_of[reading.data.reading.seq] = static_cast<int>(walk.plan.size());
  }
  for (Visit& visit : walk.visits) visit.point = point_of[visit.reading.seq];
  walk.n_done = static_cast<int>(walk.plan.size());
}

/// A correction that is known by name alone has a number below 0, one a name.
void number_the_named(std::vector<SessionWalk>& walks) {
  std::map<std::string, store::Id> numbers;
  for (SessionWalk& walk : walks) {
    if (!walk.session.compensated() || walk.compensation) continue;
    const auto next = -1 - static_cast<store::Id>(numbers.size());
    walk.compensation = numbers.emplace(walk.session.compensation_name, next).first->second;
  }
}

/// Whether every walk of these is known to be complete, without a look at its readings.
bool all_complete(store::Connection& connection, store::Id campaign,
                  const std::vector<store::Id>& sessions) {
  return std::ranges::all_of(store::list_sessions(connection, campaign),
                             [&](const store::SessionRow& session) {
                               return std::ranges::find(sessions, session.id) == sessions.end() ||
                                      (session.n_asked == 0 && session.n_ok >= session.n_points);
                             });
}

}  // namespace

std::vector<SessionWalk> walks_of(store::Connection& connection, store::Id campaign,
                                  std::vector<store::StoredReading> stored,
                                  const std::vector<store::Exclusion>& exclusions) {
  std::set<int> excluded;
  for (const store::Exclusion& e : exclusions) excluded.insert(e.seq);
  std::vector<SessionWalk> walks;
  for (const store::SessionRow& session : store::list_sessions(connection, campaign)) {
    walks.push_back(make_walk(connection, session, stored, excluded));
    if (session.n_asked > 0) plan_as_walked(walks.back(), stored);
  }
  number_the_named(walks);
  const std::vector<const Walk*> all = [&walks] {
    std::vector<const Walk*> pointers;
    for (const Walk& walk : walks) pointers.push_back(&walk);
    return pointers;
  }();
  for (std::size_t k = 0; k < all.size(); ++k) {
    walks[k].counts = stands(all, k);
    if (all[k]->compensation && walks[k].counts) walks[k].baseline = baseline_of(all, k);
  }
  return walks;
}

std::set<int> seqs_of_no_walk(store::Connection& connection, store::Id campaign,
                              const store::LoadedCampaign& loaded, bool as_then) {
  const std::vector<Reading>& readings = loaded.campaign.readings;
  if (loaded.sessions.size() < 2 || readings.empty()) return {};
  if (!as_then && all_complete(connection, campaign, loaded.sessions)) return {};
  std::vector<store::StoredReading> stored = store::readings(connection, campaign);
  if (as_then) {
    std::erase_if(stored, [last = readings.back().seq](const store::StoredReading& reading) {
      return reading.data.reading.seq > last;
    });
  }
  std::set<int> seqs;
  for (const SessionWalk& walk :
       walks_of(connection, campaign, std::move(stored), loaded.exclusions)) {
    const bool loads = std::ranges::find(loaded.sessions, walk.session.id) != loaded.sessions.end();
    if (!loads || walk.counts) continue;
    for (const Visit& visit : walk.visits) seqs.insert(visit.reading.seq);
  }
  return seqs;
}

}  // namespace trammel::job
