// The page in a real browser, against a real service.

import AxeBuilder from '@axe-core/playwright';
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, afterEach, before, test } from 'node:test';
import { promisify } from 'node:util';
import { folder, open, start, writeStl } from './harness.js';

// Not the synchronous form: a server of this process may have to answer.
const shell = async (command) => (await promisify(execFile)('sh', ['-c', command])).stdout;

// Of a measurement, until one round meets its bound.
const ROUNDS = 5;

let bench;
let opened = [];

before(async () => {
  bench = await start();
});
after(() => bench?.close());
afterEach(async () => {
  for (const { context } of opened) await context.close();
  opened = [];
});

async function visit(fragment, options) {
  const visited = await open(bench, fragment, options);
  opened.push(visited);
  return visited;
}

const field = (page, name) => page.locator(`.view:not([hidden]) [data-field="${name}"] input`).first();
const clean = (watch) => assert.deepEqual(watch, []);

/** Waits until the answer to what was typed is shown and drawn. */
async function settled(page) {
  await page.locator('#view-contact .answer[aria-busy="false"]').waitFor();
  await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve))));
}

/** The figures of the contact view by model. */
const figures = (page) =>
  page.evaluate(() => Object.fromEntries(['envelope', 'analytic'].map((model) => [model, Object.fromEntries([...document.querySelectorAll(`#view-contact td[data-model="${model}"] data`)].map((data) => [data.dataset.figure, [data.value, data.textContent]]))])));

/** The shown text of a figure rounds the service's value, and its `value` is the service's to the last digit. */
function assertFigure([value, text], expected, factor, what) {
  if (expected === null) return assert.equal(text, '∞', what);
  assert.equal(Number(value), expected, what);
  return assert.ok(Math.abs(Number(text) - expected * factor) <= 5.1e-4 * Math.abs(expected * factor) + (expected === 0 ? 1e-12 : 0), `${what}: ${text} for ${expected * factor}`);
}

const HEIGHTS = new Set(['scallop_height_mm', 'step_over_height_mm', 'feed_height_mm']);
const factorOf = (name) => (HEIGHTS.has(name) ? 1000 : ['feed_share', 'deviation'].includes(name) ? 100 : 1);
// Shares are shown with three digits.
function assertAnswer(shown, answer, model) {
  for (const [name, figure] of Object.entries(shown)) {
    const expected = name === 'deviation' ? answer.check.deviation : answer[name];
    if (factorOf(name) === 100) assert.equal(Number(figure[0]), expected, `${model} ${name}`);
    else assertFigure(figure, expected, factorOf(name), `${model} ${name}`);
  }
}

test('the contact view shows the figures of the service for every question', async () => {
  const { page, watch } = await visit('#contact');
  const cutter = { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 };
  const shared = { cutter, contact: { slope_deg: 40, feed_angle_deg: 30 } };
  const questions = [
    ['Scallop height', 'scallop-height', { step_over_mm: 0.687, feed_per_tooth_mm: 0.15 }, 'scallop_height_mm'],
    ['Largest step-over', 'step-over', { scallop_tolerance_mm: 0.01, feed_per_tooth_mm: 0.15 }, 'step_over_mm'],
    ['Largest feed', 'max-feed', { step_over_mm: 0.6, scallop_tolerance_mm: 0.01, spindle_speed_rpm: 8000 }, 'feed_rate_mm_min'],
    ['Fastest pair', 'cutting-parameters', { scallop_tolerance_mm: 0.01, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.2 }, 'area_rate_mm2_min'],
  ];
  for (const [label, endpoint, members, main] of questions) {
    await page.getByText(label, { exact: true }).first().click();
    if (members.step_over_mm) await field(page, 'step_over_mm').fill(String(members.step_over_mm));
    if (members.max_feed_per_tooth_mm) await field(page, 'max_feed_per_tooth_mm').fill(String(members.max_feed_per_tooth_mm));
    await settled(page);
    await page.locator(`td[data-model="envelope"] data[data-figure="${main}"]`).waitFor();
    const shown = await figures(page);
    for (const model of ['envelope', 'analytic']) {
      const answer = await bench.service.post(endpoint, { ...shared, ...members, model });
      assert.ok(Object.keys(shown[model]).length >= 8, `${label}: ${Object.keys(shown[model])}`);
      assertAnswer(shown[model], answer, `${label} ${model}`);
    }
  }
  // On the way from one question to the next the values may be impossible.
  clean(watch.filter((line) => !line.includes('422')));
});

