// The 3D view: loaded apart, drawn, turned and read, usable with many facets, and the map where there is no WebGL.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { clean, fileOf, graveFaults, longestFrame, shell, startForTests, writeStl } from './harness.js';

const { bench, visit } = startForTests();

const canvas = (page) => page.locator('#view-part canvas.solid');

/** Ranks a part with one ball end. */
async function rank(page, { file, diameter = 6, tolerance = 100 }) {
  await page.locator('#surface-file').setInputFiles(file);
  await page.locator('.cutter-row').first().waitFor();
  for (let row = (await page.locator('.cutter-row').count()) - 1; row >= 0; row -= 1) if (row !== 2) await page.locator('.cutter-row').nth(row).getByRole('button').click();
  await page.locator('.cutter-row [data-field="diameter_mm"] input').fill(String(diameter));
  await page.locator('#view-part [data-field="tolerance_of_plan"] input').fill(String(tolerance));
  const answered = page.waitForResponse((response) => response.url().includes('/upload'), { timeout: 120_000 });
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const answer = await (await answered).json();
  await page.locator('#view-part .map canvas:not(.solid)').first().waitFor({ timeout: 30_000 });
  return answer;
}

async function showSolid(page) {
  await page.locator('#view-part .map').getByText('3D', { exact: true }).click();
  await page.locator('#view-part canvas.solid[data-shown]').waitFor({ timeout: 60_000 });
  await page.waitForTimeout(300);
}

/** The picture of the 3D view, and how many different colours it has. */
const picture = (page) =>
  canvas(page).evaluate((element) => {
    const copy = new OffscreenCanvas(element.width, element.height).getContext('2d');
    copy.drawImage(element, 0, 0);
    const { data } = copy.getImageData(0, 0, element.width, element.height);
    return { colours: new Set(new Uint32Array(data.buffer)).size, address: element.toDataURL() };
  });

const slope = `x,y,z\n${Array.from({ length: 400 }, (_, i) => [i % 20, Math.floor(i / 20), 3 * Math.sin((i % 20) / 9)].join(',')).join('\n')}\n`;

test('the 3D view is loaded when it is asked for, in under 200 KB, and draws the part with its path and tool', async (t) => {
  const { page, watch } = await visit('#part?method=surface');
  const loaded = [];
  page.on('request', (request) => /workbench\/(solid|vendor\/ogl)/.test(request.url()) && loaded.push(request.url()));
  const { map } = await rank(page, { file: fileOf('slope.csv', slope) });
  assert.deepEqual(loaded, []);
  await showSolid(page);
  let [sent, whole] = [0, 0];
  for (const url of loaded) {
    sent += Number(await shell(`curl -sS --compressed -o /dev/null -w '%{size_download}' '${url}'`));
    whole += (await (await fetch(url)).text()).length;
  }
  t.diagnostic(`${loaded.length} files, ${(sent / 1000).toFixed(1)} KB as sent, ${(whole / 1000).toFixed(1)} KB unpacked`);
  assert.ok(sent > 0 && whole < 200_000, `${whole}`);
  const first = await picture(page);
  assert.ok(first.colours > 50, `${first.colours} colours`);
  // The values under the pointer are the raster's, and the tool stands at the path.
  await canvas(page).scrollIntoViewIfNeeded();
  const box = await canvas(page).boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.locator('#view-part .readout').getByText(/tip at/).waitFor();
  const [, x, y, z] = /^X ([\d.-]+), Y ([\d.-]+), Z ([\d.-]+)/.exec(await page.locator('#view-part .readout').textContent()).map(Number);
  const at = Math.floor((y - map.origin_mm[1]) / map.cell_mm) * map.columns + Math.floor((x - map.origin_mm[0]) / map.cell_mm);
  assert.ok([at - 1, at, at + 1].some((index) => Math.abs(map.z_mm[index] - z) < 2e-3), `${x} ${y} ${z}: ${map.z_mm[at]}`);
  const withTool = await picture(page);
  assert.notEqual(withTool.address, first.address);
  // Layers, path and keyboard change the picture; the mouse turns the part.
  await page.locator('#view-part .map [data-field="path"]').getByText('On').click();
  await page.waitForTimeout(500);
  const withPath = await picture(page);
  assert.notEqual(withPath.address, withTool.address);
  await canvas(page).focus();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('PageDown');
  await page.waitForTimeout(1000);
  const turned = await picture(page);
  assert.notEqual(turned.address, withPath.address);
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 80, box.y + box.height / 2 + 20, { steps: 5 });
  await page.mouse.up();
  await page.waitForTimeout(1000);
  assert.notEqual((await picture(page)).address, turned.address);
  for (const [colorScheme, width] of ['light', 'dark'].flatMap((scheme) => [390, 1440, 1920].map((size) => [scheme, size]))) {
    await page.emulateMedia({ colorScheme, reducedMotion: 'reduce' });
    await page.setViewportSize({ width, height: 900 });
    await page.waitForTimeout(300);
    assert.deepEqual(await graveFaults(page), [], `${colorScheme} ${width}`);
  }
  clean(watch);
});

