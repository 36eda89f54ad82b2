// What figures in the x-y plane share.
import { axis, ink } from './chart.js';

const noEnds = { color: ink, fontSize: 11, hideOverlap: true, showMinLabel: false, showMaxLabel: false };

export function planeAxes(boxes, extent, nameX = 'x [mm]', nameY = 'y [mm]') {
  return {
    grid: boxes,
    xAxis: boxes.map((_, k) => axis(nameX, { gridIndex: k, min: extent.x[0], max: extent.x[1], splitLine: { show: false }, axisLabel: noEnds })),
    yAxis: boxes.map((_, k) => axis(nameY, { gridIndex: k, min: extent.y[0], max: extent.y[1], nameGap: 36, splitLine: { show: false }, axisLabel: noEnds })),
  };
}

// A square about all points, with some room, to whole tens, or ones and tenths on a stage of millimetres.
export function squareExtent(points, room = 0.06) {
  const xs = points.map((p) => p[0]), ys = points.map((p) => p[1]);
  const [lx, hx, ly, hy] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const wanted = (Math.max(hx - lx, hy - ly) / 2) * (1 + 2 * room) || 10;
  const unit = wanted >= 10 ? 10 : 10 ** Math.floor(Math.log10(wanted));
  const half = Math.max(unit, wanted);
  const round = (v) => unit * (v < 0 ? Math.floor(v / unit) : Math.ceil(v / unit));
  const cx = (lx + hx) / 2, cy = (ly + hy) / 2;
  const r = Math.max(round(cx + half) - cx, cx - round(cx - half));
  const whole = (v) => (unit >= 10 ? Math.round(v) : Number(v.toPrecision(6)));
  return { x: [whole(cx - r), whole(cx + r)], y: [whole(cy - r), whole(cy + r)] };
}

export const cellOf = (size) => (params, api) => {
  const at = api.coord([api.value(0), api.value(1)]);
  const [w, h] = api.size([size, size]);
  return {
    type: 'rect', silent: false,
    shape: { x: at[0] - w / 2 - 0.3, y: at[1] - h / 2 - 0.3, width: w + 0.6, height: h + 0.6 },
    style: { fill: api.visual('color') },
  };
};
