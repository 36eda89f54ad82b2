#include "app/job/diagnosis_json.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr std::size_t kFindings = 8;  // of some three hundred: those that say most

/// How many readings of each set there are, and what they vary.
Json readings_json(const Campaign& campaign, const Diagnosis& d) {
  std::map<ReadingSet, int> n;
  std::set<int> epochs;
  for (const Reading& r : campaign.readings) {
    ++n[r.set];
    if (r.set == ReadingSet::identify) epochs.insert(r.conditions.epoch);
  }
  std::size_t bad = 0;
  for (const NamedEffect& e : d.effects) bad += e.seqs.size();
  return {{"identify", n[ReadingSet::identify]},
          {"validate", n[ReadingSet::validate]},
          {"predict", n[ReadingSet::predict]},
          {"epochs", epochs.size()},
          {"left_out", bad}};
}

/// Effects whose own signal stands out of what the geometry leaves, by rising p.
Json suspects_json(const StructureTest& test) {
  constexpr double kStandsOut = 0.01;  // corrected for the number of tests
  const std::string effect = "effect ";
  std::map<std::string, double> smallest;
  for (const Finding& f : test.findings) {
    if (!f.where.starts_with(effect) || f.p * test.tests > kStandsOut) continue;
    const auto [at, added] = smallest.emplace(f.where.substr(effect.size()), f.p);
    at->second = std::min(at->second, f.p);
  }
  std::vector<std::pair<double, std::string>> order;
  for (const auto& [name, p] : smallest) order.emplace_back(p, name);
  std::sort(order.begin(), order.end());
  Json all = Json::array();
  for (const auto& [p, name] : order) all.push_back({{"effect", name}, {"p", p}});
  return all;
}

/// Of phi only where it is measured.
Json noise_json(const NoiseFloor& noise, bool turns) {
  Json json = {{"sigma_xy_mm", noise.used.xy_mm}};
  if (turns) json["sigma_phi_deg"] = deg_from_rad(noise.used.phi_rad);
  json["rescaled"] = noise.rescaled;
  json["robust"] = noise.robust;
  json["correlation"] = noise.correlation;
  if (noise.stated.xy_mm > 0) {
    json["stated_xy_mm"] = noise.stated.xy_mm;
    if (turns) json["stated_phi_deg"] = deg_from_rad(noise.stated.phi_rad);
  }
  if (noise.repeats) {
    Json repeats = {{"sigma_xy_mm", noise.repeats->sigma.xy_mm}};
    if (turns) repeats["sigma_phi_deg"] = deg_from_rad(noise.repeats->sigma.phi_rad);
    repeats["degrees_of_freedom"] = noise.repeats->degrees_of_freedom;
    json["repeats"] = repeats;
  }
  return json;
}

Json audit_json(const std::vector<AuditRow>& audit) {
  Json rows = Json::array();
  for (const AuditRow& row : audit) {
    Json json = {{"effect", row.effect},
                 {"surviving_share", row.surviving_share},
                 {"smallest_visible", optional_json(row.smallest_visible)},
                 {"usual_max", row.usual_max},
                 {"unit", row.unit},
                 {"aliases", Json::array()}};
    for (const Alias& alias : row.aliases) json["aliases"].push_back(alias.effect);
    if (!row.missing.empty()) json["needs"] = row.missing;
    rows.push_back(std::move(json));
  }
  return rows;
}

Json parameters_json(const std::vector<NamedParameter>& parameters) {
  Json all = Json::array();
  for (const NamedParameter& p : parameters) {
    all.push_back({{"name", p.name}, {"value", p.value}, {"std", p.std}, {"unit", p.unit}});
    if (p.unusual) all.back()["unusual"] = true;
  }
  return all;
}

Json effects_json(const std::vector<NamedEffect>& effects) {
  Json all = Json::array();
  for (const NamedEffect& e : effects) {
    Json json = {
        {"name", e.name}, {"rails", e.rails}, {"share_of_gap", e.share_of_gap}, {"p", e.p}};
    json["parameters"] = parameters_json(e.parameters);
    if (!e.seqs.empty()) json["seq"] = e.seqs;
    if (e.name != "outlier_readings") json["sentence"] = e.sentence;
    all.push_back(std::move(json));
  }
  return all;
}

Json suspect_json(const std::vector<Suspicion>& found) {
  Json all = Json::array();
  for (const Suspicion& s : found) {
    Json json = {{"kind", to_string(s.kind)}, {"what", s.what}, {"seqs", "all"}, {"why", s.why}};
    if (!s.seqs.empty()) json["seqs"] = s.seqs;
    all.push_back(std::move(json));
  }
  return all;
}

Json suspicious_json(const std::vector<FarReading>& readings) {
  Json all = Json::array();
  for (const FarReading& r : readings) {
    char why[64];
    std::snprintf(why, sizeof why, "%.1f sigma; ", r.sigmas);
    all.push_back({{"seq", r.seq}, {"sigmas", r.sigmas}, {"why", why + r.why}});
  }
  return all;
}

Json possible_json(const std::vector<Possible>& effects) {
  Json all = Json::array();
  for (const Possible& e : effects) {
    all.push_back({{"name", e.name},
                   {"probability", e.probability},
                   {"parameters", parameters_json(e.parameters)}});
  }
  return all;
}

Json structure_json(const std::vector<Finding>& findings) {
  Json all = Json::array();
  for (std::size_t i = 0; i < findings.size() && i < kFindings; ++i) {
    all.push_back({{"where", findings[i].where},
                   {"when", findings[i].when},
                   {"p", findings[i].p},
                   {"chi2", findings[i].chi2},
                   {"terms", findings[i].terms}});
  }
  return all;
}

