-- Calibrations that any number of machines compute. A worker claims one for a while (the lease), computes outside of any
-- transaction, and finishes with the token of its claim; what a lost worker had is claimed again. Its result is a job of
-- the worker's, which is a station of its own: nothing of the campaign's station changes.
INSERT INTO trammel.archive (version) VALUES (2);
SET LOCAL search_path = trammel, pg_catalog;

-- parameters_json: NULL as in the campaign's newest job of the stage. error: why the last attempt failed.
CREATE TABLE trammel.work (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  stage text NOT NULL CHECK (length(stage) BETWEEN 1 AND 100),
  parameters_json text CHECK (length(parameters_json) BETWEEN 2 AND 1000000),
  force boolean NOT NULL,
  campaign text NOT NULL REFERENCES trammel.campaign_head,
  station text NOT NULL REFERENCES trammel.station,
  state text NOT NULL DEFAULT 'waiting' CHECK (state IN ('waiting', 'claimed', 'done', 'failed')),
  attempts int NOT NULL DEFAULT 0,
  token uuid,
  worker text,
  machine text,
  lease_until timestamptz,
  error text CHECK (length(error) <= 10000),
  job_key text,
  queued_at timestamptz NOT NULL DEFAULT now(),
  finished_at timestamptz,
  CHECK ((state = 'claimed') = (lease_until IS NOT NULL)),
  CHECK ((state IN ('done', 'failed')) = (finished_at IS NOT NULL))
);
-- Cost follows what waits and what is claimed, not what is done. Those that failed before come after the others.
CREATE INDEX work_next ON trammel.work (attempts, id) WHERE state = 'waiting';
CREATE INDEX work_leases ON trammel.work (lease_until) WHERE state = 'claimed';
CREATE INDEX work_finished ON trammel.work (finished_at) WHERE finished_at IS NOT NULL;
CREATE UNIQUE INDEX work_once ON trammel.work (campaign, stage, coalesce(parameters_json, ''))
  WHERE state IN ('waiting', 'claimed');

-- What workers found: the sealed bytes of a job, as in archive_row. outcome: SHA-256 of what a computation must repeat,
-- so without its times. One row for a job key and CPU level; a second one is an alarm (v_alarm).
CREATE TABLE trammel.result (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  work bigint NOT NULL REFERENCES trammel.work,
  station text NOT NULL REFERENCES trammel.station,
  machine text NOT NULL CHECK (length(machine) BETWEEN 1 AND 256),
  campaign text NOT NULL REFERENCES trammel.campaign_head,
  job_key text NOT NULL,
  cpu_level text NOT NULL,
  outcome bytea NOT NULL CHECK (length(outcome) = 32),
  row_key bytea NOT NULL CHECK (length(row_key) BETWEEN 45 AND 4096),
  n_rows int[] NOT NULL CHECK (cardinality(n_rows) BETWEEN 1 AND 16),
  bytes bytea NOT NULL CHECK (length(bytes) <= 256 * 1024 * 1024),
  sha256 bytea NOT NULL CHECK (sha256 = sha256(bytes)),
  received_at timestamptz NOT NULL DEFAULT now(),
  UNIQUE (campaign, job_key, cpu_level, outcome)
);
CREATE TRIGGER stays BEFORE UPDATE OR DELETE OR TRUNCATE ON trammel.result
  FOR EACH STATEMENT EXECUTE FUNCTION trammel.refuse();

-- The same computation on the same kind of processor came out otherwise.
CREATE VIEW trammel.v_alarm AS
SELECT c.name AS campaign, one.job_key, one.cpu_level, one.machine, one.station, encode(one.outcome, 'hex') AS outcome,
       other.machine AS other_machine, other.station AS other_station, encode(other.outcome, 'hex') AS other_outcome,
       other.received_at
FROM trammel.result AS one
JOIN trammel.result AS other USING (campaign, job_key, cpu_level)
JOIN trammel.campaign AS c USING (campaign)
WHERE one.id < other.id;

-- Queues the campaigns that all of the given conditions name, newest first, but those whose same work is open already.
CREATE FUNCTION trammel.queue(of_stage text, parameters text, forced boolean, of_station text, of_campaign text, newest bigint)
RETURNS bigint LANGUAGE sql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  WITH queued AS (
    INSERT INTO trammel.work (stage, parameters_json, force, campaign, station)
    SELECT of_stage, parameters, forced, h.campaign, h.station
    FROM trammel.campaign_head AS h JOIN trammel.campaign AS c USING (campaign)
    WHERE (of_station IS NULL OR h.station = of_station)
      AND (of_campaign IS NULL OR of_campaign IN (c.name, c.campaign))
    ORDER BY h.moved_at DESC LIMIT newest
    ON CONFLICT DO NOTHING RETURNING 1)
  SELECT count(*) FROM queued $$;

CREATE FUNCTION trammel.most_attempts() RETURNS int LANGUAGE sql IMMUTABLE AS $$ SELECT 3 $$;

-- The work is the worker's until its lease ends, by the server's clock. A lost worker's work comes before what waits.
-- Not waited for until it is on the disk: a claim that a dying server forgets is claimed again, and the first worker
-- finishes too late.
CREATE FUNCTION trammel.claim(by_station text, on_machine text, lease_s float8) RETURNS SETOF trammel.work
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET enable_seqscan = off SET jit = off
SET plan_cache_mode = force_generic_plan AS $$
DECLARE
  next bigint;
