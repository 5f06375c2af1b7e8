// Screenshots of the three views. Usage: node screenshots.js FOLDER

import path from 'node:path';
import { open, start } from './harness.js';

const [folder] = process.argv.slice(2);
const bench = await start();

async function shot(name, fragment, prepare, options) {
  const { page, context } = await open(bench, fragment, { viewport: { width: 1280, height: 900 }, ...options });
  await prepare(page);
  await page.waitForTimeout(600);
  await page.mouse.move(0, 0);
  await page.screenshot({ path: path.join(folder, `${name}.png`) });
  await context.close();
}

await shot('workbench-contact', '#contact', (page) => page.locator('.polar .curve').first().waitFor());
await shot('workbench-part', '#part', async (page) => {
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('.ranking').waitFor({ timeout: 60_000 });
}, { viewport: { width: 1280, height: 1400 } });
await shot('workbench-path', '#path', async (page) => {
  await page.getByRole('button', { name: 'Try an example' }).click();
  await page.locator('#view-path .uplot').first().waitFor();
});
await bench.close();
