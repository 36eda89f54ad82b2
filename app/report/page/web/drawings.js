// The mechanism, the points, the circles: drawn to scale.
import { base, colours, ink, kSmall, legendAbove, onWhite, panels, panelTitle, plain, polyline } from './chart.js';
import { cellOf, planeAxes, squareExtent } from './plane.js';

// One square of at most `most` px below its legend.
function square(names, width, most) {
  const side = Math.min(width, most);
  const { legend, top } = legendAbove(names, width);
  const box = { left: (width - side) / 2 + 56, top, width: side - 76, height: side - 76 };
  return { legend, box, height: top + side - 76 + 44 };
}

export function mechanism(data, width) {
  const { box, height, legend } = square(['rail (stroke)', 'link', ...(data.chains.length > 2 ? ['platform'] : []), 'slider', 'platform centre'], width, 620);
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
  if (joints.length > 2) series.push(polyline([...joints, joints[0]], colours.after, 3, { name: 'platform', areaStyle: undefined }));
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
    height,
    option: {
      ...base, ...planeAxes([box], extent), series, legend,
      visualMap: { show: false, seriesIndex: 0, dimension: 2, min: 0, max: 1, inRange: { color: ['#f3f8f3', '#6aa87e'] } },
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

export function plan(data, width) {
  const { box, height, legend } = square(data.sets.map((s) => s.name), width, 560);
  const shapes = { identify: ['circle', colours.fitted, 8], validate: ['triangle', colours.unseen, 8], circles: ['circle', '#777', 3] };
  return {
    height,
    option: {
      ...base, ...planeAxes([box], squareExtent(data.sets.flatMap((s) => s.points))), legend,
      series: data.sets.map((s) => {
        const [symbol, color, symbolSize] = shapes[s.name.split(' ')[0]];
        return {
          type: 'scatter', name: s.name, data: s.points, symbol, symbolSize,
          itemStyle: { color: 'transparent', borderColor: color, borderWidth: 1.6 },
          tooltip: { formatter: (p) => `point ${p.value[3]}: (${p.value[0]}, ${p.value[1]}) mm, ${p.value[2]} deg` },
        };
      }),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

// A place that is asked for, once for all that is to be done there.
function places(next) {
  const found = new Map();
  next.forEach((n) => {
    const key = `${n.x_mm} ${n.y_mm}`;
    found.set(key, [...(found.get(key) ?? []), n]);
  });
  return [...found.values()];
}

// A cross-hair turned as the platform is to be, its long arm along the platform's x, and on the
// words' side how: orientation and approach of each visit.
const turned = (params, api) => {
  const [x, y] = api.coord([api.value(0), api.value(1)]);
  const angle = (api.value(2) * Math.PI) / 180, [ux, uy] = [Math.cos(angle), -Math.sin(angle)];
  const style = { stroke: '#c00', lineWidth: 2, fill: 'none' };
  const line = (dx, dy) => ({ type: 'line', shape: { x1: x - dx / 3, y1: y - dy / 3, x2: x + dx, y2: y + dy }, style });
  return { type: 'group', children: [line(18 * ux, 18 * uy), line(9 * uy, -9 * ux), { type: 'circle', shape: { cx: x, cy: y, r: 3.5 }, style: { ...style, fill: '#fff' } }] };
};

export function nextPoints(data, width) {
  const { box, height, legend } = square(['measured', 'to measure next'], width, 760);
  const at = places(data.next);
  const words = (n) => `${n.phi_deg > 0 ? '+' : ''}${n.phi_deg} deg ${n.approach}`;
  return {
    height,
    option: {
      ...base, ...planeAxes([box], squareExtent([...data.measured, ...data.next.map((p) => [p.x_mm, p.y_mm])], 0.14)), legend,
      series: [
        { type: 'scatter', name: 'measured', data: data.measured, symbolSize: 4, itemStyle: { color: '#767676' }, silent: true },
        {
          type: 'custom', name: 'to measure next', renderItem: turned, itemStyle: { color: '#c00' },
          data: data.next.map((n) => [n.x_mm, n.y_mm, n.phi_deg]), encode: { x: 0, y: 1 },
          tooltip: { formatter: (p) => `${words(data.next[p.dataIndex])}: ${data.next[p.dataIndex].why}` },
        },
        {
          type: 'scatter', name: 'how', silent: true, symbolSize: 1, itemStyle: { color: 'transparent' },
          data: at.map((all) => ({ value: [all[0].x_mm, all[0].y_mm], words: all.map(words).join('\n') })),
          label: { show: width > 500, position: 'bottom', distance: 10, color: ink, fontSize: 10, lineHeight: 12, formatter: (p) => p.data.words, ...onWhite },
          labelLayout: { hideOverlap: true },
        }],
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

const kDivisions = 3;  // of the scale of deviations, to either side of a circle

export function circles(data, width) {
  const n = data.circles.length;
  const ring = `${plain(data.division_mm * kSmall)} um per division`;
  const { legend, top } = legendAbove(['wanted', 'before', 'after', ring], width);
  const { boxes, height } = panels(width, n, { least: n === 1 ? 600 : Math.max(330, width / 2.5), above: top });
  const closed = (points, dx, dy) => {
    const at = points.map((p) => [p[0] + data.magnification * (dx === null ? 0 : p[dx]), p[1] + data.magnification * (dy === null ? 0 : p[dy])]);
    return [...at, at[0]];
  };
  const round = (c, radius) => Array.from({ length: 121 }, (_, k) => [c.x_mm + radius * Math.cos((k * Math.PI) / 60), c.y_mm + radius * Math.sin((k * Math.PI) / 60)]);
  // By angle: points that one fit has seen stand apart in the data.
  const around = (c) => ({ ...c, points: [...c.points].sort((p, q) => Math.atan2(p[1] - c.y_mm, p[0] - c.x_mm) - Math.atan2(q[1] - c.y_mm, q[0] - c.x_mm)) });
  const axes = { grid: boxes, xAxis: [], yAxis: [], series: [] };
  data.circles.map(around).forEach((c, k) => {
    const rings = [];
    for (let d = -kDivisions; d <= kDivisions; d += 1) {
      const radius = c.radius_mm + d * data.division_mm * data.magnification;
      if (d !== 0 && radius > 0) rings.push(round(c, radius));
    }
    const all = [...closed(c.points, 2, 3), ...closed(c.points, 4, 5), ...rings.flat()];
    const one = planeAxes([boxes[k]], squareExtent(all, 0.03));
    axes.xAxis.push({ ...one.xAxis[0], gridIndex: k });
    axes.yAxis.push({ ...one.yAxis[0], gridIndex: k });
    const on = { xAxisIndex: k, yAxisIndex: k };
    rings.forEach((points) => axes.series.push(polyline(points, '#bbb', 0.8, { name: ring, ...on })));
    axes.series.push(polyline(closed(c.points, null, null), '#767676', 1.5, { name: 'wanted', ...on }));
    axes.series.push(polyline(closed(c.points, 2, 3), colours.before, 1.5, { name: 'before', ...on }));
    axes.series.push(polyline(closed(c.points, 4, 5), colours.after, 1.5, { name: 'after', ...on }));
  });
  return {
    height,
    option: {
      ...base, ...axes, legend,
      title: data.circles.map((c, k) => panelTitle(boxes[k], `${c.name}: (${c.x_mm}, ${c.y_mm}) mm, R ${c.radius_mm} mm`)),
    },
  };
}
