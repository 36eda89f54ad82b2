// Builds the page from its data.
import { init } from './chart.js';
import { element } from './dom.js';
import { kinds } from './figures.js';
import { watch } from './live.js';

// ---- figures --------------------------------------------------------------------------------

const shown = [];  // {box, chart, item, figure}: those that are redrawn when the page's width changes
const state = (figure, word, detail = '') => {
  figure.dataset.state = word;
  if (detail) figure.dataset.detail = detail;
};

function draw(entry, width) {
  const { height, option } = kinds[entry.item.kind](entry.item.data, width);
  entry.chart.resize({ width, height });
  entry.chart.setOption(option, { notMerge: true });
}

function addFlat(figure, box, item) {
  const width = box.clientWidth;
  const { height } = kinds[item.kind](item.data, width);
  const chart = init(box, null, { renderer: 'svg', width, height });
  const entry = { box, chart, item, figure };
  draw(entry, width);
  shown.push(entry);
  state(figure, 'drawn');
}

// Surfaces are drawn one after the other by one chart and kept as pictures: a browser has few
// contexts for 3-D, each new one compiles its shaders anew, and a picture prints. A click makes one
// live again.
const kSharp = 1.5;  // picture elements to a px: some 190 dpi on paper
let live = null;
const queue = [];

const surfaceChart = (box) => init(box, null, { renderer: 'canvas', width: 1, height: 1, devicePixelRatio: kSharp });

function drawSurface(chart, item, width) {
  const { height, option } = kinds[item.kind](item.data, width);
  chart.clear();  // else the library keeps the shape of the surface before
  chart.resize({ width, height });
  chart.setOption(option);
}

// Two frames: one lays the labels out, one draws. A page in the background gets none.
const frame = () => new Promise((resolve) => { requestAnimationFrame(resolve); setTimeout(resolve, 300); });
const settled = async () => { await frame(); await frame(); };

function makeLive(picture, item) {
  if (live) live();
  const box = element('div', { class: 'chart' });
  const width = picture.clientWidth;
  picture.hidden = true;
  picture.after(box);
  const chart = surfaceChart(box);
  drawSurface(chart, item, width);
  live = () => { chart.dispose(); box.remove(); picture.hidden = false; live = null; };
}

let drawing = false;

async function drawSurfaces() {
  if (drawing) return;
  drawing = true;
  const workshop = element('div', { class: 'workshop', 'aria-hidden': 'true' });
  document.body.append(workshop);
  let chart;
  while (queue.length) {
    const { figure, box, item } = queue.shift();
    try {
      chart ??= surfaceChart(workshop);
      drawSurface(chart, item, Math.min(box.clientWidth, 900));
      await settled();
      const picture = element('img', { class: 'surface', alt: item.title, title: 'click to turn it' });
      picture.src = chart.getDataURL({ pixelRatio: kSharp, backgroundColor: '#fff' });
      await picture.decode();
      picture.addEventListener('click', () => makeLive(picture, item));
      box.replaceChildren(picture);
      state(figure, 'drawn');
    } catch (error) {
      box.replaceChildren(element('p', { class: 'absent' }, 'This browser draws no 3-D (WebGL): the map shows the same numbers.'));
      state(figure, 'no-3d', String(error));
    }
  }
  chart?.dispose();
  workshop.remove();
  drawing = false;
  document.documentElement.dataset.state = 'done';
}

function addFigure(parent, item) {
  const figure = element('figure', { id: item.id, 'data-kind': item.kind ?? 'absent' }, element('h3', {}, item.title));
  parent.append(figure);
  if (item.absent !== undefined) {
    figure.append(element('p', { class: 'absent' }, `Not here: ${item.absent}`));
    state(figure, 'absent');
    return;
  }
  const box = element('div', { class: 'chart' });
  figure.append(box, element('figcaption', {}, item.caption));
  try {
    if (item.kind === 'surfaces') queue.push({ figure, box, item });
    else addFlat(figure, box, item);
  } catch (error) {
    box.append(element('p', { class: 'absent' }, 'This figure could not be drawn.'));
    state(figure, 'failed', String(error));
  }
}

function addTable(parent, item) {
  const head = element('tr', {}, ...item.columns.map((c) => element('th', { scope: 'col' }, c)));
  const rows = item.rows.map((r) => element('tr', {}, ...r.map((cell) => element('td', /\S{30}/.test(cell) ? { class: 'long' } : {}, cell))));
  const table = element('table', {}, element('thead', {}, head), element('tbody', {}, ...rows));
  const block = element('section', { id: item.id, class: 'table' }, element('h3', {}, item.title), element('div', { class: 'scroll' }, table));
  if (item.caption) block.append(element('p', { class: 'caption' }, item.caption));
  parent.append(block);
}

function show(page, contents, main) {
  page.sections.forEach((s) => {
    const section = element('section', { id: `section-${s.id}` }, element('h2', {}, s.title));
    contents.append(element('a', { href: `#section-${s.id}` }, s.title));
    main.append(section);
    s.words.forEach((words) => section.append(element('p', {}, words)));
    s.items.forEach((item) => (item.type === 'table' ? addTable(section, item) : addFigure(section, item)));
  });
  drawSurfaces();
}

// ---- screen and paper -----------------------------------------------------------------------

const kPaperWidth = 680;  // px of A4 at 96 dpi, less margins

function redraw(widthOf) {
  shown.forEach((entry) => draw(entry, widthOf(entry.box)));
}

let waiting;
window.addEventListener('resize', () => {
  clearTimeout(waiting);
  waiting = setTimeout(() => redraw((box) => box.clientWidth), 150);
});
window.addEventListener('beforeprint', () => { if (live) live(); redraw(() => kPaperWidth); });
window.addEventListener('afterprint', () => redraw((box) => box.clientWidth));

document.addEventListener('securitypolicyviolation', (event) => {
  document.documentElement.dataset.refused = `${event.violatedDirective} ${event.blockedURI}`;
});

const contents = document.getElementById('contents'), main = document.getElementById('page');

function showAgain(page) {
  if (live) live();
  shown.splice(0).forEach((entry) => entry.chart.dispose());
  queue.length = 0;
  contents.replaceChildren();
  main.replaceChildren();
  document.querySelector('.verdict').textContent = page.verdict;
  show(page, contents, main);
}

const page = JSON.parse(document.getElementById('data').textContent);
if (page.live) {
  const now = element('section', { id: 'now' });
  main.before(now);
  watch(page.live.status, now, async () => {
    const answer = await fetch(page.live.page, { cache: 'no-store' });
    if (answer.ok) showAgain(await answer.json());
  });
}
show(page, contents, main);
