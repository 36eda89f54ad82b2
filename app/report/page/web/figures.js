// How each kind of figure is drawn: data and a width in, height and chart options out.
import { axis, base, colours, floorLine, ink, legend, panels, panelTitle, scale } from './chart.js';

// Words over marks.
const onWhite = { backgroundColor: 'rgba(255,255,255,0.75)', padding: [1, 2] };
const mm = (v) => `${v.toFixed(4)} mm`;
const both = ['before', 'after'];

// ---- the plane ------------------------------------------------------------------------------

const noEnds = { color: ink, fontSize: 11, hideOverlap: true, showMinLabel: false, showMaxLabel: false };

function planeAxes(boxes, extent, nameX = 'x [mm]', nameY = 'y [mm]') {
  return {
    grid: boxes,
    xAxis: boxes.map((_, k) => axis(nameX, { gridIndex: k, min: extent.x[0], max: extent.x[1], splitLine: { show: false }, axisLabel: noEnds })),
    yAxis: boxes.map((_, k) => axis(nameY, { gridIndex: k, min: extent.y[0], max: extent.y[1], nameGap: 36, splitLine: { show: false }, axisLabel: noEnds })),
  };
}

// A square about all points, with some room, to whole tens.
function squareExtent(points, room = 0.06) {
  const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]);
  const [lx, hx, ly, hy] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const half = Math.max(10, (Math.max(hx - lx, hy - ly) / 2) * (1 + 2 * room));
  const round = (v) => 10 * (v < 0 ? Math.floor(v / 10) : Math.ceil(v / 10));
  const cx = (lx + hx) / 2, cy = (ly + hy) / 2;
  const r = Math.max(round(cx + half) - cx, cx - round(cx - half));
  return { x: [Math.round(cx - r), Math.round(cx + r)], y: [Math.round(cy - r), Math.round(cy + r)] };
}

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

const cellOf = (size) => (params, api) => {
  const at = api.coord([api.value(0), api.value(1)]);
  const [w, h] = api.size([size, size]);
  return {
    type: 'rect', silent: false,
    shape: { x: at[0] - w / 2 - 0.3, y: at[1] - h / 2 - 0.3, width: w + 0.6, height: h + 0.6 },
    style: { fill: api.visual('color') },
  };
};

function cells(grid, values) {
  const out = [];
  values.forEach((v, k) => {
    if (v === null) return;
    const i = k % grid.columns, j = Math.floor(k / grid.columns);
    out.push([grid.x_mm + i * grid.step_mm, grid.y_mm + j * grid.step_mm, v]);
  });
  return out;
}