BEGIN
  PERFORM set_config('synchronous_commit', 'off', true);
  PERFORM trammel.require_station(by_station);
  UPDATE trammel.work SET state = 'failed', lease_until = NULL, token = NULL, finished_at = now(),
    error = format('its worker on %s was lost, as those before it', machine)
    WHERE id IN (SELECT id FROM trammel.work WHERE state = 'claimed' AND lease_until < now()
                 AND attempts >= trammel.most_attempts() FOR UPDATE SKIP LOCKED);
  SELECT id INTO next FROM trammel.work WHERE state = 'claimed' AND lease_until < now()
    ORDER BY lease_until LIMIT 1 FOR UPDATE SKIP LOCKED;
  IF next IS NULL THEN
    SELECT id INTO next FROM trammel.work WHERE state = 'waiting' ORDER BY attempts, id LIMIT 1 FOR UPDATE SKIP LOCKED;
  END IF;
  RETURN QUERY UPDATE trammel.work SET state = 'claimed', attempts = attempts + 1, token = gen_random_uuid(),
    worker = by_station, machine = on_machine, lease_until = now() + make_interval(secs => lease_s)
    WHERE id = next RETURNING *;
END $$;

-- True: the lease goes on. False: the work is no longer the worker's.
CREATE FUNCTION trammel.heartbeat(of_work bigint, by_token uuid, lease_s float8) RETURNS boolean
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  PERFORM set_config('synchronous_commit', 'off', true);
  UPDATE trammel.work SET lease_until = now() + make_interval(secs => lease_s)
    WHERE id = of_work AND token = by_token AND state = 'claimed';
  RETURN FOUND;
END $$;

-- The attempt failed: it waits again, or fails for good. An empty reason: the worker was stopped, and it doesn't count.
CREATE FUNCTION trammel.give_back(of_work bigint, by_token uuid, reason text) RETURNS boolean
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  UPDATE trammel.work SET lease_until = NULL, token = NULL, error = coalesce(nullif(left(reason, 10000), ''), error),
    attempts = attempts - (reason = '')::int,
    state = CASE WHEN reason <> '' AND attempts >= trammel.most_attempts() THEN 'failed' ELSE 'waiting' END,
    finished_at = CASE WHEN reason <> '' AND attempts >= trammel.most_attempts() THEN now() END
    WHERE id = of_work AND token = by_token AND state = 'claimed';
  RETURN FOUND;
END $$;

-- Ends the work with a job: the worker's result, or (without bytes) one that the archive has. False: it is no longer the
-- worker's and nothing is stored, unless the result that is there came out otherwise: that is kept, as an alarm.
CREATE FUNCTION trammel.finish(of_work bigint, by_token uuid, by_station text, on_machine text, key text, of_outcome bytea,
  of_row_key bytea, of_n_rows int[], of_bytes bytea, of_sha256 bytea) RETURNS boolean
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  held CONSTANT trammel.work := (SELECT w FROM trammel.work AS w WHERE id = of_work FOR UPDATE);
  mine CONSTANT boolean := coalesce(held.state = 'claimed' AND held.token = by_token, false);
  job text[];
BEGIN
  PERFORM trammel.require_station(by_station);
  IF of_bytes IS NOT NULL THEN
    job := trammel.part_of('job', of_bytes, of_n_rows, 1);
    IF job[1] IS DISTINCT FROM held.campaign OR job[2] IS DISTINCT FROM key OR job[5] IS DISTINCT FROM held.stage
       OR substr(of_bytes, 10, length(of_row_key)) <> of_row_key THEN
      RAISE EXCEPTION 'work % is not what this result is of', of_work USING ERRCODE = 'data_corrupted';
    END IF;
    INSERT INTO trammel.result (work, station, machine, campaign, job_key, cpu_level, outcome, row_key, n_rows, bytes, sha256)
      SELECT of_work, by_station, on_machine, job[1], job[2], job[15], of_outcome, of_row_key, of_n_rows, of_bytes, of_sha256
      WHERE mine OR EXISTS (SELECT 1 FROM trammel.result AS r WHERE r.campaign = job[1] AND r.job_key = job[2]
                            AND r.cpu_level = job[15])
      ON CONFLICT (campaign, job_key, cpu_level, outcome) DO NOTHING;
  END IF;
  UPDATE trammel.work SET state = 'done', token = NULL, lease_until = NULL, error = NULL, job_key = key, finished_at = now()
    WHERE mine AND id = of_work;
  RETURN mine;
END $$;

GRANT SELECT ON trammel.work, trammel.result, trammel.v_alarm TO trammel_station, trammel_worker, trammel_reader;
REVOKE EXECUTE ON FUNCTION trammel.queue, trammel.claim, trammel.heartbeat, trammel.give_back, trammel.finish FROM PUBLIC;
GRANT EXECUTE ON FUNCTION trammel.queue TO trammel_station, trammel_worker;
GRANT EXECUTE ON FUNCTION trammel.claim, trammel.heartbeat, trammel.give_back, trammel.finish TO trammel_worker;