test('the drawn cusp is the service’s height without feed', async () => {
  const { page, watch } = await visit('#contact');
  for (const [slope, angle] of [[40, 30], [3, 60], [85, 90], [60, 0]]) {
    await field(page, 'slope_deg').fill(String(slope));
    await field(page, 'feed_angle_deg').fill(String(angle));
    await settled(page);
    const { envelope } = await figures(page);
    const drawn = Number(await page.locator('.detail svg[data-cusp-mm]').getAttribute('data-cusp-mm'));
    const stated = Number(envelope.step_over_height_mm[0]);
    assert.ok(Math.abs(drawn / stated - 1) < 1e-6, `${slope} ${angle}: drawn ${drawn}, service ${stated}`);
  }
  assert.match(await page.locator('.detail').textContent(), /heights × \d+/);
  clean(watch);
});

test('vectors, curvature and runout reach the service', async () => {
  const { page, watch } = await visit('#contact');
  await page.getByText('Vectors', { exact: true }).click();
  await page.getByText('Radius', { exact: true }).click();
  await field(page, 'surface_radius_mm').fill('80');
  await field(page, 'radial_mm').fill('2');
  await settled(page);
  const request = { cutter: { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 }, contact: { normal: [-0.64, 0, 0.77], feed: [1, 0, 0.84] }, surface_radius_mm: 80, runout: { radial_mm: 0.002 }, step_over_mm: 0.687, feed_per_tooth_mm: 0.15 };
  for (const model of ['envelope', 'analytic']) assertAnswer((await figures(page))[model], await bench.service.post('scallop-height', { ...request, model }), model);
  clean(watch);
});

test('a wrong value is marked at its field, and goes when it is mended', async () => {
  const { page, watch } = await visit('#contact');
  await field(page, 'corner_radius_mm').fill('8');
  const fault = page.locator('#view-contact [data-field="corner_radius_mm"] .fault');
  await fault.waitFor();
  assert.match(await fault.textContent(), /corner radius/);
  assert.equal(await field(page, 'corner_radius_mm').getAttribute('aria-invalid'), 'true');
  await field(page, 'slope_deg').fill('steep');
  await page.locator('#view-contact [data-field="slope_deg"] .fault').waitFor();
  await field(page, 'corner_radius_mm').fill('2');
  await field(page, 'slope_deg').fill('40');
  await page.locator('td[data-model="envelope"] data[data-figure="scallop_height_mm"]').waitFor();
  assert.equal(await page.locator('.view:not([hidden]) .fault:visible').count(), 0);
  clean(watch.filter((line) => !line.includes('422')));
});

test('a fault of one model stands in its column', async () => {
  const { page } = await visit('#contact');
  await field(page, 'slope_deg').fill('0');
  await page.getByText('Published: no answer.').waitFor();
  assert.ok((await figures(page)).envelope.scallop_height_mm);
});

test('a link holds the whole state, inches included', async () => {
  const { page, watch } = await visit('#contact');
  await page.locator('#settings').getByText('inch').click();
  await field(page, 'diameter_mm').fill('0.375');
  await field(page, 'slope_deg').fill('25');
  await settled(page);
  const shown = await figures(page);
  // The address follows the fields after a moment.
  await page.waitForFunction(() => location.hash.includes('slope_deg=25'));
  await page.getByRole('button', { name: 'Copy link' }).first().click();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  assert.match(link, /slope_deg=25/);
  const { page: other, watch: otherWatch } = await visit(link.slice(bench.address.length));
  await settled(other);
  assert.deepEqual(await figures(other), shown);
  assert.equal(await field(other, 'diameter_mm').inputValue(), '0.375');
  assert.equal(await other.locator('tr[data-row="step_over_mm"] td.unit').textContent(), 'in');
  clean([...watch, ...otherWatch]);
});

test('the copied curl command gives the page’s figures', async () => {
  const { page } = await visit('#contact');
  await page.locator('data[data-figure="scallop_height_mm"]').first().waitFor();
  await page.getByRole('button', { name: 'Copy as curl' }).first().click();
  const command = await page.evaluate(() => navigator.clipboard.readText());
  const answer = JSON.parse(await shell(command));
  assertAnswer((await figures(page)).envelope, answer, 'curl');
});

