-- v_accuracy by the rules of core/judge, as `trammel query` answers it on a station: a compensated session that was
-- finished against its baseline, visit by visit, in the figures that the machine measures. Before, a target's mean stood
-- for its visits, sessions that were stopped counted, and a machine without phi had an attitude without a value.
INSERT INTO trammel.archive (version) VALUES (7);
SET LOCAL search_path = trammel, pg_catalog;

-- A station's file has no other numbers (schemas/sql); not a number, from a stranger, would end every question about all.
ALTER TABLE trammel.reading ADD CONSTRAINT reading_has_numbers CHECK (
  greatest(target_x_mm, target_y_mm, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm,
           encoder_l1_mm, encoder_l2_mm, encoder_l3_mm) <= 1e5
  AND least(target_x_mm, target_y_mm, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm,
            encoder_l1_mm, encoder_l2_mm, encoder_l3_mm) >= -1e5
  AND greatest(abs(x_mm), abs(y_mm)) <= 1e6 AND abs(target_phi_rad) <= 100 AND abs(phi_rad) <= 1000
  AND abs(time_s) <= 1e10 AND temp_degc BETWEEN -273.15 AND 1000) NOT VALID;

-- The role of each reading of an imported session, by its seq; none where a stranger's settings are not JSON.
CREATE FUNCTION trammel.roles_of(settings_json text) RETURNS jsonb LANGUAGE plpgsql IMMUTABLE AS $$
BEGIN
  RETURN settings_json::jsonb -> 'roles';
EXCEPTION WHEN data_exception OR program_limit_exceeded THEN RETURN NULL;
END $$;
-- Of a station's job: the seq of the readings that it left out.
CREATE FUNCTION trammel.left_out(of_campaign text, of_job_id bigint) RETURNS bigint[] LANGUAGE sql STABLE AS $$
  SELECT ARRAY(SELECT v[1]::bigint FROM trammel.archive_row AS a, trammel.part_of('job', a.bytes, a.n_rows, 3) AS v
               WHERE a.campaign = of_campaign AND a.table_name = 'job' AND a.row_ids[1] = of_job_id) $$;
-- How far an angle is from a whole turn.
CREATE FUNCTION trammel.turn_deg(rad float8) RETURNS float8 LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT abs(trammel.deg(rad - 6.283185307179586 * trammel.nearest(rad / 6.283185307179586))) $$;

-- Of one campaign, so that a question about one looks at no other. Numbers as in core/judge: targets are one within
-- 1e-3 mm and 1e-5 rad. What a plan had is known as far as it was walked. Each step is taken for one row by whoever
-- plans the question: in loops within loops 15,000 readings took half a minute.
CREATE OR REPLACE FUNCTION trammel.measured_accuracy(of_campaign text)
RETURNS TABLE (session text, method text, reading_set text, metric text, in_sample bigint, n bigint,
  before_mean float8, before_max float8, before_min float8, before_p95 float8,
  after_mean float8, after_max float8, after_min float8, after_p95 float8, improvement_pct float8)
