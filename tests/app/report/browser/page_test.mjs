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
  await trammel('reading', 'exclude', kHostile, '--seq', '3', '--reason', kHostile);
  await trammel('report', kHostile, '--html', 'hostile.html');
}

async function makeCampaigns() {
  await importHostile();
  await trammel('demo', 'demo', '--db', join(folder, 'trammel.db'));
  await trammel('report', 'paper', '--html', 'paper.html');
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
    absent: f.querySelector('.absent')?.textContent ?? '' };
}))`;

// The last surface is clicked, which draws it again to be turned: the share of picture elements that
// are as the picture has them. One chart draws all pictures; what it kept of another would show.
const kClicked = `(async () => {
  const picture = [...document.querySelectorAll('img.surface')].pop();
  picture.click();
  const layers = () => [...picture.nextElementSibling.querySelectorAll('canvas')];
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
  const figures = await page.ask(kFigures);
  everyFigureDrew(figures);
  const drawn = (kind) => figures.filter((f) => f.kind === kind && f.state === 'drawn').length;
  const least = { maps: 7, surfaces: 12, 'by-point': 12, simulated: 4, residuals: 1, effect: 3, waterfall: 2 };
  for (const [kind, n] of Object.entries(least)) assert.ok(drawn(kind) >= n, `${kind}: ${drawn(kind)}`);
  for (const kind of ['mechanism', 'plan', 'circles', 'sensitivity', 'network', 'contest', 'next-points', 'temperature']) {
    assert.equal(drawn(kind), 1, kind);
  }
  for (const f of figures.filter((each) => each.kind === 'maps' || each.kind === 'by-point')) {
    assert.match(f.words, /mm|deg/, f.id);  // axes have units
  }
  assert.ok(await page.ask("document.querySelector('.simulated').getBoundingClientRect().height > 30"));
  assert.ok(await page.ask(kClicked) > 0.99);

  const width = "document.querySelector('#headline svg').getBoundingClientRect().width";
  const wide = await page.ask(width);
  await page.ask(`addEventListener('beforeprint', () => {
    window.widest = Math.max(...[...document.querySelectorAll('figure svg')].map((s) => s.getBoundingClientRect().width));
  })`);
  const pdf = await page.paper();
  assert.equal(pdf.subarray(0, 5).toString(), '%PDF-');
  const pages = pdf.toString('latin1').match(/\/Type\s*\/Page\b/g).length;
  assert.ok(pages >= 10 && pages <= 60, `${pages} pages`);
  assert.ok(await page.ask('window.widest') <= 690);
  assert.equal(await page.ask(width), wide);

  await page.resize(420, 800);
  await page.until(`${width} < ${wide / 2}`);
  everyFigureDrew(await page.ask(kFigures));
  assert.ok(await page.ask('document.documentElement.scrollWidth <= document.documentElement.clientWidth'));
  await undisturbed(page);
  await page.close();
});

test('hostile names and texts stay text', async () => {
  const page = await open('hostile.html', 1280, 900);
  everyFigureDrew(await page.ask(kFigures));
  const words = await page.ask('document.body.textContent');
  for (const text of kTexts) assert.ok(words.includes(text.trim()), text);
  assert.equal(await page.ask("document.querySelectorAll('img[src=\"x\"], svg[onload], script[src]').length"), 0);
  assert.equal(await page.ask('document.title'), `Campaign ${kHostile}`);
  await undisturbed(page);
  await page.close();
});
