#include "app/report/gather.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "app/files/budget_json.hpp"
#include "app/files/numbers.hpp"
#include "app/files/stored_campaign.hpp"
#include "app/job/run.hpp"
#include "app/job/stages.hpp"
#include "app/report/from_job.hpp"
#include "app/report/job_uncertainty.hpp"
#include "app/report/methods.hpp"
#include "app/report/print.hpp"
#include "app/report/remarks.hpp"
#include "app/report/simulation.hpp"
#include "app/terminal/decimals.hpp"
#include "core/calibrate/map_uncertainty.hpp"
#include "core/judge/before_after.hpp"
#include "core/judge/floor.hpp"
#include "core/measure/noise.hpp"
#include "core/measure/screen.hpp"
#include "core/mechanism/machine_solver.hpp"
#include "core/plane/circle.hpp"
#include "core/statistics/limits.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

std::optional<Demand> demand_on(const ErrorTable& table, const std::optional<double>& floor_mm) {
  if (table.method != kModel || table.figure != "position" || !floor_mm) return std::nullopt;
  if (table.standing == Standing::unknown_epoch) return std::nullopt;
  Demand demand;
  if (!table.improvement_pct) return std::nullopt;
  demand.perfect_pct = 100 * (1 - *floor_mm / table.before.mean);
  const bool better = *table.improvement_pct >= demand.improvement_pct || !demand.within_reach();
  demand.reached = better && table.after.mean <= demand.floor_ratio * *floor_mm;
  return demand;
}

ErrorTable table_of(const Comparison& c, Figure figure) {
  const Errors errors = errors_of(c.paired, figure);
  const bool position = figure == Figure::position_mm;
  ErrorTable table{.method = method_of(*c.job),
                   .figure = position ? "position" : "attitude",
                   .unit = position ? "mm" : "deg",
                   .set = c.group->set == ReadingSet::identify ? "identify" : "validate",
                   .session = c.group->walk->session.name,
                   .job = c.job->id,
                   .standing = c.standing,
                   .after_predicted = c.paired.predicted,
                   .before = errors.summary_before,
                   .after = errors.summary_after};
  if (c.standing != Standing::unknown_epoch) table.improvement_pct = errors.improvement_pct;
  for (std::size_t k = 0; k < c.paired.pairs.size(); ++k) {
    const Pose& target = c.paired.pairs[k].before->reading.target;
    table.points.push_back({target.x_mm, target.y_mm, errors.before[k], errors.after[k]});
  }
  return table;
}

void add_tables(Report& report, const Comparison& c, const Machine& machine) {
  for (const Figure figure : figures_of(machine)) {
    ErrorTable table = table_of(c, figure);
    table.id = fmt::format("{}-{}-{}", table.method, table.before.n, table.figure);
    const bool taken =
        std::any_of(report.tables.begin(), report.tables.end(),
                    [&table](const ErrorTable& other) { return other.id == table.id; });
    if (taken) table.id += "-" + c.group->walk->session.name;
    if (report.published) {
      const auto& printed = report.published->tables;
      const auto at = std::ranges::find(printed, table.id, &PublishedTable::id);
      if (at != printed.end()) table.paper = *at;
    }
    table.demand = demand_on(table, report.floor_mean_mm);
    report.tables.push_back(std::move(table));
  }
}

