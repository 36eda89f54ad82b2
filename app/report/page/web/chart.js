// The parts of the charting library that are used, and what all figures share.
import { init, setPlatformAPI, use } from 'echarts/core';
import { BarChart, CustomChart, LineChart, ScatterChart } from 'echarts/charts';
import {
  GridComponent, LegendComponent, MarkLineComponent, TitleComponent, TooltipComponent,
  VisualMapComponent,
} from 'echarts/components';
import { CanvasRenderer, SVGRenderer } from 'echarts/renderers';
import { SurfaceChart } from 'echarts-gl/charts';
import { Grid3DComponent } from 'echarts-gl/components';

use([BarChart, CustomChart, LineChart, ScatterChart, GridComponent, LegendComponent,
  MarkLineComponent, TitleComponent, TooltipComponent, VisualMapComponent, SVGRenderer,
  CanvasRenderer, SurfaceChart, Grid3DComponent]);

// The library takes the width of this sign for a line's height. Where no font has it, what stands in
// for it is narrow, and lines would overlap.
const context = document.createElement('canvas').getContext('2d');
setPlatformAPI({
  measureText(words, font = '12px sans-serif') {
    context.font = font;
    return words === '国' ? { width: parseFloat(/([\d.]+)px/.exec(font)?.[1] ?? '12') } : context.measureText(words);
  },
});

export { init };

export const ink = '#222';
export const colours = {
  before: '#d95f02', after: '#1f6fb4', floor: '#555', pale: '#f5cda8', palest: '#bcd6ec',
  fitted: '#1f6fb4', unseen: '#d95f02', rails: ['#1b9e77', '#d95f02', '#7570b3'],
};
// Viridis: even in lightness, readable without colour and by the colour-blind.
export const scale = ['#440154', '#46327e', '#365c8d', '#277f8e', '#1fa187', '#4ac16d', '#a0da39',
  '#fde725'];

const text = { color: ink, fontSize: 12, fontFamily: 'system-ui, sans-serif' };

export const base = {
  animation: false,
  textStyle: text,
  // Rich text is drawn: no name of a campaign can become markup.
  tooltip: { renderMode: 'richText', confine: true, textStyle: { fontSize: 12 } },
};

export function axis(name, more = {}) {
  return {
    type: 'value', name, nameLocation: 'middle', nameGap: 28, scale: true,
    nameTextStyle: { color: ink, fontSize: 12 },
    axisLine: { show: true, onZero: false, lineStyle: { color: '#888' } },
    axisTick: { show: true }, axisLabel: { color: ink, fontSize: 11, hideOverlap: true },
    splitLine: { lineStyle: { color: '#eee' } }, ...more,
  };
}

export const legend = (more = {}) => ({ top: 0, itemWidth: 18, textStyle: text, ...more });

// A dashed line at a value, named in the legend.
export function floorLine(value, words, unit) {
  if (value === null) return [];
  const lineStyle = { color: colours.floor, type: 'dashed', width: 1.5 };
  return [{
    type: 'line', name: `${words} ${value.toFixed(4)} ${unit}`, data: [], symbol: 'none', lineStyle, itemStyle: { color: colours.floor },
    markLine: { silent: true, symbol: 'none', lineStyle, label: { show: false }, data: [{ yAxis: value }] },
  }];
}

// Panels of one width side by side, or below each other where the page is narrow.
export function panels(width, count, { least = 300, ratio = 1, left = 52, right = 14, top = 46, bottom = 44 } = {}) {
  const columns = Math.max(1, Math.min(count, Math.floor(width / least)));
  const cell = width / columns;
  const inner = cell - left - right;
  const height = inner * ratio;
  const boxes = [];
  for (let k = 0; k < count; k += 1) {
    boxes.push({
      left: (k % columns) * cell + left,
      top: Math.floor(k / columns) * (height + top + bottom) + top,
      width: inner, height,
    });
  }
  return { boxes, height: Math.ceil(count / columns) * (height + top + bottom) };
}

export const panelTitle = (box, words) => ({
  text: words, left: box.left + box.width / 2, top: box.top - 20, textAlign: 'center',
  textStyle: { ...text, fontWeight: 600, fontSize: 13 }, padding: 0,
});

// A line without marks.
export const polyline = (points, colour, lineWidth, more = {}) => ({
  type: 'line', data: points, symbol: 'none', lineStyle: { color: colour, width: lineWidth }, itemStyle: { color: colour }, silent: true, ...more,
});

// Words over marks.
export const onWhite = { backgroundColor: 'rgba(255,255,255,0.75)', padding: [1, 2] };
export const mm = (v) => `${v.toFixed(4)} mm`;
export const both = ['before', 'after'];