test('without WebGL the map from above stays', async () => {
  const { page, context } = await visit('#contact');
  await context.addInitScript(() => {
    const { getContext } = HTMLCanvasElement.prototype;
    HTMLCanvasElement.prototype.getContext = function get(kind, ...rest) {
      return kind.startsWith('webgl') ? null : getContext.call(this, kind, ...rest);
    };
  });
  await page.goto(`${bench().address}?plain#part?method=surface`);
  await rank(page, { file: fileOf('slope.csv', slope) });
  await page.locator('#view-part .map').getByText('3D', { exact: true }).click();
  await page.locator('#view-part .readout').getByText(/no WebGL/).waitFor();
  assert.ok(await page.locator('#view-part .map canvas:not(.solid)').first().isVisible());
});

/** Shows a part of so many facets in 3D and moves the mouse over it; returns what the page says below it. */
async function showPartOf(facets, page, t) {
  await rank(page, { file: writeStl(facets), diameter: 6, tolerance: 200 });
  await page.evaluate(() => {
    globalThis.tasks = [];
    new PerformanceObserver((list) => globalThis.tasks.push(...list.getEntries().map(({ duration }) => duration))).observe({ entryTypes: ['longtask'] });
  });
  const begun = Date.now();
  await showSolid(page);
  const shown = Date.now() - begun;
  const told = await page.locator('#view-part .readout').textContent();
  await canvas(page).scrollIntoViewIfNeeded();
  const frame = await longestFrame(page, canvas(page));
  await page.locator('#view-part .readout').getByText(/tip at/).waitFor();
  await page.waitForTimeout(500);
  const longest = Math.max(0, ...(await page.evaluate(() => globalThis.tasks)));
  t.diagnostic(`drawn after ${(shown / 1000).toFixed(1)} s; longest task of the page ${longest.toFixed(0)} ms; longest frame while the mouse moves ${frame.toFixed(0)} ms`);
  assert.ok((await picture(page)).colours > 50);
  assert.ok(longest < 2000, `${longest} ms`);
  return told;
}

/** Shows a part of so many facets in a browser whose graphics have this name; returns what the page says below it. */
async function showWith(graphics, facets, t) {
  const { page, context, watch } = await visit('#contact');
  await context.addInitScript((name) => {
    const { getParameter } = WebGL2RenderingContext.prototype;
    const [RENDERER, UNMASKED] = [0x1f01, 0x9246];
    WebGL2RenderingContext.prototype.getParameter = function get(kind) {
      return kind === RENDERER || kind === UNMASKED ? name : getParameter.call(this, kind);
    };
  }, graphics);
  await page.goto(`${bench().address}?plain#part?method=surface`);
  const told = await showPartOf(facets, page, t);
  clean(watch);
  return told;
}

test('where the processor draws, a million facets are drawn by the cells of the map, and the page says so', async (t) => {
  assert.match(await showWith('llvmpipe', 1_000_000, t), /cells of the map/);
});

// Fewer, as the browser of the tests has no graphics card and takes seconds for a frame of a million.
test('where a graphics card draws, all facets of a file are drawn, and the page stays responsive', async (t) => {
  assert.doesNotMatch(await showWith('A graphics card', 100_000, t), /cells of the map/);
});
