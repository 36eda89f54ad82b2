// What a figure shows, for who does not see it: its numbers as a table, and their ranges in a sentence.
import { both, kSmall } from './chart.js';
import { binsOf } from './points.js';

const at = (grid, k) => [grid.x_mm + (k % grid.columns) * grid.step_mm, grid.y_mm + Math.floor(k / grid.columns) * grid.step_mm];
const times = (rows) => {
  const columns = [['x [mm]', 'x_mm'], ['y [mm]', 'y_mm'], ['phi [deg]', 'phi_deg'], ['length [mm]', 'position_mm']].filter(([, key]) => rows.length && key in rows[0]);
  return [['point', ...columns.map(([name]) => name)], rows.map((r) => [r.point, ...columns.map(([, key]) => r[key])])];
};

// By kind: names of columns, then rows.
const tables = {
  maps: (d) => [['target x [mm]', 'target y [mm]', 'before [mm]', 'after [mm]'],
    d.points.map((p) => [p[0], p[1], Math.hypot(p[2], p[3]), Math.hypot(p[5], p[6])])],
  along: (d) => [[d.where, 'direction of travel', `before, ${d.what} [${d.unit}]`, `after, ${d.what} [${d.unit}]`], d.rows.map((r) => [r[0], r[1], r[2] * kSmall, r[3] * kSmall])],
  surfaces: (d) => [['x [mm]', 'y [mm]', `before, interpolated [${d.unit}]`, `after, interpolated [${d.unit}]`],
    d.grid.before.map((v, k) => [...at(d.grid, k), v, d.grid.after[k]]).filter((r) => r[2] !== null)],
  mechanism: (d) => [['chain', 'rail from x [mm]', 'from y [mm]', 'rail to x [mm]', 'to y [mm]', 'slider x [mm]', 'slider y [mm]', 'joint x [mm]', 'joint y [mm]'],
    d.chains.map((c, k) => [k + 1, ...c.rail.flat(), ...c.slider, ...c.joint])],
  plan: (d) => [['set', 'point', 'x [mm]', 'y [mm]', 'phi [deg]'], d.sets.flatMap((s) => s.points.map((p) => [s.name, p[3], p[0], p[1], p[2]]))],
  'next-points': (d) => [['x [mm]', 'y [mm]', 'phi [deg]', 'approach of the rails', 'why'], d.next.map((n) => [n.x_mm, n.y_mm, n.phi_deg, n.approach, n.why])],
  circles: (d) => [['circle', 'target x [mm]', 'target y [mm]', 'before dx [mm]', 'before dy [mm]', 'after dx [mm]', 'after dy [mm]'],
    d.circles.flatMap((c) => c.points.map((p) => [c.name, ...p]))],
  'by-point': (d) => [['target', ...both.map((side) => `${side} [${d.unit}]`)], d.targets.map((t, k) => [t, d.before[k], d.after[k]])],
  histogram: (d) => [['side', 'error from', 'to', 'points'],
    both.flatMap((side) => binsOf(d, side).map(([from, to, n]) => [`${side} [${side === 'after' ? d.small_unit : d.unit}]`, from, to, n]))],
  simulated: (d) => [['point', ...['measured', 'simulated'].flatMap((s) => [`${s} x [mm]`, `${s} y [mm]`, `${s} phi [deg]`])],
    d.measured.map((m, k) => [k + 1, ...m, ...d.simulated[k]])],
  sensitivity: (d) => [['source', ...['x', 'y', 'phi'].slice(0, d.rows.length).map((c) => `share in ${c} [%]`)], d.sources.map((s, k) => [s, ...d.rows.map((r) => r[k])])],
  network: (d) => [['set', 'joint', 'measured [mm]', 'network [mm]'], d.sets.flatMap((s) => s.joints.flatMap((j, k) => j.map((p) => [s.name, k + 1, ...p])))],
  contest: (d) => [['method', 'judged', 'n', 'mean before [mm]', 'mean after [mm]', '95 % from', 'to'],
    d.bars.map((b) => [b.method, b.judged, b.n, b.before, b.after, b.low, b.high])],
  waterfall: (d) => [['model', 'fitted [mm]', 'unseen [mm]'], d.steps.map((s) => [s.model, s.fitted, s.unseen])],
  residuals: (d) => [['reading', 'rail', 'travel [mm]', 'direction', 'geometry alone [mm]', 'with named effects [mm]', 'time [h]', 'temperature [degC]'],
    d.readings.flatMap((r, i) => r.rails.map((v, k) => [i + 1, d.names[k], ...v, r.time_h, r.temp_degc]))],
  effect: (d) => [['rail', d.axis, 'residual [mm]', 'effect [mm]', 'fitted'], d.rails.flatMap((points, k) => points.map((p) => [d.names[k], p[0], p[1], p[2], p[3] ? 'yes' : 'no']))],
  temperature: (d) => [['session', 'time [h]', 'temperature [degC]'], d.sessions.flatMap((s) => s.points.map((p) => [s.name, ...p]))],
  deviations: times,
  drift: times,
};

// Numbers as the data have them: five decimals, of what is smaller three digits.
const shown = (v) => (typeof v === 'number' ? String(Number(Math.abs(v) < 0.001 ? v.toPrecision(3) : v.toFixed(5))) : v);

export function numbersOf(item) {
  const [columns, rows] = tables[item.kind](item.data);
  return { columns, rows: rows.map((row) => row.map(shown)) };
}

// "Position error: 80 rows; before [mm] 0.08 to 0.44; after [mm] 0.003 to 0.03."
export function spoken(item) {
  const [columns, rows] = tables[item.kind](item.data);
  const ranges = columns.flatMap((name, k) => {
    const values = rows.map((row) => row[k]).filter((v) => typeof v === 'number');
    return values.length ? [`${name} ${shown(Math.min(...values))} to ${shown(Math.max(...values))}`] : [];
  });
  return [`${item.title}: ${rows.length} rows`, ...ranges].join('; ');
}
