-- What did each diagnosis promise for points it had not fitted, and what was measured there?
SELECT p.session AS computed_from, p.n, round(p.after_mean, 4) AS predicted_mm,
       (SELECT round(m.after_mean, 4) FROM v_accuracy AS m
        WHERE m.source = 'measured' AND m.session = 'measure-48-model'
        AND m.metric = p.metric) AS measured_mm
FROM v_accuracy AS p
WHERE p.source = 'predicted' AND p.metric = 'position_mm' AND p.in_sample = 0
ORDER BY p.session;
