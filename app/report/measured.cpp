#include "app/report/measured.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "app/job/correction_json.hpp"
#include "app/job/run.hpp"
#include "store/transaction.hpp"

namespace trammel::report {

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

Walk make_walk(store::Connection& connection, const store::SessionRow& session,
               const std::vector<store::StoredReading>& stored) {
  Walk walk;
  walk.session = session;
  walk.n_epochs = static_cast<int>(store::epochs(connection, session.id).size());
  walk.compensation = session.compensation_job;
  walk.n_done = session.n_ok;
  const std::vector<store::Point> plan = store::points(connection, session.id);
  for (const store::Point& point : plan) walk.plan.push_back(point.target);
  const auto points = points_by_attempt(connection, session.id, plan);
  const store::ImportedWalk imported = store::imported_walk(session);
  for (const store::StoredReading& reading : stored) {
    if (reading.session_id != session.id || !reading.data.reading.measured) continue;
    Visit visit{.point = reading.data.reading.seq, .role = {}, .reading = reading.data.reading};
    if (reading.attempt_id) {
      const auto point = points.find(*reading.attempt_id);
      if (point == points.end()) continue;
      visit.point = point->second.seq;
      visit.role = point->second.role;
    } else if (const auto role = imported.roles.find(visit.point); role != imported.roles.end()) {
      visit.role = role->second;
    }
    if (is_reference(visit.role)) continue;
    walk.visits.push_back(std::move(visit));
  }
  return walk;
}

/// Of an imported walk the targets are known as far as it went.
void plan_as_walked(Walk& walk, const std::vector<store::SessionReading>& stored) {
  walk.n_asked = walk.session.n_asked;
  std::map<int, int> point_of;
  for (const auto& [session, reading] : stored) {
    if (session != walk.session.id) continue;
    walk.plan.push_back(reading.target);
    point_of[reading.seq] = static_cast<int>(walk.plan.size());
  }
  for (Visit& visit : walk.visits) visit.point = point_of[visit.reading.seq];
  walk.n_done = static_cast<int>(walk.plan.size());
}

/// A correction that is known by name alone has a number below 0, one a name.
void number_the_named(std::vector<Walk>& walks) {
  std::map<std::string, store::Id> numbers;
  for (Walk& walk : walks) {
    if (!walk.session.compensated() || walk.compensation) continue;
    const auto next = -1 - static_cast<store::Id>(numbers.size());
    walk.compensation = numbers.emplace(walk.session.compensation_name, next).first->second;
  }
}

/// The group as a complete walk under the job found it again; nothing where none did.
std::vector<Pair> measured_pairs(const Measured& measured, const Group& group, store::Id job_id) {
  std::vector<Pair> best;
  for (const Walk& walk : measured.walks) {
    if (walk.compensation != job_id || !walk.counts) continue;
    if (!walk.baseline || &measured.walks[*walk.baseline] != group.walk) continue;
    std::vector<Pair> pairs;
    for (const auto& [before, after] :
         pair_visits(group.visits, walk.visits, same_plan(*group.walk, walk))) {
      pairs.push_back({group.visits[before], *walk.visits[after].reading.measured});
    }
    if (pairs.size() >= best.size()) best = std::move(pairs);
  }
  return best;
}

std::vector<Pair> predicted_pairs(const Measured& measured, const Group& group,
                                  const Correction& correction) {
  std::vector<Pair> pairs;
  const NominalMachine machine(measured.campaign.machine);
  for (const Visit* before : group.visits) {
    const auto after = predicted_after(correction, machine, before->reading);
    if (after) pairs.push_back({before, machine.measured_else(*after, before->reading.target)});
  }
  return pairs;
}

}  // namespace

