#pragma once
// The campaign's models: nominal -> geometry -> +effect -> …, each an immutable version.

#include <vector>

#include "store/statement.hpp"

namespace trammel::store {

struct NewModel {
  Id campaign_id = 0;
  std::string name;                // "nominal", "geometry", "+lead_scale"
  std::optional<int> parent = {};  // the version it was made from
  std::optional<Id> job_id = {};
  std::string parameters_json = "{}";  // values, standard deviations, units
  // rms of simulated minus measured over x and y, per coordinate.
  std::optional<double> identify_rms_mm = {};
  std::optional<double> validate_rms_mm = {};
  std::optional<double> noise_floor_mm = {};
};

struct Model {
  Id id = 0;
  int version = 0;      // 1, 2, … in the campaign
  std::string job_key;  // empty without a job
  std::string created_utc;
  NewModel data;
};

/// Stores the campaign's next version and returns its number.
/// @throws NotFoundError  no such parent version
int add_model(Connection& connection, const NewModel& model);
std::vector<Model> list_models(Connection& connection, Id campaign_id);
/// @throws NotFoundError
Model get_model(Connection& connection, Id campaign_id, int version);

}  // namespace trammel::store
