-- Where does a compensated session's correction come from?
SELECT session.name AS session, job.job_id AS job, job.stage, job.algorithm_version AS version,
       v_job.sessions AS computed_from, job.n_readings AS readings, v_job.n_exclusions AS left_out
FROM session
JOIN job ON job.job_id = session.compensation_job_id
JOIN v_job ON v_job.job_id = job.job_id
ORDER BY session.session_id;
