#include "app/report/gather.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/files/numbers.hpp"
#include "app/report/from_job.hpp"
#include "app/report/methods.hpp"
#include "app/report/remarks.hpp"
#include "app/report/simulation.hpp"
#include "core/judge/deviation.hpp"
#include "core/measure/noise.hpp"
#include "core/plane/circle.hpp"
#include "core/units.hpp"

namespace trammel::report {

namespace {

double error_of(const Pose& measured, const Pose& target, bool position) {
  return position ? position_error_mm(measured, target)
                  : deg_from_rad(attitude_error_rad(measured, target));
}

struct Errors {
  std::vector<double> before, after;
};

Errors errors_of(const std::vector<Pair>& pairs, bool position) {
  Errors errors;
  for (const Pair& pair : pairs) {
    const Reading& reading = pair.before->reading;
    errors.before.push_back(error_of(*reading.measured, reading.target, position));
    errors.after.push_back(error_of(pair.after, reading.target, position));
  }
  return errors;
}

std::optional<Demand> demand_on(const ErrorTable& table, const std::optional<double>& floor_mm) {
  if (table.method != kModel || table.figure != "position" || !floor_mm) return std::nullopt;
  Demand demand;
  const auto better = improvement_pct(table.before, table.after);
  demand.reached = better && *better >= demand.improvement_pct &&
                   table.after.mean <= demand.floor_ratio * *floor_mm;
  return demand;
}

void add_tables(Report& report, const Comparison& c) {
  const Paired& paired = c.paired;
  for (const bool position : {true, false}) {
    const Errors errors = errors_of(paired.pairs, position);
    ErrorTable table;
    table.method = method_of(*c.job);
    table.figure = position ? "position" : "attitude";
    table.unit = position ? "mm" : "deg";
    table.id = fmt::format("{}-{}-{}", table.method, paired.pairs.size(), table.figure);
    const bool taken =
        std::any_of(report.tables.begin(), report.tables.end(),
                    [&table](const ErrorTable& other) { return other.id == table.id; });
    if (taken) table.id += "-" + c.group->walk->session.name;
    table.set = c.group->set == ReadingSet::identify ? "identify" : "validate";
    table.in_sample = c.in_sample;
    table.after_predicted = paired.predicted;
    table.before = summarise(errors.before);
    table.after = summarise(errors.after);
    for (std::size_t k = 0; k < paired.pairs.size(); ++k) {
      const Pose& target = paired.pairs[k].before->reading.target;
      table.points.push_back({target.x_mm, target.y_mm, errors.before[k], errors.after[k]});
    }
    table.paper = paper_figures(table.id);
    table.demand = demand_on(table, report.floor_mean_mm);
    report.tables.push_back(std::move(table));
  }
}

/// Two-sided 95 % of Student's t, by the expansion of Cornish and Fisher in 1/n; to 1 % from n = 5.
double student_95(double degrees) {
  constexpr double z = 1.959963985;
  return z + (z * z * z + z) / (4 * degrees) +
         (5 * std::pow(z, 5) + 16 * z * z * z + 3 * z) / (96 * degrees * degrees);
}

std::optional<Contest> contest_of(const std::string& name_a, const Paired& a,
                                  const std::string& name_b, const Paired& b) {
  if (a.pairs.size() != b.pairs.size() || a.predicted != b.predicted || a.pairs.size() < 5) {
    return std::nullopt;
  }
  const std::vector<double> left_a = errors_of(a.pairs, true).after;
  const std::vector<double> left_b = errors_of(b.pairs, true).after;
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
  contest.half_width_mm = student_95(n - 1) * std::sqrt(squares / (n - 1) / n);
  return contest;
}

CircleDeviation deviation(const FittedCircle& seen, const FittedCircle& wanted) {
  return {seen.x_mm - wanted.x_mm, seen.y_mm - wanted.y_mm, seen.radius_mm - wanted.radius_mm};
}

CircleTable circle_table(const store::Job& job, const Paired& paired) {
  CircleTable table{.method = method_of(job), .after_predicted = paired.predicted};
  const Errors errors = errors_of(paired.pairs, true);
  table.before = summarise(errors.before);
  table.after = summarise(errors.after);
  std::map<std::string, std::vector<const Pair*>> by_role;
  for (const Pair& pair : paired.pairs) by_role[pair.before->role].push_back(&pair);
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
    report.floor_mean_mm = noise_floor_mean_mm(noise.sigma.xy_mm);
    // The mean of |N(0, sigma)|.
    report.floor_mean_deg = deg_from_rad(noise.sigma.phi_rad) * std::sqrt(2 / kPi);
  } catch (const InputError& error) {
    report.noise = error.text().what;
  }
}

std::string mechanism_line(const Mechanism& mechanism) {
  const Chain& c = mechanism.geometry.chains[0];
  return fmt::format(
      "3-PRR: R {:g}, S {:g}, r {:g} mm, screw lead {:g} mm; zeroed at ({:g}, {:g}) mm, {:g} deg",
      c.R_mm, c.S_mm, c.r_mm, mechanism.screw_lead_mm, mechanism.home.x_mm, mechanism.home.y_mm,
      deg_from_rad(mechanism.home.phi_rad));
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
         .compensation = job ? fmt::format("{} (job {})", stages[*job], *job) : "",
         .n_points = walk.session.n_points,
         .n_readings = walk.session.n_readings,
         .n_epochs = walk.n_epochs});
  }
  for (const store::Exclusion& e : measured.exclusions) {
    report.exclusions.push_back(fmt::format("seq {}: {}", e.seq, e.reason));
  }
  for (const auto& fact : measured.campaign.facts) report.facts.push_back(fact);
  report.chain_head = store::hex(store::chain_head(connection, campaign_id));
}

}  // namespace

