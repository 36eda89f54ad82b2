// Errors over the plane: heat and arrows, surfaces.
import { base, ink, kSmall, mm, panels, panelTitle, plain, scale } from './chart.js';
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

// Before and after on one scale, and after on its own, in the small unit.
const viewsOf = (data) => [
  { name: 'before', side: 'before', at: 2, max: data.max, factor: 1, unit: data.unit, magnification: data.magnification },
  { name: 'after, same scale', side: 'after', at: 5, max: data.max, factor: 1, unit: data.unit, magnification: data.magnification },
  { name: `after, own scale [${data.small_unit}]`, side: 'after', at: 5, max: data.max_after * kSmall, factor: kSmall, unit: data.small_unit, magnification: data.magnification_after },
];

// Of the colours of some views of one scale.
const colourBar = (view, seriesIndex, more) => ({
  min: 0, max: view.max, dimension: 2, seriesIndex, inRange: { color: scale }, itemWidth: 13, calculable: false, hoverLink: false,
  text: [`${view.max.toPrecision(3)} ${view.unit}`, '0'], textStyle: { color: ink, fontSize: 11 }, textGap: 6, ...more,
});

export function maps(data, width) {
  const views = viewsOf(data);
  const { boxes, columns, height } = panels(width, 3, { least: 165, left: width < 700 ? 44 : 52, right: width < 700 ? 6 : 14, above: 0 });
  const { grid, points } = data;
  const extent = squareExtent(points, 0.09);
  const on = (k) => ({ xAxisIndex: k, yAxisIndex: k, clip: true });
  const heat = views.map((v, k) => ({
    type: 'custom', name: `${v.name}, heat`, ...on(k),
    data: cells(grid, grid[v.side]).map(([x, y, e]) => [x, y, e * v.factor]), renderItem: cellOf(grid.step_mm),
    tooltip: { formatter: (p) => `(${p.value[0].toFixed(0)}, ${p.value[1].toFixed(0)}) mm: ${p.value[2].toPrecision(3)} ${v.unit}, interpolated` },
  }));
  const arrows = views.map((v, k) => ({
    type: 'custom', name: `${v.name}, arrows`, ...on(k), z: 5, renderItem: arrow,
    data: points.map((p) => [p[0], p[1], p[0] + v.magnification * p[v.at], p[1] + v.magnification * p[v.at + 1], Math.hypot(p[v.at], p[v.at + 1])]),
    tooltip: { formatter: (p) => `target (${p.value[0]}, ${p.value[1]}) mm\nerror ${mm(p.value[4])}` },
  }));
  const long = Math.min(150, boxes[0].width - 90);
  const bar = (view, of, centre) => colourBar(view, of, { orient: 'horizontal', left: centre - long / 2 - 40, bottom: 0, itemHeight: long });
  const centre = (k) => boxes[k].left + boxes[k].width / 2;
  return {
    height: height + 32,
    option: {
      ...base, ...planeAxes(boxes, extent), title: boxes.map((b, k) => panelTitle(b, views[k].name)), series: [...heat, ...arrows],
      yAxis: planeAxes(boxes, extent).yAxis.map((y, k) => ({ ...y, name: k % columns === 0 ? y.name : '', nameGap: 30 })),
      visualMap: [bar(views[0], [0, 1], columns === 3 ? (centre(0) + centre(1)) / 2 : centre(0)), bar(views[2], [2], columns === 3 ? centre(2) : width * 0.75)],
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

// An axis of some four steps from zero to beyond `most`. It begins a step below: the library leaves the
// label at an axis' beginning out, and zero has one.
function heights(most) {
  const rough = (most || 1) / 4, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((wide) => wide >= rough * 0.999);
  return { min: -step, max: step * Math.ceil(most / step - 1e-9), interval: step };
}

export function surfaces(data, width) {
  const { grid } = data;
  const views = viewsOf(data);
  const stacked = width < 560;
  const cell = stacked ? { wide: width * 0.84, high: 290 } : { wide: (width - 60) / 3, high: Math.min(340, width * 0.36) };
  const height = stacked ? 3 * cell.high : cell.high + 20;
  const low = { x: grid.x_mm, y: grid.y_mm };
  const high = { x: low.x + (grid.columns - 1) * grid.step_mm, y: low.y + (grid.rows - 1) * grid.step_mm };
  const small = { fontSize: 11, color: ink };
  // Not at the ends, where an odd one lies over its neighbour and over the next axis' own.
  const inner = (from, to) => ({ min: from, max: to, axisLabel: { textStyle: small, margin: 6, formatter: (v) => (v <= from || v >= to ? '' : plain(v)) } });
  const axis3 = (k, name, more) => ({
    type: 'value', grid3DIndex: k, name, nameTextStyle: { fontSize: 12, color: ink }, nameGap: 22,
    axisLine: { lineStyle: { color: '#777', width: 1 } },
    splitLine: { lineStyle: { color: '#ddd', width: 1 } }, splitNumber: 4, ...more,
  });
  return {
    gl: true, height,
    option: {
      backgroundColor: '#fff',
      title: views.flatMap((v, k) => {
        const left = stacked ? 0 : k * cell.wide, top = stacked ? cell.high * k : 0;
        return [
          { text: v.name, left: left + cell.wide / 2, top, textAlign: 'center', textStyle: { fontSize: 13, color: ink } },
          { text: `error [${v.unit}]`, left: left + 4, top: top + 0.24 * cell.high, textStyle: { fontSize: 12, fontWeight: 'normal', color: ink } }];
      }),
      visualMap: [
        colourBar(views[0], [0, 1], { orient: 'vertical', right: 4, top: stacked ? cell.high * 0.8 : 8, itemHeight: 90, itemWidth: 12 }),
        colourBar(views[2], [2], { orient: 'vertical', right: 4, bottom: stacked ? 60 : 4, itemHeight: 90, itemWidth: 12 })],
      grid3D: views.map((_, k) => ({
        left: stacked ? 0 : k * cell.wide, top: stacked ? cell.high * k : 10, width: cell.wide, height: cell.high,
        boxWidth: 100, boxDepth: 100, boxHeight: 72,
        viewControl: { alpha: 24, beta: 35, distance: 245, center: [0, -5, 0], animation: false, autoRotate: false, projection: 'perspective' },
        light: { main: { intensity: 1.0, shadow: false, alpha: 50, beta: 20 }, ambient: { intensity: 0.55 } },
        axisPointer: { show: false }, postEffect: { enable: false }, temporalSuperSampling: { enable: false },
      })),
      xAxis3D: views.map((_, k) => axis3(k, 'x [mm]', inner(low.x, high.x))),
      yAxis3D: views.map((_, k) => axis3(k, 'y [mm]', inner(low.y, high.y))),
      zAxis3D: views.map((v, k) => axis3(k, '', { ...heights(v.max), axisLabel: { textStyle: small, margin: 14, formatter: (e) => (e < 0 ? '' : plain(e)) } })),
      series: views.map((v, k) => ({
        type: 'surface', grid3DIndex: k, shading: 'lambert', dataShape: [grid.rows, grid.columns],
        wireframe: { show: true, lineStyle: { color: 'rgba(0,0,0,0.25)', width: 0.7 } },
        data: grid[v.side].map((e, n) => [
          low.x + (n % grid.columns) * grid.step_mm, low.y + Math.floor(n / grid.columns) * grid.step_mm, e === null ? NaN : e * v.factor]),
      })),
    },
  };
}
