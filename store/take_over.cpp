#include "store/take_over.hpp"

#include <sqlite3.h>

#include "store/clock.hpp"
#include "store/open.hpp"
#include "store/reading.hpp"
#include "store/scheme.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

// In an order in which every row finds those that it names.
constexpr const char* kCopies[] = {
    "INSERT INTO campaign SELECT campaign_id, uuid, name, kind, origin, created_utc, "
    "tracker_sigma_xy_mm, tracker_sigma_phi_rad FROM former.campaign",
    "INSERT INTO machine SELECT campaign_id, '3-PRR', home_x_mm, home_y_mm, home_phi_rad, 1, 1, 1 "
    "FROM former.campaign",
    "INSERT INTO machine_chain SELECT campaign_id, chain, 'alpha_rad', alpha_rad "
    "FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'beta_rad', beta_rad FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'r_mm', platform_r_mm FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'S_mm', link_S_mm FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'l_zero_mm', l_zero_mm FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'R_mm', rail_R_mm FROM former.campaign_chain UNION ALL "
    "SELECT campaign_id, chain, 'h_mm', h_mm FROM former.campaign_chain",
    "INSERT INTO drive SELECT campaign_id, chain, screw_lead_mm, l_min_mm, l_max_mm "
    "FROM former.campaign JOIN former.campaign_chain USING (campaign_id)",
    "INSERT INTO campaign_fact SELECT campaign_id, key, value FROM former.campaign_fact",
    "INSERT INTO job SELECT job_id, campaign_id, key, 1, run, stage, algorithm_version, "
    "parameters_json, model_json, result_json, n_readings, tool_version, git_revision, compiler, "
    "libraries, cpu_level, created_utc, duration_s FROM former.job",
    "INSERT INTO session SELECT session_id, session.campaign_id, name, compensation_job_id, "
    "coalesce(job.stage, ''), plan_name, n_points, n_imported, 0, session.stage, tracker, "
    "settings_json, session.tool_version, session.created_utc FROM former.session AS session "
    "LEFT JOIN former.job AS job ON job.job_id = compensation_job_id",
    "INSERT INTO session_event SELECT event_id, session_id, row_number() OVER (PARTITION BY "
    "session_id ORDER BY event_id), kind, detail, at_utc FROM former.session_event",
    "INSERT INTO epoch SELECT epoch_id, session_id, number, reason, opened_utc FROM former.epoch",
    "INSERT INTO point SELECT point_id, session_id, seq, reading_set, target_x_mm, target_y_mm, "
    "target_phi_rad, approach_1, approach_2, approach_3, repeat, is_reference, role, "
    "planned_l1_mm, planned_l2_mm, planned_l3_mm FROM former.point",
    "INSERT INTO attempt SELECT attempt_id, point_id, number, epoch_id, status, n_readings, "
    "detail, opened_utc, closed_utc FROM former.attempt",
};
constexpr const char* kCopiesAfterReadings[] = {
    "INSERT INTO exclusion SELECT exclusion_id, campaign_id, seq, reason, created_utc "
    "FROM former.exclusion",
    "INSERT INTO job_session SELECT job_id, session_id FROM former.job_session",
    "INSERT INTO job_exclusion SELECT job_id, exclusion_id FROM former.job_exclusion",
    "INSERT INTO job_parent SELECT job_id, parent_job_id FROM former.job_parent",
    "INSERT INTO job_key_part SELECT job_id, part, sha256 FROM former.job_key_part",
    "INSERT INTO job_statistic SELECT job_id, reading_set, metric, in_sample, phase, mean, max, "
    "min, p95, n FROM former.job_statistic",
    "INSERT INTO job_point SELECT job_id, seq, in_sample, before_x_mm, before_y_mm, "
    "before_phi_rad, after_x_mm, after_y_mm, after_phi_rad FROM former.job_point",
    "INSERT INTO model SELECT model_id, campaign_id, version, parent_model_id, job_id, name, "
    "parameters_json, identify_rms_mm, validate_rms_mm, noise_floor_mm, created_utc "
    "FROM former.model ORDER BY model_id",
};

