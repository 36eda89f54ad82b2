#include "app/job/text.hpp"
#include "app/report/assess/assessment.hpp"
#include "app/report/budget.hpp"
#include "core/units.hpp"

namespace trammel::assess {

namespace {

using Json = nlohmann::ordered_json;

Json summary_json(const Summary& s, double unit = 1) {
  return {{"mean", unit * s.mean},
          {"p95", unit * s.p95},
          {"max", unit * s.max},
          {"min", unit * s.min},
          {"n", s.n}};
}

Json symbol_json(const IsoSymbol& s) {
  const double unit = s.is_angle ? deg_from_rad(1) : 1;
  Json json = {{"symbol", s.name},
               {"unit", s.is_angle ? "deg" : "mm"},
               {"value", s.value ? Json(unit * *s.value) : Json()},
               {"refused", !s.value}};
  if (s.floor) json["floor"] = unit * *s.floor;
  if (!s.reason.empty()) json["reason"] = s.reason;
  return json;
}

Json symbols_json(const std::vector<IsoSymbol>& symbols) {
  Json all = Json::array();
  for (const IsoSymbol& s : symbols) all.push_back(symbol_json(s));
  return all;
}

Json session_json(const Session& s) {
  Json rails = Json::array();
  for (const Iso230& rail : s.rails) {
    rails.push_back({{"rail", rail.rail == 0 ? Json() : Json(rail.rail)},
                     {"targets", rail.n_targets},
                     {"runs", rail.least_runs},
                     {"travel_mm", rail.travel_mm},
                     {"symbols", symbols_json(rail.symbols)}});
  }
  return {{"session", s.name},
          {"plan", s.plan},
          {"compensation_job", s.compensation_job ? Json(*s.compensation_job) : Json()},
          {"compensation", s.compensation},
          {"position_mm", summary_json(s.position_mm)},
          {"attitude_deg", summary_json(s.attitude_rad, deg_from_rad(1))},
          {"verdict", s.verdict},
          {"iso_9283",
           {{"poses", s.poses.n_poses},
            {"least_visits", s.poses.least_n},
            {"most_visits", s.poses.most_n},
            {"symbols", symbols_json(s.poses.symbols)}}},
          {"iso_230_2", rails}};
}

Json judged_json(const Judged& j) {
  Json points = Json::array();
  for (const Point& p : j.points) {
    points.push_back({{"seq", p.seq},
                      {"x_mm", p.target.x_mm},
                      {"y_mm", p.target.y_mm},
                      {"phi_deg", deg_from_rad(p.target.phi_rad)},
                      {"before_mm", p.before_mm},
                      {"after_mm", p.after_mm},
                      {"U_k2_mm", p.U ? Json(p.U->U_mm) : Json()},
                      {"U_k2_deg", p.U ? Json(deg_from_rad(p.U->U_rad)) : Json()},
                      {"why_no_U", p.why_no_U},
                      {"outside_measured_range", !p.why_no_U.empty()}});
  }
  Json json = {{"session", j.session},
               {"set", j.set},
               {"in_sample", j.in_sample()},
               {"judged", name_of(j.standing)},
               {"cross_validated", j.cross_validated},
               {"after_is", j.predicted ? "predicted" : "measured"},
               {"before_mm", summary_json(j.before_mm)},
               {"after_mm", summary_json(j.after_mm)},
               {"improvement_pct", j.improvement_pct ? Json(*j.improvement_pct) : Json()},
               {"improvement_95_pct", Json()},
               {"covered_by_U_pct", j.covered_pct ? Json(*j.covered_pct) : Json()},
               {"verdict", j.verdict},
               {"points", points}};
  if (j.improvement_95_pct) {
    json["improvement_95_pct"] = {j.improvement_95_pct->low, j.improvement_95_pct->high};
  }
  return json;
}

}  // namespace

Json to_json(const Assessment& a) {
  Json json = {{"campaign", a.campaign},
               {"kind", job::kind_text(a.simulated)},
               {"noise", a.noise},
               {"floor_mean_mm", a.floor_mean_mm ? Json(*a.floor_mean_mm) : Json()},
               {"sessions", Json::array()},
               {"job", Json()}};
  for (const Session& s : a.sessions) json["sessions"].push_back(session_json(s));
  if (a.job) {
    Json sets = Json::array();
    for (const Judged& j : a.job->sets) sets.push_back(judged_json(j));
    json["job"] = {{"id", a.job->id},
                   {"stage", a.job->stage},
                   {"uncertainty_from", a.job->uncertainty_from},
                   {"budget", report::budget_json(a.job->budget)},
                   {"sets", sets},
                   {"warnings", a.job->warnings}};
  }
  return json;
}

}  // namespace trammel::assess