Json test_json(const StructureTest& test) {
  return {{"family_p", test.family_p},
          {"tests", test.tests},
          {"findings", structure_json(test.findings)}};
}

Json base_json(const BaseDistance& base) {
  Json json = {{"tolerances", base.tolerances}, {"directions", base.directions}, {"p", base.p}};
  if (base.implausible()) json["implausible"] = in_words(base);
  return json;
}

/// An XY stage is told of each of its axes, whose errors can differ by an order.
Json gap_json(const std::vector<GapStep>& gap, const Machine& machine) {
  const bool in_plane = machine.kind->n_chains == 2 && machine.measured[0] && machine.measured[1];
  Json all = Json::array();
  for (const GapStep& g : gap) {
    Json json = {{"model", g.model},
                 {"identify_rms_mm", optional_json(g.identify_rms_mm)},
                 {"validate_rms_mm", optional_json(g.validate_rms_mm)},
                 {"identify_rms_deg", optional_json(g.identify_rms_deg)},
                 {"validate_rms_deg", optional_json(g.validate_rms_deg)}};
    const auto by_axis = [&](const char* name, const std::optional<Eigen::Vector3d>& rms) {
      if (in_plane && rms) json[name] = {(*rms)[0], (*rms)[1]};
    };
    by_axis("identify_rms_by_axis_mm", g.identify_rms);
    by_axis("validate_rms_by_axis_mm", g.validate_rms);
    if (g.closed_share) {
      json["closed_share"] = *g.closed_share;
      if (g.closed_low) json["closed_interval_95"] = {*g.closed_low, *g.closed_high};
    }
    all.push_back(std::move(json));
  }
  return all;
}

/// Coordinates and directions that the machine has.
Json next_json(const NextPoints& next, int n_drives) {
  Json all = Json::array();
  for (const NextPoint& p : next.points) {
    Json json = {{"x_mm", p.target.x_mm}};
    if (n_drives > 1) json["y_mm"] = p.target.y_mm;
    if (n_drives > 2) json["phi_deg"] = deg_from_rad(p.target.phi_rad);
    json["approach"] = std::vector<int>(p.approach.begin(), p.approach.begin() + n_drives);
    json["why"] = p.why;
    all.push_back(std::move(json));
  }
  return all;
}

Json state_json(const NextState& state) {
  Json json = Json::object();
  if (state.temp_degc) json["temp_degc"] = *state.temp_degc;
  if (state.wait_h) json["wait_h"] = *state.wait_h;
  json["approach_mm"] = state.approach_mm;
  return json;
}

Json undecided_json(const NextPoints& next) {
  Json all = Json::array();
  for (const Undecided& u : next.undecided) {
    all.push_back({{"what", u.what}, {"instead", u.instead}});
  }
  return all;
}

Json considered_json(const std::vector<Considered>& considered) {
  Json all = Json::array();
  for (const Considered& c : considered) {
    all.push_back({{"names", c.names},
                   {"parameters", c.parameters},
                   {"behind_chi2", c.behind},
                   {"usual", c.usual}});
  }
  return all;
}

Json predictions_json(const std::vector<PredictedRow>& rows) {
  Json all = Json::array();
  for (const PredictedRow& p : rows) {
    all.push_back({{"seq", p.seq},
                   {"x_mm", p.pose.x_mm},
                   {"y_mm", p.pose.y_mm},
                   {"phi_deg", deg_from_rad(p.pose.phi_rad)},
                   {"std_x_mm", p.std[0]},
                   {"std_y_mm", p.std[1]},
                   {"std_phi_deg", deg_from_rad(p.std[2])}});
  }
  return all;
}

}  // namespace

Json diagnosis_json(const Diagnosis& d, const Campaign& campaign) {
  Json json = {{"campaign", campaign.name},
               {"verdict", to_string(d.verdict)},
               {"noise_floor_mm", d.noise.used.xy_mm},
               {"noise_source", to_string(d.noise.source)},
               {"noise", noise_json(d.noise, campaign.machine.measured[2])},
               {"readings", readings_json(campaign, d)},
               {"audit", audit_json(d.audit)},
               {"before", test_json(d.before)},
               {"suspects", suspects_json(d.before)},
               {"suspect", suspect_json(d.suspect)},
               {"suspicious_readings", suspicious_json(d.suspicious)},
               {"effects", effects_json(d.effects)},
               {"rivals", Json::array()}};
  for (const Rival& r : d.rivals) {
    json["rivals"].push_back(r.names);
    json["rival_odds"].push_back(
        {{"names", r.names}, {"odds", r.evidence}, {"structural", r.structural}});
  }
  json["may_also_hold"] = possible_json(d.may_also_hold);
  json["considered"] = considered_json(d.considered);
  if (d.after.tests > 0) json["after"] = test_json(d.after);
  if (!d.tried.empty()) json["tried"] = effects_json(d.tried);
  json["structure"] = structure_json(d.structure);
  json["base_distance"] = base_json(d.base);
  json["gap"] = gap_json(d.gap, d.fit.model.nominal);
  if (d.gap_tried.size() > 0) json["gap_tried"] = gap_json(d.gap_tried, d.fit.model.nominal);
  json["next_points"] = next_json(d.next, d.fit.model.nominal.kind->n_chains);
  json["next_state"] = state_json(d.next.state);
  json["undecided"] = undecided_json(d.next);
  json["predictions"] = predictions_json(d.predictions);
  json["notes"] = d.notes;
  return json;
}

}  // namespace trammel::job
