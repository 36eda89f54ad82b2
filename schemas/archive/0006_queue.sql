-- What is queued is named campaign by campaign: which those are, whoever asks says in a question of his own.
INSERT INTO trammel.archive (version) VALUES (6);
SET LOCAL search_path = trammel, pg_catalog;

-- In this order, but those whose same work is open already.
DROP FUNCTION trammel.queue(text, text, boolean, text, text, bigint);
CREATE FUNCTION trammel.queue(of_stage text, parameters text, forced boolean, of_campaigns text[])
RETURNS bigint LANGUAGE sql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
  WITH queued AS (
    INSERT INTO trammel.work (stage, parameters_json, force, campaign, station)
    SELECT of_stage, parameters, forced, h.campaign, h.station
    FROM unnest(of_campaigns) WITH ORDINALITY AS asked (campaign, n)
    JOIN trammel.campaign_head AS h USING (campaign) JOIN trammel.campaign USING (campaign)
    ORDER BY asked.n
    ON CONFLICT DO NOTHING RETURNING 1)
  SELECT count(*) FROM queued $$;

REVOKE EXECUTE ON FUNCTION trammel.queue FROM PUBLIC;
GRANT EXECUTE ON FUNCTION trammel.queue TO trammel_station, trammel_worker;
