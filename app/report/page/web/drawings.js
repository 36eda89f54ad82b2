// The mechanism, the points, the circles: drawn to scale.
import { base, colours, ink, legend, panels, panelTitle, polyline } from './chart.js';
import { cellOf, planeAxes, squareExtent } from './plane.js';

export function mechanism(data, width) {
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

export function plan(data, width) {
  const side = Math.min(width, 560);
  const box = { left: (width - side) / 2 + 56, top: 40, width: side - 76, height: side - 76 };
  const shapes = { identify: ['circle', colours.fitted, 8], validate: ['triangle', colours.unseen, 8], circles: ['circle', '#777', 3] };
  return {
    height: side,
    option: {
      ...base, ...planeAxes([box], squareExtent(data.sets.flatMap((s) => s.points))), legend: legend(),
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

export function nextPoints(data, width) {
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

export function circles(data, width) {
  const n = data.circles.length;
  const { boxes, height } = panels(width, n, { least: n === 1 ? 600 : Math.max(330, width / 2.5), top: 54 });
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
