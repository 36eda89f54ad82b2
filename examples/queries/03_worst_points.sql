-- Which five points are worst, and where do they lie?
SELECT session, seq, target_x_mm, target_y_mm, round(error_x_mm, 4) AS error_x_mm,
       round(error_y_mm, 4) AS error_y_mm, round(position_mm, 4) AS position_mm
FROM v_point_error
WHERE method <> 'baseline' AND excluded IS NULL
ORDER BY position_mm DESC, seq
LIMIT 5;
