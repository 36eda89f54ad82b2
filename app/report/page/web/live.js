// The top of the live page: how the session is doing, asked for again and again.
import { mm } from './chart.js';
import { element } from './dom.js';
import { drawFlat, numbers } from './figure.js';

const kEvery_ms = 1000;

function duration(seconds) {
  if (seconds === null || seconds === undefined) return 'not known yet';
  const s = Math.round(seconds), h = Math.floor(s / 3600), m = Math.floor((s % 3600) / 60);
  const two = (v) => String(v).padStart(2, '0');
  return h > 0 ? `${h}:${two(m)}:${two(s % 60)} h` : `${m}:${two(s % 60)} min`;
}

const count = (n, what) => `${n} ${what}${n === 1 ? '' : 's'}`;

function facts(status) {
  const retries = Object.entries(status.retries).map(([what, n]) => `${what}: ${n}`);
  if (status.n_interrupted > 0) retries.push(`interrupted: ${status.n_interrupted}`);
  return [
    ['session', `${status.session} (${status.plan}${status.compensated ? ', compensated' : ''})`],
    ['state', status.detail ? `${status.state}: ${status.detail}` : status.state],
    ['points', `${status.n_ok} of ${status.n_points}, epoch ${status.epoch}`],
    ['time left', status.n_ok === status.n_points ? 'none' : duration(status.left_s)],
    ['last stored', `${duration(status.silent_s)} ago (${status.last_utc})`],
    ['retries', retries.length ? retries.join(', ') : 'none'],
    ['base nests', baseNests(status.base)],
    ['process', status.process ?? 'none measures now'],
  ];
}

/// The last look at the tracker's base nests, when the session looks at them.
function baseNests(looks) {
  const last = looks.at(-1);
  if (!last) return 'not looked at';
  const judged = last.off ? ', beyond the gate' : last.moved ? ', more than chance' : '';
  return `${last.nest} moved ${mm(last.moved_mm)} after ${count(last.after, 'point')} (chance ${mm(last.chance_mm)})${judged}`;
}

class Chart {
  constructor(parent, kind, title) {
    this.kind = kind;
    this.title = title;
    this.box = element('div', { class: 'chart' });
    this.figure = element('figure', { id: `live-${kind}`, 'data-kind': kind }, element('h3', {}, title), this.box, numbers(() => this.item));
    parent.append(this.figure);
  }

  show(rows) {
    this.rows = rows;
    if (rows.length === 0) {
      this.chart?.dispose();
      this.chart = null;
      this.box.replaceChildren(element('p', { class: 'absent' }, 'Nothing yet.'));
      this.figure.dataset.state = 'absent';
      return;
    }
    if (!this.chart) this.box.replaceChildren();
    this.item = { kind: this.kind, title: this.title, data: rows };
    drawFlat(this, this.box.clientWidth);
    this.figure.dataset.state = 'drawn';
  }
}

/// Shows the status at `url` in `parent` for as long as the page is open; `changed` is called when
/// a session has come to another state.
export function watch(url, parent, changed) {
  const alarm = element('p', { class: 'alarm', role: 'alert' });
  const bar = element('progress', { max: 1, value: 0, 'aria-label': 'points measured' });
  const table = element('tbody');
  parent.append(element('h2', {}, 'Now'), alarm, bar, element('table', { class: 'now' }, table));
  const deviations = new Chart(parent, 'deviations', 'Last deviations, measured - target');
  const drift = new Chart(parent, 'drift', 'Drift of the reference points, against their first reading');
  let known;
  window.addEventListener('resize', () => [deviations, drift].forEach((c) => c.rows && c.show(c.rows)));

  function show(status) {
    alarm.textContent = status.stalled
      ? `STALLED: nothing was stored for ${duration(status.silent_s)}, expected within ${duration(status.stall_after_s)}` : '';
    bar.max = status.n_points || 1;
    bar.value = status.n_ok;
    table.replaceChildren(...facts(status).map(([name, value]) => element('tr', {}, element('th', { scope: 'row' }, name), element('td', {}, String(value)))));
    deviations.show(status.last);
    drift.show(status.drift);
    const now = `${status.session} ${status.state}`;
    if (known !== undefined && known !== now) changed();
    known = now;
    parent.dataset.state = status.stalled ? 'stalled' : status.state;
  }

  async function look() {
    try {
      const answer = await fetch(url, { cache: 'no-store' });
      if (!answer.ok) throw new Error(`${answer.status}`);
      show(await answer.json());
    } catch (error) {
      alarm.textContent = `No answer from trammel serve (${error.message}): what stands below is old.`;
      parent.dataset.state = 'no-answer';
    }
    setTimeout(look, kEvery_ms);
  }
  look();
}
