-- What does each model of the last diagnosis leave unexplained, fitted and unseen?
SELECT version, name, round(identify_rms_mm, 4) AS fitted_rms_mm,
       round(validate_rms_mm, 4) AS unseen_rms_mm, round(noise_floor_mm, 4) AS noise_floor_mm
FROM model
WHERE job_id = (SELECT max(job_id) FROM model)
ORDER BY version;
