#include "app/job/model_chain.hpp"

#include "core/units.hpp"
#include "store/model.hpp"
#include "store/transaction.hpp"

namespace trammel::job {

namespace {

/// Value of a fitted parameter less its nominal one, in the model's own units (rad, mm, …).
double change_of(const FreeParameter& p, const RobotModel& robot) {
  switch (p.kind) {
    case FreeParameter::Kind::geometry: {
      const MachineParameter& of =
          parameters_of(*robot.nominal.kind)[static_cast<std::size_t>(p.index)];
      const auto chain = static_cast<std::size_t>(of.chain);
      return robot.machine.chains[chain][of.place] - robot.nominal.chains[chain][of.place];
    }
    case FreeParameter::Kind::epoch_zero:
      return robot.epochs.at(p.owner).l_zero_mm[p.index];
    case FreeParameter::Kind::epoch_frame:
      return robot.epochs.at(p.owner).frame.vector()[p.index];
    case FreeParameter::Kind::effect:
      return robot.effects[static_cast<std::size_t>(p.owner)].values[p.index];
  }
  return 0;
}

Json number_json(const std::optional<double>& value, double factor) {
  return value ? Json(factor * *value) : Json(nullptr);
}

/// What this step fitted: its own values, each with the standard deviation it has in this model.
void add_fitted(Json& json, const GapStep& step) {
  for (std::size_t k = 0; k < step.parameters.size(); ++k) {
    const FreeParameter& p = step.parameters[k];
    const double change = change_of(p, step.robot);
    if (p.kind == FreeParameter::Kind::effect) {
      const Effect& effect = *step.robot.effects[static_cast<std::size_t>(p.owner)].effect;
      json["effects"].push_back(
          {{"effect", effect.name},
           {"name", effect.parameters[static_cast<std::size_t>(p.index)].name},
           {"value", change},
           {"std", number_json(step.std[k], 1)},
           {"unit", p.unit}});
      continue;
    }
    const double unit = p.unit == "deg" ? deg_from_rad(1) : 1;
    Json fitted = {{"name", p.name}, {"unit", p.unit}, {"identified", step.std[k].has_value()}};
    fitted["change"] = unit * change;
    if (step.std[k]) fitted["std"] = unit * *step.std[k];
    json["geometry"].push_back(std::move(fitted));
  }
}

}  // namespace

Json model_chain_json(const Diagnosis& d) {
  Json chain = Json::array();
  for (const GapStep& g : d.gap) {
    Json step = {{"name", g.model},
                 {"correction", correction_json(ModelCorrection{g.robot})},
                 {"effects", Json::array()},
                 {"geometry", Json::array()}};
    add_fitted(step, g);
    if (g.identify_rms_mm) step["identify_rms_mm"] = *g.identify_rms_mm;
    if (g.validate_rms_mm) step["validate_rms_mm"] = *g.validate_rms_mm;
    step["noise_floor_mm"] = d.noise.used.xy_mm;
    chain.push_back(std::move(step));
  }
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
    const Json parameters = {{"correction", step["correction"]},
                             {"effects", step["effects"]},
                             {"geometry", step["geometry"]}};
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
