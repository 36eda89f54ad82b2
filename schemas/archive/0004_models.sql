-- Models, as a station's table has them, with the station. They are asked from the bytes that were sent.
INSERT INTO trammel.archive (version) VALUES (4);
SET LOCAL search_path = trammel, pg_catalog;

CREATE INDEX archive_row_models ON trammel.archive_row (campaign) WHERE table_name = 'model';

-- A model may be of a job of another campaign: its own first.
CREATE VIEW trammel.model AS
SELECT a.row_ids[1] AS model_id, c.campaign_id, v[2]::bigint AS version, parent.row_ids[1] AS parent_model_id, j.job_id,
       v[6] AS name, v[7] AS parameters_json, v[8]::float8 AS identify_rms_mm, v[9]::float8 AS validate_rms_mm,
       v[10]::float8 AS noise_floor_mm, v[11] AS created_utc, h.station
FROM trammel.archive_row AS a
JOIN trammel.campaign AS c USING (campaign) JOIN trammel.campaign_head AS h USING (campaign)
CROSS JOIN LATERAL trammel.part_of('model', a.bytes, a.n_rows, 1) AS v
LEFT JOIN trammel.archive_row AS parent ON parent.campaign = a.campaign AND parent.table_name = 'model'
  AND parent.row_key = trammel.canonical(a.campaign) || trammel.canonical(v[3]::bigint)
LEFT JOIN LATERAL (SELECT job.job_id FROM trammel.job
                   WHERE job.key = v[4] AND job.run = v[5]::bigint AND job.station = h.station AND job.job_id IS NOT NULL
                   ORDER BY job.campaign = a.campaign DESC, job.job_id LIMIT 1) AS j ON true
WHERE a.table_name = 'model';

GRANT SELECT ON trammel.model TO trammel_station, trammel_worker, trammel_reader;
