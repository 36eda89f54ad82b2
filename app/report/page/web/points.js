// Errors in the order of points.
import { axis, base, both, colours, floorLine, ink, legend, mm } from './chart.js';

export function byPoint(data, width) {
  return {
    height: 250,
    option: {
      ...base, legend: legend(), grid: { left: 58, right: 18, top: 32, bottom: 44 },
      xAxis: axis('point, in the order of the plan', { min: 0, max: data.before.length + 1, minInterval: 1 }),
      yAxis: axis(`error [${data.unit}]`, { min: 0, scale: false, nameGap: 42 }),
      series: [...both.map((side, k) => ({
        type: 'line', name: side, data: data[side].map((v, i) => [i + 1, v]), symbol: k === 0 ? 'emptyCircle' : 'circle',
        symbolSize: width < 500 ? 3 : 5, lineStyle: { width: 1, color: colours[side] }, itemStyle: { color: colours[side] },
        tooltip: { formatter: (p) => `${data.targets[p.dataIndex]}\n${side}: ${p.value[1].toFixed(4)} ${data.unit}` },
      })), ...floorLine(data.floor, 'mean of a perfect reading', data.unit)],
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

export function simulated(data, width) {
  const names = ['x error [mm]', 'y error [mm]', 'phi error [deg]'];
  const high = 150, gap = 22;
  const boxes = names.map((_, k) => ({ left: 62, top: 32 + k * (high + gap), width: width - 80, height: high }));
  const sides = [['measured', colours.before], ['simulated', colours.after]];
  return {
    height: 32 + 3 * (high + gap) + 30,
    option: {
      ...base, legend: legend(), grid: boxes,
      xAxis: names.map((_, k) => axis(k === 2 ? 'point, in the order of the plan' : '', { gridIndex: k, min: 0, max: data.measured.length + 1, axisLabel: { show: k === 2 } })),
      yAxis: names.map((name, k) => axis(name, { gridIndex: k, nameGap: 44, splitNumber: 4 })),
      series: names.flatMap((_, k) => sides.map(([side, colour], s) => ({
        type: 'line', name: side, xAxisIndex: k, yAxisIndex: k, data: data[side].map((v, i) => [i + 1, v[k]]),
        symbol: s === 0 ? 'emptyCircle' : 'circle', symbolSize: 4, lineStyle: { width: 1, color: colour }, itemStyle: { color: colour },
      }))),
      tooltip: { ...base.tooltip, trigger: 'axis' },
    },
  };
}

// Rows {point, x_mm, y_mm, position_mm}: components and length, in the order they were measured.
function recent(rows, width, nameOf) {
  const parts = [['x', 'x_mm', '#1b9e77'], ['y', 'y_mm', '#7570b3'], ['length', 'position_mm', ink]];
  return {
    height: 220,
    option: {
      ...base, legend: legend(), grid: { left: 62, right: 18, top: 32, bottom: 44 },
      xAxis: { type: 'category', data: rows.map(nameOf), name: 'point', nameLocation: 'middle', nameGap: 26, axisLabel: { color: ink, fontSize: 11, hideOverlap: true } },
      yAxis: axis('[mm]', { nameGap: 46 }),
      series: parts.map(([name, key, colour]) => ({
        type: 'line', name, data: rows.map((r) => r[key]), symbolSize: 6, lineStyle: { width: 1.2, color: colour }, itemStyle: { color: colour },
      })),
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: mm },
    },
  };
}

export const deviations = (rows, width) => recent(rows, width, (r) => `${r.point}`);
export const drift = (rows, width) => recent(rows, width, (r) => `${r.point}, epoch ${r.epoch}`);