test('the keyboard alone changes tabs, values and choices', async () => {
  const { page, watch } = await visit('#contact');
  await page.locator('#tab-contact').focus();
  await page.keyboard.press('ArrowRight');
  await page.locator('#view-part').waitFor();
  await page.keyboard.press('ArrowLeft');
  await page.locator('#view-contact').waitFor();
  await field(page, 'slope_deg').focus();
  await page.keyboard.press('ArrowUp');
  assert.equal(await field(page, 'slope_deg').inputValue(), '41');
  assert.ok(await page.locator('#tooltip').isVisible());
  await page.keyboard.press('Escape');
  assert.ok(!(await page.locator('#tooltip').isVisible()));
  clean(watch);
});

test('every figure of an answer has a tooltip, and every quantity a unit', async () => {
  const { page } = await visit('#contact');
  await page.locator('tr[data-row]').first().waitFor();
  for (const row of await page.locator('tr[data-row]').all()) {
    assert.ok((await row.locator('[data-help]').getAttribute('data-help')).length > 10);
    if ((await row.getAttribute('data-row')) !== 'limited_by') assert.notEqual(await row.locator('td.unit').textContent(), '');
  }
  await page.locator('tr[data-row="effective_radius_mm"] .term').hover();
  assert.match(await page.locator('#tooltip').textContent(), /groove/);
});

test('the part view ranks the cutters of an example as the service does', async () => {
  const { page, watch } = await visit('#part');
  const answered = page.waitForResponse((response) => response.url().includes('cutter-recommendation'));
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const answer = await (await answered).json();
  await page.locator('.ranking tbody tr').first().waitFor();
  const rows = await page.locator('.ranking tbody tr').evaluateAll((all) => all.map((row) => [Number(row.dataset.cutter), Object.fromEntries([...row.querySelectorAll('data')].map((data) => [data.dataset.figure, data.value]))]));
  assert.deepEqual(rows.map(([cutter]) => cutter), answer.candidates.map(({ cutter }) => cutter));
  rows.forEach(([, shown], i) => {
    const candidate = answer.candidates[i];
    for (const name of ['machining_time_s', 'direction_deg', 'passes', 'feed_rate_mm_min', 'over_tolerance_share', 'uncut_share', 'least_time_s']) {
      if (candidate[name] !== undefined && typeof candidate[name] !== 'object') assert.equal(Number(shown[name]), candidate[name], name);
    }
    assert.equal(Number(shown.step_over_xy_mm), candidate.step_over_xy_mm.median);
    assert.equal(Number(shown.scallop_p99_mm), candidate.scallop_height_mm.p99);
  });
  assert.ok(await page.locator('#view-part .uplot').isVisible());
  assert.match(await page.locator('.confidence').textContent(), new RegExp(answer.confidence.level));
  // The value under the pointer is the raster's.
  const canvas = page.locator('.map canvas');
  await canvas.focus();
  await page.keyboard.press('ArrowRight');
  const { columns, rows: count, z_mm: z, slope_deg: slope } = answer.map;
  const cell = Math.floor(count / 2) * columns + Math.floor(columns / 2) + 1;
  if (z[cell] !== null) assert.ok((await page.locator('.map .readout').textContent()).includes(`slope ${slope[cell] === 0 ? '0' : Number(slope[cell]).toPrecision(4)}`.slice(0, 9)));
  for (const layer of ['Slope', 'Uncut', 'Height']) await page.locator('.map').getByText(layer, { exact: true }).click();
  await page.locator('.map').getByText('Turned').click();
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download JSON' }).first().click()]);
  assert.deepEqual(JSON.parse(readFileSync(await download.path(), 'utf8')), answer);
  const [csv] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download CSV', exact: true }).click()]);
  assert.equal(readFileSync(await csv.path(), 'utf8').trim().split('\n').length, answer.candidates.length + 1);
  await page.getByRole('button', { name: 'Show the map' }).first().click();
  await page.locator('.ranking tbody tr').nth(1).getByText('shown').waitFor();
  clean(watch);
});

