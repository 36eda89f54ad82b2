// Shares, fits and methods.
import { axis, base, both, colours, fixed, floorLine, ink, legendAbove, mm, onWhite, panels, panelTitle, polyline, wordsOn } from './chart.js';

export function sensitivity(data, width) {
  const chains = [['#0b3c5d', '#1f6fb4', '#5b9bd5', '#8fbce6', '#b9d6f2', '#dbe9f8'], ['#7a3100', '#d95f02', '#f08a3c', '#f5a96b', '#f9c69b', '#fde3cd'],
    ['#0d4f3c', '#1b9e77', '#4dbb98', '#7fd0b5', '#aee2d0', '#d7f1e8']];
  const rows = ['x', 'y', 'phi'].slice(0, data.rows.length);
  const { legend, top } = legendAbove(data.sources, width);
  return {
    height: top + 216,
    option: {
      ...base, legend, grid: { left: 56, right: 22, top, height: 170 },
      xAxis: axis('share of the error [%]', { min: 0, max: 100, scale: false }),
      yAxis: { type: 'category', data: rows, inverse: true, axisLabel: { color: ink, fontSize: 13 } },
      series: data.sources.map((name, j) => ({
        type: 'bar', stack: 'all', name, data: data.rows.map((r) => r[j]), itemStyle: { color: chains[Math.floor(j / 6)][j % 6], borderColor: '#fff', borderWidth: 0.5 },
        label: { show: true, formatter: (p) => (p.value >= 6 ? name : ''), color: wordsOn(chains[Math.floor(j / 6)][j % 6]), fontSize: 11 },
        tooltip: { formatter: (p) => `${name}: ${p.value.toFixed(2)} % of the error in ${rows[p.dataIndex]}` },
      })),
      tooltip: { ...base.tooltip, trigger: 'item' },
    },
  };
}

export function network(data, width) {
  const { legend, top } = legendAbove(data.sets.map((s) => s.name), width);
  const { boxes, height } = panels(width, data.sets[0].joints.length, { least: 240, above: top });
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
      ...base, grid: boxes, xAxis, yAxis, series, legend,
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

export function contest(data, width) {
  const narrow = width < 100 * data.bars.length;  // names stand upright
  const names = data.bars.map((b) => [b.method, b.judged, `n = ${b.n}`].join(narrow ? ', ' : '\n'));
  const whiskers = '95 % interval of the mean';
  const floor = floorLine(data.floor, 'mean length of a perfect reading', 'mm');
  const { legend, top } = legendAbove([...both, whiskers, ...floor.map((line) => line.name)], width);
  return {
    height: top + (narrow ? 420 : 300),
    option: {
      ...base, legend, grid: { left: 58, right: 18, top, bottom: narrow ? 170 : 66 },
      xAxis: { type: 'category', data: names, axisLabel: { color: ink, fontSize: 11, lineHeight: 15, interval: 0, rotate: narrow ? 90 : 0 }, axisTick: { show: false } },
      yAxis: axis('mean position error [mm]', { min: 0, scale: false, nameGap: 42 }),
      series: [
        { type: 'bar', name: 'before', data: data.bars.map((b) => b.before), itemStyle: { color: colours.pale, borderColor: colours.before }, barGap: '-100%', barWidth: '62%' },
        {
          type: 'bar', name: 'after', data: data.bars.map((b) => b.after), itemStyle: { color: colours.after }, barWidth: '62%', z: 3,
          label: { show: !narrow, position: 'top', distance: 14, formatter: (p) => fixed(p.value), color: ink, fontSize: 11, ...onWhite },
        },
        { type: 'custom', name: whiskers, renderItem: whisker, z: 5, itemStyle: { color: ink },
          data: data.bars.map((b, i) => [i, b.low ?? b.after, b.high ?? b.after]), silent: true },
        ...floor,
      ],
      tooltip: { ...base.tooltip, trigger: 'axis', valueFormatter: (v) => (typeof v === 'number' ? mm(v) : '') },
    },
  };
}
