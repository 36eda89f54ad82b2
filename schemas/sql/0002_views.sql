-- Version 2: the questions people ask, as views. Lengths mm, angles degrees. store/README.md.

-- Where each planned point stands: planned, open, ok, failed or interrupted.
CREATE VIEW v_point_status AS
SELECT campaign.name AS campaign, session.name AS session, point.session_id, point.seq,
       point.reading_set, point.role,
       CASE WHEN EXISTS (SELECT 1 FROM attempt WHERE attempt.point_id = point.point_id
                         AND status = 'ok') THEN 'ok'
            ELSE coalesce((SELECT status FROM attempt WHERE attempt.point_id = point.point_id
                           ORDER BY number DESC LIMIT 1), 'planned') END AS status,
       (SELECT count(*) FROM attempt WHERE attempt.point_id = point.point_id) AS n_attempts
FROM point JOIN session USING (session_id) JOIN campaign USING (campaign_id);

-- Measured minus target of every reading, and under what it was taken.
CREATE VIEW v_point_error AS
SELECT campaign.campaign_id, campaign.name AS campaign, campaign.kind, reading.session_id,
       session.name AS session, coalesce(job.stage, 'baseline') AS method,
       session.compensation_job_id, reading.seq, reading.epoch, reading.reading_set,
       target_x_mm, target_y_mm, degrees(target_phi_rad) AS target_phi_deg,
       x_mm - target_x_mm AS error_x_mm, y_mm - target_y_mm AS error_y_mm,
       sqrt((x_mm - target_x_mm) * (x_mm - target_x_mm)
            + (y_mm - target_y_mm) * (y_mm - target_y_mm)) AS position_mm,
       degrees(phi_rad - target_phi_rad) AS error_phi_deg,
       abs(degrees(phi_rad - target_phi_rad)) AS attitude_deg,
       time_s, temp_degc, exclusion.reason AS excluded
FROM reading JOIN campaign USING (campaign_id)
JOIN session ON session.session_id = reading.session_id
LEFT JOIN job ON job.job_id = session.compensation_job_id
LEFT JOIN exclusion ON exclusion.campaign_id = reading.campaign_id AND exclusion.seq = reading.seq
WHERE x_mm IS NOT NULL;

-- Jobs with what they were made from and what they are worth.
CREATE VIEW v_job AS
SELECT job.job_id, campaign.name AS campaign, campaign.kind, stage, algorithm_version, run, key,
       n_readings,
       (SELECT group_concat(name, ' ') FROM job_session JOIN session USING (session_id)
        WHERE job_session.job_id = job.job_id) AS sessions,
       (SELECT count(*) FROM job_exclusion WHERE job_exclusion.job_id = job.job_id)
         AS n_exclusions,
       (SELECT group_concat(parent_job_id, ' ') FROM job_parent
        WHERE job_parent.job_id = job.job_id) AS parents,
       parameters_json, job.created_utc, duration_s, tool_version, git_revision, cpu_level
FROM job JOIN campaign USING (campaign_id);