test('the passes are drawn, downloaded, and read by the tool path view', async () => {
  const { page, watch } = await visit('#part');
  await page.locator('#view-part').getByText('Point by point').click();
  const answered = page.waitForResponse((response) => response.url().includes('cutter-recommendation'));
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const { passes } = await (await answered).json();
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download passes as CSV' }).click()]);
  const text = readFileSync(await download.path(), 'utf8');
  assert.equal(text.trim().split('\n').length, passes.tip_mm.length + 1);
  await page.locator('#tab-path').click();
  const file = path.join(folder, 'passes.csv');
  writeFileSync(file, text);
  await page.locator('#path-file').setInputFiles(file);
  await page.locator('[data-figure="contacts"]').waitFor();
  assert.equal(await page.locator('[data-figure="contacts"]').getAttribute('value'), String(passes.tip_mm.length));
  // A point whose tip was raised has no contact, and no answer.
  const raised = passes.contact_mm.filter((contact) => contact === null).length;
  assert.ok(Number(await page.locator('[data-figure="failures"]').getAttribute('value')) >= raised);
  clean(watch);
});

test('a wrong cutter is marked in its row', async () => {
  const { page } = await visit('#part');
  await page.locator('.cutter-row').nth(1).locator('[data-field="corner_radius_mm"] input').fill('9');
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const fault = page.locator('.cutter-row').nth(1).locator('[data-field="corner_radius_mm"] .fault');
  await fault.waitFor();
  assert.match(await fault.textContent(), /corner radius/);
});

test('a broken file is refused with the line, at the file', async () => {
  const { page } = await visit('#part');
  const file = path.join(folder, 'broken.csv');
  writeFileSync(file, 'x,y,z\n1,2,3\n1,broken,3\n');
  await page.locator('#surface-file').setInputFiles(file);
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('#file-fault').waitFor();
  assert.match(await page.locator('#file-fault').textContent(), /line 3/);
  assert.ok(!(await page.locator('.part-results').isVisible()));
});

test('a file of a million facets leaves the page responsive', async (t) => {
  const { page, watch } = await visit('#part');
  const file = writeStl(1_000_000);
  await page.locator('#surface-file').setInputFiles(file);
  // Two cutters are enough: what is tried is the page.
  for (let i = 0; i < 2; i += 1) await page.locator('.cutter-row').last().getByRole('button').click();
  await page.evaluate(() => {
    globalThis.gaps = [];
    let last = performance.now();
    const tick = () => {
      const now = performance.now();
      globalThis.gaps.push(now - last);
      last = now;
      globalThis.timer = setTimeout(tick, 10);
    };
    tick();
    globalThis.progress = [];
    new MutationObserver(() => globalThis.progress.push(document.querySelector('.progress span').textContent)).observe(document.querySelector('.progress'), { childList: true, subtree: true, characterData: true });
  });
  const begun = Date.now();
  const answered = page.waitForResponse((response) => response.url().includes('/upload'), { timeout: 120_000 });
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  // Meanwhile another view answers.
  await page.locator('#tab-contact').click();
  await field(page, 'slope_deg').fill('33');
  await page.locator('data[data-figure="scallop_height_mm"]').first().waitFor();
  await page.locator('#tab-part').click();
  assert.equal((await answered).status(), 200);
  await page.locator('.ranking tbody tr').first().waitFor({ timeout: 30_000 });
  const { gaps, progress } = await page.evaluate(() => ({ gaps: globalThis.gaps.sort((a, b) => a - b), progress: globalThis.progress }));
  t.diagnostic(`answered after ${((Date.now() - begun) / 1000).toFixed(1)} s; event loop gaps: p99 ${gaps[Math.floor(gaps.length * 0.99)].toFixed(0)} ms, longest ${gaps.at(-1).toFixed(0)} ms`);
  assert.ok(gaps.at(-1) < 300, `the page stood still for ${gaps.at(-1)} ms`);
  assert.ok(progress.some((text) => /% sent/.test(text)), `progress: ${progress}`);
  clean(watch);
});

test('the tool path view adds the feed of the service to each row', async () => {
  const { page, watch } = await visit('#path');
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg\n10,0\n35,45\n\n20,20\n');
  await page.locator('#view-path .uplot').first().waitFor();
  const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('button', { name: 'Download CSV with the answer' }).click()]);
  const [header, ...rows] = readFileSync(await download.path(), 'utf8').trim().split('\n').map((line) => line.split(','));
  assert.deepEqual(header.slice(0, 5), ['slope_deg', 'feed_angle_deg', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm']);
  for (const row of rows) {
    const answer = await bench.service.post('max-feed', { cutter: { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 }, contact: { slope_deg: Number(row[0]), feed_angle_deg: Number(row[1]) }, step_over_mm: 0.6, scallop_tolerance_mm: 0.01, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.4, model: 'envelope' });
    // A batch and a single calculation may differ in the last digits.
    assert.ok(Math.abs(Number(row[3]) / answer.feed_rate_mm_min - 1) < 1e-9, `${row} against ${answer.feed_rate_mm_min}`);
  }
  clean(watch);
});

