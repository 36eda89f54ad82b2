// Surfaces are drawn one after the other by one chart and kept as pictures: a browser has few
// contexts for 3-D, each new one compiles its shaders anew, and a picture prints. A picture is a
// button: it becomes live, to be turned by mouse or arrow keys until Escape.
import { init } from './chart.js';
import { element } from './dom.js';
import { kinds } from './figures.js';
import { spoken } from './numbers.js';

const kSharp = 1.5;  // picture elements to a px: some 190 dpi on paper
const kMost = 1240;  // px, as wide as the page
const kTurn = 8;     // deg a key
let live = null;

export const still = () => live?.();

const surfaceChart = (box) => init(box, null, { renderer: 'canvas', width: 1, height: 1, devicePixelRatio: kSharp });

function drawSurface(chart, item, width) {
  const { height, option } = kinds[item.kind](item.data, width);
  chart.clear();  // else the library keeps the shape of the surface before
  chart.resize({ width, height });
  chart.setOption(option);
  return option.grid3D.map((grid) => ({ ...grid.viewControl }));
}

// Two frames: one lays the labels out, one draws. A page in the background gets none.
const frame = () => new Promise((resolve) => { requestAnimationFrame(resolve); setTimeout(resolve, 300); });
const settled = async () => { await frame(); await frame(); };

function makeLive(button, item) {
  still();
  const box = element('div', { class: 'chart live', tabindex: '0', role: 'img', 'aria-label': `${spoken(item)}. Arrow keys turn it, Escape ends.` });
  const width = button.clientWidth;
  button.hidden = true;
  button.after(box);
  const chart = surfaceChart(box);
  const views = drawSurface(chart, item, width);
  const turn = { ArrowLeft: ['beta', -kTurn], ArrowRight: ['beta', kTurn], ArrowUp: ['alpha', kTurn], ArrowDown: ['alpha', -kTurn] };
  box.addEventListener('keydown', (event) => {
    if (event.key === 'Escape') { still(); button.focus(); }
    if (!turn[event.key]) return;
    event.preventDefault();
    const [angle, by] = turn[event.key];
    views.forEach((view) => { view[angle] += by; });
    chart.setOption({ grid3D: views.map((viewControl) => ({ viewControl })) });
  });
  live = () => { live = null; chart.dispose(); box.remove(); button.hidden = false; };
  box.focus();
}

const queue = [];
let drawing = false;
export const isIdle = () => !drawing && queue.length === 0;
export const forget = () => { still(); queue.length = 0; };

// `drawn(error)` once the picture stands in the box, or cannot.
export async function addSurface(box, item, drawn) {
  queue.push({ box, item, drawn });
  if (drawing) return;
  drawing = true;
  const workshop = element('div', { class: 'workshop', 'aria-hidden': 'true' });
  document.body.append(workshop);
  let chart;
  while (queue.length) {
    const next = queue.shift();
    try {
      chart ??= surfaceChart(workshop);
      drawSurface(chart, next.item, Math.min(next.box.clientWidth, kMost));
      await settled();
      const picture = element('img', { alt: spoken(next.item) });
      picture.src = chart.getDataURL({ pixelRatio: kSharp, backgroundColor: '#fff' });
      await picture.decode();
      const button = element('button', { class: 'surface', type: 'button', title: 'turn it' }, picture);
      button.addEventListener('click', () => makeLive(button, next.item));
      next.box.replaceChildren(button);
      next.drawn();
    } catch (error) {
      next.box.replaceChildren(element('p', { class: 'absent' }, 'This browser draws no 3-D (WebGL): the map and the numbers below show the same.'));
      next.drawn(error);
    }
  }
  chart?.dispose();
  workshop.remove();
  drawing = false;
}
