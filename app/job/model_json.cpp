#include "app/job/model_json.hpp"

namespace trammel::job {

namespace {

Json parameter_json(const ModelParameter& p) {
  return {{"name", p.name}, {"unit", p.unit}, {"value", p.value}, {"std", optional_json(p.std)}};
}

Json effects_json(const StoredModel& model) {
  Json all = Json::array();
  for (const ActiveEffect& active : model.robot.effects) {
    Json effect = {{"effect", active.effect->name},
                   {"sentence", active.effect->sentence},
                   {"parameters", Json::array()}};
    for (const ModelParameter& p : model.parameters) {
      if (p.group == active.effect->name) effect["parameters"].push_back(parameter_json(p));
    }
    all.push_back(std::move(effect));
  }
  return all;
}

Json base_json(const StoredModel& model) {
  Json all = Json::array();
  for (const ModelParameter& p : model.parameters) {
    if (p.group != "geometry" && !p.group.starts_with("epoch ")) continue;
    Json json = {{"group", p.group}};
    json.update(parameter_json(p));
    json["change"] = p.change;
    json["identified"] = !p.not_identified;
    if (p.not_identified) json["value"] = json["change"] = nullptr;  // one of many that fit
    all.push_back(std::move(json));
  }
  return all;
}

}  // namespace

Json model_row_json(const store::Model& m) {
  return {{"version", m.version},
          {"name", m.data.name},
          {"parent", optional_json(m.data.parent)},
          {"identify_rms_mm", optional_json(m.data.identify_rms_mm)},
          {"validate_rms_mm", optional_json(m.data.validate_rms_mm)},
          {"noise_floor_mm", optional_json(m.data.noise_floor_mm)},
          {"job", optional_json(m.data.job_id)},
          {"job_key", m.job_key.empty() ? Json(nullptr) : Json(m.job_key)},
          {"created_utc", m.created_utc}};
}

Json model_json(const StoredModel& model, const std::string& campaign) {
  Json json = {{"campaign", campaign}};
  json.update(model_row_json(model.row));
  json["effects"] = effects_json(model);
  json["base"] = base_json(model);
  json["not_identified"] = not_identified(model);
  json["words"] = model_words(model);
  return json;
}

Json model_file_json(const StoredModel& model, const std::string& campaign) {
  Json json = {{"format", "model/1"}};
  json.update(model_json(model, campaign));
  json["correction"] = correction_json(ModelCorrection{model.robot});
  return json;
}

}  // namespace trammel::job