test('the example path, a broken table and rows without an answer are shown for what they are', async () => {
  const { page, watch } = await visit('#path');
  await page.getByRole('button', { name: 'Try an example' }).click();
  await page.locator('[data-figure="contacts"]').waitFor();
  assert.equal(await page.locator('[data-figure="contacts"]').textContent(), '241');
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg\n10,0\nsteep,0\n');
  await page.locator('#path-fault').waitFor();
  assert.match(await page.locator('#path-fault').textContent(), /Line 3/);
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg,step_over_mm\n40,0,0.5\n40,0,3\n');
  await page.getByText('Rows without an answer (1)').click();
  await page.getByText(/^Line 3:/).waitFor();
  await field(page, 'diameter_mm').fill('-1');
  await page.locator('#view-path [data-field="diameter_mm"] .fault').waitFor();
  clean(watch.filter((line) => !line.includes('422')));
});

test('a hundred thousand contacts from a file leave the page responsive', async (t) => {
  const { page, watch } = await visit('#path');
  const file = path.join(folder, 'long.csv');
  writeFileSync(file, `slope_deg,feed_angle_deg\n${Array.from({ length: 100_000 }, (_, i) => `${10 + (i % 700) / 10},${i % 180}`).join('\n')}\n`);
  const begun = Date.now();
  await page.locator('#path-file').setInputFiles(file);
  await page.locator('[data-figure="contacts"]').waitFor({ timeout: 60_000 });
  assert.equal(await page.locator('[data-figure="contacts"]').textContent(), '100,000');
  t.diagnostic(`read, answered and drawn after ${((Date.now() - begun) / 1000).toFixed(1)} s`);
  clean(watch);
});

test('the service may go away and come back', async () => {
  const { page } = await visit('#contact');
  await page.locator('data[data-figure="scallop_height_mm"]').first().waitFor();
  const before = await figures(page);
  await bench.service.stop();
  await field(page, 'slope_deg').fill('41');
  await page.locator('#away').waitFor();
  await bench.service.start();
  await page.locator('#away').waitFor({ state: 'hidden', timeout: 10_000 });
  await page.waitForFunction((old) => document.querySelector('data[data-figure="scallop_height_mm"]').value !== old, before.envelope.scallop_height_mm[0]);
  const { envelope } = await figures(page);
  const answer = await bench.service.post('scallop-height', { cutter: { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 }, contact: { slope_deg: 41, feed_angle_deg: 30 }, step_over_mm: 0.687, feed_per_tooth_mm: 0.15, model: 'envelope' });
  assert.equal(Number(envelope.scallop_height_mm[0]), answer.scallop_height_mm);
});

test('accessibility: no serious fault in any view, light or dark', async () => {
  for (const colorScheme of ['light', 'dark']) {
    for (const [view, prepare] of [
      ['contact', async (page) => page.locator('.polar .curve').first().waitFor()],
      ['part', async (page) => {
        await page.getByRole('button', { name: 'Find the cutter' }).click();
        await page.locator('.ranking').waitFor();
      }],
      ['path', async (page) => {
        await page.getByRole('button', { name: 'Try an example' }).click();
        await page.locator('#view-path .uplot').first().waitFor();
      }],
    ]) {
      const { page } = await visit(`#${view}`, { colorScheme });
      await prepare(page);
      const { violations } = await new AxeBuilder({ page }).analyze();
      const grave = violations.filter(({ impact }) => ['serious', 'critical'].includes(impact));
      assert.deepEqual(grave.map(({ id, nodes }) => [id, nodes.map(({ target }) => target.join(' ')).slice(0, 4)]), [], `${view} ${colorScheme}`);
    }
  }
});

