-- How warm was the machine in each session, and when was it measured?
SELECT session, count(*) AS readings, round(min(temp_degc), 2) AS min_degc,
       round(max(temp_degc), 2) AS max_degc, round(min(time_s) / 3600, 2) AS from_h,
       round(max(time_s) / 3600, 2) AS to_h
FROM v_point_error
GROUP BY session_id, session
ORDER BY from_h;
