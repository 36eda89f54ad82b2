-- The questions people ask, under the names and columns of the store's views (store/README.md), with the station.
-- What they look at stands in typed tables, which the archive fills from the bytes it was sent: X_of(archive_row) are
-- the rows of table X that a row makes, `filled` asks them as rows arrive, typed_findings() asks them again.
-- Numbers of rows (campaign_id, session_id, job_id) are the station's own: unique with the station alone.
INSERT INTO trammel.archive (version) VALUES (3);
SET LOCAL search_path = trammel, pg_catalog;

CREATE TABLE trammel.session (
  campaign text NOT NULL REFERENCES trammel.campaign_head,
  session_id bigint NOT NULL,
  name text NOT NULL,
  compensation_job_key text,
  compensation_job_run bigint,
  compensation_name text NOT NULL,
  plan_name text NOT NULL,
  n_points bigint NOT NULL,
  n_imported bigint NOT NULL,
  n_asked bigint NOT NULL,
  stage text NOT NULL,
  tracker text NOT NULL,
  settings_json text NOT NULL,
  tool_version text NOT NULL,
  created_utc text NOT NULL,
  PRIMARY KEY (campaign, name)
);
CREATE TABLE trammel.point (
  campaign text NOT NULL,
  session text NOT NULL,
  seq bigint NOT NULL,
  reading_set text NOT NULL,
  is_reference bigint NOT NULL,
  role text NOT NULL,
  PRIMARY KEY (campaign, session, seq)
);
CREATE TABLE trammel.attempt (
  campaign text NOT NULL,
  session text NOT NULL,
  point bigint NOT NULL,
  number bigint NOT NULL,
  status text NOT NULL,
  PRIMARY KEY (campaign, session, point, number)
);
CREATE TABLE trammel.exclusion (
  campaign text NOT NULL,
  seq bigint NOT NULL,
  reason text NOT NULL,
  PRIMARY KEY (campaign, seq)
);
-- fitted: the seq of the readings that it was fitted to. job_id is NULL where no station has it: a worker's result.
CREATE TABLE trammel.job (
  station text NOT NULL REFERENCES trammel.station,
  campaign text NOT NULL REFERENCES trammel.campaign_head,
  job_id bigint,
  key text NOT NULL,
  key_scheme bigint NOT NULL,
  run bigint NOT NULL,
  stage text NOT NULL,
  algorithm_version bigint NOT NULL,
  parameters_json text NOT NULL,
  n_readings bigint NOT NULL,
  tool_version text NOT NULL,
  git_revision text NOT NULL,
  compiler text NOT NULL,
  libraries text NOT NULL,
  cpu_level text NOT NULL,
  created_utc text NOT NULL,
  duration_s float8 NOT NULL,
  sessions text[] NOT NULL,
  n_exclusions bigint NOT NULL,
  parent_keys text[] NOT NULL,
  parent_runs bigint[] NOT NULL,
  fitted bigint[] NOT NULL,
  PRIMARY KEY (campaign, station, key, run)
);
CREATE INDEX job_by_stage ON trammel.job (stage, created_utc DESC);
CREATE INDEX job_by_key ON trammel.job (key);
CREATE TABLE trammel.job_statistic (
  station text NOT NULL,
  campaign text NOT NULL,
  key text NOT NULL,
  run bigint NOT NULL,
  reading_set text NOT NULL,
  metric text NOT NULL,
  in_sample bigint NOT NULL,
  phase text NOT NULL,
  mean float8 NOT NULL,
  max float8 NOT NULL,
  min float8 NOT NULL,
  p95 float8 NOT NULL,
  n bigint NOT NULL,
  PRIMARY KEY (campaign, station, key, run, reading_set, metric, in_sample, phase)
);

CREATE FUNCTION trammel.session_of(a trammel.archive_row) RETURNS SETOF trammel.session LANGUAGE sql STABLE AS $$
  SELECT v[1], a.row_ids[1], v[2], v[3], v[4]::bigint, v[5], v[6], v[7]::bigint, v[8]::bigint, v[9]::bigint, v[10],
         v[11], v[12], v[13], v[14]
  FROM trammel.part_of('session', a.bytes, a.n_rows, 1) AS v $$;
CREATE FUNCTION trammel.point_of(a trammel.archive_row) RETURNS SETOF trammel.point LANGUAGE sql STABLE AS $$
  SELECT a.campaign, s[2], v[1]::bigint, v[2], v[10]::bigint, v[11]
  FROM trammel.part_of('session', a.bytes, a.n_rows, 1) AS s, trammel.part_of('session', a.bytes, a.n_rows, 2, false) AS v $$;
