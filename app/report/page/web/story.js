// The gap, the residuals, the conditions.
import { axis, base, colours, fixed, floorLine, ink, legendAbove, mm, onWhite, panels, panelTitle, polyline, shapes } from './chart.js';

export function waterfall(data, width) {
  const sets = [['fitted', 'fitted (in-sample)', colours.fitted, colours.palest], ['unseen', 'unseen (held-out)', colours.unseen, colours.pale]]
    .filter(([key]) => data.steps.some((s) => s[key] !== null));
  const series = [];
  sets.forEach(([key, name, full, pale]) => {
    series.push({
      type: 'bar', stack: key, name, data: data.steps.map((s) => s[key]), itemStyle: { color: full },
      label: { show: width > 500, position: 'top', distance: 3, formatter: (p) => (typeof p.value === 'number' ? fixed(p.value) : ''), color: ink, fontSize: 11, ...onWhite },
      z: 3,
    });
    series.push({
      type: 'bar', stack: key, name: `closed, ${key}`, itemStyle: { color: pale },
      data: data.steps.map((s, i) => (i === 0 || s[key] === null || data.steps[i - 1][key] === null ? 0 : Math.max(0, data.steps[i - 1][key] - s[key]))),
    });
  });
  const floor = floorLine(data.floor, 'sigma per coordinate', 'mm');
  const { legend, top } = legendAbove([...sets.map((set) => set[1]), ...floor.map((f) => f.name)], width);
  const narrow = width < 90 * data.steps.length;  // names stand upright
  return {
    height: top + (narrow ? 380 : 266),
    option: {
      ...base, legend, grid: { left: 58, right: 18, top, bottom: narrow ? 148 : 34 },
      xAxis: { type: 'category', data: data.steps.map((s) => s.model), axisLabel: { color: ink, fontSize: 12, interval: 0, rotate: narrow ? 90 : 0 }, axisTick: { show: false } },
      yAxis: axis('rms per coordinate [mm]', { min: 0, scale: false, nameGap: 42 }), series: [...series, ...floor],
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: (v) => (typeof v === 'number' ? mm(v) : '-') },
    },
  };
}

// Full marks: fitted; open: unseen.
const mark = (colour, isFitted) => (isFitted ? { color: colour, opacity: 0.75 } : { color: 'transparent', borderColor: colour, borderWidth: 1.2 });

const marks = ['circle', 'triangle', 'rect'];  // of the rails: colours are not all there is

const directions = { min: -2, max: 2, interval: 1, axisLabel: { formatter: (v) => ({ '-1': '-', 0: '0', 1: '+' })[v] ?? '', color: ink, fontSize: 13 } };

// Of an axis of errors up to `most` mm.
const errorTick = (most) => (v) => v.toFixed(most >= 0.05 ? 2 : most >= 0.005 ? 3 : 4);

function scatterOf(points, rail, name, isFitted, on) {
  return {
    type: 'scatter', name, ...on, data: points, symbol: marks[rail], symbolSize: 6, itemStyle: mark(colours.rails[rail], isFitted),
    tooltip: { formatter: (p) => `${name}, ${isFitted ? 'fitted' : 'unseen'}: ${mm(p.value[1])}` },
  };
}

