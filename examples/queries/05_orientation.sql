-- And the orientation: does each compensation improve it as well?
SELECT session, method, CASE in_sample WHEN 1 THEN 'in-sample' ELSE 'held-out' END AS judged, n,
       round(before_mean, 4) AS before_mean_deg, round(after_mean, 4) AS after_mean_deg,
       round(improvement_pct, 1) AS improvement_pct
FROM v_accuracy
WHERE source = 'measured' AND metric = 'attitude_deg'
ORDER BY improvement_pct;