std::optional<Contest> contest_of(const std::string& name_a, const Paired& a,
                                  const std::string& name_b, const Paired& b) {
  if (a.pairs.size() != b.pairs.size() || a.predicted != b.predicted || a.pairs.size() < 5) {
    return std::nullopt;
  }
  const std::vector<double> left_a = errors_of(a, Figure::position_mm).after;
  const std::vector<double> left_b = errors_of(b, Figure::position_mm).after;
  const double n = static_cast<double>(left_a.size());
  Contest contest{.a = name_a, .b = name_b, .n = static_cast<int>(left_a.size())};
  for (std::size_t k = 0; k < left_a.size(); ++k) {
    contest.mean_difference_mm += (left_a[k] - left_b[k]) / n;
    contest.b_better += left_b[k] < left_a[k] ? 1 : 0;
  }
  double squares = 0;
  for (std::size_t k = 0; k < left_a.size(); ++k) {
    squares += std::pow(left_a[k] - left_b[k] - contest.mean_difference_mm, 2);
  }
  contest.half_width_mm = student_limit(0.05, n - 1) * std::sqrt(squares / (n - 1) / n);
  return contest;
}

CircleDeviation deviation(const FittedCircle& seen, const FittedCircle& wanted) {
  return {seen.x_mm - wanted.x_mm, seen.y_mm - wanted.y_mm, seen.radius_mm - wanted.radius_mm};
}

CircleTable circle_table(const std::vector<Comparison>& comparisons) {
  CircleTable table{.method = method_of(*comparisons.front().job),
                    .after_predicted = comparisons.front().paired.predicted};
  std::map<std::string, std::vector<const Pair*>> by_role;
  for (const Comparison& c : comparisons) {
    table.errors.push_back(table_of(c, Figure::position_mm));
    for (const Pair& pair : c.paired.pairs) by_role[pair.before->role].push_back(&pair);
  }
  for (const auto& [role, pairs] : by_role) {
    std::vector<Place> targets, before, after;
    const auto place = [](const Pose& pose) { return Place{pose.x_mm, pose.y_mm}; };
    for (const Pair* pair : pairs) {
      targets.push_back(place(pair->before->reading.target));
      before.push_back(place(*pair->before->reading.measured));
      after.push_back(place(pair->after));
    }
    const FittedCircle wanted = fit_circle(targets);
    table.rows.push_back({.name = role,
                          .x_mm = rounded(wanted.x_mm, 6),
                          .y_mm = rounded(wanted.y_mm, 6),
                          .radius_mm = rounded(wanted.radius_mm, 6),
                          .n = static_cast<int>(pairs.size()),
                          .before = deviation(fit_circle(before), wanted),
                          .after = deviation(fit_circle(after), wanted)});
  }
  return table;
}

void add_noise(Report& report, const Measured& measured) {
  try {
    const NoiseLevel noise = noise_level(measured.campaign);
    report.noise = noise.words;
    report.floor_mean_mm = perfect_mean_mm(measured.campaign.machine, noise.sigma.xy_mm);
    if (!measured.campaign.machine.measured[2]) return;
    // The mean of |N(0, sigma)|.
    report.floor_mean_deg = deg_from_rad(noise.sigma.phi_rad) * std::sqrt(2 / kPi);
  } catch (const InputError& error) {
    report.noise = error.text().what;
  }
}

std::string machine_line(const Machine& machine) {
  std::vector<double> leads_mm;
  for (int i = 0; i < machine.kind->n_chains; ++i) {
    const double lead_mm = machine.drives[static_cast<std::size_t>(i)].lead_mm;
    if (leads_mm.empty() || lead_mm != leads_mm.front()) leads_mm.push_back(lead_mm);
  }
  std::string text = fmt::format("{}: ", machine.kind->name);
  if (machine.kind->chain == &kPrrChain) {
    const Chain c = geometry_of(machine).chains[0];
    text += fmt::format("R {:g}, S {:g}, r {:g} mm, ", c.R_mm, c.S_mm, c.r_mm);
  }
  text += fmt::format("screw lead {:g} mm; zeroed at ", fmt::join(leads_mm, ", "));
  text += machine.kind->n_chains == 1
              ? fmt::format("{:g} mm", machine.home.x_mm)
              : fmt::format("({:g}, {:g}) mm", machine.home.x_mm, machine.home.y_mm);
  if (machine.kind->has_point_platform()) return text;
  return text + fmt::format(", {:g} deg", deg_from_rad(machine.home.phi_rad));
}