CREATE FUNCTION trammel.attempt_of(a trammel.archive_row) RETURNS SETOF trammel.attempt LANGUAGE sql STABLE AS $$
  SELECT v[1], v[2], v[3]::bigint, v[4]::bigint, v[6] FROM trammel.part_of('attempt', a.bytes, a.n_rows, 1) AS v $$;
CREATE FUNCTION trammel.exclusion_of(a trammel.archive_row) RETURNS SETOF trammel.exclusion LANGUAGE sql STABLE AS $$
  SELECT v[1], v[2]::bigint, v[3] FROM trammel.part_of('exclusion', a.bytes, a.n_rows, 1) AS v $$;

-- A job is its campaign's station's, unless a worker found it.
CREATE FUNCTION trammel.station_of(of_campaign text) RETURNS text LANGUAGE sql STABLE AS
$$ SELECT station FROM trammel.campaign_head WHERE campaign = of_campaign $$;
-- The points of a result stand as {"points": {"in_sample": […], "seq": […], …}}; until version 3 of the store in part 7.
CREATE FUNCTION trammel.fitted_of(result json) RETURNS bigint[] LANGUAGE sql IMMUTABLE AS $$
  SELECT coalesce(array_agg(seq::bigint ORDER BY seq::bigint) FILTER (WHERE fitted IN ('1', 'true')), '{}')
  FROM ROWS FROM (json_array_elements_text(result #> '{points,seq}'),
                  json_array_elements_text(result #> '{points,in_sample}')) AS p (seq, fitted)
$$;
CREATE FUNCTION trammel.job_of(a trammel.archive_row, of_station text, of_id bigint) RETURNS SETOF trammel.job
LANGUAGE sql STABLE AS $$
  SELECT of_station, v[1], of_id, v[2], v[3]::bigint, v[4]::bigint, v[5], v[6]::bigint, v[7], v[10]::bigint, v[11], v[12],
         v[13], v[14], v[15], v[16], v[17]::float8,
         ARRAY(SELECT s[1] FROM trammel.part_of('job', a.bytes, a.n_rows, 2) AS s), a.n_rows[3]::bigint,
         ARRAY(SELECT p[1] FROM trammel.part_of('job', a.bytes, a.n_rows, 4) AS p),
         ARRAY(SELECT p[2]::bigint FROM trammel.part_of('job', a.bytes, a.n_rows, 4) AS p),
         trammel.fitted_of(v[9]::json) || ARRAY(SELECT p[1]::bigint FROM trammel.part_of('job', a.bytes, a.n_rows, 7, false) AS p
                                                 WHERE p[2] = '1')
  FROM trammel.part_of('job', a.bytes, a.n_rows, 1) AS v $$;
CREATE FUNCTION trammel.job_statistic_of(a trammel.archive_row, of_station text) RETURNS SETOF trammel.job_statistic
LANGUAGE sql STABLE AS $$
  SELECT of_station, j[1], j[2], j[4]::bigint, v[1], v[2], v[3]::bigint, v[4], v[5]::float8, v[6]::float8, v[7]::float8,
         v[8]::float8, v[9]::bigint
  FROM trammel.part_of('job', a.bytes, a.n_rows, 1) AS j, trammel.part_of('job', a.bytes, a.n_rows, 6) AS v $$;

-- The rows that typed rows are made of: what stations sent, and what workers found. The latter have no number.
CREATE FUNCTION trammel.row_of(r trammel.result) RETURNS trammel.archive_row LANGUAGE sql IMMUTABLE AS $$
  SELECT ROW(r.campaign, 'job', r.row_key, '{0}'::bigint[], r.n_rows, r.bytes, r.sha256, r.received_at)::trammel.archive_row $$;
CREATE VIEW trammel.made AS
SELECT r.table_name, trammel.station_of(r.campaign) AS station, r.row_ids[1] AS id, r AS a FROM trammel.archive_row AS r
UNION ALL
SELECT 'job', r.station, NULL, trammel.row_of(r) FROM trammel.result AS r
WHERE NOT EXISTS (SELECT 1 FROM trammel.result AS earlier WHERE earlier.campaign = r.campaign
                  AND earlier.station = r.station AND earlier.row_key = r.row_key AND earlier.id < r.id);

CREATE FUNCTION trammel.filled() RETURNS trigger
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET enable_seqscan = off SET jit = off
SET plan_cache_mode = force_generic_plan AS $$
BEGIN
  INSERT INTO trammel.campaign SELECT made.* FROM arrived AS a, trammel.campaign_of(ROW(a.*)::trammel.archive_row) AS made
    WHERE a.table_name = 'campaign';
  INSERT INTO trammel.session SELECT made.* FROM arrived AS a, trammel.session_of(ROW(a.*)::trammel.archive_row) AS made
    WHERE a.table_name = 'session';
  INSERT INTO trammel.point SELECT made.* FROM arrived AS a, trammel.point_of(ROW(a.*)::trammel.archive_row) AS made
    WHERE a.table_name = 'session' AND a.n_rows[2] > 0;
  INSERT INTO trammel.attempt SELECT made.* FROM arrived AS a, trammel.attempt_of(ROW(a.*)::trammel.archive_row) AS made
    WHERE a.table_name = 'attempt';
  INSERT INTO trammel.exclusion SELECT made.* FROM arrived AS a, trammel.exclusion_of(ROW(a.*)::trammel.archive_row) AS made
    WHERE a.table_name = 'exclusion';
  INSERT INTO trammel.job SELECT made.* FROM arrived AS a, 
    trammel.job_of(ROW(a.*)::trammel.archive_row, trammel.station_of(a.campaign), a.row_ids[1]) AS made
    WHERE a.table_name = 'job';
  INSERT INTO trammel.job_statistic SELECT made.* FROM arrived AS a,
    trammel.job_statistic_of(ROW(a.*)::trammel.archive_row, trammel.station_of(a.campaign)) AS made WHERE a.table_name = 'job';
  RETURN NULL;
END $$;
CREATE TRIGGER filled AFTER INSERT ON trammel.archive_row REFERENCING NEW TABLE AS arrived
  FOR EACH STATEMENT EXECUTE FUNCTION trammel.filled();

-- Of several results under one key and run (of other CPU levels, of alarms) the first is the one that is asked about.
CREATE FUNCTION trammel.result_filled() RETURNS trigger
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  INSERT INTO trammel.job SELECT * FROM trammel.job_of(trammel.row_of(NEW), NEW.station, NULL) ON CONFLICT DO NOTHING;
  IF FOUND THEN
    INSERT INTO trammel.job_statistic SELECT * FROM trammel.job_statistic_of(trammel.row_of(NEW), NEW.station);
  END IF;
  RETURN NULL;
END $$;
CREATE TRIGGER filled AFTER INSERT ON trammel.result FOR EACH ROW EXECUTE FUNCTION trammel.result_filled();

DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['session', 'point', 'attempt', 'exclusion', 'job', 'job_statistic'] LOOP
    EXECUTE format('CREATE TRIGGER stays BEFORE UPDATE OR DELETE OR TRUNCATE ON trammel.%I '
                   'FOR EACH STATEMENT EXECUTE FUNCTION trammel.refuse()', name);
  END LOOP;
END $$;

-- Everything recomputed: what was sent, and what was made of it. None where all is well.
CREATE FUNCTION trammel.findings() RETURNS SETOF text LANGUAGE plpgsql STABLE AS $$
DECLARE
  one record;
BEGIN
  RETURN QUERY SELECT trammel.stored_findings();
  FOR one IN SELECT * FROM (VALUES ('campaign', 'campaign', 'a'), ('session', 'session', 'a'), ('point', 'session', 'a'),
      ('attempt', 'attempt', 'a'), ('exclusion', 'exclusion', 'a'), ('job', 'job', 'a, station, id'),
      ('job_statistic', 'job', 'a, station')) AS t (typed, sealed, given) LOOP
    RETURN QUERY EXECUTE format($query$
      WITH made AS (SELECT made.campaign, made::text AS text FROM trammel.made AS m, trammel.%1$I_of(%3$s) AS made
                    WHERE m.table_name = %2$L),
           typed AS (SELECT t.campaign, t::text AS text FROM trammel.%1$I AS t)
      SELECT format('campaign %%s: a row of %1$s differs from the bytes it was made of', campaign)
      FROM ((TABLE made EXCEPT ALL TABLE typed) UNION ALL (TABLE typed EXCEPT ALL TABLE made)) AS differing
      $query$, one.typed, one.sealed, one.given);
  END LOOP;
END $$;

-- The visits' session with the job of its compensation, which may be one of another campaign: its own first.
CREATE VIEW trammel.v_session AS
SELECT h.station, c.campaign AS campaign_uuid, c.campaign_id, c.name AS campaign, c.kind, s.session_id, s.name AS session,
       s.compensation_name, j.job_id AS compensation_job_id, j.campaign AS job_campaign_uuid, j.fitted,
       coalesce(j.stage, nullif(s.compensation_name, ''), 'baseline') AS method
FROM trammel.session AS s JOIN trammel.campaign AS c USING (campaign) JOIN trammel.campaign_head AS h USING (campaign)
LEFT JOIN LATERAL (SELECT job.job_id, job.campaign, job.stage, job.fitted FROM trammel.job
                   WHERE job.key = s.compensation_job_key AND job.run = s.compensation_job_run AND job.station = h.station
                     AND job.job_id IS NOT NULL
                   ORDER BY job.campaign = s.campaign DESC, job.job_id LIMIT 1) AS j ON true;

-- The campaign, and those whose jobs its sessions and jobs are built on, and theirs.
CREATE FUNCTION trammel.needed_by(of_campaign text) RETURNS SETOF text LANGUAGE sql STABLE AS $$
  WITH RECURSIVE needed (campaign) AS (
    SELECT of_campaign UNION
    SELECT other.campaign FROM needed AS n,
      LATERAL (SELECT compensation_job_key, compensation_job_run FROM trammel.session WHERE session.campaign = n.campaign
               UNION SELECT unnest(parent_keys), unnest(parent_runs) FROM trammel.job WHERE job.campaign = n.campaign) AS named (key, run),
      LATERAL (SELECT job.campaign FROM trammel.job
               WHERE job.key = named.key AND job.run = named.run AND job.station = trammel.station_of(of_campaign)
                 AND job.job_id IS NOT NULL
               ORDER BY job.campaign = n.campaign DESC, job.job_id LIMIT 1) AS other)
  SELECT campaign FROM needed $$;

CREATE VIEW trammel.v_point_status AS
SELECT c.name AS campaign, p.session, s.session_id, p.seq, p.reading_set, p.role,
       coalesce((SELECT status FROM trammel.attempt AS a
                 WHERE a.campaign = p.campaign AND a.session = p.session AND a.point = p.seq
                 ORDER BY status = 'ok' DESC, number DESC LIMIT 1), 'planned') AS status,
       (SELECT count(*) FROM trammel.attempt AS a
        WHERE a.campaign = p.campaign AND a.session = p.session AND a.point = p.seq) AS n_attempts,
       h.station
FROM trammel.point AS p JOIN trammel.session AS s ON s.campaign = p.campaign AND s.name = p.session
JOIN trammel.campaign AS c ON c.campaign = p.campaign JOIN trammel.campaign_head AS h ON h.campaign = p.campaign;

-- As SQLite computes them: degrees by one multiplication, halves away from zero.
CREATE FUNCTION trammel.deg(rad float8) RETURNS float8 LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT rad * 57.29577951308232 $$;
CREATE FUNCTION trammel.nearest(v float8) RETURNS bigint LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT (sign(v) * floor(abs(v) + 0.5))::bigint $$;
-- round(x, digits) of a question asks this one, where `trammel` is searched.
CREATE FUNCTION trammel.round(v float8, digits int) RETURNS float8 LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT pg_catalog.round(v::text::numeric, digits)::float8 $$;

CREATE VIEW trammel.v_point_error AS
SELECT s.campaign_id, s.campaign, s.kind, s.session_id, s.session, s.method, s.compensation_job_id, s.compensation_name,
       r.seq, r.epoch, r.reading_set, r.target_x_mm, r.target_y_mm, trammel.deg(r.target_phi_rad) AS target_phi_deg,
       r.x_mm - r.target_x_mm AS error_x_mm, r.y_mm - r.target_y_mm AS error_y_mm,
       sqrt(coalesce((r.x_mm - r.target_x_mm) * (r.x_mm - r.target_x_mm), 0)
            + coalesce((r.y_mm - r.target_y_mm) * (r.y_mm - r.target_y_mm), 0)) AS position_mm,
       trammel.deg(r.phi_rad - r.target_phi_rad) AS error_phi_deg,
       abs(trammel.deg(r.phi_rad - r.target_phi_rad)) AS attitude_deg,
       r.time_s, r.temp_degc, e.reason AS excluded,
       trammel.nearest(1e6 * r.target_x_mm) AS target_x_nm,
       trammel.nearest(1e6 * coalesce(r.target_y_mm, 0)) AS target_y_nm,
       trammel.nearest(1e6 * (coalesce(r.target_phi_rad, 0) - 6.283185307179586
         * trammel.nearest(coalesce(r.target_phi_rad, 0) / 6.283185307179586))) AS target_phi_urad,
       s.station, s.campaign_uuid
FROM trammel.v_session AS s JOIN trammel.reading AS r ON r.campaign = s.campaign_uuid AND r.session = s.session
LEFT JOIN trammel.exclusion AS e ON e.campaign = r.campaign AND e.seq = r.seq
WHERE r.reading_set <> 'predict';

CREATE VIEW trammel.v_job AS
SELECT j.job_id, c.name AS campaign, c.kind, j.stage, j.algorithm_version, j.run, j.key, j.key_scheme, j.n_readings,
       (SELECT string_agg(s.name, ' ' ORDER BY s.session_id) FROM trammel.session AS s
        WHERE s.campaign = j.campaign AND s.name = ANY (j.sessions)) AS sessions,
       j.n_exclusions,
       (SELECT string_agg(p.job_id::text, ' ' ORDER BY p.job_id)
        FROM ROWS FROM (unnest(j.parent_keys), unnest(j.parent_runs)) AS named (key, run),
             LATERAL (SELECT parent.job_id FROM trammel.job AS parent
                      WHERE parent.key = named.key AND parent.run = named.run AND parent.station = j.station
                      ORDER BY parent.campaign = j.campaign DESC, parent.job_id LIMIT 1) AS p) AS parents,
       j.parameters_json, j.created_utc, j.duration_s, j.tool_version, j.git_revision, j.cpu_level, j.station
FROM trammel.job AS j JOIN trammel.campaign AS c USING (campaign);

CREATE VIEW trammel.v_drift AS
WITH visit AS (
  SELECT s.campaign, s.session, r.seq, r.epoch, r.time_s, r.temp_degc, r.x_mm, r.y_mm, r.phi_rad, r.target_x_mm,
         r.target_y_mm, trammel.deg(r.target_phi_rad) AS target_phi_deg, coalesce(p.is_reference, 0) AS is_reference,
         count(*) OVER same AS n_visits, s.station,
         row_number() OVER in_turn AS visit,
         first_value(r.x_mm) OVER in_turn AS first_x_mm, first_value(r.y_mm) OVER in_turn AS first_y_mm,
         first_value(r.phi_rad) OVER in_turn AS first_phi_rad, first_value(r.temp_degc) OVER in_turn AS first_temp_degc
  FROM trammel.v_session AS s JOIN trammel.reading AS r ON r.campaign = s.campaign_uuid AND r.session = s.session
  LEFT JOIN trammel.point AS p ON p.campaign = r.campaign AND p.session = r.session AND p.seq = r.point
  WHERE r.reading_set <> 'predict'
  WINDOW same AS (PARTITION BY s.station, s.campaign, s.session, r.cmd_l1_mm, r.cmd_l2_mm, r.cmd_l3_mm,
                  sign(r.cmd_l1_mm - r.from_l1_mm), sign(r.cmd_l2_mm - r.from_l2_mm), sign(r.cmd_l3_mm - r.from_l3_mm)),
         in_turn AS (same ORDER BY r.seq)
)
SELECT campaign, session, seq, epoch, is_reference, visit, n_visits, time_s, temp_degc,
       target_x_mm, target_y_mm, target_phi_deg,
       x_mm - first_x_mm AS drift_x_mm, y_mm - first_y_mm AS drift_y_mm,
       trammel.deg(phi_rad - first_phi_rad) AS drift_phi_deg, temp_degc - first_temp_degc AS drift_temp_degc, station
FROM visit WHERE n_visits > 1;

-- Of one campaign, so that a question about one looks at no other. As the view of the store's file: `measured` compares
-- a compensated session, target by target, with the baseline session that shares most of its targets.
CREATE FUNCTION trammel.measured_accuracy(of_campaign text)
RETURNS TABLE (session text, method text, reading_set text, metric text, in_sample bigint, n bigint,
  before_mean float8, before_max float8, before_min float8, before_p95 float8,
  after_mean float8, after_max float8, after_min float8, after_p95 float8, improvement_pct float8)
LANGUAGE sql STABLE AS $$
WITH seen AS MATERIALIZED (
  SELECT * FROM trammel.v_point_error WHERE campaign_uuid = of_campaign
), figure AS (
  SELECT seen.*, m.metric, m.value FROM seen,
         LATERAL (VALUES ('position_mm', position_mm), ('attitude_deg', attitude_deg)) AS m (metric, value)
  WHERE excluded IS NULL
), shared AS (
  SELECT compensated.session_id, plain.session_id AS baseline_id,
         row_number() OVER (PARTITION BY compensated.session_id ORDER BY count(*) DESC, plain.session_id) AS rank
  FROM figure AS compensated JOIN figure AS plain USING (metric, target_x_nm, target_y_nm, target_phi_urad)
  WHERE metric = 'position_mm' AND compensated.compensation_name <> '' AND plain.compensation_name = ''
  GROUP BY compensated.session_id, plain.session_id
), baseline AS (
  SELECT shared.session_id, metric, target_x_nm, target_y_nm, target_phi_urad, avg(value) AS before
  FROM shared JOIN figure ON figure.session_id = shared.baseline_id
  WHERE rank = 1 GROUP BY shared.session_id, metric, target_x_nm, target_y_nm, target_phi_urad
), fit AS (
  SELECT DISTINCT s.session_id, at.target_x_nm, at.target_y_nm
  FROM trammel.v_session AS s JOIN trammel.v_point_error AS at
    ON at.campaign_uuid = s.job_campaign_uuid AND at.seq = ANY (s.fitted)
  WHERE s.campaign_uuid = of_campaign
), pair AS (
  SELECT figure.*, baseline.before,
         EXISTS (SELECT 1 FROM fit WHERE fit.session_id = figure.session_id AND fit.target_x_nm = figure.target_x_nm
                 AND fit.target_y_nm = figure.target_y_nm)::int::bigint AS fitted
  FROM figure JOIN baseline USING (session_id, metric, target_x_nm, target_y_nm, target_phi_urad)
  WHERE figure.compensation_name <> ''
), ranked AS (
  SELECT *, count(*) OVER part AS n, row_number() OVER (part ORDER BY before) - 1 AS before_rank,
         row_number() OVER (part ORDER BY value) - 1 AS after_rank
  FROM pair WINDOW part AS (PARTITION BY session_id, reading_set, metric, fitted)
)
SELECT session, method, reading_set, metric, fitted, n,
       avg(before), max(before), min(before),
       sum(before * greatest(0, 1 - abs(before_rank - 0.95::float8 * (n - 1)))),
       avg(value), max(value), min(value),
       sum(value * greatest(0, 1 - abs(after_rank - 0.95::float8 * (n - 1)))),
       100 * (1 - avg(value) / nullif(avg(before), 0))
FROM ranked GROUP BY session_id, session, method, reading_set, metric, fitted, n
$$;

CREATE VIEW trammel.v_accuracy AS
SELECT c.name AS campaign, c.kind, m.session, m.method, 'measured' AS source, m.reading_set, m.metric, m.in_sample, m.n,
       m.before_mean, m.before_max, m.before_min, m.before_p95, m.after_mean, m.after_max, m.after_min, m.after_p95,
       m.improvement_pct, h.station
FROM trammel.campaign AS c JOIN trammel.campaign_head AS h USING (campaign),
     LATERAL trammel.measured_accuracy(c.campaign) AS m
UNION ALL
SELECT c.name, c.kind, (SELECT string_agg(s.name, ' ' ORDER BY s.session_id) FROM trammel.session AS s
                        WHERE s.campaign = j.campaign AND s.name = ANY (j.sessions)),
       j.stage, 'predicted', b.reading_set, b.metric, b.in_sample, b.n, b.mean, b.max, b.min, b.p95,
       a.mean, a.max, a.min, a.p95, 100 * (1 - a.mean / nullif(b.mean, 0)), j.station
FROM trammel.job AS j JOIN trammel.campaign AS c USING (campaign)
JOIN trammel.job_statistic AS b USING (campaign, station, key, run)
JOIN trammel.job_statistic AS a USING (campaign, station, key, run, reading_set, metric, in_sample)
WHERE b.phase = 'before' AND a.phase = 'after';

GRANT SELECT ON ALL TABLES IN SCHEMA trammel TO trammel_station, trammel_worker, trammel_reader;
REVOKE EXECUTE ON FUNCTION trammel.filled, trammel.result_filled FROM PUBLIC;
