#include "store/seal.hpp"

#include <algorithm>

namespace trammel::store {

const std::vector<Sealed>& sealed_tables() {
  static const std::vector<Sealed> tables = {
      {"campaign",
       "campaign_id",
       {"SELECT uuid, name, kind, origin, created_utc, tracker_sigma_xy_mm, tracker_sigma_phi_rad "
        "FROM campaign WHERE campaign_id = ?1",
        "SELECT kind, home_x_mm, home_y_mm, home_phi_rad, measures_x, measures_y, measures_phi "
        "FROM machine WHERE campaign_id = ?1",
        "SELECT chain, parameter, value FROM machine_chain WHERE campaign_id = ?1 "
        "ORDER BY chain, parameter",
        "SELECT drive, lead_mm, l_min_mm, l_max_mm FROM drive WHERE campaign_id = ?1 "
        "ORDER BY drive",
        "SELECT key, value FROM campaign_fact WHERE campaign_id = ?1 ORDER BY key"}},
      {"session",
       "session_id",
       {"SELECT uuid, session.name, job.key, job.run, compensation_name, plan_name, n_points, "
        "n_imported, n_asked, session.stage, tracker, settings_json, session.tool_version, "
        "session.created_utc FROM session JOIN campaign USING (campaign_id) "
        "LEFT JOIN job ON job.job_id = compensation_job_id WHERE session_id = ?1",
        "SELECT seq, reading_set, target_x_mm, target_y_mm, target_phi_rad, approach_1, "
        "approach_2, approach_3, repeat, is_reference, role, planned_l1_mm, planned_l2_mm, "
        "planned_l3_mm FROM point WHERE session_id = ?1 ORDER BY seq"}},
      {"session_event",
       "event_id",
       {"SELECT uuid, session.name, number, session_event.kind, detail, at_utc FROM session_event "
        "JOIN session USING (session_id) JOIN campaign USING (campaign_id) WHERE event_id = ?1"}},
      {"epoch",
       "epoch_id",
       {"SELECT uuid, session.name, number, reason, opened_utc FROM epoch "
        "JOIN session USING (session_id) JOIN campaign USING (campaign_id) WHERE epoch_id = ?1"}},
      {"attempt",
       "attempt_id",
       {"SELECT uuid, session.name, point.seq, attempt.number, epoch.number, status, n_readings, "
        "detail, attempt.opened_utc, closed_utc FROM attempt JOIN point USING (point_id) "
        "JOIN epoch USING (epoch_id) JOIN session ON session.session_id = point.session_id "
        "JOIN campaign USING (campaign_id) WHERE attempt_id = ?1"}},
      {"exclusion",
       "exclusion_id",
       {"SELECT uuid, seq, reason, exclusion.created_utc FROM exclusion "
        "JOIN campaign USING (campaign_id) WHERE exclusion_id = ?1"}},
      {"job",
       "job_id",
       {"SELECT uuid, key, key_scheme, run, stage, algorithm_version, parameters_json, model_json, "
        "result_json, n_readings, tool_version, git_revision, compiler, libraries, cpu_level, "
        "job.created_utc, duration_s FROM job JOIN campaign USING (campaign_id) WHERE job_id = ?1",
        "SELECT session.name FROM job_session JOIN session USING (session_id) WHERE job_id = ?1 "
        "ORDER BY session.name",
        "SELECT seq FROM job_exclusion JOIN exclusion USING (exclusion_id) WHERE job_id = ?1 "
        "ORDER BY seq",
        "SELECT key, run FROM job_parent JOIN job ON job.job_id = parent_job_id "
        "WHERE job_parent.job_id = ?1 ORDER BY key, run",
        "SELECT part, sha256 FROM job_key_part WHERE job_id = ?1 ORDER BY part",
        "SELECT reading_set, metric, in_sample, phase, mean, max, min, p95, n FROM job_statistic "
        "WHERE job_id = ?1 ORDER BY reading_set, metric, in_sample, phase",
        "SELECT seq, in_sample, before_x_mm, before_y_mm, before_phi_rad, after_x_mm, after_y_mm, "
        "after_phi_rad FROM job_point WHERE job_id = ?1 ORDER BY seq"}},
      {"model",
       "model_id",
       {"SELECT uuid, model.version, parent.version, job.key, job.run, model.name, "
        "model.parameters_json, model.identify_rms_mm, model.validate_rms_mm, "
        "model.noise_floor_mm, model.created_utc FROM model "
        "JOIN campaign ON campaign.campaign_id = model.campaign_id "
        "LEFT JOIN model AS parent ON parent.model_id = model.parent_model_id "
        "LEFT JOIN job ON job.job_id = model.job_id WHERE model.model_id = ?1"}},
      {"taken_over",
       "campaign_id",
       {"SELECT uuid, from_version, head, taken_utc FROM taken_over "
        "JOIN campaign USING (campaign_id) WHERE campaign_id = ?1"}},
  };
  return tables;
}

Sha256 seal_of(Connection& connection, const Sealed& sealed, Id id, ByteOrder order) {
  Digest digest(order);
  for (std::size_t part = 0; part < sealed.rows.size(); ++part) {
    digest << static_cast<int>(part);
    Statement rows(connection, sealed.rows[part]);
    rows << id;
    while (rows.step()) digest.row(rows, 0, rows.columns());
  }
  return digest.finish();
}

void seal(Connection& connection, std::string_view table, Id id) {
  const auto& all = sealed_tables();
  const auto sealed = std::ranges::find(all, table, &Sealed::table);
  TRAMMEL_ASSERT(sealed != all.end());
  const Sha256 sha256 = seal_of(connection, *sealed, id);
  Statement insert(connection, "INSERT INTO seal (table_name, row_id, sha256) VALUES (?, ?, ?)");
  insert << table << id << Bytes(sha256);
  insert.run();
}

}  // namespace trammel::store