void add_origin(Report& report, store::Connection& connection, store::Id campaign_id,
                const Measured& measured) {
  std::map<store::Id, std::string> stages;
  for (const store::JobRow& job : store::list_jobs(connection, campaign_id)) {
    stages[job.id] = job.stage;
    report.jobs.push_back({job.id, job.stage, job.key});
  }
  for (const Walk& walk : measured.walks) {
    const auto& job = walk.session.compensation_job;
    report.sessions.push_back(
        {.name = walk.session.name,
         .plan = walk.session.plan_name,
         .compensation = job ? fmt::format("{} (job {})", stages[*job], *job)
                         : walk.session.compensated()
                             ? walk.session.compensation_name + " (its job is not stored here)"
                             : "",
         .n_points = std::max(walk.session.n_points, walk.session.n_asked),
         .n_done = walk.n_done,
         .n_readings = walk.session.n_readings,
         .n_epochs = walk.n_epochs,
         .counts = walk.counts});
  }
  for (const store::Exclusion& e : measured.exclusions) {
    report.exclusions.push_back(fmt::format("seq {}: {}", e.seq, e.reason));
  }
  for (const auto& fact : measured.campaign.facts) {
    if (fact.first != kBudgetFact && fact.first != kPublishedFact) report.facts.push_back(fact);
  }
  report.chain_head = store::hex(store::chain_head(connection, campaign_id));
  report.taken_over = store::taken_head(connection, campaign_id);
}

/// Of the correction (job_uncertainty.hpp); nothing of so many readings that a report would wait
/// for it.
std::optional<double> model_u_mm(store::Connection& connection, const Measured& measured,
                                 const store::Job& job, const NoiseLevel& noise) {
  if (is_by_name(job) || job.data.n_readings > static_cast<int>(kMostFieldSamples))
    return std::nullopt;
  return uncertainty_of(connection, measured, job, noise).rms_mm;
}

/// Behind the correction that the headline speaks of.
void add_budget(Report& report, store::Connection& connection, const Measured& measured,
                const std::vector<Comparison>& compared) {
  const ErrorTable* best = best_table(report);
  if (best == nullptr || !report.floor_mean_mm) return;
  const NoiseLevel noise = noise_level(measured.campaign);
  const auto judged = std::ranges::find_if(compared, [best](const Comparison& c) {
    return method_of(*c.job) == best->method && c.standing == best->standing &&
           c.paired.pairs.size() == best->before.n;
  });
  std::optional<double> u_mm;
  if (judged != compared.end()) {
    u_mm = model_u_mm(connection, measured, *judged->job, noise);
  }
  report.budget = budget_of(measured.campaign, budget_facts(measured.campaign), noise, u_mm);
}

/// All errors in mm have as many decimals, and so have those in deg.
void set_decimals(Report& report) {
  for (const bool position : {true, false}) {
    const auto& floor = position ? report.floor_mean_mm : report.floor_mean_deg;
    std::vector<ErrorTable*> tables;
    for (ErrorTable& table : report.tables) {
      if ((table.figure == "position") == position) tables.push_back(&table);
    }
    if (position && report.circles) {
      for (ErrorTable& table : report.circles->errors) tables.push_back(&table);
    }
    double least = floor.value_or(0);
    for (const ErrorTable* table : tables) {
      const double mean = std::min(table->before.mean, table->after.mean);
      if (!(least > 0) || (!floor && mean > 0 && mean < least)) least = mean;
    }
    const int decimals = terminal::decimals_of(least);
    (position ? report.decimals_mm : report.decimals_deg) = decimals;
    for (ErrorTable* table : tables) table->decimals = decimals;
  }
}

