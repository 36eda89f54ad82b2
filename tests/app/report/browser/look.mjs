// node look.mjs CHROMIUM URL OUT: what the page looks like, wide, narrow and on paper.
import { writeFileSync } from 'node:fs';
import { Browser } from './browser.mjs';

const [program, url, out] = process.argv.slice(2);
const kSlice = 1500;  // px: what can be looked at in one picture

async function slices(page, name, width) {
  const height = await page.ask('document.documentElement.scrollHeight');
  for (let y = 0, k = 0; y < height; y += kSlice, k += 1) {
    const clip = { x: 0, y, width, height: Math.min(kSlice, height - y), scale: 1 };
    const { data } = await page.send('Page.captureScreenshot', { captureBeyondViewport: true, clip });
    writeFileSync(`${out}-${name}-${String(k).padStart(2, '0')}.png`, Buffer.from(data, 'base64'));
  }
}

const browser = await Browser.start(program);
try {
  const page = await browser.open(url, 1280, 900);
  await page.until("document.documentElement.dataset.state === 'done'");
  await slices(page, 'wide', 1280);
  await page.resize(420, 800);
  await new Promise((r) => setTimeout(r, 600));
  await slices(page, 'narrow', 420);
  await page.resize(1280, 900);
  writeFileSync(`${out}.pdf`, await page.paper());
  console.log(JSON.stringify({ errors: page.errors, requests: page.requests.filter((u) => !u.startsWith('data:')),
    states: await page.ask("[...document.querySelectorAll('figure')].map((f) => [f.id, f.dataset.state, f.dataset.detail])"),
    refused: await page.ask('document.documentElement.dataset.refused ?? null') }, null, 1));
} finally {
  await browser.stop();
}
