#include "app/job/model_chain.hpp"

#include "core/units.hpp"
#include "store/model.hpp"
#include "store/transaction.hpp"

namespace trammel::job {

namespace {

/// Geometry that is identified by itself: change from nominal with its standard deviation.
Json geometry_json(const Diagnosis& d) {
  Json all = Json::array();
  for (std::size_t k = 0; k < d.fit.parameters.size(); ++k) {
    const FreeParameter& p = d.fit.parameters[k];
    if (p.kind == FreeParameter::Kind::effect) continue;
    const auto row = static_cast<Eigen::Index>(k);
    // a parameter by itself is identified when hardly any of it lies in the null space
    const double kept = d.fit.identified.directions.row(row).squaredNorm();
    Json json = {{"name", p.name}, {"unit", p.unit}, {"identified", kept > 1 - 1e-6}};
    if (kept > 1 - 1e-6) {
      const double unit = p.scale * (p.unit == "deg" ? deg_from_rad(1) : 1);
      json["change"] = unit * d.fit.z[row];
      json["std"] = unit * std::sqrt(d.fit.covariance(row, row));
    }
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace

Json model_chain_json(const Diagnosis& d) {
  Json chain = Json::array();
  for (const GapStep& g : d.gap) {
    Json step = {{"name", g.model},
                 {"correction", correction_json(ModelCorrection{g.robot})},
                 {"effects", Json::array()}};
    for (const ActiveEffect& active : g.robot.effects) {
      for (const NamedEffect& named : d.effects) {
        if (named.name != active.effect->name) continue;
        for (const NamedParameter& p : named.parameters) {
          step["effects"].push_back({{"effect", named.name},
                                     {"name", p.name},
                                     {"value", p.value},
                                     {"std", p.std},
                                     {"unit", p.unit}});
        }
      }
    }
    if (g.identify_rms_mm) step["identify_rms_mm"] = *g.identify_rms_mm;
    if (g.validate_rms_mm) step["validate_rms_mm"] = *g.validate_rms_mm;
    step["noise_floor_mm"] = d.noise.used.xy_mm;
    chain.push_back(std::move(step));
  }
  chain.back()["geometry"] = geometry_json(d);
  return chain;
}

void store_model_chain(store::Connection& connection, const store::Job& job) {
  const Json chain = Json::parse(job.data.result_json)["details"]["models"];
  store::Transaction transaction(connection);
  for (const store::Model& model : store::list_models(connection, job.data.campaign_id)) {
    if (model.data.job_id == job.id) return;  // stored when the job was
  }
  std::optional<int> parent;
  for (const Json& step : chain) {
    const Json parameters = {
        {"correction", step["correction"]},
        {"effects", step["effects"]},
        {"geometry", step.contains("geometry") ? step["geometry"] : Json::array()}};
    parent =
        store::add_model(connection, {.campaign_id = job.data.campaign_id,
                                      .name = step["name"],
                                      .parent = parent,
                                      .job_id = job.id,
                                      .parameters_json = parameters.dump(),
                                      .identify_rms_mm = optional_number(step, "identify_rms_mm"),
                                      .validate_rms_mm = optional_number(step, "validate_rms_mm"),
                                      .noise_floor_mm = optional_number(step, "noise_floor_mm")});
  }
  transaction.commit();
}

}  // namespace trammel::job
