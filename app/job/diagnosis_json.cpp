#include "app/job/diagnosis_json.hpp"

#include "core/units.hpp"

namespace trammel::job {

namespace {

constexpr std::size_t kFindings = 8;  // of some three hundred: those that say most

Json noise_json(const NoiseFloor& noise) {
  Json json = {{"sigma_xy_mm", noise.used.xy_mm},
               {"sigma_phi_deg", deg_from_rad(noise.used.phi_rad)},
               {"rescaled", noise.rescaled},
               {"correlation", noise.correlation}};
  if (noise.stated.xy_mm > 0) {
    json["stated_xy_mm"] = noise.stated.xy_mm;
    json["stated_phi_deg"] = deg_from_rad(noise.stated.phi_rad);
  }
  if (noise.repeats) {
    json["repeats"] = {{"sigma_xy_mm", noise.repeats->sigma.xy_mm},
                       {"sigma_phi_deg", deg_from_rad(noise.repeats->sigma.phi_rad)},
                       {"degrees_of_freedom", noise.repeats->degrees_of_freedom}};
  }
  return json;
}

Json audit_json(const std::vector<AuditRow>& audit) {
  Json rows = Json::array();
  for (const AuditRow& row : audit) {
    Json json = {{"effect", row.effect},
                 {"surviving_share", row.surviving_share},
                 {"smallest_visible", optional_json(row.smallest_visible)},
                 {"unit", row.unit},
                 {"aliases", Json::array()}};
    for (const Alias& alias : row.aliases) json["aliases"].push_back(alias.effect);
    if (!row.missing.empty()) json["needs"] = row.missing;
    rows.push_back(std::move(json));
  }
  return rows;
}

Json effects_json(const std::vector<NamedEffect>& effects) {
  Json all = Json::array();
  for (const NamedEffect& e : effects) {
    Json json = {
        {"name", e.name}, {"rails", e.rails}, {"share_of_gap", e.share_of_gap}, {"p", e.p}};
    json["parameters"] = Json::array();
    for (const NamedParameter& p : e.parameters) {
      Json parameter = {{"name", p.name}, {"value", p.value}, {"std", p.std}, {"unit", p.unit}};
      if (p.unusual) parameter["unusual"] = true;
      json["parameters"].push_back(std::move(parameter));
    }
    if (!e.seqs.empty()) json["seq"] = e.seqs;
    if (e.name != "outlier_readings") json["sentence"] = find_effect(e.name).sentence;
    all.push_back(std::move(json));
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

Json gap_json(const std::vector<GapStep>& gap) {
  Json all = Json::array();
  for (const GapStep& g : gap) {
    Json json = {{"model", g.model},
                 {"identify_rms_mm", optional_json(g.identify_rms_mm)},
                 {"validate_rms_mm", optional_json(g.validate_rms_mm)},
                 {"identify_rms_deg", optional_json(g.identify_rms_deg)},
                 {"validate_rms_deg", optional_json(g.validate_rms_deg)}};
    if (g.closed_share) {
      json["closed_share"] = *g.closed_share;
      if (g.closed_low) json["closed_interval_95"] = {*g.closed_low, *g.closed_high};
    }
    all.push_back(std::move(json));
  }
  return all;
}

Json next_json(const NextPoints& next) {
  Json all = Json::array();
  for (const NextPoint& p : next.points) {
    all.push_back({{"x_mm", p.target.x_mm},
                   {"y_mm", p.target.y_mm},
                   {"phi_deg", deg_from_rad(p.target.phi_rad)},
                   {"approach", p.approach},
                   {"why", p.why}});
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

Json diagnosis_json(const Diagnosis& d, const std::string& campaign) {
  Json json = {{"campaign", campaign},
               {"verdict", to_string(d.verdict)},
               {"noise_floor_mm", d.noise.used.xy_mm},
               {"noise_source", to_string(d.noise.source)},
               {"noise", noise_json(d.noise)},
               {"audit", audit_json(d.audit)},
               {"before", test_json(d.before)},
               {"effects", effects_json(d.effects)},
               {"rivals", Json::array()}};
  for (const Rival& r : d.rivals) {
    json["rivals"].push_back(r.names);
    json["rival_odds"].push_back(
        {{"names", r.names}, {"odds", r.evidence}, {"structural", r.structural}});
  }
  if (d.after.tests > 0) json["after"] = test_json(d.after);
  if (!d.tried.empty()) json["tried"] = effects_json(d.tried);
  json["structure"] = structure_json(d.structure);
  json["gap"] = gap_json(d.gap);
  json["next_points"] = next_json(d.next);
  json["undecided"] = d.next.undecided;
  json["predictions"] = predictions_json(d.predictions);
  json["notes"] = d.notes;
  return json;
}

}  // namespace trammel::job
