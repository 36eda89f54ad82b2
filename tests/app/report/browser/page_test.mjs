// node --test page_test.mjs, with TRAMMEL and CHROMIUM in the environment: the report in a browser, as
// a file and live.
import assert from 'node:assert/strict';
import { execFile, spawn } from 'node:child_process';
import { once } from 'node:events';
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';
import { Browser } from './browser.mjs';

const { TRAMMEL, CHROMIUM } = process.env;
const root = join(dirname(fileURLToPath(import.meta.url)), '../../../..');
const kHostile = '</script><img src=x onerror=alert(1)>';
const kTexts = [kHostile, '=HYPERLINK("http://192.0.2.1/","x")', '\u2028\u2029<!--', '"><svg onload=alert(2)>', '{{7*7}} ${7*7}'];

let folder, browser, campaigns;
const children = [];

const settings = () => ({ cwd: folder, env: { ...process.env, TRAMMEL_DB: join(folder, 'trammel.db') } });
const trammel = (...words) => promisify(execFile)(TRAMMEL, words, settings());

// The drive-error campaign under a name and with facts that try to be markup, calibrated.
async function importHostile() {
  const from = join(folder, 'hostile');
  cpSync(join(root, 'tests/support/campaigns/drive-error'), from, { recursive: true });
  const file = join(from, 'campaign.json');
  const campaign = JSON.parse(readFileSync(file, 'utf8'));
  campaign.name = kHostile;
  kTexts.forEach((text, k) => { campaign.facts = { ...campaign.facts, [`fact ${k}${text}`]: text }; });
  writeFileSync(file, JSON.stringify(campaign));
  await trammel('campaign', 'import', 'hostile');
  await trammel('calibrate', 'lsq', kHostile);
  await trammel('diagnose', kHostile);
  await trammel('reading', 'exclude', kHostile, '--seq', '3', '--reason', kHostile);
  await trammel('report', kHostile, '--html', 'hostile.html');
}

async function makeCampaigns() {
  await importHostile();
  await trammel('demo', 'demo', '--db', join(folder, 'trammel.db'));
  await trammel('report', 'paper', '--html', 'paper.html');
  for (const method of ['geometry', 'gp', 'hybrid', 'contest']) await trammel('calibrate', method, 'paper');
  await trammel('report', 'paper', '--html', 'eight.html');
  await trammel('template', 'machine', 'x', '--out', 'x.json');
  await trammel('plan', 'create', 'rail', '--travel', '140', '--targets', '7', '--runs', '3', '--mechanism', 'x.json', '--out', 'runs.json');
  await trammel('session', 'run', 'axis', '--plan', 'runs.json', '--stage', `sim:${join(root, 'examples/one-axis/robot.json')}`);
  await trammel('calibrate', 'geometry', 'axis');
  await trammel('report', 'axis', '--html', 'axis.html');
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'trammel-page-'));
  campaigns = makeCampaigns();  // while the live page, which needs none of them, is watched
  browser = await Browser.start(CHROMIUM);
});