test('the glossary lists names and codes without serious faults', async () => {
  const { page, watch } = await visit('glossary');
  await page.locator('#codes td').first().waitFor();
  assert.match(await page.locator('#codes').textContent(), /tolerance-exceeded/);
  assert.ok((await page.locator('#terms tr').count()) > 50);
  const { violations } = await new AxeBuilder({ page }).analyze();
  assert.deepEqual(violations.filter(({ impact }) => ['serious', 'critical'].includes(impact)).map(({ id }) => id), []);
  clean(watch);
});

test('nothing overflows from 360 to 1920 px', async () => {
  for (const width of [360, 768, 1080, 1440, 1920]) {
    for (const view of ['contact', 'part', 'path']) {
      const { page } = await visit(`#${view}`, { viewport: { width, height: 900 } });
      if (view === 'part') {
        await page.getByRole('button', { name: 'Find the cutter' }).click();
        await page.locator('.ranking').waitFor();
      }
      if (view === 'path') await page.getByRole('button', { name: 'Try an example' }).click();
      await page.waitForTimeout(300);
      const [wide, room] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
      assert.ok(wide <= room, `${view} at ${width}: ${wide}`);
    }
  }
});

test('the page’s policy allows no inline script or style', async () => {
  const response = await fetch(bench.address);
  const policy = response.headers.get('content-security-policy');
  assert.ok(policy && !policy.includes('unsafe'), policy);
  assert.equal((await fetch(`${bench.address}favicon.ico`)).status, 200);
});

test('the first load is under 150 KB compressed and 200 ms', async (t) => {
  const { page, watch } = await visit('#contact');
  const urls = await page.evaluate(() => [location.href.split('#')[0], ...performance.getEntriesByType('resource').map(({ name }) => name)]);
  const assets = [...new Set(urls)].filter((url) => !url.includes('/v1/'));
  let bytes = 0;
  for (const url of assets) bytes += Number(await shell(`curl -sS --compressed -o /dev/null -w '%{size_download}' '${url}'`));
  // The least of several rounds: what else the machine does can only add.
  const medians = [];
  for (let round = 0; round < ROUNDS && !(medians.at(-1) < 200); round += 1) {
    const loads = [];
    for (let i = 0; i < 7; i += 1) {
      await page.reload();
      await page.locator('data[data-figure="scallop_height_mm"]').first().waitFor();
      loads.push(await page.evaluate(() => performance.getEntriesByType('navigation')[0].loadEventEnd));
    }
    medians.push(loads.sort((x, y) => x - y)[3]);
  }
  t.diagnostic(`${assets.length} files, ${(bytes / 1000).toFixed(1)} KB as sent; load event after ${medians.map((ms) => ms.toFixed(0)).join(', ')} ms (medians of 7), load of the machine ${os.loadavg()[0].toFixed(1)}`);
  assert.ok(bytes > 0 && bytes < 150_000, `${bytes} bytes`);
  assert.ok(Math.min(...medians) < 200, `${medians} ms`);
  clean(watch);
});

test('an answer follows a keystroke within 50 ms, 19 times out of 20', async (t) => {
  const { page, watch } = await visit('#contact');
  await page.locator('.polar .curve').first().waitFor();
  const typed = () =>
    page.evaluate(async () => {
      const input = document.querySelector('#view-contact [data-field="slope_deg"] input');
      const found = [];
      for (let i = 0; i < 60; i += 1) {
        const answer = document.querySelector('#view-contact .answer');
        const begun = performance.now();
        const shown = new Promise((resolve) => new MutationObserver((_, observer) => (observer.disconnect(), resolve(performance.now()))).observe(answer, { childList: true }));
        input.value = String(30 + Math.random() * 15);
        input.dispatchEvent(new Event('input', { bubbles: true }));
        found.push((await shown) - begun);
        await new Promise((resolve) => setTimeout(resolve, i % 10 === 9 ? 400 : 80));
      }
      return found.sort((a, b) => a - b);
    });
  const rounds = [];
  for (let round = 0; round < ROUNDS && !(rounds.at(-1)?.[57] < 50); round += 1) rounds.push(await typed());
  t.diagnostic(`typing to answer, median / p95: ${rounds.map((waits) => `${waits[30].toFixed(1)} / ${waits[57].toFixed(1)} ms`).join(', ')}; load of the machine ${os.loadavg()[0].toFixed(1)}`);
  assert.ok(Math.min(...rounds.map((waits) => waits[57])) < 50);
  clean(watch);
});