Measured load_measured(store::Connection& connection, const store::CampaignRow& campaign) {
  Measured measured;
  const store::Snapshot snapshot(connection);
  store::LoadedCampaign loaded = store::load_campaign(connection, campaign.id);
  std::vector<store::StoredReading> stored = store::readings(connection, campaign.id);
  for (const store::StoredReading& reading : stored) {
    measured.stored.push_back({reading.session_id, reading.data.reading});
  }
  std::erase_if(stored, [&](const store::StoredReading& reading) {
    return std::ranges::find(loaded.exclusions, reading.data.reading.seq, &store::Exclusion::seq) !=
           loaded.exclusions.end();
  });
  measured.held = store::held_epochs(connection, campaign.id);
  for (const store::SessionRow& session : store::list_sessions(connection, campaign.id)) {
    measured.walks.push_back(make_walk(connection, session, stored));
    if (session.n_asked > 0) plan_as_walked(measured.walks.back(), measured.stored);
  }
  number_the_named(measured.walks);
  std::vector<const trammel::Walk*> walks;
  for (const Walk& walk : measured.walks) walks.push_back(&walk);
  for (std::size_t k = 0; k < walks.size(); ++k) {
    measured.walks[k].counts = stands(walks, k);
    if (walks[k]->compensation && measured.walks[k].counts) {
      measured.walks[k].baseline = baseline_of(walks, k);
    }
  }
  measured.campaign = std::move(loaded.campaign);
  const NominalMachine machine(measured.campaign.machine);
  for (Walk& walk : measured.walks) {  // what is not measured is no error
    for (Visit& visit : walk.visits) {
      visit.reading.measured = machine.measured_else(*visit.reading.measured, visit.reading.target);
    }
  }
  measured.exclusions = std::move(loaded.exclusions);
  return measured;
}

std::vector<store::Job> corrections_by_name(const Measured& measured, store::Id campaign_id) {
  std::vector<store::Job> all;
  std::vector<store::Id> baselines;
  for (const Walk& walk : measured.walks) {
    if (!walk.compensation) baselines.push_back(walk.session.id);
  }
  for (const Walk& walk : measured.walks) {
    const store::Id id = walk.compensation.value_or(0);
    if (id >= 0 || std::ranges::find(all, id, &store::Job::id) != all.end()) continue;
    all.push_back({.id = id,
                   .created_utc = {},
                   .provenance = {},
                   .data = {.campaign_id = campaign_id,
                            .stage = walk.session.compensation_name,
                            .n_readings = static_cast<int>(measured.stored.size()),
                            .sessions = baselines}});
  }
  return all;
}

Seen seen_by(const Measured& measured, const store::Job& job) {
  const auto has = [](const std::vector<store::Id>& ids, store::Id id) {
    return std::ranges::find(ids, id) != ids.end();
  };
  std::set<int> honoured;
  for (const store::Exclusion& e : measured.exclusions) {
    if (has(job.data.exclusions, e.id)) honoured.insert(e.seq);
  }
  std::vector<Reading> taken;
  int n = 0;
  for (const auto& [session, reading] : measured.stored) {
    if (!has(job.data.sessions, session) || honoured.contains(reading.seq)) continue;
    if (n++ == job.data.n_readings) break;  // what came later it did not see
    if (reading.set == ReadingSet::identify && reading.measured) taken.push_back(reading);
  }
  return Seen(taken, measured.held, job::is_one_set_up(job::Json::parse(job.data.parameters_json)));
}

std::vector<Group> baseline_groups(const Measured& measured) {
  std::vector<Group> groups;
  for (const Walk& walk : measured.walks) {
    if (walk.compensation || !walk.counts) continue;
    const std::size_t first = groups.size();
    for (const Visit& visit : walk.visits) {
      const auto same = [&visit](const Group& group) {
        return group.set == visit.reading.set && group.circles == on_circle(visit);
      };
      auto group =
          std::find_if(groups.begin() + static_cast<std::ptrdiff_t>(first), groups.end(), same);
      if (group == groups.end()) {
        groups.push_back(
            {.walk = &walk, .set = visit.reading.set, .circles = on_circle(visit), .visits = {}});
        group = groups.end() - 1;
      }
      group->visits.push_back(&visit);
    }
  }
  return groups;
}

Paired paired(const Measured& measured, const Group& group, const store::Job& job) {
  std::vector<Pair> again = measured_pairs(measured, group, job.id);
  if (!again.empty() || is_by_name(job)) return {.predicted = false, .pairs = std::move(again)};
  return {.predicted = true,
          .pairs = predicted_pairs(measured, group, job::correction_of(job.data.result_json))};
}

Paired of_standing(const Paired& paired, const Seen& seen, Standing standing) {
  Paired some{.predicted = paired.predicted, .pairs = {}};
  for (const Pair& pair : paired.pairs) {
    const Reading& before = pair.before->reading;
    const Standing its = paired.predicted ? seen.standing(before) : seen.standing(before.target);
    if (its == standing) some.pairs.push_back(pair);
  }
  return some;
}

Errors errors_of(const Paired& paired, Figure figure) {
  std::vector<BeforeAfter> points;
  for (const Pair& pair : paired.pairs) {
    const Reading& reading = pair.before->reading;
    points.push_back({reading.target, *reading.measured, pair.after});
  }
  return errors_in(figure, points);
}

}  // namespace trammel::report