after(async () => {
  children.forEach((child) => child.kill('SIGKILL'));
  await browser?.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function open(name, width, height) {
  await campaigns;
  const page = await browser.open(`file://${join(folder, name)}`, width, height);
  await page.until("document.documentElement.dataset.state === 'done'");
  return page;
}

// Opens every fold, numbers too, and waits until everything in them is drawn.
async function unfold(page) {
  await page.ask("document.querySelectorAll('details').forEach((d) => { d.open = true; })");
  await page.until("[...document.querySelectorAll('figure[data-kind]')].every((f) => !['folded', undefined].includes(f.dataset.state))");
}

// Nothing but the page itself was asked for, nothing was refused, nothing failed.
async function undisturbed(page) {
  assert.deepEqual(page.requests.filter((url) => !/^(file|data|blob):/.test(url)), []);
  assert.deepEqual(page.errors, []);
  assert.equal(await page.ask('document.documentElement.dataset.refused ?? null'), null);
  assert.deepEqual(page.dialogs, []);
}

// Of each figure: its state, what it shows, and whether it stays inside the page.
const kFigures = `Promise.all([...document.querySelectorAll('figure')].map(async (f) => {
  const svg = f.querySelector('svg'), img = f.querySelector('img');
  let inks = 0;
  if (img) {  // how many colours the middle line of a picture has
    const canvas = document.createElement('canvas');
    canvas.width = img.naturalWidth; canvas.height = img.naturalHeight;
    const context = canvas.getContext('2d');
    context.drawImage(img, 0, 0);
    const row = context.getImageData(0, canvas.height / 2, canvas.width, 1).data;
    const seen = new Set();
    for (let k = 0; k < row.length; k += 4) seen.add(row[k] << 16 | row[k + 1] << 8 | row[k + 2]);
    inks = seen.size;
  }
  return { id: f.id, kind: f.dataset.kind, state: f.dataset.state, detail: f.dataset.detail ?? '',
    marks: svg ? svg.querySelectorAll('path, circle, polyline, rect').length : 0, inks,
    nan: svg ? /NaN|undefined/.test(svg.outerHTML) : false,
    words: svg ? svg.textContent : '',
    outside: f.getBoundingClientRect().right > document.documentElement.clientWidth + 1
      || (svg ? svg.getBoundingClientRect().right > document.documentElement.clientWidth + 1 : false),
    said: f.querySelector('[role=img]')?.getAttribute('aria-label') ?? img?.alt ?? '',
    rows: f.querySelectorAll('.numbers tbody tr').length,
    absent: f.querySelector('.absent')?.textContent ?? '' };
}))`;

// Where things of the first screen end, px from the top of the page, and where the first fold begins.
const kFirstScreen = `(() => {
  const box = (what) => document.querySelector(what).getBoundingClientRect();
  return { table: box('#before-after table').bottom, named: box('#named').bottom, picture: box('#headline svg').bottom,
    warnings: box('#warnings').bottom, fold: box('main > details').top, open: [...document.querySelectorAll('details[open] details.fold[open]')].map((d) => d.id) };
})()`;

// Pairs of words in figures that lie over each other.
const kOverlaps = `[...document.querySelectorAll('figure svg')].flatMap((svg) => {
  const all = svg.getBoundingClientRect();
  const words = [...svg.querySelectorAll('text')].filter((t) => t.textContent.trim()).map((t) => [t.textContent, t.getBoundingClientRect()]);
  const cut = words.filter(([, r]) => r.left < all.left - 1 || r.right > all.right + 1)
    .map(([a]) => svg.closest('figure').id + ': "' + a + '" is cut');
  return words.flatMap(([a, r], k) => words.slice(k + 1).filter(([, s]) =>
    Math.min(r.right, s.right) - Math.max(r.left, s.left) > 3 && Math.min(r.bottom, s.bottom) - Math.max(r.top, s.top) > 4)
    .map(([b]) => svg.closest('figure').id + ': "' + a + '" over "' + b + '"')).concat(cut);
})`;

// Of a figure with a noise floor: px from the top where its dashed line is painted, and where the
// number in its name belongs by the axis' own labels.
const kFloor = `(async () => {
  const svg = document.querySelector('#contest svg');
  const image = new Image();
  image.src = 'data:image/svg+xml,' + encodeURIComponent(new XMLSerializer().serializeToString(svg));
  await image.decode();
  const canvas = document.createElement('canvas');
  const { width, height } = svg.getBoundingClientRect();
  canvas.width = width; canvas.height = height;
  const context = canvas.getContext('2d');
  context.fillStyle = '#fff';
  context.fillRect(0, 0, width, height);
  context.drawImage(image, 0, 0, width, height);
  const ink = context.getImageData(0, 0, canvas.width, canvas.height).data;
  const greys = Array.from({ length: canvas.height }, (_, y) => {
    let n = 0;
    for (let x = 0; x < canvas.width; x += 1) {
      const at = 4 * (y * canvas.width + x);
      const [r, g, b] = ink.slice(at, at + 3);
      if (r > 0x50 && r < 0x90 && Math.abs(r - g) < 3 && Math.abs(g - b) < 3) n += 1;  // #555, smoothed at its edges
    }
    return n;
  });
  const texts = [...svg.querySelectorAll('text')];
  const yOf = (t) => { const m = t.getCTM(); return m.f + m.d * Number(t.getAttribute('y') ?? 0); };
  const ticks = texts.filter((t) => /^[0-9.]+$/.test(t.textContent) && t.getAttribute('text-anchor') === 'end').map((t) => [Number(t.textContent), yOf(t)]);
  const [v0, y0] = ticks[0], [v1, y1] = ticks[ticks.length - 1];
  const value = Number(/mean length of a perfect reading ([0-9.]+)/.exec(svg.textContent)[1]);
  const most = Math.max(...greys), line = greys.map((n, y) => [n, y + 0.5]).filter(([n]) => n > most / 2);
  const painted = line.reduce((sum, [n, y]) => sum + n * y, 0) / line.reduce((sum, [n]) => sum + n, 0);
  return { painted, due: y0 + (y1 - y0) * (value - v0) / (v1 - v0), rounded: y0 + (y1 - y0) * (Number(value.toFixed(2)) - v0) / (v1 - v0) };
})()`;

// Words that stand out from what is behind them by less than 4.5 : 1 (WCAG 2, AA).
const kPale = `(() => {
  const rgb = (text) => (/rgba?\\(([^)]*)\\)/.exec(text)?.[1] ?? '').split(/[ ,/]+/).filter(Boolean).map(Number);
  const light = (c) => { const [r, g, b] = c.map((v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4)); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const behind = (e) => { for (let at = e; at; at = at.parentElement) { const c = rgb(getComputedStyle(at).backgroundColor); if (c.length === 3 || c[3] > 0) return c.slice(0, 3); } return [255, 255, 255]; };
  const under = (t) => {  // in a figure: the last shape before the words that holds them
    const r = t.getBoundingClientRect(), y = r.top + r.height / 2;
    const shapes = [...t.ownerSVGElement.querySelectorAll('path, rect')].filter((s) => s.compareDocumentPosition(t) & 4).filter((s) => {
      const b = s.getBoundingClientRect(), fill = rgb(getComputedStyle(s).fill);
      return fill.length === 3 && Number(getComputedStyle(s).fillOpacity) > 0.5 && b.left < r.left + 2 && b.right > r.right - 2 && b.top < y && b.bottom > y;
    });
    return shapes.length ? rgb(getComputedStyle(shapes.pop()).fill) : [255, 255, 255];
  };
  return [...document.querySelectorAll('body *')].filter((e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()) && e.getClientRects().length
    && !['SCRIPT', 'STYLE', 'NOSCRIPT'].includes(e.tagName)).flatMap((e) => {
    const svg = e instanceof SVGElement, style = getComputedStyle(e);
    const a = light(rgb(svg ? style.fill : style.color).slice(0, 3)), b = light(svg ? under(e) : behind(e));
    const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    return contrast < 4.5 ? [contrast.toFixed(2) + ': ' + e.textContent.slice(0, 40)] : [];
  });
})()`;

// The last surface is clicked, which draws it again to be turned: the share of picture elements that
// are as the picture has them. One chart draws all pictures; what it kept of another would show.
const kClicked = `(async () => {
  const button = [...document.querySelectorAll('button.surface')].pop(), picture = button.firstChild;
  button.click();
  const layers = () => [...button.nextElementSibling.querySelectorAll('canvas')];
  const inks = (...images) => {
    const canvas = document.createElement('canvas');
    canvas.width = picture.naturalWidth; canvas.height = picture.naturalHeight;
    const context = canvas.getContext('2d', { willReadFrequently: true });
    context.fillStyle = '#fff';
    context.fillRect(0, 0, canvas.width, canvas.height);
    images.forEach((image) => context.drawImage(image, 0, 0));
    return new Uint32Array(context.getImageData(0, 0, canvas.width, canvas.height).data.buffer);
  };
  for (let frame = 0; frame < 3; frame += 1) await new Promise(requestAnimationFrame);
  const was = inks(picture), is = inks(...layers());
  return is.filter((ink, k) => ink === was[k]).length / is.length;
})()`;

function everyFigureDrew(figures) {
  for (const f of figures) {
    const what = JSON.stringify({ ...f, words: undefined });
    assert.ok(['drawn', 'absent'].includes(f.state), what);
    if (f.state === 'absent') assert.match(f.absent, /^Not here: .{10,}/, what);
    else if (f.kind === 'surfaces') assert.ok(f.inks > 12, what);
    else assert.ok(f.marks > 10, what);
    assert.ok(!f.nan && !f.outside, what);
    if (f.state === 'absent') continue;
    assert.match(f.said, /: [0-9]+ rows; .*[0-9] to -?[0-9]/, what);  // what is seen is said with its numbers
    assert.ok(f.rows > 0, what);
  }
}

// `trammel WORDS…` in the background, ended with the tests.
function started(...words) {
  const child = spawn(TRAMMEL, words, { ...settings(), stdio: ['ignore', 'pipe', 'ignore'] });
  children.push(child);
  return child;
}

test('the live page follows a session that another process measures, and its end', async () => {
  const lab = ['--db', 'lab.db'];
  const robot = `sim:${join(root, 'examples/paper/robot.json')}`;
  await trammel('plan', 'create', 'lattice', '--step', '50', '--out', 'plan.json');
  await trammel('session', 'run', 'lab', '--plan', 'plan.json', '--session', 'first', '--stage', robot, ...lab);
  const serve = started('serve', 'lab', ...lab);
  const [line] = await once(serve.stdout, 'data');
  const url = line.toString().trim();
  const page = await browser.open(url, 1280, 900);
  await page.until("document.getElementById('now')?.dataset.state === 'done'");
  assert.ok(await page.ask("document.querySelector('.simulated').getBoundingClientRect().height > 30"));

  const live = (what) => `document.querySelector('#now').textContent.includes(${JSON.stringify(what)})`;
  const run = started('session', 'run', 'lab', '--plan', 'plan.json', '--session', 'watched', '--stage', robot, ...lab);
  const ended = once(run, 'exit');
  await page.until(live('watched'));
  assert.deepEqual(await ended, [0, null]);
  await page.until(`${live('watched')} && document.getElementById('now').dataset.state === 'done'`);
  assert.ok(await page.ask("document.querySelectorAll('#live-deviations svg path').length > 10"));
  assert.match(await page.ask("document.querySelector('#live-deviations svg').textContent"), /phi \[deg\]/);
  assert.doesNotMatch(await page.ask("document.querySelector('#now').textContent"), /points left/);
  // The report below is asked for anew: the session that has ended is in it.
  await page.until("document.getElementById('sessions')?.textContent.includes('watched')");
  assert.deepEqual(page.requests.filter((asked) => !asked.startsWith(url) && !/^(data|blob):/.test(asked)), []);
  assert.equal(await page.ask('document.documentElement.dataset.refused ?? null'), null);

  serve.kill('SIGTERM');
  assert.deepEqual(await once(serve, 'exit'), [0, null]);
  await page.until("document.getElementById('now').dataset.state === 'no-answer'");
  assert.ok(await page.ask(live('No answer from trammel serve')));
  await page.close();
});

test('every figure of the demo draws on a wide window, a narrow one and on paper, and asks nobody', async () => {
  const page = await open('paper.html', 1280, 900);
  const first = await page.ask(kFirstScreen);
  for (const what of ['table', 'named', 'picture', 'warnings']) assert.ok(first[what] > 100 && first[what] <= 900, JSON.stringify(first));
  assert.ok(first.fold <= 930, JSON.stringify(first));
  assert.deepEqual(first.open, ['method-model-48']);  // the chosen method alone

  // On paper: what is open, and a list of what is not.
  const width = "document.querySelector('#headline svg').getBoundingClientRect().width";
  const wide = await page.ask(width);
  await page.ask(`addEventListener('beforeprint', () => {
    window.widest = Math.max(...[...document.querySelectorAll('figure svg')].map((s) => s.getBoundingClientRect().width));
    window.unprinted = document.getElementById('folded').textContent;
  })`);
  const pdf = await page.paper();
  assert.equal(pdf.subarray(0, 5).toString(), '%PDF-');
  const pages = pdf.toString('latin1').match(/\/Type\s*\/Page\b/g).length;
  assert.ok(pages >= 2 && pages <= 12, `${pages} pages`);
  assert.ok(await page.ask('window.widest') <= 690);
  assert.match(await page.ask('window.unprinted'), /least squares on the geometry, 80 points.*Raw facts.*Third-party notices/s);
  assert.equal(await page.ask(width), wide);

  // By keyboard: to a fold, into it, to a surface, around it and back.
  const key = async (name, code, text = '') => {
    for (const type of ['keyDown', 'keyUp']) await page.send('Input.dispatchKeyEvent', { type, key: name, code: name, windowsVirtualKeyCode: code, ...(type === 'keyDown' && text ? { text } : {}) });
  };
  const focused = (what) => page.ask(`document.activeElement.matches(${JSON.stringify(what)})`);
  await key('Tab', 9);
  assert.ok(await focused('a.skip'));
  for (let k = 0; k < 60 && !await focused('#section-contest > summary'); k += 1) await key('Tab', 9);
  assert.ok(await focused('#section-contest > summary'));
  await key('Enter', 13, '\r');
  await page.until("document.querySelector('#section-contest[open] #contest')?.dataset.state === 'drawn'");
  await page.ask("document.querySelector('button.surface').focus()");
  await key('Enter', 13, '\r');
  assert.ok(await focused('.live'));
  const seen = () => page.ask("(async () => { for (let k = 0; k < 4; k += 1) await new Promise(requestAnimationFrame); return [...document.querySelectorAll('.live canvas')].map((c) => c.toDataURL()).join(); })()");
  const unturned = await seen();
  await key('ArrowRight', 39);
  assert.notEqual(await seen(), unturned);
  await key('Escape', 27);
  assert.ok(await focused('button.surface'));

  const floor = await page.ask(kFloor);
  assert.ok(Math.abs(floor.painted - floor.due) <= 1 && Math.abs(floor.rounded - floor.due) > 1.5, JSON.stringify(floor));

  await unfold(page);
  const figures = await page.ask(kFigures);
  everyFigureDrew(figures);
  const drawn = (kind) => figures.filter((f) => f.kind === kind && f.state === 'drawn').length;
  const least = { maps: 7, surfaces: 12, 'by-point': 12, histogram: 12, simulated: 4, residuals: 1, effect: 3, waterfall: 2 };
  for (const [kind, n] of Object.entries(least)) assert.ok(drawn(kind) >= n, `${kind}: ${drawn(kind)}`);
  for (const kind of ['mechanism', 'plan', 'circles', 'sensitivity', 'network', 'contest', 'temperature']) {
    assert.equal(drawn(kind), 1, kind);
  }
  for (const f of figures.filter((each) => each.kind === 'maps' || each.kind === 'by-point')) {
    assert.match(f.words, /mm|deg/, f.id);  // axes have units
  }
  assert.match(figures.find((f) => f.kind === 'circles').words, /[0-9] um per division/);
  assert.match(figures.find((f) => f.id === 'headline').words, /own scale \[um\]/);
  assert.ok(await page.ask("document.querySelector('.simulated').getBoundingClientRect().height > 20"));
  assert.ok(await page.ask(kClicked) > 0.99);
  assert.deepEqual(await page.ask(kPale), []);
  assert.doesNotMatch(await page.ask("document.getElementById('jobs').textContent"), /[{}]/);
  const notices = await page.ask("document.getElementById('notices').textContent");
  for (const name of ['echarts', 'zrender', 'echarts-gl', 'claygl']) assert.ok(notices.includes(`${name} `), name);
  assert.match(notices, /Apache License.*Redistribution and use in source and binary forms/s);

  await page.resize(420, 800);
  await page.until(`${width} < ${0.8 * wide}`);  // half of a wide window is more than a narrow one
  everyFigureDrew(await page.ask(kFigures));
  assert.deepEqual(await page.ask(kOverlaps), []);
  assert.ok(await page.ask('document.documentElement.scrollWidth <= document.documentElement.clientWidth'));
  await undisturbed(page);
  await page.close();
});

test('with eight methods the first screen still ends at 900 px, and paper takes 12 pages at most', async () => {
  const page = await open('eight.html', 1280, 900);
  const first = await page.ask(kFirstScreen);
  for (const what of ['table', 'named', 'picture', 'warnings']) assert.ok(first[what] > 100 && first[what] <= 900, JSON.stringify(first));
  assert.ok(await page.ask("document.querySelectorAll('#before-after tbody tr').length") >= 9);
  assert.ok(await page.ask('document.documentElement.scrollWidth <= document.documentElement.clientWidth'));
  // No alarm that the table belies, and no claim of its title that a row belies: some are predicted.
  assert.doesNotMatch(await page.ask("document.getElementById('warnings').textContent"), /nothing of these readings is held out/);
  assert.doesNotMatch(await page.ask("document.querySelector('#before-after h3').textContent"), /measured again|predicted/);
  // Every warning stands there, cut to a line where there is no room for more, whole once it is opened, and on paper.
  const lines = await page.ask("[...document.querySelectorAll('#warnings .line')].map((l) => [l.open, l.getBoundingClientRect().height, l.textContent.length])");
  assert.ok(lines.length > 8 && lines.every(([, height]) => height > 8), JSON.stringify(lines));
  assert.ok(lines.some(([open]) => !open));
  await page.ask("document.querySelectorAll('#warnings .line').forEach((l) => { l.open = true; })");
  await page.ask('new Promise((resolve) => { setTimeout(resolve, 300); })');
  assert.equal(await page.ask("document.querySelectorAll('#warnings .line:not([open])').length"), 0);  // what is opened stays so
  assert.ok((await page.ask(kFirstScreen)).warnings > 900);  // so the test sees what is too long
  const pages = (await page.paper()).toString('latin1').match(/\/Type\s*\/Page\b/g).length;
  assert.ok(pages >= 2 && pages <= 12, `${pages} pages`);
  await page.close();
});

test('a single axis has its error over position in both directions, and says nothing twice', async () => {
  const page = await open('axis.html', 1280, 900);
  const [headline] = (await page.ask(kFigures)).filter((f) => f.id === 'headline');
  assert.equal(headline.kind, 'along');
  assert.equal(headline.state, 'drawn');
  for (const words of ['positive travel', 'negative travel', 'measured - target [um]', 'x [mm]']) assert.ok(headline.words.includes(words), headline.words);
  await unfold(page);
  everyFigureDrew(await page.ask(kFigures));
  const absent = await page.ask("[...document.querySelectorAll('.absent')].map((e) => e.textContent)");
  assert.equal(new Set(absent).size, absent.length, absent.join('\n'));
  await page.resize(420, 800);
  assert.deepEqual(await page.ask(kOverlaps), []);
  await undisturbed(page);
  await page.close();
});

test('hostile names and texts stay text', async () => {
  const page = await open('hostile.html', 1280, 900);
  await unfold(page);
  everyFigureDrew(await page.ask(kFigures));
  const words = await page.ask('document.body.textContent');
  for (const text of kTexts) assert.ok(words.includes(text.trim()), text);
  assert.equal(await page.ask("document.querySelectorAll('img[src=\"x\"], svg[onload], script[src]').length"), 0);
  assert.equal(await page.ask('document.title'), `Campaign ${kHostile}`);
  await undisturbed(page);
  await page.close();
});
