// Figures with their captions and numbers: drawn once they are seen, and again where the page's
// width changes.
import { init } from './chart.js';
import { element, tableOf } from './dom.js';
import { kinds } from './figures.js';
import { numbersOf, spoken } from './numbers.js';
import { addSurface, forget } from './turning.js';

const waiting = [];  // in closed folds: {box, item, figure}
const shown = [];    // {chart, width} more: those that are redrawn

const state = (figure, word, detail = '') => {
  figure.dataset.state = word;
  if (detail) figure.dataset.detail = detail;
};

// A chart in its box, made where there is none; what it shows is said to who does not see it.
export function drawFlat(entry, width) {
  const { height, option } = kinds[entry.item.kind](entry.item.data, width);
  entry.chart ??= init(entry.box, null, { renderer: 'svg', width, height });
  entry.width = width;
  entry.chart.resize({ width, height });
  entry.chart.setOption({ ...option, aria: { enabled: true, label: { description: spoken(entry.item) } } }, { notMerge: true });
}

function drawEntry(entry) {
  const { box, item, figure } = entry;
  try {
    if (item.kind === 'surfaces') {
      addSurface(box, item, (error) => (error ? state(figure, 'no-3d', String(error)) : state(figure, 'drawn')));
    } else {
      drawFlat(entry, box.clientWidth);
      shown.push(entry);
      state(figure, 'drawn');
    }
  } catch (error) {
    box.append(element('p', { class: 'absent' }, 'This figure could not be drawn.'));
    state(figure, 'failed', String(error));
  }
}

const isSeen = ({ box }) => box.closest('details:not([open])') === null;

// After folds were opened: draws what can be seen now.
export function reveal() {
  waiting.splice(0).forEach((entry) => (isSeen(entry) ? drawEntry(entry) : waiting.push(entry)));
  redraw((box) => box.clientWidth);
}

export function redraw(widthOf) {
  shown.filter(isSeen).forEach((entry) => {
    const width = widthOf(entry.box);
    if (width !== entry.width) drawFlat(entry, width);
  });
}

export function forgetFigures() {
  forget();
  waiting.length = 0;
  shown.splice(0).forEach((entry) => entry.chart.dispose());
}

// The table of what the figure shows then, made when it is opened: some have thousands of rows.
export function numbers(itemNow) {
  const summary = element('summary', {}, 'Numbers'), fold = element('details', { class: 'numbers' }, summary);
  fold.addEventListener('toggle', () => {
    const item = itemNow();
    if (!fold.open || !item) return;
    const { columns, rows } = numbersOf(item);
    fold.replaceChildren(summary, tableOf(`${item.title}: numbers`, columns, rows));
  });
  return fold;
}

export function addFigure(parent, item) {
  const figure = element('figure', { id: item.id, 'data-kind': item.kind ?? 'absent' }, element('h3', {}, item.title));
  parent.append(figure);
  if (item.absent !== undefined) {
    figure.append(element('p', { class: 'absent' }, `Not here: ${item.absent}`));
    state(figure, 'absent');
    return;
  }
  const box = element('div', { class: 'chart' });
  figure.append(box, element('figcaption', {}, item.caption), numbers(() => item));
  state(figure, 'folded');
  waiting.push({ box, item, figure });
}
