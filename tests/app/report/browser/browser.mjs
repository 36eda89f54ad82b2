// A headless Chromium, driven over two pipes by the DevTools protocol: no library, no port.
import { spawn } from 'node:child_process';
import { mkdtempSync } from 'node:fs';
import { rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const kTimeout_ms = 240_000;  // a loaded machine draws surfaces in software

export class Browser {
  static async start(program) {
    const browser = new Browser();
    browser.profile = mkdtempSync(join(tmpdir(), 'trammel-browser-'));
    browser.process = spawn(program, ['--headless', '--no-sandbox', '--remote-debugging-pipe',
      '--use-angle=swiftshader', '--enable-unsafe-swiftshader',  // 3-D without a graphics card; the rest
      '--disable-gpu-compositing', '--disable-dev-shm-usage',    // of a page is painted faster directly
      '--no-first-run', '--disable-background-networking', '--disable-component-update',
      '--disable-sync', `--user-data-dir=${browser.profile}`, 'about:blank'],
      { stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'] });
    browser.gone = new Promise((resolve) => { browser.process.on('exit', resolve); });
    browser.waiting = new Map();
    browser.listeners = [];
    browser.number = 0;
    let rest = '';
    browser.process.stdio[4].on('data', (chunk) => {
      rest += chunk;
      for (let end = rest.indexOf('\0'); end >= 0; end = rest.indexOf('\0')) {
        browser.received(JSON.parse(rest.slice(0, end)));
        rest = rest.slice(end + 1);
      }
    });
    await browser.send('Browser.getVersion');
    return browser;
  }

  received(message) {
    const waiting = this.waiting.get(message.id);
    if (waiting) {
      this.waiting.delete(message.id);
      clearTimeout(waiting.timer);
      if (message.error) waiting.reject(new Error(`${waiting.method}: ${message.error.message}`));
      else waiting.resolve(message.result);
    } else {
      this.listeners.forEach((listener) => listener(message));
    }
  }

  send(method, params = {}, sessionId = undefined) {
    this.number += 1;
    const id = this.number;
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`${method}: no answer`)), kTimeout_ms);
      this.waiting.set(id, { method, resolve, reject, timer });
      this.process.stdio[3].write(`${JSON.stringify({ id, method, params, sessionId })}\0`);
    });
  }

  async open(url, width, height) {
    const { targetId } = await this.send('Target.createTarget', { url: 'about:blank' });
    const { sessionId } = await this.send('Target.attachToTarget', { targetId, flatten: true });
    const page = new Page(this, targetId, sessionId);
    for (const domain of ['Page', 'Runtime', 'Network', 'Log']) await page.send(`${domain}.enable`);
    await page.resize(width, height);
    await page.send('Page.navigate', { url });
    return page;
  }

  async stop() {
    await this.send('Browser.close');  // a signal would leave children that still write
    await this.gone;
    await rm(this.profile, { recursive: true, force: true, maxRetries: 20 });
  }
}

class Page {
  constructor(browser, targetId, sessionId) {
    Object.assign(this, { browser, targetId, sessionId, requests: [], dialogs: [], errors: [] });
    browser.listeners.push((message) => {
      if (message.sessionId !== sessionId) return;
      const { method, params } = message;
      if (method === 'Network.requestWillBeSent') this.requests.push(params.request.url);
      if (method === 'Runtime.exceptionThrown') {
        this.errors.push(params.exceptionDetails.exception?.description ?? params.exceptionDetails.text);
      }
      if (method === 'Log.entryAdded' && params.entry.level === 'error') this.errors.push(params.entry.text);
      if (method === 'Page.javascriptDialogOpening') {
        this.dialogs.push(params.message);
        this.send('Page.handleJavaScriptDialog', { accept: true });
      }
    });
  }

  send(method, params = {}) {
    return this.browser.send(method, params, this.sessionId);
  }

  resize(width, height) {
    return this.send('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: false });
  }

  // The value of an expression in the page; promises are awaited.
  async ask(expression) {
    const { result, exceptionDetails } = await this.send('Runtime.evaluate',
      { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
    return result.value;
  }

  // Resolves once the expression holds, looked at in every frame of the page.
  until(expression) {
    return this.ask(`new Promise((resolve, reject) => {
      const end = performance.now() + ${kTimeout_ms - 5000};
      const look = () => {
        if (document.readyState === 'complete' && (${expression})) resolve(true);
        else if (performance.now() > end) reject(new Error('never: ' + ${JSON.stringify(expression)}));
        else setTimeout(look, 20);
      };
      look();
    })`);
  }

  async paper() {
    const { data } = await this.send('Page.printToPDF', { preferCSSPageSize: true, printBackground: true });
    return Buffer.from(data, 'base64');
  }

  close() {
    return this.browser.send('Target.closeTarget', { targetId: this.targetId });
  }
}
