-- How accurate is the robot before and after each compensation, measured again?
SELECT session, method, CASE in_sample WHEN 1 THEN 'in-sample' ELSE 'held-out' END AS judged, n,
       round(before_mean, 4) AS before_mean_mm, round(after_mean, 4) AS after_mean_mm,
       round(after_max, 4) AS after_max_mm, round(improvement_pct, 1) AS improvement_pct
FROM v_accuracy
WHERE source = 'measured' AND metric = 'position_mm'
ORDER BY after_mean;
