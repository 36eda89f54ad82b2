-- How far apart are repeated visits of a point in one session (same command, same side)?
SELECT session, count(*) AS repeated_visits,
       round(sqrt(avg(drift_x_mm * drift_x_mm + drift_y_mm * drift_y_mm)), 4) AS rms_mm,
       round(max(abs(drift_phi_deg)), 4) AS max_phi_deg
FROM v_drift
WHERE visit > 1
GROUP BY session;
