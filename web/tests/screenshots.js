// Screenshots of the views. Usage: node screenshots.js FOLDER

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
const rank = async (page) => {
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('.ranking').waitFor({ timeout: 240_000 });
};
await shot('workbench-part', '#part?method=surface', rank, { viewport: { width: 1280, height: 1400 } });
await shot('workbench-solid', '#part?method=surface&tolerance_of_plan=0.05', async (page) => {
  await rank(page);
  await page.locator('#view-part .map').getByText('3D', { exact: true }).click();
  await page.locator('#view-part canvas.solid[data-shown]').waitFor();
  await page.evaluate(() => scrollTo(0, 640));
  await page.waitForTimeout(2000);
}, { viewport: { width: 1280, height: 1400 } });
await shot('workbench-path', '#part?method=surface&tolerance_of_plan=0.05', async (page) => {
  await rank(page);
  await page.locator('#view-part').getByRole('button', { name: 'Check the program' }).click();
  await page.locator('#path-check .verdict').waitFor({ timeout: 120_000 });
}, { viewport: { width: 1280, height: 1100 } });
await bench.close();
