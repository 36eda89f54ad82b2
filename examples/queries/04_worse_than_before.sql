-- At how many points has a compensation made things worse?
WITH visit AS (
  SELECT session, method, position_mm, row_number() OVER (PARTITION BY session_id ORDER BY seq) AS k
  FROM v_point_error
)
SELECT after.session, count(*) AS points, count(*) FILTER (WHERE after.position_mm > before.position_mm) AS worse,
       round(max(after.position_mm - before.position_mm), 4) AS worst_by_mm
FROM visit AS after
JOIN visit AS before ON before.k = after.k AND before.method = 'baseline'
  AND after.session LIKE before.session || '-%'
WHERE after.method <> 'baseline'
GROUP BY after.session
ORDER BY worse DESC, after.session;
