#include "app/report/measured.hpp"

#include <algorithm>
#include <set>

#include "app/job/correction_json.hpp"
#include "app/job/run.hpp"
#include "store/transaction.hpp"

namespace trammel::report {

namespace {

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
    // what no such robot can have read predicts nothing: the screen names it
    if (!machine.chains(*before->reading.measured).ok()) continue;
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
  measured.held = store::held_epochs(connection, campaign.id);
  measured.walks = job::walks_of(connection, campaign.id, std::move(stored), loaded.exclusions);
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