Report gather(store::Connection& connection, const store::CampaignRow& campaign) {
  const Measured measured = load_measured(connection, campaign);
  const Jobs jobs = chosen_jobs(connection, campaign.id, measured);
  const std::vector<const store::Job*> methods = in_order(jobs);
  Report report{.campaign = campaign.name,
                .simulated = campaign.simulated,
                .imported = campaign.imported,
                .mechanism = mechanism_line(measured.campaign.mechanism),
                .noise = {},
                .n_readings = campaign.n_readings - campaign.n_exclusions,
                .n_excluded = campaign.n_exclusions};
  add_noise(report, measured);
  const std::vector<Group> groups = baseline_groups(measured);
  std::map<const Group*, std::map<std::string, const Paired*>> held_out;
  const std::vector<Comparison> compared = comparisons(measured, groups, methods);
  for (const Comparison& c : compared) {
    add_tables(report, c);
    if (c.job->data.stage == "lsq") {
      report.simulation.push_back(simulation_table(measured, *c.group, *c.job, c.in_sample));
    }
    if (!c.in_sample) held_out[c.group].emplace(c.job->data.stage, &c.paired);
  }
  for (const Group& group : groups) {
    const auto& of = held_out[&group];
    if (!report.contest && of.contains("idw") && of.contains("rbf")) {
      report.contest = contest_of("idw", *of.at("idw"), "rbf", *of.at("rbf"));
    }
  }
  if (const auto circles = circle_comparison(measured, groups, methods)) {
    report.circles = circle_table(*circles->job, circles->paired);
  }
  if (const auto lsq = jobs.find("lsq"); lsq != jobs.end()) {
    report.identification = identification_of(lsq->second);
  }
  if (const auto rbf = jobs.find("rbf"); rbf != jobs.end())
    report.network = network_of(rbf->second);
  if (const auto diagnosis = jobs.find("diagnose"); diagnosis != jobs.end()) {
    report.story = story_of(connection, measured, diagnosis->second);
  }
  report.remarks = remarks_on(report);
  add_origin(report, connection, campaign.id, measured);
  return report;
}

}  // namespace trammel::report
