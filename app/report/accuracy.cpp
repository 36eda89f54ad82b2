#include "app/report/accuracy.hpp"

#include <algorithm>
#include <map>

#include "app/job/run.hpp"
#include "app/report/methods.hpp"
#include "store/transaction.hpp"

namespace trammel::report {

namespace {

store::Cell cell(const std::optional<double>& value) {
  return value ? store::Cell(*value) : store::Cell(nullptr);
}

/// The columns up to the figures; then those.
struct AccuracyRow {
  const store::CampaignRow& campaign;
  std::string session, method, source, set, metric;
  bool in_sample = false;
  store::Summary before = {}, after = {};
  std::optional<double> improvement_pct = {};
};

std::vector<store::Cell> cells(const AccuracyRow& row) {
  std::vector<store::Cell> all = {row.campaign.name,
                                  std::string(row.campaign.simulated ? "simulated" : "real"),
                                  row.session,
                                  row.method,
                                  row.source,
                                  row.set,
                                  row.metric,
                                  std::int64_t{row.in_sample},
                                  std::int64_t{row.before.n}};
  for (const store::Summary& s : {row.before, row.after}) {
    for (const double value : {s.mean, s.max, s.min, s.p95}) all.emplace_back(value);
  }
  all.push_back(cell(row.improvement_pct));
  return all;
}

store::Summary stored_summary(const Summary& s) {
  return {.mean = s.mean, .max = s.max, .min = s.min, .p95 = s.p95, .n = static_cast<int>(s.n)};
}

void add_measured(store::Connection& connection, const store::CampaignRow& campaign,
                  const Measured& measured, store::ComputedTable& table) {
  const std::vector<store::Job> named = corrections_by_name(measured, campaign.id);
  for (const Walk& walk : measured.walks) {
    if (!walk.counts || !walk.baseline) continue;
    const Walk& baseline = measured.walks[*walk.baseline];
    const auto by_name = std::ranges::find(named, *walk.compensation, &store::Job::id);
    const store::Job job =
        by_name != named.end() ? *by_name : store::get_job(connection, *walk.compensation);
    const Seen seen = seen_by(measured, job);
    std::vector<const Visit*> before;
    for (const Visit& visit : baseline.visits) before.push_back(&visit);
    std::map<std::pair<ReadingSet, Standing>, std::vector<BeforeAfter>> sets;
    for (const auto& [b, a] : pair_visits(before, walk.visits, same_plan(baseline, walk))) {
      const Reading& reading = before[b]->reading;
      sets[{reading.set, seen.standing(reading.target)}].push_back(
          {reading.target, *reading.measured, *walk.visits[a].reading.measured});
    }
    for (const auto& [key, points] : sets) {
      std::vector<Figure> figures = figures_of(measured.campaign.machine);
      std::ranges::reverse(figures);  // by name
      for (const Figure figure : figures) {
        const Errors errors = errors_in(figure, points);
        table.rows.push_back(
            cells({.campaign = campaign,
                   .session = walk.session.name,
                   .method = job.data.stage,
                   .source = "measured",
                   .set = store::name_of(key.first),
                   .metric = figure == Figure::position_mm ? "position_mm" : "attitude_deg",
                   .in_sample = key.second == Standing::fitted,
                   .before = stored_summary(errors.summary_before),
                   .after = stored_summary(errors.summary_after),
                   .improvement_pct = errors.improvement_pct}));
      }
    }
  }
}

void add_predicted(store::Connection& connection, const store::CampaignRow& campaign,
                   const Measured& measured, store::ComputedTable& table) {
  std::map<store::Id, std::string> names;
  for (const Walk& walk : measured.walks) names[walk.session.id] = walk.session.name;
  for (const store::JobRow& row : store::list_jobs(connection, campaign.id)) {
    const store::Job job = store::get_job(connection, row.id);
    std::string sessions;
    for (const store::Id id : job.data.sessions) {
      sessions += (sessions.empty() ? "" : " ") + names[id];
    }
    for (const store::Statistic& s : job.data.statistics) {
      if (!s.before || !s.after) continue;
      std::optional<double> better;
      if (s.set != job::kNewEpoch) {
        better = improvement_pct({.mean = s.before->mean}, {.mean = s.after->mean});
      }
      table.rows.push_back(cells({.campaign = campaign,
                                  .session = sessions,
                                  .method = job.data.stage,
                                  .source = "predicted",
                                  .set = s.set,
                                  .metric = s.metric,
                                  .in_sample = s.in_sample,
                                  .before = *s.before,
                                  .after = *s.after,
                                  .improvement_pct = better}));
    }
  }
}

}  // namespace

store::ComputedTable accuracy(store::Connection& connection) {
  store::ComputedTable table{
      .name = "v_accuracy",
      .columns = {"campaign", "kind", "session", "method", "source", "reading_set", "metric",
                  "in_sample", "n", "before_mean", "before_max", "before_min", "before_p95",
                  "after_mean", "after_max", "after_min", "after_p95", "improvement_pct"},
      .rows = {}};
  const store::Snapshot snapshot(connection);
  for (const store::CampaignRow& campaign : store::list_campaigns(connection)) {
    const Measured measured = load_measured(connection, campaign);
    add_measured(connection, campaign, measured, table);
    add_predicted(connection, campaign, measured, table);
  }
  return table;
}

}  // namespace trammel::report