/// Which points judge no method, and why.
void add_new_epochs(Report& report, const std::vector<Comparison>& compared) {
  std::map<const Group*, std::pair<std::vector<std::string>, const Comparison*>> by_group;
  for (const Comparison& c : compared) {
    if (c.standing != Standing::unknown_epoch) continue;
    by_group[c.group].first.push_back(method_of(*c.job));
    by_group[c.group].second = &c;
  }
  for (const auto& [group, found] : by_group) {
    std::set<int> epochs;
    for (const Pair& p : found.second->paired.pairs) {
      epochs.insert(p.before->reading.conditions.epoch);
    }
    report.remarks.push_back(fmt::format("{} of {} under {} {}.",
                                         points_in_words(found.second->paired.pairs.size()),
                                         group->walk->session.name, fmt::join(found.first, ", "),
                                         job::new_epoch_words({epochs.begin(), epochs.end()})));
  }
}

}  // namespace

Gathered gather(store::Connection& connection, const store::CampaignRow& campaign) {
  Gathered all;
  const Measured& measured = all.measured = load_measured(connection, campaign);
  std::vector<std::string> left_out;
  const Jobs& jobs = all.jobs = chosen_jobs(connection, campaign.id, measured, &left_out);
  const std::vector<const store::Job*> methods = in_order(jobs);
  Report& report = all.report;
  report.campaign = campaign.name;
  report.simulated = campaign.simulated;
  report.imported = campaign.imported;
  report.mechanism = machine_line(measured.campaign.machine);
  report.n_readings = campaign.n_readings - campaign.n_exclusions;
  report.n_excluded = campaign.n_exclusions;
  report.published = published_of(measured.campaign);
  add_noise(report, measured);
  const std::vector<Group>& groups = all.groups = baseline_groups(measured);
  std::map<const Group*, std::map<std::string, const Paired*>> held_out;
  all.comparisons = comparisons(measured, groups, methods);
  for (const Comparison& c : all.comparisons) {
    add_tables(report, c, measured.campaign.machine);
    if (c.job->data.stage == "lsq" && !is_by_name(*c.job)) {
      report.simulation.push_back(simulation_table(measured, c));
    }
    if (c.standing == Standing::unseen) held_out[c.group].emplace(c.job->data.stage, &c.paired);
  }
  all.circles = circle_comparison(measured, groups, methods);
  if (!all.circles.empty()) report.circles = circle_table(all.circles);
  set_decimals(report);
  for (const Group& group : groups) {
    const auto& of = held_out[&group];
    if (!report.contest && of.contains("idw") && of.contains("rbf")) {
      report.contest = contest_of("idw", *of.at("idw"), "rbf", *of.at("rbf"));
    }
  }
  if (const auto contest = jobs.find("contest"); contest != jobs.end()) {
    report.picked = picked_of(contest->second);
  }
  if (const auto lsq = jobs.find("lsq"); lsq != jobs.end()) {
    report.identification = identification_of(lsq->second);
    if (report.published) {
      for (ParameterRow& row : report.identification->parameters) {
        const auto printed = report.published->parameters.find(row.name);
        if (printed != report.published->parameters.end()) row.paper = printed->second;
      }
    }
  }
  if (const auto rbf = jobs.find("rbf"); rbf != jobs.end())
    report.network = network_of(rbf->second);
  if (const auto diagnosis = jobs.find("diagnose"); diagnosis != jobs.end()) {
    report.story = story_of(connection, measured, diagnosis->second);
  }
  add_origin(report, connection, campaign.id, measured);
  add_budget(report, connection, measured, all.comparisons);
  report.remarks = remarks_on(report);
  report.remarks.insert(report.remarks.end(), left_out.begin(), left_out.end());
  for (const Suspicion& s : screened(stored_campaign(connection, campaign))) {
    if (rule_of(s.kind).gravity != Gravity::remark)
      report.remarks.push_back("The screen: " + in_words(s) + ".");
  }
  add_new_epochs(report, all.comparisons);
  return all;
}

}  // namespace trammel::report
