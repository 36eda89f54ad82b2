-- When a work was claimed last, so that what is said of the rate is of the time in which somebody computed.
INSERT INTO trammel.archive (version) VALUES (8);
SET LOCAL search_path = trammel, pg_catalog;

ALTER TABLE trammel.work ADD COLUMN claimed_at timestamptz;

-- The work is the worker's until its lease ends, by the server's clock. A lost worker's work comes before what waits.
-- Not waited for until it is on the disk: a claim that a dying server forgets is claimed again, and the first worker
-- finishes too late.
CREATE OR REPLACE FUNCTION trammel.claim(by_station text, on_machine text, lease_s float8) RETURNS SETOF trammel.work
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET enable_seqscan = off SET jit = off
SET plan_cache_mode = force_generic_plan AS $$
DECLARE
  ended_after timestamptz := now() - interval '10 s';
  reached CONSTANT bigint := coalesce(pg_sequence_last_value('trammel.work_reached'), 1);
  from_id bigint := reached;
  next bigint;
  tries int;
BEGIN
  PERFORM set_config('synchronous_commit', 'off', true);
  PERFORM trammel.require_station(by_station);
  LOOP
    SELECT id, attempts INTO next, tries FROM trammel.work
      WHERE state = 'claimed' AND lease_until < now() AND lease_until >= ended_after
      ORDER BY lease_until LIMIT 1 FOR UPDATE SKIP LOCKED;
    IF tries >= trammel.most_attempts() THEN
      UPDATE trammel.work SET state = 'failed', lease_until = NULL, token = NULL, finished_at = now(),
        error = format('its worker on %s was lost, as those before it', machine) WHERE id = next;
      CONTINUE;
    END IF;
    IF next IS NULL THEN
      SELECT id, attempts INTO next, tries FROM trammel.work WHERE state = 'waiting' AND (attempts, id) >= (0, from_id)
        ORDER BY attempts, id LIMIT 1 FOR UPDATE SKIP LOCKED;
    END IF;
    EXIT WHEN next IS NOT NULL OR from_id = 0;
    ended_after := '-infinity';
    from_id := 0;
  END LOOP;
  IF tries = 0 AND next > reached THEN PERFORM setval('trammel.work_reached', next); END IF;
  RETURN QUERY UPDATE trammel.work SET state = 'claimed', attempts = attempts + 1, token = gen_random_uuid(),
    worker = by_station, machine = on_machine, claimed_at = now(),
    lease_until = now() + make_interval(secs => lease_s) WHERE id = next RETURNING *;
END $$;
