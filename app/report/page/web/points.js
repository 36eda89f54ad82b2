// Errors in the order of points.
import { axis, base, both, colours, fixed, floorLine, ink, kSmall, legendAbove, panels, panelTitle, polyline } from './chart.js';

export function byPoint(data, width) {
  const floor = floorLine(data.floor, 'mean of a perfect reading', data.unit);
  const { legend, top } = legendAbove([...both, ...floor.map((line) => line.name)], width);
  return {
    height: top + 218,
    option: {
      ...base, legend, grid: { left: 58, right: 18, top, bottom: 44 },
      xAxis: axis('point, in the order of the plan', { min: 0, max: data.before.length + 1, minInterval: 1 }),
      yAxis: axis(`error [${data.unit}]`, { min: 0, scale: false, nameGap: 42 }),
      series: [...both.map((side, k) => ({
        type: 'line', name: side, data: data[side].map((v, i) => [i + 1, v]), symbol: k === 0 ? 'emptyCircle' : 'circle',
        symbolSize: width < 500 ? 3 : 5, lineStyle: { width: 1, color: colours[side] }, itemStyle: { color: colours[side] },
        tooltip: { formatter: (p) => `${data.targets[p.dataIndex]}\n${side}: ${fixed(p.value[1], data.unit)} ${data.unit}` },
      })), ...floor],
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

export function simulated(data, width) {
  const names = data.axes.map((k) => ['x error [mm]', 'y error [mm]', 'phi error [deg]'][k]);
  const last = names.length - 1;
  const high = 150, gap = 22;
  const { legend, top } = legendAbove(['measured', 'simulated'], width);
  const boxes = names.map((_, k) => ({ left: 62, top: top + k * (high + gap), width: width - 80, height: high }));
  const sides = [['measured', colours.before], ['simulated', colours.after]];
  return {
    height: top + names.length * (high + gap) + 30,
    option: {
      ...base, legend, grid: boxes,
      xAxis: names.map((_, k) => axis(k === last ? 'point, in the order of the plan' : '', { gridIndex: k, min: 0, max: data.measured.length + 1, axisLabel: { show: k === last } })),
      yAxis: names.map((name, k) => axis(name, { gridIndex: k, nameGap: 44, splitNumber: 4 })),
      series: names.flatMap((_, k) => sides.map(([side, colour], s) => ({
        type: 'line', name: side, xAxisIndex: k, yAxisIndex: k, data: data[side].map((v, i) => [i + 1, v[data.axes[k]]]),
        symbol: s === 0 ? 'emptyCircle' : 'circle', symbolSize: 4, lineStyle: { width: 1, color: colour }, itemStyle: { color: colour },
      }))),
      tooltip: { ...base.tooltip, trigger: 'axis' },
    },
  };
}

// Along one line, where targets stand on one: each side on its own scale, and of a single axis each
// direction of approach apart.
export function along(data, width) {
  const looks = [[1, 'positive travel', '#1b9e77', 'triangle', 'solid'], [-1, 'negative travel', '#7570b3', 'emptyCircle', 'dashed'], [0, 'as it came', ink, 'circle', 'solid']]
    .filter(([direction]) => data.rows.some((r) => r[1] === direction));
  const { legend, top } = legendAbove(looks.map((look) => look[1]), width);
  const { boxes, height } = panels(width, 2, { least: 250, ratio: 0.8, left: 60, above: top });
  const of = (direction, side) => data.rows.filter((r) => r[1] === direction).map((r) => [r[0], r[2 + side] * kSmall]);
  const means = (points) => {
    const found = new Map();
    points.forEach(([x, e]) => found.set(x, [...(found.get(x) ?? []), e]));
    return [...found].map(([x, all]) => [x, all.reduce((sum, e) => sum + e, 0) / all.length]).sort((a, b) => a[0] - b[0]);
  };
  return {
    height,
    option: {
      ...base, legend, grid: boxes, title: both.map((side, k) => panelTitle(boxes[k], side)),
      xAxis: both.map((_, k) => axis(data.where, { gridIndex: k, splitNumber: 4 })),
      yAxis: both.map((_, k) => axis(`${data.what} [${data.unit}]`, { gridIndex: k, nameGap: 40, splitNumber: 5 })),
      series: both.flatMap((_, k) => looks.flatMap(([direction, name, colour, symbol, type]) => {
        const points = of(direction, k), on = { name, xAxisIndex: k, yAxisIndex: k };
        return [
          { type: 'scatter', ...on, data: points, symbol, symbolSize: 7, itemStyle: { color: colour, opacity: 0.75 },
            tooltip: { formatter: (p) => `${data.where} ${p.value[0]}\n${name}: ${+p.value[1].toFixed(3)} ${data.unit}` } },
          polyline(means(points), colour, 1.5, { ...on, lineStyle: { color: colour, width: 1.5, type } })];
      })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

// Round borders of some 12 bins from 0 to beyond `most`.
function bordersOf(most) {
  const rough = (most || 1) / 12, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((wide) => wide >= rough);
  return Array.from({ length: Math.floor(most / step) + 2 }, (_, k) => k * step);
}

// Of one side, in its own unit: [from, to, how many].
export function binsOf(data, side) {
  const factor = side === 'after' ? kSmall : 1;
  const values = data[side].map((v) => v * factor);
  const borders = bordersOf(Math.max(...values));
  return borders.slice(1).map((to, k) => [borders[k], to, values.filter((v) => v >= borders[k] && v < to).length]);
}

const bin = (params, api) => {
  const [x1, y1] = api.coord([api.value(0), api.value(2)]), [x2, y2] = api.coord([api.value(1), 0]);
  return { type: 'rect', shape: { x: x1 + 0.5, y: y1, width: x2 - x1 - 1, height: y2 - y1 }, style: { fill: api.visual('color') } };
};

// Each side on its own scale, in its own unit.
export function histogram(data, width) {
  const sides = both.map((side) => ({
    side, unit: side === 'after' ? data.small_unit : data.unit, factor: side === 'after' ? kSmall : 1, limits: data.limits[side], bins: binsOf(data, side),
  }));
  const limits = [['95 %', 'p95', 'dashed'], ['largest', 'max', 'solid']];
  const { boxes, height } = panels(width, 2, { least: 330, ratio: 0.36, above: 0 });
  const words = ({ side, unit, factor, limits: l }) => `${side}: 95 % ${(l.p95 * factor).toPrecision(3)} (dashed), largest ${(l.max * factor).toPrecision(3)} ${unit}`;
  return {
    height,
    option: {
      ...base, grid: boxes,
      title: sides.map((s, k) => panelTitle(boxes[k], words(s))),
      xAxis: sides.map((s, k) => axis(`error [${s.unit}]`, { gridIndex: k, min: 0, max: s.bins.at(-1)[1], scale: false })),
      yAxis: sides.map((s, k) => axis('points', { gridIndex: k, min: 0, scale: false, minInterval: 1, nameGap: 34 })),
      series: sides.flatMap((s, k) => [
        {
          type: 'custom', name: s.side, xAxisIndex: k, yAxisIndex: k, data: s.bins, renderItem: bin, itemStyle: { color: colours[s.side] }, encode: { x: [0, 1], y: 2 },
          tooltip: { formatter: (p) => `${p.value[2]} points from ${+p.value[0].toFixed(6)} to ${+p.value[1].toFixed(6)} ${s.unit}` },
        },
        ...limits.map(([name, which, type]) => ({
          type: 'line', name, xAxisIndex: k, yAxisIndex: k, data: [], symbol: 'none', lineStyle: { color: ink, type, width: 1.5 }, itemStyle: { color: ink },
          markLine: { precision: -1, silent: true, symbol: 'none', label: { show: false }, lineStyle: { color: ink, type, width: 1.5 }, data: [{ xAxis: s.limits[which] * s.factor }] },
        })),
      ]),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

// Rows {point, x_mm, y_mm, phi_deg, position_mm}, without what is not measured: in the order they were measured, phi on the right.
function recent(rows, width, nameOf) {
  const parts = [['x [mm]', 'x_mm', '#1b9e77', 'circle'], ['y [mm]', 'y_mm', '#7570b3', 'triangle'], ['length [mm]', 'position_mm', ink, 'rect'],
    ['phi [deg]', 'phi_deg', colours.before, 'diamond']].filter(([, key]) => key in rows[0]);
  const { legend, top } = legendAbove(parts.map(([name]) => name), width);
  return {
    height: top + 188,
    option: {
      ...base, legend, grid: { left: 62, right: 62, top, bottom: 44 },
      xAxis: { type: 'category', data: rows.map(nameOf), name: 'point', nameLocation: 'middle', nameGap: 26, axisLabel: { color: ink, fontSize: 11, hideOverlap: true } },
      yAxis: [axis('[mm]', { nameGap: 46 }), axis('phi_deg' in rows[0] ? 'phi [deg]' : '', { nameGap: 46, splitLine: { show: false } })],
      series: parts.map(([name, key, colour, symbol]) => ({
        type: 'line', name, data: rows.map((r) => r[key]), symbol, symbolSize: 6, yAxisIndex: key === 'phi_deg' ? 1 : 0,
        lineStyle: { width: 1.2, color: colour, type: key === 'phi_deg' ? 'dashed' : 'solid' }, itemStyle: { color: colour },
      })),
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: (v) => fixed(v) },
    },
  };
}

export const deviations = (rows, width) => recent(rows, width, (r) => `${r.point}`);
export const drift = (rows, width) => recent(rows, width, (r) => `${r.point}, epoch ${r.epoch}`);
