#include "store/model.hpp"

#include "store/clock.hpp"
#include "store/job_key.hpp"
#include "store/seal.hpp"
#include "store/stored_json.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

int add_model(Connection& connection, const NewModel& m) {
  Transaction transaction(connection);
  std::optional<Id> parent_id;
  if (m.parent) parent_id = get_model(connection, m.campaign_id, *m.parent).id;
  Statement next(connection,
                 "SELECT 1 + coalesce(max(version), 0) FROM model WHERE campaign_id = ?");
  next << m.campaign_id;
  static_cast<void>(next.step());
  const auto version = static_cast<int>(next.integer(0));
  Statement insert(connection,
                   "INSERT INTO model (campaign_id, version, parent_model_id, job_id, name, "
                   "parameters_json, identify_rms_mm, validate_rms_mm, noise_floor_mm, "
                   "created_utc) VALUES (?,?,?,?,?,?,?,?,?,?)");
  insert << m.campaign_id << version << parent_id << m.job_id << m.name
         << canonical_json(m.parameters_json, "parameters") << m.identify_rms_mm
         << m.validate_rms_mm << m.noise_floor_mm << utc_now();
  seal(connection, "model", insert.run());
  next.reset();
  transaction.commit();
  return version;
}

std::vector<Model> list_models(Connection& connection, Id campaign_id) {
  std::vector<Model> all;
  Statement rows(connection,
                 "SELECT m.model_id, m.version, coalesce(job.key, ''), m.created_utc, m.name, "
                 "parent.version, m.job_id, m.parameters_json, m.identify_rms_mm, "
                 "m.validate_rms_mm, m.noise_floor_mm FROM model AS m LEFT JOIN model AS parent ON "
                 "parent.model_id = m.parent_model_id LEFT JOIN job ON job.job_id = m.job_id WHERE "
                 "m.campaign_id = ? ORDER BY m.version");
  rows << campaign_id;
  while (rows.step()) {
    const auto parent = rows.optional_integer(5);
    all.push_back(
        {.id = rows.integer(0),
         .version = static_cast<int>(rows.integer(1)),
         .job_key = rows.text(2),
         .created_utc = rows.text(3),
         .data = {.campaign_id = campaign_id,
                  .name = rows.text(4),
                  .parent = parent ? std::optional(static_cast<int>(*parent)) : std::nullopt,
                  .job_id = rows.optional_integer(6),
                  .parameters_json = stored_json(rows, 7),
                  .identify_rms_mm = rows.optional_real(8),
                  .validate_rms_mm = rows.optional_real(9),
                  .noise_floor_mm = rows.optional_real(10)}});
  }
  return all;
}

Model get_model(Connection& connection, Id campaign_id, int version) {
  for (Model& model : list_models(connection, campaign_id)) {
    if (model.version == version) return std::move(model);
  }
  throw NotFoundError(
      {.what = "the campaign has no such version of its model", .got = std::to_string(version)});
}

}  // namespace trammel::store