LANGUAGE sql STABLE SET enable_nestloop = off SET enable_mergejoin = off SET jit = off AS $$
WITH machine AS MATERIALIZED (
  SELECT v[7] = '1' AS has_phi FROM trammel.archive_row AS a, trammel.part_of('campaign', a.bytes, a.n_rows, 2, false) AS v
  WHERE a.campaign = of_campaign AND a.table_name = 'campaign'
), session AS MATERIALIZED (
  SELECT v.session_id, v.session, v.method, v.station, v.compensation_job_id, v.job_campaign_uuid, s.n_points, s.n_asked,
         s.compensation_name <> '' AS compensated,
         CASE WHEN s.n_points = 0 THEN trammel.roles_of(s.settings_json) END AS roles
  FROM trammel.v_session AS v JOIN trammel.session AS s ON s.campaign = v.campaign_uuid AND s.name = v.session
  WHERE v.campaign_uuid = of_campaign
), place AS MATERIALIZED (
  SELECT seq, session, point, reading_set, target_x_mm AS to_x, coalesce(target_y_mm, 0) AS to_y,
         coalesce(target_phi_rad, 0) AS to_phi, coalesce(x_mm, target_x_mm) AS x, coalesce(y_mm, target_y_mm, 0) AS y,
         coalesce(phi_rad, target_phi_rad, 0) AS phi
  FROM trammel.reading WHERE campaign = of_campaign
), apart AS (
  SELECT *, to_x - lag(to_x) OVER (ORDER BY to_x) > 1e-3 AS new_x, to_y - lag(to_y) OVER (ORDER BY to_y) > 1e-3 AS new_y,
         turned - lag(turned) OVER (ORDER BY turned) > 1e-5 AS new_phi
  FROM (SELECT *, to_phi - 6.283185307179586 * floor(to_phi / 6.283185307179586 + 0.500001) AS turned FROM place) AS p
), numbered AS (
  SELECT *, ARRAY[count(*) FILTER (WHERE new_x) OVER (ORDER BY to_x), count(*) FILTER (WHERE new_y) OVER (ORDER BY to_y),
                  count(*) FILTER (WHERE new_phi) OVER (ORDER BY turned)] AS target FROM apart
), walked AS MATERIALIZED (
  SELECT s.session_id, s.session, r.seq, r.reading_set, r.target, r.to_x, r.to_y, r.to_phi, r.x, r.y, r.phi,
         CASE WHEN s.n_asked > 0 THEN row_number() OVER (PARTITION BY s.session_id ORDER BY r.seq)
              ELSE coalesce(r.point, r.seq) END AS point,
         r.reading_set <> 'predict' AS measured,
         r.reading_set <> 'predict' AND e.seq IS NULL
           AND coalesce(p.role, s.roles ->> r.seq::text, '') NOT LIKE 'reference%' AS counts
  FROM session AS s JOIN numbered AS r USING (session)
  LEFT JOIN trammel.exclusion AS e ON e.campaign = of_campaign AND e.seq = r.seq
  LEFT JOIN trammel.point AS p ON p.campaign = of_campaign AND p.session = r.session AND p.seq = r.point
), walk AS MATERIALIZED (
  SELECT session_id, compensated, planned, counts,
         CASE WHEN n_asked > 0 THEN n_walked ELSE n_points_done END >= planned AS complete
  FROM (SELECT s.session_id, s.compensated, s.n_asked, count(*) AS n_walked, bool_or(w.counts) AS counts,
               count(DISTINCT w.point) FILTER (WHERE w.measured) AS n_points_done,
               CASE WHEN s.n_asked > 0 THEN greatest(s.n_asked, count(*)) ELSE s.n_points END AS planned
        FROM session AS s JOIN walked AS w USING (session_id)
        GROUP BY s.session_id, s.compensated, s.n_asked, s.n_points) AS counted
), one_plan AS MATERIALIZED (
  SELECT a.session_id AS a, b.session_id AS b FROM walk AS a JOIN walk AS b USING (planned) WHERE planned > 0
  EXCEPT
  SELECT a.session_id, b.session_id FROM walked AS a JOIN walked AS b USING (point) WHERE a.target <> b.target
), stands AS MATERIALIZED (
  SELECT session_id, compensated FROM walk
  WHERE counts AND (complete OR NOT compensated AND NOT EXISTS (
    SELECT FROM one_plan JOIN walk AS whole ON whole.session_id = one_plan.a
    WHERE one_plan.b = walk.session_id AND whole.counts AND whole.complete AND NOT whole.compensated))
), visit AS MATERIALIZED (
  SELECT *, row_number() OVER (PARTITION BY session_id, target ORDER BY seq) AS turn,
         row_number() OVER (PARTITION BY session_id, target, point ORDER BY seq) AS turn_of_point
  FROM walked WHERE counts
), compared AS (
  SELECT c.session_id, b.session_id AS baseline_id,
         EXISTS (SELECT FROM one_plan WHERE a = b.session_id AND one_plan.b = c.session_id) AS same_plan
  FROM stands AS c JOIN stands AS b ON c.compensated AND NOT b.compensated
), pair AS MATERIALIZED (
  SELECT c.session_id, c.baseline_id, before.reading_set, before.target,
         sqrt((before.x - before.to_x) ^ 2 + (before.y - before.to_y) ^ 2) AS before_mm,
         sqrt((later.x - before.to_x) ^ 2 + (later.y - before.to_y) ^ 2) AS after_mm,
         trammel.turn_deg(before.phi - before.to_phi) AS before_deg, trammel.turn_deg(later.phi - before.to_phi) AS after_deg
  FROM compared AS c JOIN visit AS before ON before.session_id = c.baseline_id
  JOIN visit AS later ON later.session_id = c.session_id AND later.target = before.target
  WHERE CASE WHEN c.same_plan THEN later.point = before.point AND later.turn_of_point = before.turn_of_point
             ELSE later.turn = before.turn END
), chosen AS (
  SELECT DISTINCT ON (session_id) session_id, baseline_id FROM pair GROUP BY session_id, baseline_id
  ORDER BY session_id, count(*) DESC, baseline_id
), correction AS MATERIALIZED (
  SELECT s.session_id, j.sessions, j.n_readings, trammel.left_out(of_campaign, j.job_id) AS left_out
  FROM session AS s JOIN trammel.job AS j ON s.job_campaign_uuid = of_campaign AND j.campaign = of_campaign
    AND j.station = s.station AND j.job_id = s.compensation_job_id
), taken AS (
  SELECT c.session_id, w.target, w.reading_set, c.n_readings,
         row_number() OVER (PARTITION BY c.session_id ORDER BY w.seq) AS n
  FROM correction AS c JOIN walked AS w ON w.session = ANY (c.sessions) AND w.seq <> ALL (c.left_out)
  UNION ALL
  SELECT s.session_id, w.target, w.reading_set, 0, 0 FROM session AS s
  JOIN session AS plain ON s.compensated AND s.compensation_job_id IS NULL AND NOT plain.compensated
  JOIN walked AS w ON w.session_id = plain.session_id
), fit AS MATERIALIZED (
  SELECT DISTINCT session_id, target, 1::bigint AS fitted FROM taken WHERE n <= n_readings AND reading_set = 'identify'
), figure AS (
  SELECT s.session_id, s.session, s.method, pair.reading_set, m.metric, coalesce(fitted, 0) AS fitted, m.before, m.later
  FROM pair JOIN chosen USING (session_id, baseline_id) JOIN session AS s USING (session_id)
  LEFT JOIN fit USING (session_id, target)
  CROSS JOIN machine CROSS JOIN LATERAL (VALUES ('position_mm', before_mm, after_mm),
                             ('attitude_deg', before_deg, after_deg)) AS m (metric, before, later)
  WHERE m.metric = 'position_mm' OR has_phi
), ranked AS (
  SELECT *, count(*) OVER part AS n, row_number() OVER (part ORDER BY before) - 1 AS before_rank,
         row_number() OVER (part ORDER BY later) - 1 AS after_rank
  FROM figure WINDOW part AS (PARTITION BY session_id, reading_set, metric, fitted)
)
SELECT session, method, reading_set, metric, fitted, n,
       avg(before), max(before), min(before),
       sum(before * greatest(0, 1 - abs(before_rank - 0.95::float8 * (n - 1)))),
       avg(later), max(later), min(later),
       sum(later * greatest(0, 1 - abs(after_rank - 0.95::float8 * (n - 1)))),
       100 * (1 - avg(later) / nullif(avg(before), 0))
