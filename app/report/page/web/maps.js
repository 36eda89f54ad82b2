// Errors over the plane: heat and arrows, surfaces.
import { base, both, ink, mm, panels, panelTitle, scale } from './chart.js';
import { cellOf, planeAxes, squareExtent } from './plane.js';

function arrow(params, api) {
  const [x, y] = api.coord([api.value(0), api.value(1)]);
  const [tx, ty] = api.coord([api.value(2), api.value(3)]);
  const length = Math.hypot(tx - x, ty - y);
  const style = { stroke: ink, fill: ink, lineWidth: 1.2 };
  const dot = { type: 'circle', shape: { cx: x, cy: y, r: 1.3 }, style: { fill: ink } };
  if (length < 1) return { type: 'group', children: [dot] };
  const head = Math.min(5, length / 2);
  const ux = (tx - x) / length, uy = (ty - y) / length;
  const bx = tx - ux * head, by = ty - uy * head;
  return {
    type: 'group',
    children: [dot,
      { type: 'line', shape: { x1: x, y1: y, x2: bx, y2: by }, style },
      {
        type: 'polygon', style,
        shape: { points: [[tx, ty], [bx - uy * head * 0.5, by + ux * head * 0.5], [bx + uy * head * 0.5, by - ux * head * 0.5]] },
      }],
  };
}

function cells(grid, values) {
  const out = [];
  values.forEach((v, k) => {
    if (v === null) return;
    const i = k % grid.columns, j = Math.floor(k / grid.columns);
    out.push([grid.x_mm + i * grid.step_mm, grid.y_mm + j * grid.step_mm, v]);
  });
  return out;
}

export function maps(data, width) {
  const { boxes, height } = panels(width, 2, { least: 330 });
  const { grid, points } = data;
  const extent = squareExtent(points, 0.09);
  const series = [];
  both.forEach((side, k) => {
    series.push({
      type: 'custom', name: `${side}, heat`, xAxisIndex: k, yAxisIndex: k,
      data: cells(grid, grid[side]), renderItem: cellOf(grid.step_mm), clip: true,
      tooltip: { formatter: (p) => `(${p.value[0].toFixed(0)}, ${p.value[1].toFixed(0)}) mm: ${mm(p.value[2])}` },
    });
  });
  both.forEach((side, k) => {
    const at = k === 0 ? 2 : 5;
    series.push({
      type: 'custom', name: `${side}, arrows`, xAxisIndex: k, yAxisIndex: k, clip: true, z: 5,
      data: points.map((p) => [p[0], p[1], p[0] + data.magnification * p[at], p[1] + data.magnification * p[at + 1], Math.hypot(p[at], p[at + 1])]),
      renderItem: arrow,
      tooltip: { formatter: (p) => `target (${p.value[0]}, ${p.value[1]}) mm\nerror ${mm(p.value[4])}` },
    });
  });
  const bar = 46;
  return {
    height: height + bar,
    option: {
      ...base, ...planeAxes(boxes, extent), title: boxes.map((b, k) => panelTitle(b, both[k])), series,
      visualMap: {
        type: 'continuous', min: 0, max: data.max, dimension: 2, seriesIndex: [0, 1], inRange: { color: scale },
        orient: 'horizontal', left: 'center', bottom: 4, itemWidth: 14, itemHeight: Math.min(300, width / 2),
        text: [`${data.max.toFixed(3)} ${data.unit}`, `0 ${data.unit}`], textStyle: { color: ink, fontSize: 12 },
        calculable: false, hoverLink: false,
      },
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

// To the next 1, 2, 3, …, 9 times a power of ten: no label at an odd end.
function roundUp(v) {
  const power = 10 ** Math.floor(Math.log10(v));
  return Math.ceil(v / power - 1e-9) * power;
}

export function surfaces(data, width) {
  const { grid } = data;
  const stacked = width < 560;
  const height = stacked ? 600 : Math.min(380, width * 0.42);
  const low = { x: grid.x_mm, y: grid.y_mm };
  const high = { x: low.x + (grid.columns - 1) * grid.step_mm, y: low.y + (grid.rows - 1) * grid.step_mm };
  const name3 = { fontSize: 13, color: ink }, label3 = { fontSize: 12, color: ink };
  const axis3 = (k, name, more) => ({
    type: 'value', grid3DIndex: k, name, nameTextStyle: name3, nameGap: 20, axisLabel: { textStyle: label3, margin: 6 },
    axisLine: { lineStyle: { color: '#777', width: 1 } }, splitLine: { lineStyle: { color: '#ddd', width: 1 } }, splitNumber: 4, ...more,
  });
  return {
    gl: true, height,
    option: {
      backgroundColor: '#fff',
      title: both.map((side, k) => ({
        text: side, left: stacked ? '50%' : `${25 + 50 * k}%`, top: stacked ? 300 * k : 0, textAlign: 'center',
        textStyle: { fontSize: 13, color: ink },
      })),
      visualMap: {
        show: true, min: 0, max: data.max, dimension: 2, seriesIndex: [0, 1], inRange: { color: scale },
        orient: 'vertical', right: 4, top: 'middle', itemWidth: 12, itemHeight: 160, calculable: false,
        text: [`${data.max.toFixed(3)} ${data.unit}`, '0'], textStyle: { color: ink, fontSize: 11 },
      },
      grid3D: both.map((_, k) => ({
        left: stacked ? 0 : `${k * 47}%`, top: stacked ? 300 * k : 6, width: stacked ? '92%' : '48%', height: stacked ? 300 : height - 6,
        boxWidth: 100, boxDepth: 100, boxHeight: 72,
        viewControl: { alpha: 24, beta: 35, distance: 200, center: [0, -5, 0], animation: false, autoRotate: false, projection: 'perspective' },
        light: { main: { intensity: 1.0, shadow: false, alpha: 50, beta: 20 }, ambient: { intensity: 0.55 } },
        axisPointer: { show: false }, postEffect: { enable: false }, temporalSuperSampling: { enable: false },
      })),
      xAxis3D: both.map((_, k) => axis3(k, 'x [mm]', { min: low.x, max: high.x })),
      yAxis3D: both.map((_, k) => axis3(k, 'y [mm]', { min: low.y, max: high.y })),
      zAxis3D: both.map((_, k) => axis3(k, '', { min: 0, max: roundUp(data.max), axisLabel: { formatter: (v) => (v === 0 ? '' : v.toFixed(2)), textStyle: label3, margin: 6 } })),
      series: both.map((side, k) => ({
        type: 'surface', grid3DIndex: k, shading: 'lambert', dataShape: [grid.rows, grid.columns],
        wireframe: { show: true, lineStyle: { color: 'rgba(0,0,0,0.25)', width: 0.7 } },
        data: grid[side].map((v, n) => [
          low.x + (n % grid.columns) * grid.step_mm, low.y + Math.floor(n / grid.columns) * grid.step_mm, v === null ? NaN : v]),
      })),
    },
  };
}