-- Before and after per campaign, session and method. Two sources, never mixed: `predicted` is what a
-- job states of its own fit; `measured` compares a compensated session with the baseline readings of
-- the same targets in its campaign, target by target. in_sample: judged at points that were fitted.
-- p95 interpolates between order statistics.
CREATE VIEW v_accuracy AS
WITH figure AS (
  SELECT campaign_id, campaign, kind, session_id, session, method, compensation_job_id,
         reading_set, 'position_mm' AS metric, position_mm AS value,
         target_x_mm, target_y_mm, target_phi_deg
  FROM v_point_error WHERE excluded IS NULL
  UNION ALL
  SELECT campaign_id, campaign, kind, session_id, session, method, compensation_job_id,
         reading_set, 'attitude_deg', attitude_deg, target_x_mm, target_y_mm, target_phi_deg
  FROM v_point_error WHERE excluded IS NULL
), baseline AS (
  SELECT campaign_id, metric, target_x_mm, target_y_mm, target_phi_deg, avg(value) AS value
  FROM figure WHERE compensation_job_id IS NULL
  GROUP BY campaign_id, metric, target_x_mm, target_y_mm, target_phi_deg
), pair AS (
  SELECT figure.*, baseline.value AS before,
         EXISTS (SELECT 1 FROM job_point JOIN reading ON reading.campaign_id = figure.campaign_id
                 AND reading.seq = job_point.seq
                 WHERE job_point.job_id = figure.compensation_job_id AND job_point.in_sample = 1
                 AND reading.target_x_mm = figure.target_x_mm
                 AND reading.target_y_mm = figure.target_y_mm) AS fitted
  FROM figure JOIN baseline USING (campaign_id, metric, target_x_mm, target_y_mm, target_phi_deg)
  WHERE figure.compensation_job_id IS NOT NULL
), ranked AS (
  SELECT *, count(*) OVER (PARTITION BY session_id, reading_set, metric, fitted) AS n,
         row_number() OVER (PARTITION BY session_id, reading_set, metric, fitted
                            ORDER BY before) - 1 AS before_rank,
         row_number() OVER (PARTITION BY session_id, reading_set, metric, fitted
                            ORDER BY value) - 1 AS after_rank
  FROM pair
)
SELECT campaign, kind, session, method, 'measured' AS source, reading_set, metric,
       fitted AS in_sample, n,
       avg(before) AS before_mean, max(before) AS before_max, min(before) AS before_min,
       sum(before * max(0.0, 1 - abs(before_rank - 0.95 * (n - 1)))) AS before_p95,
       avg(value) AS after_mean, max(value) AS after_max, min(value) AS after_min,
       sum(value * max(0.0, 1 - abs(after_rank - 0.95 * (n - 1)))) AS after_p95,
       100 * (1 - avg(value) / nullif(avg(before), 0)) AS improvement_pct
FROM ranked GROUP BY session_id, reading_set, metric, fitted
UNION ALL
SELECT campaign.name, campaign.kind, (SELECT group_concat(name, ' ') FROM job_session
       JOIN session USING (session_id) WHERE job_session.job_id = job.job_id),
       stage, 'predicted', b.reading_set, b.metric, b.in_sample, b.n,
       b.mean, b.max, b.min, b.p95, a.mean, a.max, a.min, a.p95,
       100 * (1 - a.mean / nullif(b.mean, 0))
FROM job JOIN campaign USING (campaign_id)
JOIN job_statistic AS b ON b.job_id = job.job_id AND b.phase = 'before'
JOIN job_statistic AS a ON a.job_id = job.job_id AND a.phase = 'after'
  AND a.reading_set = b.reading_set AND a.metric = b.metric AND a.in_sample = b.in_sample;

-- What moved between visits: the same command from the same side, compared with the first visit in
-- its session. n_visits = 1 tells nothing and is left out.
CREATE VIEW v_drift AS
WITH visit AS (
  SELECT campaign.name AS campaign, session.name AS session, reading.seq, reading.epoch, time_s,
         temp_degc, x_mm, y_mm, phi_rad, reading.target_x_mm, reading.target_y_mm,
         degrees(reading.target_phi_rad) AS target_phi_deg, coalesce(point.is_reference, 0) AS is_reference,
         count(*) OVER same AS n_visits,
         row_number() OVER (same ORDER BY reading.seq) AS visit,
         first_value(x_mm) OVER (same ORDER BY reading.seq) AS first_x_mm,
         first_value(y_mm) OVER (same ORDER BY reading.seq) AS first_y_mm,
         first_value(phi_rad) OVER (same ORDER BY reading.seq) AS first_phi_rad,
         first_value(temp_degc) OVER (same ORDER BY reading.seq) AS first_temp_degc
  FROM reading JOIN campaign USING (campaign_id)
  JOIN session ON session.session_id = reading.session_id
  LEFT JOIN attempt ON attempt.attempt_id = reading.attempt_id
  LEFT JOIN point ON point.point_id = attempt.point_id
  WHERE x_mm IS NOT NULL
  WINDOW same AS (PARTITION BY reading.session_id, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm,
                  sign(cmd_l1_mm - from_l1_mm), sign(cmd_l2_mm - from_l2_mm),
                  sign(cmd_l3_mm - from_l3_mm))
)
SELECT campaign, session, seq, epoch, is_reference, visit, n_visits, time_s, temp_degc,
       target_x_mm, target_y_mm, target_phi_deg,
       x_mm - first_x_mm AS drift_x_mm, y_mm - first_y_mm AS drift_y_mm,
       degrees(phi_rad - first_phi_rad) AS drift_phi_deg,
       temp_degc - first_temp_degc AS drift_temp_degc
FROM visit WHERE n_visits > 1;
