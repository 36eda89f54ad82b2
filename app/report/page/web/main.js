// Builds the page from its data.
import { setDecimals } from './chart.js';
import { element, tableOf } from './dom.js';
import { addFigure, forgetFigures, redraw, reveal } from './figure.js';
import { watch } from './live.js';
import { isIdle, still } from './turning.js';

// ---- items ----------------------------------------------------------------------------------

function addTable(parent, item) {
  const block = element('section', { id: item.id, class: 'table' }, element('h3', {}, item.title), tableOf(item.title, item.columns, item.rows));
  if (item.caption) block.append(element('p', { class: 'caption' }, item.caption));
  parent.append(block);
}

// A sentence a fold: closed it takes one line, and the screen's end cuts it.
function addSentences(parent, item) {
  const fold = (line) => {
    const made = element('details', { class: 'line' }, element('summary', {}, line));
    made.open = true;
    return made;
  };
  parent.append(element('section', { id: item.id, class: 'sentences' }, element('h3', {}, item.title),
    element('ul', {}, ...item.lines.map((line) => element('li', {}, fold(line))))));
}

const kScreen = 900;  // px: what decides ends above

// Where what is told at length would not end on the first screen, the last of it is cut to a line each.
function fitFirstScreen() {
  const first = document.getElementById('section-verdict');
  if (!first || innerWidth < 1000) return;
  const end = () => Math.max(...[...first.children].map((e) => e.getBoundingClientRect().bottom)) + scrollY;
  [...first.querySelectorAll('.line[open]')].reverse().forEach((line) => { if (end() > kScreen) line.open = false; });
}

function addFold(parent, item) {
  const fold = element('details', { id: item.id, class: 'fold' }, element('summary', {}, item.title));
  fold.open = item.open;
  parent.append(fold);
  item.items.forEach((each) => add(fold, each));
}

const adders = { figure: addFigure, table: addTable, sentences: addSentences, fold: addFold };
const add = (parent, item) => adders[item.type](parent, item);

// The first section decides and is never folded; of the others the one with the chosen method is open.
function addSection(main, s, first) {
  const title = element('h2', {}, s.title);
  const section = first ? element('section', {}, title) : element('details', { class: 'fold' }, element('summary', {}, title));
  section.id = `section-${s.id}`;
  if (!first) section.open = s.items.some((item) => item.open);
  s.words.forEach((words) => section.append(element('p', {}, words)));
  s.items.forEach((item) => add(section, item));
  main.append(section);
}

// ---- the page -------------------------------------------------------------------------------

const contents = document.getElementById('contents'), main = document.getElementById('page'), notices = document.getElementById('notices');

function open(fold) {
  for (let at = fold; at; at = at.parentElement) if (at.tagName === 'DETAILS') at.open = true;
}

let fresh = true;  // a page just shown: what a reader opens stays open

async function settle() {
  reveal();
  if (fresh) { fresh = false; fitFirstScreen(); }
  while (!isIdle()) await new Promise((resolve) => { setTimeout(resolve, 20); });
  document.documentElement.dataset.state = 'done';
}

function show(page) {
  contents.replaceChildren();
  main.replaceChildren();
  fresh = true;
  setDecimals(page.decimals_mm ?? 4);
  page.sections.forEach((s, k) => {
    const link = element('a', { href: `#section-${s.id}` }, s.title);
    link.addEventListener('click', () => open(document.getElementById(`section-${s.id}`)));
    contents.append(link);
    addSection(main, s, k === 0);
  });
}

document.addEventListener('toggle', settle, true);

// ---- screen and paper -----------------------------------------------------------------------

const kPaperWidth = 680;  // px of A4 at 96 dpi, less margins

let pause;
window.addEventListener('resize', () => {
  clearTimeout(pause);
  pause = setTimeout(() => { still(); redraw((box) => box.clientWidth); }, 150);
});

// What stays folded is not printed: the paper says so.
function listFolded() {
  const closed = [...document.querySelectorAll('details.fold:not([open])')].filter((fold) => !fold.parentElement.closest('details:not([open])'));
  document.getElementById('folded').replaceChildren(...(closed.length === 0 ? [] : [element('h2', {}, 'Folded, so not printed'),
    element('ul', {}, ...closed.map((fold) => {
      const figures = fold.querySelectorAll('figure:not([data-state=absent])').length, tables = fold.querySelectorAll('section.table').length;
      return element('li', {}, `${fold.querySelector('summary').textContent} (figures: ${figures}, tables: ${tables})`);
    }))]));
}

window.addEventListener('beforeprint', () => { still(); listFolded(); redraw(() => kPaperWidth); });
window.addEventListener('afterprint', () => redraw((box) => box.clientWidth));

document.addEventListener('securitypolicyviolation', (event) => {
  document.documentElement.dataset.refused = `${event.violatedDirective} ${event.blockedURI}`;
});

// Once more, with the same folds open.
function showAgain(page) {
  const opened = [...document.querySelectorAll('details[open][id]')].map((fold) => fold.id);
  forgetFigures();
  document.querySelector('.verdict').textContent = page.verdict;
  show(page);
  opened.forEach((id) => { const fold = document.getElementById(id); if (fold) fold.open = true; });
  settle();
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
notices.classList.add('fold');
show(page);
settle();
