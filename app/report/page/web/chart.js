// The parts of the charting library that are used, and what all figures share.
import { init, setPlatformAPI, use } from 'echarts/core';
import { BarChart, CustomChart, LineChart, ScatterChart } from 'echarts/charts';
import {
  AriaComponent, GridComponent, LegendComponent, MarkLineComponent, TitleComponent, TooltipComponent,
  VisualMapComponent,
} from 'echarts/components';
import { CanvasRenderer, SVGRenderer } from 'echarts/renderers';
import { SurfaceChart } from 'echarts-gl/charts';
import { Grid3DComponent } from 'echarts-gl/components';

use([BarChart, CustomChart, LineChart, ScatterChart, AriaComponent, GridComponent, LegendComponent,
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

// Okabe and Ito's colours, which the colour-blind tell apart, without the yellow that white swallows.
const distinct = ['#0072b2', '#d55e00', '#009e73', '#cc79a7', '#e69f00', '#56b4e9', '#000000'];
export const shapes = ['circle', 'triangle', 'rect', 'diamond', 'emptyCircle', 'emptyTriangle'];

export const base = {
  animation: false, color: distinct,
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

const kItem = 18, kGap = 10, kRow = 24;  // px of a legend

// A legend of these names above the figure, and where the figure may begin: the library breaks a
// legend into as many rows as it needs, and lets them lie over what stands below.
export function legendAbove(names, width, more = {}) {
  context.font = `12px ${text.fontFamily}`;
  let rows = 1, at = 0;
  names.forEach((name) => {
    const wide = kItem + 5 + context.measureText(name.name ?? name).width;
    if (at > 0 && at + wide > width - 20) { rows += 1; at = 0; }
    at += wide + kGap;
  });
  return {
    legend: { type: 'plain', top: 0, itemWidth: kItem, itemGap: kGap, width: width - 10, textStyle: text, data: names, ...more },
    top: 10 + kRow * rows, rows,
  };
}

// A dashed line at a value, named in the legend.
export function floorLine(value, words, unit) {
  if (value === null) return [];
  const lineStyle = { color: colours.floor, type: 'dashed', width: 1.5 };
  return [{
    type: 'line', name: `${words} ${fixed(value, unit)} ${unit}`, data: [], symbol: 'none', lineStyle, itemStyle: { color: colours.floor },
    // Else the library rounds the value to two decimals before it draws it.
    markLine: { precision: -1, silent: true, symbol: 'none', lineStyle, label: { show: false }, data: [{ yAxis: value }] },
  }];
}

// Panels of one width side by side, or below each other where the page is narrow.
// `above`: room for a legend over all of them.
export function panels(width, count, { least = 300, ratio = 1, left = 52, right = 14, top = 30, bottom = 44, above = 16 } = {}) {
  const columns = Math.max(1, Math.min(count, Math.floor(width / least)));
  const cell = width / columns;
  const inner = cell - left - right;
  const height = inner * ratio;
  const boxes = [];
  for (let k = 0; k < count; k += 1) {
    boxes.push({
      left: (k % columns) * cell + left,
      top: above + Math.floor(k / columns) * (height + top + bottom) + top,
      width: inner, height, cell: { left: (k % columns) * cell, width: cell },
    });
  }
  return { boxes, columns, height: above + Math.ceil(count / columns) * (height + top + bottom) };
}

// Over the panel's plot; words that are wider, over the whole panel, and no larger than it holds.
export function panelTitle(box, words) {
  const size = 13;
  context.font = `600 ${size}px ${text.fontFamily}`;
  const wide = context.measureText(words).width + 4;
  const over = wide > box.width && box.cell ? box.cell : box;
  return {
    text: words, left: over.left + over.width / 2, top: box.top - 20, textAlign: 'center', padding: 0,
    textStyle: { ...text, fontWeight: 600, fontSize: Math.min(size, Math.floor((size * over.width) / wide)) },
  };
}

// A line without marks.
export const polyline = (points, colour, lineWidth, more = {}) => ({
  type: 'line', data: points, symbol: 'none', lineStyle: { color: colour, width: lineWidth }, itemStyle: { color: colour }, silent: true, ...more,
});

// Black or white, whichever stands out more from a colour "#rrggbb" (WCAG 2: by relative luminance).
export function wordsOn(colour) {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(colour.slice(k, k + 2), 16) / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  const light = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  return 1.05 / (light + 0.05) > (light + 0.05) / 0.05 ? '#ffffff' : '#000000';
}

// Words over marks.
export const onWhite = { backgroundColor: 'rgba(255,255,255,0.75)', padding: [1, 2] };
let decimals = 4;  // of errors in mm, as the whole report has them
export const setDecimals = (n) => { decimals = n; };
export const fixed = (v, unit = 'mm') => v.toFixed(unit === 'mm' ? decimals : 4);
export const mm = (v) => `${fixed(v)} mm`;
// In the small unit: um for mm, mdeg for deg.
export const kSmall = 1000;
export const both = ['before', 'after'];
// A number without the tail that sums of decimals grow: 59.999999999999986 is 60.
export const plain = (v) => String(Number(v.toPrecision(6)));