FROM ranked GROUP BY session_id, session, method, reading_set, metric, fitted, n
$$;

-- What a fit could not know (an epoch of its own) is no improvement of it.
CREATE OR REPLACE VIEW trammel.v_accuracy AS
SELECT c.name AS campaign, c.kind, m.session, m.method, 'measured' AS source, m.reading_set, m.metric, m.in_sample, m.n,
       m.before_mean, m.before_max, m.before_min, m.before_p95, m.after_mean, m.after_max, m.after_min, m.after_p95,
       m.improvement_pct, h.station
FROM trammel.campaign AS c JOIN trammel.campaign_head AS h USING (campaign),
     LATERAL trammel.measured_accuracy(c.campaign) AS m
UNION ALL
SELECT c.name, c.kind, (SELECT string_agg(s.name, ' ' ORDER BY s.session_id) FROM trammel.session AS s
                        WHERE s.campaign = j.campaign AND s.name = ANY (j.sessions)),
       j.stage, 'predicted', b.reading_set, b.metric, b.in_sample, b.n, b.mean, b.max, b.min, b.p95,
       a.mean, a.max, a.min, a.p95,
       CASE WHEN b.reading_set <> 'new epoch' THEN 100 * (1 - a.mean / nullif(b.mean, 0)) END, j.station
FROM trammel.job AS j JOIN trammel.campaign AS c USING (campaign)
JOIN trammel.job_statistic AS b USING (campaign, station, key, run)
JOIN trammel.job_statistic AS a USING (campaign, station, key, run, reading_set, metric, in_sample)
WHERE b.phase = 'before' AND a.phase = 'after';
