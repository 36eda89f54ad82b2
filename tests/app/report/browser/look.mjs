// node look.mjs CHROMIUM URL OUT [WIDTH [unfold]]: pictures of the whole page as a window of that width
// shows it, with all folds open or as it comes, and OUT.pdf as it prints; for whoever changes how it
// looks.
import { writeFileSync } from 'node:fs';
import { Browser } from './browser.mjs';

const [program, url, out, width = '1280', unfold] = process.argv.slice(2);
const kHeight = 1500;
const browser = await Browser.start(program);
try {
  const page = await browser.open(url, Number(width), kHeight);
  await page.until("document.documentElement.dataset.state === 'done'");
  if (unfold) {
    await page.ask("document.querySelectorAll('details.fold').forEach((d) => { d.open = true; })");
    await page.until("[...document.querySelectorAll('figure[data-kind]')].every((f) => f.dataset.state !== 'folded')");
  }
  const whole = await page.ask('document.documentElement.scrollHeight');
  for (let y = 0, k = 0; y < whole; y += kHeight, k += 1) {
    await page.ask(`scrollTo(0, ${y})`);
    const { data } = await page.send('Page.captureScreenshot');
    writeFileSync(`${out}-${String(k).padStart(2, '0')}.png`, Buffer.from(data, 'base64'));
  }
  writeFileSync(`${out}.pdf`, await page.paper());
  const states = await page.ask("[...document.querySelectorAll('figure')].map((f) => `${f.dataset.state} ${f.id} ${f.dataset.detail ?? ''}`)");
  console.log([...states, ...page.errors].join('\n'));
} finally {
  await browser.stop();
}
