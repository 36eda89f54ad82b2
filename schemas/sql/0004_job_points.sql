-- Version 4: the points of a job stand in its result, as `points`: columns seq, in_sample, x_mm, y_mm,
-- phi_rad (the predicted error after the correction). What was measured before stands in the readings
-- already. job_point keeps the rows of jobs stored until version 3; the view has both.

CREATE VIEW v_job_point AS
WITH predicted AS (
  SELECT job_id, seq, in_sample, after_x_mm, after_y_mm, after_phi_rad FROM job_point
  UNION ALL
  SELECT job.job_id, max(CASE part.key WHEN 'seq' THEN item.value END),
         max(CASE part.key WHEN 'in_sample' THEN item.value END),
         max(CASE part.key WHEN 'x_mm' THEN item.value END),
         max(CASE part.key WHEN 'y_mm' THEN item.value END),
         max(CASE part.key WHEN 'phi_rad' THEN item.value END)
  FROM job, json_each(job.result_json, '$.points') AS part, json_each(part.value) AS item
  GROUP BY job.job_id, item.key
)
SELECT predicted.job_id, campaign.name AS campaign, campaign.kind, job.stage, predicted.seq, in_sample,
       target_x_mm, target_y_mm, degrees(target_phi_rad) AS target_phi_deg,
       x_mm - target_x_mm AS before_x_mm, y_mm - target_y_mm AS before_y_mm,
       degrees(phi_rad - target_phi_rad) AS before_phi_deg,
       after_x_mm, after_y_mm, degrees(after_phi_rad) AS after_phi_deg
FROM predicted JOIN job USING (job_id) JOIN campaign USING (campaign_id)
JOIN reading ON reading.campaign_id = job.campaign_id AND reading.seq = predicted.seq;

DROP VIEW v_accuracy;

-- Before and after per campaign, session and method. Two sources, never mixed: `predicted` is what a
-- job states of its own fit; `measured` compares a compensated session, target by target, with the
-- baseline session that shares most of its targets (of equals the first). in_sample: judged at points
-- that were fitted. p95 interpolates between order statistics.
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
), shared AS (
  SELECT compensated.session_id, plain.session_id AS baseline_id,
         row_number() OVER (PARTITION BY compensated.session_id
                            ORDER BY count(*) DESC, plain.session_id) AS rank
  FROM figure AS compensated
  JOIN figure AS plain USING (campaign_id, metric, target_x_mm, target_y_mm, target_phi_deg)
  WHERE metric = 'position_mm' AND compensated.compensation_job_id IS NOT NULL
    AND plain.compensation_job_id IS NULL
  GROUP BY compensated.session_id, plain.session_id
), baseline AS (
  SELECT shared.session_id, metric, target_x_mm, target_y_mm, target_phi_deg, avg(value) AS value
  FROM shared JOIN figure ON figure.session_id = shared.baseline_id
  WHERE rank = 1
  GROUP BY shared.session_id, metric, target_x_mm, target_y_mm, target_phi_deg
), fit AS (
  SELECT DISTINCT job_id, target_x_mm, target_y_mm FROM v_job_point
  WHERE in_sample = 1 AND job_id IN (SELECT compensation_job_id FROM session)
), pair AS (
  SELECT figure.*, baseline.value AS before,
         EXISTS (SELECT 1 FROM fit WHERE fit.job_id = figure.compensation_job_id
                 AND fit.target_x_mm = figure.target_x_mm
                 AND fit.target_y_mm = figure.target_y_mm) AS fitted
  FROM figure JOIN baseline USING (session_id, metric, target_x_mm, target_y_mm, target_phi_deg)
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
