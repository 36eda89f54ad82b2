#include "store/job.hpp"

#include "store/clock.hpp"
#include "store/insert_rows.hpp"
#include "store/seal.hpp"
#include "store/stored_json.hpp"
#include "store/transaction.hpp"

namespace trammel::store {

namespace {

void add_links(Connection& connection, Id job_id, const std::string& table,
               const std::vector<Id>& ids) {
  insert_rows(connection, table, 2, ids, [&](Statement& row, Id id) { row << job_id << id; });
}

void add_key_parts(Connection& connection, Id job_id, const JobKey& key) {
  const std::vector<std::pair<std::string, std::string>> parts(key.parts.begin(), key.parts.end());
  insert_rows(connection, "job_key_part", 3, parts, [&](Statement& row, const auto& part) {
    row << job_id << part.first << part.second;
  });
}

void add_statistics(Connection& connection, Id job_id, const std::vector<Statistic>& statistics) {
  struct Line {
    const Statistic& of;
    const char* phase;
    const Summary& summary;
  };
  std::vector<Line> rows;
  for (const Statistic& s : statistics) {
    if (s.before) rows.push_back({s, "before", *s.before});
    if (s.after) rows.push_back({s, "after", *s.after});
  }
  insert_rows(connection, "job_statistic", 10, rows, [&](Statement& row, const Line& r) {
    row << job_id << r.of.set << r.of.metric << r.of.in_sample << r.phase << r.summary.mean
        << r.summary.max << r.summary.min << r.summary.p95 << r.summary.n;
  });
}

Id add_row(Connection& connection, const NewJob& job) {
  const Provenance program = this_program();
  Statement insert(connection,
                   "INSERT INTO job (campaign_id, key, key_scheme, run, stage, algorithm_version, "
                   "parameters_json, model_json, result_json, n_readings, tool_version, "
                   "git_revision, compiler, libraries, cpu_level, created_utc, duration_s) "
                   "SELECT ?1, ?2, ?3, 1 + coalesce(max(run), 0), ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
                   "?11, ?12, ?13, ?14, ?15, ?16 FROM job WHERE campaign_id = ?1 AND key = ?2");
  insert << job.campaign_id << job.key.key << job.key.scheme << job.stage << job.algorithm_version
         << canonical_json(job.parameters_json, "parameters")
         << canonical_json(job.model_json, "model") << job.result_json << job.n_readings
         << program.tool_version << program.git_revision << program.compiler << program.libraries
         << program.cpu_level << utc_now() << job.duration_s;
  return insert.run();
}

std::vector<Id> links(Connection& connection, Id job_id, const char* sql) {
  std::vector<Id> ids;
  Statement rows(connection, sql);
  rows << job_id;
  while (rows.step()) ids.push_back(rows.integer(0));
  return ids;
}

std::vector<Statistic> statistics(Connection& connection, Id job_id) {
  std::vector<Statistic> all;
  Statement rows(connection,
                 "SELECT reading_set, metric, in_sample, phase, mean, max, min, p95, n FROM "
                 "job_statistic WHERE job_id = ? ORDER BY rowid");
  rows << job_id;
  while (rows.step()) {
    Statistic s{.set = rows.text(0), .metric = rows.text(1), .in_sample = rows.integer(2) != 0};
    const bool same = !all.empty() && all.back().set == s.set && all.back().metric == s.metric &&
                      all.back().in_sample == s.in_sample;
    if (!same) all.push_back(std::move(s));
    auto& summary = rows.text(3) == "before" ? all.back().before : all.back().after;
    summary = Summary{rows.real(4), rows.real(5), rows.real(6), rows.real(7),
                      static_cast<int>(rows.integer(8))};
  }
  return all;
}

}  // namespace

Id add_job(Connection& connection, const NewJob& job) {
  Transaction transaction(connection);
  const Id id = add_row(connection, job);
  add_links(connection, id, "job_session", job.sessions);
  add_links(connection, id, "job_exclusion", job.exclusions);
  add_links(connection, id, "job_parent", job.parents);
  add_key_parts(connection, id, job.key);
  add_statistics(connection, id, job.statistics);
  seal(connection, "job", id);
  transaction.commit();
  return id;
}

std::optional<Job> find_job(Connection& connection, Id campaign_id, std::string_view key) {
  Statement find(
      connection,
      "SELECT job_id FROM job WHERE key = ? AND campaign_id = ? ORDER BY run DESC LIMIT 1");
  find << key << campaign_id;
  if (!find.step()) return std::nullopt;
  return get_job(connection, find.integer(0));
}

bool has_job(Connection& connection, Id campaign_id, std::string_view key) {
  Statement find(connection, "SELECT 1 FROM job WHERE key = ? AND campaign_id = ?");
  find << key << campaign_id;
  return find.step();
}

std::optional<Id> newest_job(Connection& connection, Id campaign_id, std::string_view stage) {
  Statement find(connection, "SELECT max(job_id) FROM job WHERE campaign_id = ? AND stage = ?");
  find << campaign_id << stage;
  return find.step() ? find.optional_integer(0) : std::nullopt;
}

Job get_job(Connection& connection, Id job_id) {
  Statement row(
      connection,
      "SELECT campaign_id, key, run, stage, algorithm_version, parameters_json, "
      "model_json, result_json, n_readings, tool_version, git_revision, compiler, "
      "libraries, cpu_level, created_utc, duration_s, key_scheme FROM job WHERE job_id = ?");
  row << job_id;
  if (!row.step()) {
    throw NotFoundError({.what = "no such job", .got = std::to_string(job_id)});
  }
  Job job{.id = job_id,
          .run = static_cast<int>(row.integer(2)),
          .created_utc = row.text(14),
          .provenance = {row.text(9), row.text(10), row.text(11), row.text(12), row.text(13)},
          .data = {.campaign_id = row.integer(0),
                   .key = {row.text(1), {}, static_cast<int>(row.integer(16))},
                   .stage = row.text(3),
                   .algorithm_version = static_cast<int>(row.integer(4)),
                   .parameters_json = stored_json(row, 5),
                   .model_json = stored_json(row, 6),
                   .result_json = stored_json(row, 7),
                   .n_readings = static_cast<int>(row.integer(8)),
                   .duration_s = row.real(15)}};
  job.data.sessions =
      links(connection, job_id, "SELECT session_id FROM job_session WHERE job_id = ?");
  job.data.exclusions =
      links(connection, job_id, "SELECT exclusion_id FROM job_exclusion WHERE job_id = ?");
  job.data.parents =
      links(connection, job_id, "SELECT parent_job_id FROM job_parent WHERE job_id = ?");
  Statement parts(connection, "SELECT part, sha256 FROM job_key_part WHERE job_id = ?");
  parts << job_id;
  while (parts.step()) job.data.key.parts.emplace(parts.text(0), parts.text(1));
  job.data.statistics = statistics(connection, job_id);
  return job;
}

std::vector<JobPoint> stored_points(Connection& connection, Id job_id) {
  std::vector<JobPoint> all;
  Statement rows(
      connection,
      "SELECT seq, in_sample, after_x_mm, after_y_mm, after_phi_rad FROM job_point WHERE "
      "job_id = ? ORDER BY seq");
  rows << job_id;
  while (rows.step()) {
    all.push_back({.seq = static_cast<int>(rows.integer(0)),
                   .in_sample = rows.integer(1) != 0,
                   .after = {rows.real(2), rows.real(3), rows.real(4)}});
  }
  return all;
}

std::vector<JobRow> list_jobs(Connection& connection, std::optional<Id> campaign_id) {
  std::vector<JobRow> all;
  Statement rows(connection,
                 "SELECT job_id, campaign_id, campaign.name, key, run, stage, algorithm_version, "
                 "n_readings, job.created_utc, duration_s FROM job JOIN campaign USING "
                 "(campaign_id) WHERE ?1 IS NULL OR campaign_id = ?1 ORDER BY job_id");
  rows << campaign_id;
  while (rows.step()) {
    all.push_back({.id = rows.integer(0),
                   .campaign_id = rows.integer(1),
                   .campaign = rows.text(2),
                   .key = rows.text(3),
                   .run = static_cast<int>(rows.integer(4)),
                   .stage = rows.text(5),
                   .algorithm_version = static_cast<int>(rows.integer(6)),
                   .n_readings = static_cast<int>(rows.integer(7)),
                   .created_utc = rows.text(8),
                   .duration_s = rows.real(9)});
  }
  return all;
}

}  // namespace trammel::store