export function residuals(data, width) {
  const railNames = data.names.map((name, k) => ({ name, itemStyle: { color: colours.rails[k], opacity: 1 } }));
  const jitter = (i, k) => 0.09 * (k - 1) + 0.05 * (((i * 37) % 11) / 11 - 0.5);
  const axes = [
    ['travel from home [mm]', (r, k) => r.rails[k][0]], ['direction of approach', (r, k, i) => r.rails[k][1] + jitter(i, k)],
    ['time [h]', (r) => r.time_h], ['temperature [degC]', (r) => r.temp_degc]];
  const recorded = axes.filter(([, x]) => data.readings.some((r, i) => x(r, 0, i) !== null));
  const states = [['geometry alone [mm]', 2], ['with named effects [mm]', 3]];
  const columns = width < 620 ? Math.min(2, recorded.length) : recorded.length;
  const cell = width / columns, high = 170;
  const grid = [], xAxis = [], yAxis = [], series = [];
  const all = data.readings.flatMap((r) => r.rails.map((v) => Math.abs(v[2])));
  const most = Math.max(...all) * 1.08 || 1;
  recorded.forEach(([name, x], a) => states.forEach(([state, value], s) => {
    const n = grid.length, band = Math.floor(a / columns), column = a % columns;
    grid.push({ left: column * cell + 58, top: 30 + (2 * band + s) * (high + 48), width: cell - 72, height: high });
    xAxis.push(axis(name, { gridIndex: n, splitNumber: 3, ...(name.startsWith('direction') ? directions : {}) }));
    yAxis.push(axis(column === 0 ? state : '', { gridIndex: n, min: -most, max: most, nameGap: 42, axisLabel: { formatter: errorTick(most), showMinLabel: false, showMaxLabel: false, color: ink, fontSize: 11 } }));
    data.names.forEach((name, k) => [true, false].forEach((isFitted) => {
      const points = data.readings.map((r, i) => [r, i]).filter(([r, i]) => r.fitted === isFitted && x(r, k, i) !== null).map(([r, i]) => [x(r, k, i), r.rails[k][value]]);
      if (points.length) series.push(scatterOf(points, k, name, isFitted, { xAxisIndex: n, yAxisIndex: n }));
    }));
  }));
  return {
    height: 30 + 2 * Math.ceil(recorded.length / columns) * (high + 48),
    option: { ...base, grid, xAxis, yAxis, series, legend: legendAbove(railNames, width).legend, tooltip: { ...base.tooltip, trigger: 'item' } },
  };
}

export function effect(data, width) {
  const { legend, top } = legendAbove(['the effect as fitted'], width);
  const { boxes, height } = panels(width, data.names.length, { least: 240, ratio: 0.8, above: top });
  const discrete = data.axis.startsWith('direction');
  const series = [];
  data.rails.forEach((points, k) => {
    const on = { xAxisIndex: k, yAxisIndex: k };
    [1, 0].forEach((isFitted) => {
      const some = points.filter((p) => p[3] === isFitted);
      if (some.length) series.push(scatterOf(some, k, data.names[k], isFitted === 1, on));
    });
    const curve = points.map((p) => [p[0], p[2]]).sort((a, b) => a[0] - b[0]);
    if (discrete) {
      const at = (v) => curve.filter((p) => p[0] === v);
      const steps = [-1, 0, 1].filter((v) => at(v).length).flatMap((v) => {
        const mean = at(v).reduce((sum, p) => sum + p[1], 0) / at(v).length;
        return [[v - 0.35, mean], [v + 0.35, mean], null];
      });
      series.push(polyline(steps, ink, 2.5, { ...on, name: 'the effect as fitted', z: 6 }));
    } else {
      series.push(polyline(curve, ink, 2, { ...on, name: 'the effect as fitted', z: 6 }));
    }
  });
  const values = data.rails.flat().flatMap((p) => [p[1], p[2]]);
  const most = Math.max(...values.map(Math.abs)) * 1.1 || 1;
  return {
    height,
    option: {
      ...base, grid: boxes, series, legend, title: boxes.map((b, k) => panelTitle(b, data.names[k])),
      xAxis: boxes.map((_, k) => axis(data.axis, { gridIndex: k, splitNumber: 4, ...(discrete ? directions : {}) })),
      yAxis: boxes.map((_, k) => axis(k === 0 || boxes[k].left === boxes[0].left ? 'joint error [mm]' : '', { gridIndex: k, nameGap: 42, min: -most, max: most, axisLabel: { formatter: errorTick(most), showMinLabel: false, showMaxLabel: false, color: ink, fontSize: 11 } })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

export function temperature(data, width) {
  const { legend, top } = legendAbove(data.sessions.map((session) => session.name), width);
  return {
    height: 226 + top,
    option: {
      ...base, legend, grid: { left: 58, right: 18, top, bottom: 44 },
      xAxis: axis('time since the start [h]'), yAxis: axis('temperature [degC]', { nameGap: 42 }),
      series: data.sessions.map((s, k) => ({ type: 'scatter', name: s.name, data: s.points, symbol: shapes[k % shapes.length], symbolSize: 5 })),
      tooltip: { ...base.tooltip, trigger: 'item', formatter: (p) => `${p.value[0].toFixed(2)} h: ${p.value[1].toFixed(2)} degC` },
    },
  };
}
