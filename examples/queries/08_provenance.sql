-- Where does a compensated session's correction come from?
SELECT used.session, v_job.job_id AS job, stage, algorithm_version AS version,
       sessions AS computed_from, n_readings AS readings, n_exclusions AS left_out
FROM (SELECT DISTINCT session_id, session, compensation_job_id FROM v_point_error) AS used
JOIN v_job ON v_job.job_id = used.compensation_job_id
ORDER BY used.session_id;
