-- Is every planned point measured, and how many tries did it take?
SELECT session, count(*) AS planned, count(*) FILTER (WHERE status = 'ok') AS measured, max(n_attempts) AS most_tries
FROM v_point_status
GROUP BY session_id, session
ORDER BY session_id;