void copy_readings(Connection& to) {
  constexpr int kColumns = kEndChained - kFirstChained;
  Statement rows(
      to,
      "SELECT reading_id, reading.campaign_id, reading.session_id, reading.attempt_id, "
      "reading.seq, session.name, epoch, point.seq, attempt.number, reading.reading_set, "
      "reading.target_x_mm, reading.target_y_mm, reading.target_phi_rad, cmd_l1_mm, cmd_l2_mm, "
      "cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, encoder_l1_mm, "
      "encoder_l2_mm, encoder_l3_mm, time_s, temp_degc, raw_reply, extra_json "
      "FROM former.reading AS reading JOIN former.session AS session ON session.session_id = "
      "reading.session_id "
      "LEFT JOIN former.attempt AS attempt ON attempt.attempt_id = reading.attempt_id "
      "LEFT JOIN former.point AS point ON point.point_id = attempt.point_id "
      "ORDER BY reading.campaign_id, reading.seq");
  constexpr int kFirst = 4, kSession = 5, kPoint = 7, kAttempt = 8;
  std::string places = "?";
  for (int k = 0; k < kColumns + 1; ++k) places += ",?";
  Statement insert(to,
                   "INSERT INTO reading (reading_id, campaign_id, session_id, attempt_id, seq, "
                   "epoch, reading_set, target_x_mm, target_y_mm, target_phi_rad, cmd_l1_mm, "
                   "cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad, "
                   "encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, time_s, temp_degc, raw_reply, "
                   "extra_json, sha256) VALUES (" +
                       places + ")");
  Id campaign = 0;
  Sha256 head{};
  while (rows.step()) {
    if (rows.integer(1) != campaign) head = {};
    campaign = rows.integer(1);
    Digest digest;
    digest << Bytes(head);
    head = digest.row(rows, kFirst, kFirst + kColumns).finish();
    int place = 0;
    for (int column = 0; column < kFirst + kColumns; ++column) {
      if (column == kSession || column == kPoint || column == kAttempt) continue;
      sqlite3_bind_value(insert.handle(), ++place, sqlite3_column_value(rows.handle(), column));
    }
    sqlite3_bind_blob(insert.handle(), ++place, head.data(), static_cast<int>(head.size()),
                      SQLITE_TRANSIENT);
    insert.run();
    insert.reset();
  }
}

void keep_heads(Connection& to, int from_version) {
  Statement insert(to,
                   "INSERT INTO taken_over SELECT campaign_id, ?1, coalesce((SELECT sha256 FROM "
                   "former.reading WHERE reading.campaign_id = campaign.campaign_id ORDER BY seq "
                   "DESC LIMIT 1), zeroblob(32)), ?2 FROM campaign");
  insert << from_version << utc_now();
  insert.run();
}

void seal_all(Connection& to) {
  for (const Sealed& sealed : sealed_tables()) {
    const bool attempts = sealed.table == "attempt";
    Statement rows(to, "SELECT " + sealed.id + " FROM " + sealed.table +
                           (attempts ? " WHERE status <> 'open'" : "") + " ORDER BY 1");
    while (rows.step()) seal(to, sealed.table, rows.integer(0));
  }
}

}  // namespace

std::vector<std::string> take_guards_off(Connection& to) {
  std::vector<std::string> guards, names;
  {
    Statement rows(to, "SELECT name, sql FROM sqlite_schema WHERE type = 'trigger'");
    while (rows.step()) {
      names.push_back(rows.text(0));
      guards.push_back(rows.text(1));
    }
  }
  for (const std::string& name : names) to.execute("DROP TRIGGER " + name);
  return guards;
}

void take_over(Connection& to, const std::filesystem::path& from, int from_version) {
  {
    Statement attach(to, "ATTACH DATABASE ? AS former");
    attach << read_only_uri(from);
    attach.run();
  }
  {
    Transaction transaction(to);
    const std::vector<std::string> guards = take_guards_off(to);
    for (const char* sql : kCopies) to.execute(sql);
    copy_readings(to);
    for (const char* sql : kCopiesAfterReadings) to.execute(sql);
    keep_heads(to, from_version);
    seal_all(to);
    for (const std::string& guard : guards) to.execute(guard);
    transaction.commit();
  }
  to.execute("DETACH DATABASE former");
}

}  // namespace trammel::store