function maps(data, width) {
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

function surfaces(data, width) {
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
        boxWidth: 100, boxDepth: 100, boxHeight: 55,
        viewControl: { alpha: 24, beta: 35, distance: 200, center: [0, -9, 0], animation: false, autoRotate: false, projection: 'perspective' },
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

const polyline = (points, colour, lineWidth, more = {}) => ({
  type: 'line', data: points, symbol: 'none', lineStyle: { color: colour, width: lineWidth }, itemStyle: { color: colour }, silent: true, ...more,
});

function mechanism(data, width) {
  const side = Math.min(width, 620);
  const box = { left: (width - side) / 2 + 56, top: 40, width: side - 76, height: side - 76 };
  const ends = data.chains.flatMap((c) => [...c.rail, c.slider, c.joint]);
  const extent = squareExtent(ends, 0.04);
  const joints = data.chains.map((c) => c.joint);
  const series = [{
    type: 'custom', name: 'workspace at phi = 0', data: data.reach, renderItem: cellOf(data.cell_mm), itemStyle: { color: '#8fbf9f' },
    tooltip: { formatter: (p) => `(${p.value[0]}, ${p.value[1]}) mm\ndistance from singular ${p.value[2].toFixed(2)} (1: far, 0: singular)` },
  }];
  data.chains.forEach((c) => {
    series.push(polyline(c.rail, '#888', 5, { name: 'rail (stroke)' }));
    series.push(polyline([c.slider, c.joint], ink, 3, { name: 'link' }));
  });
  series.push(polyline([...joints, joints[0]], colours.after, 3, { name: 'platform', areaStyle: undefined }));
  series.push({
    type: 'scatter', name: 'slider', data: data.chains.map((c) => c.slider), symbol: 'rect', symbolSize: 13, itemStyle: { color: colours.before },
    label: { show: true, formatter: (p) => `B${p.dataIndex + 1}`, position: 'right', color: ink }, z: 6,
    tooltip: { formatter: (p) => `slider ${p.dataIndex + 1}: (${p.value[0].toFixed(1)}, ${p.value[1].toFixed(1)}) mm` },
  });
  series.push({
    type: 'scatter', name: 'platform joint',
    data: joints.map((c) => ({ value: c, label: { position: Math.abs(c[0] - data.pose[0]) > 30 ? (c[0] > data.pose[0] ? 'right' : 'left') : 'bottom' } })), symbolSize: 9, itemStyle: { color: colours.after }, z: 6,
    label: { show: true, formatter: (p) => `C${p.dataIndex + 1}`, color: ink },
  });
  series.push({ type: 'scatter', name: 'platform centre', data: [data.pose], symbol: 'diamond', symbolSize: 11, itemStyle: { color: '#c00' }, z: 7 });
  return {
    height: side,
    option: {
      ...base, ...planeAxes([box], extent), series, legend: legend({ data: ['rail (stroke)', 'link', 'platform', 'slider', 'platform centre'] }),
      visualMap: { show: false, seriesIndex: 0, dimension: 2, min: 0, max: 1, inRange: { color: ['#f3f8f3', '#6aa87e'] } },
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function plan(data, width) {
  const side = Math.min(width, 560);
  const box = { left: (width - side) / 2 + 56, top: 40, width: side - 76, height: side - 76 };
  const shapes = [{ symbol: 'circle', color: colours.fitted }, { symbol: 'triangle', color: colours.unseen }];
  return {
    height: side,
    option: {
      ...base, ...planeAxes([box], squareExtent(data.sets.flatMap((s) => s.points))), legend: legend(),
      series: data.sets.map((s) => {
        const look = shapes[s.name.startsWith('identify') ? 0 : 1];
        return {
          type: 'scatter', name: s.name, data: s.points, symbol: look.symbol, symbolSize: 8,
          itemStyle: { color: 'transparent', borderColor: look.color, borderWidth: 1.6 },
          tooltip: { formatter: (p) => `point ${p.value[3]}: (${p.value[0]}, ${p.value[1]}) mm, ${p.value[2]} deg` },
        };
      }),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function nextPoints(data, width) {
  const side = Math.min(width, 560);
  const box = { left: (width - side) / 2 + 56, top: 40, width: side - 76, height: side - 76 };
  const next = data.next.map((p) => [p.x_mm, p.y_mm]);
  return {
    height: side,
    option: {
      ...base, ...planeAxes([box], squareExtent([...data.measured, ...next])), legend: legend(),
      series: [
        { type: 'scatter', name: 'measured', data: data.measured, symbolSize: 4, itemStyle: { color: '#aaa' }, silent: true },
        {
          type: 'scatter', name: 'to measure next', data: next, symbol: 'diamond', symbolSize: 13,
          itemStyle: { color: 'transparent', borderColor: '#c00', borderWidth: 2 },
          tooltip: {
            formatter: (p) => data.next.filter((n) => n.x_mm === p.value[0] && n.y_mm === p.value[1])
              .map((n) => `${n.phi_deg} deg, approach ${n.approach}: ${n.why}`).join('\n'),
          },
        }],
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function circles(data, width) {
  const n = data.circles.length;
  const { boxes, height } = panels(width, n, { least: n === 1 ? 600 : 400, top: 54 });
  const closed = (points, dx, dy) => {
    const at = points.map((p) => [p[0] + data.magnification * (dx === null ? 0 : p[dx]), p[1] + data.magnification * (dy === null ? 0 : p[dy])]);
    return [...at, at[0]];
  };
  const axes = { grid: boxes, xAxis: [], yAxis: [], series: [] };
  data.circles.forEach((c, k) => {
    const all = [...closed(c.points, 2, 3), ...closed(c.points, 4, 5)];
    const one = planeAxes([boxes[k]], squareExtent(all, 0.03));
    axes.xAxis.push({ ...one.xAxis[0], gridIndex: k });
    axes.yAxis.push({ ...one.yAxis[0], gridIndex: k });
    const on = { xAxisIndex: k, yAxisIndex: k };
    axes.series.push(polyline(closed(c.points, null, null), '#999', 1.5, { name: 'wanted', ...on }));
    axes.series.push(polyline(closed(c.points, 2, 3), colours.before, 1.5, { name: 'before', ...on }));
    axes.series.push(polyline(closed(c.points, 4, 5), colours.after, 1.5, { name: 'after', ...on }));
  });
  return {
    height,
    option: {
      ...base, ...axes, legend: legend(),
      title: data.circles.map((c, k) => panelTitle(boxes[k], `${c.name}: (${c.x_mm}, ${c.y_mm}) mm, R ${c.radius_mm} mm`)),
    },
  };
}

// ---- by point -------------------------------------------------------------------------------

function byPoint(data, width) {
  return {
    height: 250,
    option: {
      ...base, legend: legend(), grid: { left: 58, right: 18, top: 32, bottom: 44 },
      xAxis: axis('point, in the order of the plan', { min: 0, max: data.before.length + 1, minInterval: 1 }),
      yAxis: axis(`error [${data.unit}]`, { min: 0, scale: false, nameGap: 42 }),
      series: both.map((side, k) => ({
        type: 'line', name: side, data: data[side].map((v, i) => [i + 1, v]), symbol: k === 0 ? 'emptyCircle' : 'circle',
        symbolSize: width < 500 ? 3 : 5, lineStyle: { width: 1, color: colours[side] }, itemStyle: { color: colours[side] },
        markLine: k === 1 ? floorLine(data.floor, 'a perfect robot reads', data.unit) : undefined,
        tooltip: { formatter: (p) => `${data.targets[p.dataIndex]}\n${side}: ${p.value[1].toFixed(4)} ${data.unit}` },
      })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function simulated(data, width) {
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

// ---- fits -----------------------------------------------------------------------------------

function sensitivity(data, width) {
  const chains = [['#0b3c5d', '#1f6fb4', '#5b9bd5', '#8fbce6', '#b9d6f2', '#dbe9f8'], ['#7a3100', '#d95f02', '#f08a3c', '#f5a96b', '#f9c69b', '#fde3cd'],
    ['#0d4f3c', '#1b9e77', '#4dbb98', '#7fd0b5', '#aee2d0', '#d7f1e8']];
  const rows = ['x', 'y', 'phi'];
  return {
    height: 236 + 24 * Math.ceil((18 * 74) / width),
    option: {
      ...base, legend: legend({ bottom: 0, top: undefined, type: 'plain', itemWidth: 12, itemGap: 8, width: width - 40 }),
      grid: { left: 56, right: 22, top: 10, height: 170 },
      xAxis: axis('share of the error [%]', { min: 0, max: 100, scale: false }),
      yAxis: { type: 'category', data: rows, inverse: true, axisLabel: { color: ink, fontSize: 13 } },
      series: data.sources.map((name, j) => ({
        type: 'bar', stack: 'all', name, data: data.rows.map((r) => r[j]), itemStyle: { color: chains[Math.floor(j / 6)][j % 6], borderColor: '#fff', borderWidth: 0.5 },
        label: { show: true, formatter: (p) => (p.value >= 6 ? name : ''), color: j % 6 < 2 ? '#fff' : ink, fontSize: 11 },
        tooltip: { formatter: (p) => `${name}: ${p.value.toFixed(2)} % of the error in ${rows[p.dataIndex]}` },
      })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function network(data, width) {
  const { boxes, height } = panels(width, 3, { least: 240, top: 56 });
  const look = { 'in-sample': { color: colours.fitted }, 'held-out': { color: 'transparent', borderColor: colours.unseen, borderWidth: 1.4 } };
  const series = [], xAxis = [], yAxis = [];
  boxes.forEach((_, k) => {
    const all = data.sets.flatMap((s) => s.joints[k].flat());
    const low = Math.min(...all), high = Math.max(...all), room = 0.05 * (high - low || 1);
    const ends = { min: low - room, max: high + room, axisLabel: { formatter: (v) => v.toFixed(2), color: ink, fontSize: 11, hideOverlap: true, showMinLabel: false, showMaxLabel: false }, splitNumber: 4 };
    xAxis.push(axis('measured [mm]', { gridIndex: k, ...ends }));
    yAxis.push(axis('network [mm]', { gridIndex: k, nameGap: 38, ...ends }));
    series.push(polyline([[low - room, low - room], [high + room, high + room]], '#999', 1, { xAxisIndex: k, yAxisIndex: k }));
    data.sets.forEach((s) => series.push({
      type: 'scatter', name: s.name, xAxisIndex: k, yAxisIndex: k, data: s.joints[k], symbolSize: 5, itemStyle: look[s.name],
      tooltip: { formatter: (p) => `${s.name}: measured ${mm(p.value[0])}, network ${mm(p.value[1])}` },
    }));
  });
  return {
    height,
    option: {
      ...base, grid: boxes, xAxis, yAxis, series, legend: legend({ data: data.sets.map((s) => s.name) }),
      title: boxes.map((b, k) => panelTitle(b, `joint ${k + 1}`)), tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

const whisker = (params, api) => {
  const x = api.coord([api.value(0), 0])[0];
  const low = api.coord([0, api.value(1)])[1], high = api.coord([0, api.value(2)])[1];
  const style = { stroke: ink, lineWidth: 1.5 };
  const line = (x1, y1, x2, y2) => ({ type: 'line', shape: { x1, y1, x2, y2 }, style });
  return { type: 'group', children: [line(x, low, x, high), line(x - 6, low, x + 6, low), line(x - 6, high, x + 6, high)] };
};

function contest(data, width) {
  const names = data.bars.map((b) => `${b.method}\n${b.judged}\nn = ${b.n}`);
  return {
    height: 330,
    option: {
      ...base, legend: legend(), grid: { left: 58, right: 18, top: 34, bottom: 66 },
      xAxis: { type: 'category', data: names, axisLabel: { color: ink, fontSize: width < 500 ? 9 : 11, lineHeight: 15, interval: 0 }, axisTick: { show: false } },
      yAxis: axis('mean position error [mm]', { min: 0, scale: false, nameGap: 42 }),
      series: [
        { type: 'bar', name: 'before', data: data.bars.map((b) => b.before), itemStyle: { color: colours.pale }, barGap: '-100%', barWidth: '62%' },
        {
          type: 'bar', name: 'after', data: data.bars.map((b) => b.after), itemStyle: { color: colours.after }, barWidth: '62%', z: 3,
          label: { show: true, position: 'top', distance: 14, formatter: (p) => p.value.toFixed(4), color: ink, fontSize: 11, ...onWhite },
          markLine: floorLine(data.floor, 'noise floor', 'mm'),
        },
        { type: 'custom', name: '95 % interval of the mean', renderItem: whisker, z: 5, itemStyle: { color: ink },
          data: data.bars.map((b, i) => [i, b.low ?? b.after, b.high ?? b.after]), silent: true },
      ],
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: (v) => (typeof v === 'number' ? mm(v) : '') },
    },
  };
}

// ---- the story ------------------------------------------------------------------------------

function waterfall(data, width) {
  const sets = [['fitted', 'fitted (in-sample)', colours.fitted, colours.palest], ['unseen', 'unseen (held-out)', colours.unseen, colours.pale]]
    .filter(([key]) => data.steps.some((s) => s[key] !== null));
  const series = [];
  sets.forEach(([key, name, full, pale]) => {
    series.push({
      type: 'bar', stack: key, name, data: data.steps.map((s) => s[key]), itemStyle: { color: full },
      label: { show: width > 500, position: 'top', distance: 3, formatter: (p) => (typeof p.value === 'number' ? p.value.toFixed(4) : ''), color: ink, fontSize: 11, ...onWhite },
      z: 3,
      markLine: key === 'fitted' ? floorLine(data.floor, 'a perfect model leaves', 'mm') : undefined,
    });
    series.push({
      type: 'bar', stack: key, name: `closed, ${key}`, itemStyle: { color: pale },
      data: data.steps.map((s, i) => (i === 0 || s[key] === null || data.steps[i - 1][key] === null ? 0 : Math.max(0, data.steps[i - 1][key] - s[key]))),
    });
  });
  return {
    height: 300,
    option: {
      ...base, legend: legend({ data: sets.map((s) => s[1]) }), grid: { left: 58, right: 18, top: 34, bottom: 34 },
      xAxis: { type: 'category', data: data.steps.map((s) => s.model), axisLabel: { color: ink, fontSize: 12, interval: 0 }, axisTick: { show: false } },
      yAxis: axis('rms per coordinate [mm]', { min: 0, scale: false, nameGap: 42 }), series,
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: (v) => (typeof v === 'number' ? mm(v) : '-') },
    },
  };
}

// Full marks: fitted; open: unseen.
const mark = (colour, isFitted) => (isFitted ? { color: colour, opacity: 0.75 } : { color: 'transparent', borderColor: colour, borderWidth: 1.2 });

const directions = { min: -2, max: 2, interval: 1, axisLabel: { formatter: (v) => ({ '-1': '-', 0: '0', 1: '+' })[v] ?? '', color: ink, fontSize: 13 } };

function scatterOf(points, rail, isFitted, on) {
  return {
    type: 'scatter', name: `rail ${rail + 1}`, ...on, data: points, symbolSize: 5, itemStyle: mark(colours.rails[rail], isFitted),
    tooltip: { formatter: (p) => `rail ${rail + 1}, ${isFitted ? 'fitted' : 'unseen'}: ${mm(p.value[1])}` },
  };
}

const rails = [0, 1, 2];
const railLegend = () => legend({ data: rails.map((k) => ({ name: `rail ${k + 1}`, itemStyle: { color: colours.rails[k], opacity: 1 } })) });

function residuals(data, width) {
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
    yAxis.push(axis(column === 0 ? state : '', { gridIndex: n, min: -most, max: most, nameGap: 42, axisLabel: { formatter: (v) => v.toFixed(2), showMinLabel: false, showMaxLabel: false, color: ink, fontSize: 11 } }));
    rails.forEach((k) => [true, false].forEach((isFitted) => {
      const points = data.readings.map((r, i) => [r, i]).filter(([r, i]) => r.fitted === isFitted && x(r, k, i) !== null).map(([r, i]) => [x(r, k, i), r.rails[k][value]]);
      if (points.length) series.push(scatterOf(points, k, isFitted, { xAxisIndex: n, yAxisIndex: n }));
    }));
  }));
  return {
    height: 30 + 2 * Math.ceil(recorded.length / columns) * (high + 48),
    option: { ...base, grid, xAxis, yAxis, series, legend: railLegend(), tooltip: { ...base.tooltip, trigger: 'item' } },
  };
}

function effect(data, width) {
  const { boxes, height } = panels(width, 3, { least: 240, ratio: 0.8, top: 54 });
  const discrete = data.axis.startsWith('direction');
  const series = [];
  data.rails.forEach((points, k) => {
    const on = { xAxisIndex: k, yAxisIndex: k };
    [1, 0].forEach((isFitted) => {
      const some = points.filter((p) => p[3] === isFitted);
      if (some.length) series.push(scatterOf(some, k, isFitted === 1, on));
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
      ...base, grid: boxes, series, legend: legend({ data: ['the effect as fitted'] }), title: boxes.map((b, k) => panelTitle(b, `rail ${k + 1}`)),
      xAxis: boxes.map((_, k) => axis(data.axis, { gridIndex: k, splitNumber: 4, ...(discrete ? directions : {}) })),
      yAxis: boxes.map((_, k) => axis(k === 0 || boxes[k].left === boxes[0].left ? 'joint error [mm]' : '', { gridIndex: k, nameGap: 42, min: -most, max: most, axisLabel: { formatter: (v) => v.toFixed(2), showMinLabel: false, showMaxLabel: false, color: ink, fontSize: 11 } })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

function temperature(data) {
  return {
    height: 260,
    option: {
      ...base, legend: legend({ type: 'scroll' }), grid: { left: 58, right: 18, top: 34, bottom: 44 },
      xAxis: axis('time since the start [h]'), yAxis: axis('temperature [degC]', { nameGap: 42 }),
      series: data.sessions.map((s) => ({ type: 'scatter', name: s.name, data: s.points, symbolSize: 3 })),
      tooltip: { ...base.tooltip, trigger: 'item', formatter: (p) => `${p.value[0].toFixed(2)} h: ${p.value[1].toFixed(2)} degC` },
    },
  };
}

// ---- live -----------------------------------------------------------------------------------

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

const deviations = (rows, width) => recent(rows, width, (r) => `${r.point}`);
const drift = (rows, width) => recent(rows, width, (r) => `${r.point}, epoch ${r.epoch}`);

export const kinds = {
  deviations, drift,
  maps, surfaces, mechanism, plan, 'next-points': nextPoints, circles, 'by-point': byPoint, simulated, sensitivity, network, contest,
  waterfall, residuals, effect, temperature,
};
