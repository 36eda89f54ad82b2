#include "app/report/budget.hpp"
#include "app/report/print.hpp"
#include "app/report/simulation.hpp"

namespace trammel::report {

namespace {

using Json = nlohmann::ordered_json;

Json summary_json(const Summary& summary) {
  return {{"mean", summary.mean},
          {"max", summary.max},
          {"min", summary.min},
          {"p95", summary.p95},
          {"n", summary.n}};
}

Json optional_json(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json paper_json(const PublishedTable& paper) {
  const auto three = [](const std::vector<double>& v) {
    return Json{{"mean", v[0]}, {"max", v[1]}, {"min", v[2]}};
  };
  return {{"table", paper.table},
          {"in_sample", paper.in_sample},
          {"before", three(paper.before)},
          {"after", three(paper.after)},
          {"improvement_pct", 100 * (1 - paper.after[0] / paper.before[0])}};
}

Json before_after_json(const ErrorTable& table) {
  return {{"before", summary_json(table.before)},
          {"after", summary_json(table.after)},
          {"after_is", table.after_predicted ? "predicted" : "measured"},
          {"improvement_pct", optional_json(table.improvement_pct)}};
}

Json table_json(const ErrorTable& table) {
  Json json = {{"id", table.id},     {"method", table.method}, {"figure", table.figure},
               {"unit", table.unit}, {"set", table.set},       {"in_sample", table.in_sample()}};
  json["judged"] = name_of(table.standing);
  json.update(before_after_json(table));
  if (table.paper) json["paper"] = paper_json(*table.paper);
  if (table.demand) {
    json["demand"] = {{"improvement_pct_at_least", table.demand->improvement_pct},
                      {"floor_ratio_at_most", table.demand->floor_ratio},
                      {"perfect_improvement_pct", table.demand->perfect_pct},
                      {"improvement_within_reach", table.demand->within_reach()},
                      {"reached", table.demand->reached}};
  }
  return json;
}

Json deviation_json(const CircleDeviation& d) {
  return {
      {"centre_x_mm", d.centre_x_mm}, {"centre_y_mm", d.centre_y_mm}, {"radius_mm", d.radius_mm}};
}

Json circles_json(const CircleTable& circles, const std::optional<CircleDeviation>& printed) {
  const ErrorTable& errors = most_unseen(circles);
  Json json = {{"id", "circles"}, {"method", circles.method}, {"figure", "position"},
               {"unit", "mm"},    {"set", errors.set},        {"in_sample", errors.in_sample()}};
  json["judged"] = name_of(errors.standing);
  json.update(before_after_json(errors));
  for (const ErrorTable& other : circles.errors) {
    if (&other == &errors) continue;
    json["others"].push_back(before_after_json(other));
    json["others"].back()["judged"] = name_of(other.standing);
  }
  json["circles"] = Json::array();
  for (const CircleRow& row : circles.rows) {
    json["circles"].push_back({{"name", row.name},
                               {"x_mm", row.x_mm},
                               {"y_mm", row.y_mm},
                               {"radius_mm", row.radius_mm},
                               {"n", row.n},
                               {"before", deviation_json(row.before)},
                               {"after", deviation_json(row.after)}});
  }
  json["mean_abs_before"] = deviation_json(mean_deviation(circles, &CircleRow::before));
  json["mean_abs_after"] = deviation_json(mean_deviation(circles, &CircleRow::after));
  if (printed) json["paper"] = {{"table", "XI"}, {"mean_abs_after", deviation_json(*printed)}};
  return json;
}

/// What is not identified has no number.
std::optional<double> number(const ParameterRow& row, double value) {
  return row.identified ? std::optional<double>(value) : std::nullopt;
}

Json parameters_json(const std::vector<ParameterRow>& rows) {
  Json json = Json::array();
  for (const ParameterRow& row : rows) {
    json.push_back({{"name", row.name},
                    {"unit", row.unit},
                    {"epoch", row.epoch},
                    {"value", optional_json(number(row, row.value))},
                    {"standard_uncertainty", optional_json(number(row, row.standard_uncertainty))},
                    {"identified", row.identified}});
    if (row.paper) json.back()["paper"] = *row.paper;
  }
  return json;
}

Json network_json(const NetworkFit& fit, const std::optional<Published>& published) {
  Json json = {{"neurons", fit.neurons},   {"n", fit.n},
               {"sigma_mm", fit.sigma_mm}, {"mae_mm", fit.mae_mm},
               {"mse_mm2", fit.mse_mm2},   {"in_sample", true}};
  for (const auto& value : fit.r2_pearson) json["r2_pearson"].push_back(optional_json(value));
  for (const auto& value : fit.r2) json["r2"].push_back(optional_json(value));
  if (published && published->network_mae_mm) {
    json["paper"] = {{"table", "VIII"},
                     {"mae_mm", *published->network_mae_mm},
                     {"mse_mm2", optional_json(published->network_mse_mm2)},
                     {"r2_pearson", published->network_r2_pearson}};
  }
  return json;
}

Json tolerance_json(const ToleranceTest& test) {
  Json points = Json::array();
  for (std::size_t k = 0; k < test.verdicts.size(); ++k) {
    const JudgedPoint& p = test.of.points[k];
    points.push_back({{"x_mm", p.x_mm},
                      {"y_mm", p.y_mm},
                      {"error_mm", p.error_mm},
                      {"U_k2_mm", optional_json(p.U_mm)},
                      {"verdict", name_of(test.verdicts[k])}});
  }
  const JudgedPoints& of = test.of;
  return {{"tolerance_mm", test.tolerance_mm},
          {"machine", name_of(test.machine)},
          {"words", tolerance_words(test)},
          {"method", of.method},
          {"session", of.session},
          {"judged", of.method.empty() ? "baseline" : name_of(of.standing)},
          {"error_is", of.predicted ? "predicted" : "measured"},
          {"U_from", of.U_from},
          {"n_passes", test.n(Conformity::passes)},
          {"n_fails", test.n(Conformity::fails)},
          {"n_undecided", test.n(Conformity::undecided)},
          {"points", points}};
}

Json contest_json(const Contest& contest) {
  return {{"a", contest.a},
          {"b", contest.b},
          {"n", contest.n},
          {"b_better", contest.b_better},
          {"mean_difference_mm", contest.mean_difference_mm},
          {"half_width_95_mm", contest.half_width_mm}};
}

Json origin_json(const Report& report) {
  Json sessions = Json::array(), jobs = Json::array(), facts = Json::object();
  for (const SessionRow& s : report.sessions) {
    sessions.push_back({{"name", s.name},
                        {"plan", s.plan},
                        {"compensation", s.compensation},
                        {"n_points", s.n_points},
                        {"n_done", s.n_done},
                        {"n_readings", s.n_readings},
                        {"n_epochs", s.n_epochs}});
  }
  for (const JobRow& j : report.jobs) {
    jobs.push_back({{"id", j.id}, {"stage", j.stage}, {"key", j.key}});
  }
  for (const auto& [key, value] : report.facts) facts[key] = value;
  return {{"sessions", sessions},
          {"jobs", jobs},
          {"exclusions", report.exclusions},
          {"facts", facts},
          {"budget", budget_json(report.budget)},
          {"chain_head", report.chain_head},
          {"taken_over", report.taken_over ? Json{{"from_version", report.taken_over->from_version},
                                                  {"chain_head", report.taken_over->head}}
                                           : Json()}};
}

}  // namespace

nlohmann::ordered_json to_json(const Report& report) {
  Json json = {{"campaign", report.campaign},
               {"kind", report.simulated ? "simulated" : "real"},
               {"imported", report.imported},
               {"verdict", verdict(report)},
               {"n_readings", report.n_readings},
               {"n_excluded", report.n_excluded},
               {"noise", report.noise},
               {"floor_mean_mm", optional_json(report.floor_mean_mm)},
               {"floor_mean_deg", optional_json(report.floor_mean_deg)},
               {"remarks", report.remarks},
               {"tables", Json::array()}};
  for (const ErrorTable& table : report.tables) json["tables"].push_back(table_json(table));
  if (report.circles)
    json["tables"].push_back(circles_json(*report.circles, published_circles(report)));
  if (report.tolerance) json["tolerance"] = tolerance_json(*report.tolerance);
  if (report.contest) json["contest"] = contest_json(*report.contest);
  if (const auto& found = report.identification) {
    json["identification"] = {{"job_key", found->job_key},
                              {"rank", found->rank},
                              {"columns", found->columns},
                              {"sigma_ratio", found->sigma_ratio},
                              {"parameters", parameters_json(found->parameters)},
                              {"combinations", parameters_json(found->combinations)},
                              {"words", found->words}};
  }
  if (!report.simulation.empty()) json["simulation"] = simulation_json(report.simulation);
  if (report.network) json["network"] = network_json(*report.network, report.published);
  if (!report.story.empty()) json["story"] = story_json(report.story);
  json.update(origin_json(report));
  return json;
}

}  // namespace trammel::report
