// The tool path view: tables in, figures along the path and a table with the answer out.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { assertFigure, clean, downloaded, field, fileOf, startForTests } from './harness.js';

const { bench, visit } = startForTests();

test('the tool path view adds the feed of the service to each row', async () => {
  const { page, watch } = await visit('#path');
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg\n10,0\n35,45\n\n20,20\n');
  await page.locator('#view-path .uplot').first().waitFor();
  const csv = await downloaded(page, () => page.getByRole('button', { name: 'Download CSV with the answer' }).click());
  const [header, ...rows] = csv.trim().split('\n').map((line) => line.split(','));
  assert.deepEqual(header.slice(0, 5), ['slope_deg', 'feed_angle_deg', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm']);
  const feeds = [];
  for (const row of rows) {
    const answer = await bench().service.post('max-feed', { cutter: { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 }, contact: { slope_deg: Number(row[0]), feed_angle_deg: Number(row[1]) }, step_over_mm: 0.6, scallop_tolerance_mm: 0.01, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.4, model: 'envelope' });
    // A batch and a single calculation may differ in the last digits.
    assert.ok(Math.abs(Number(row[3]) / answer.feed_rate_mm_min - 1) < 1e-9, `${row} against ${answer.feed_rate_mm_min}`);
    feeds.push(Number(row[3]));
  }
  const summary = () => page.locator('#view-path .figures data[data-figure="feed_rate_mm_min"]').evaluateAll((all) => all.map((data) => [data.value, data.textContent]));
  for (const [units, factor] of [['inch', 1 / 25.4], ['mm', 1]]) {
    await page.locator('#settings').getByText(units, { exact: true }).click();
    const [least, most] = await summary();
    assertFigure(least, Math.min(...feeds), factor, `least feed in ${units}`);
    assertFigure(most, Math.max(...feeds), factor, `largest feed in ${units}`);
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
  clean(watch, { refused: true });
});

test('a hundred thousand contacts from a file leave the page responsive', async (t) => {
  const { page, watch } = await visit('#path');
  const file = fileOf('long.csv', `slope_deg,feed_angle_deg\n${Array.from({ length: 100_000 }, (_, i) => `${10 + (i % 700) / 10},${i % 180}`).join('\n')}\n`);
  const begun = Date.now();
  await page.locator('#path-file').setInputFiles(file);
  await page.locator('[data-figure="contacts"]').waitFor({ timeout: 60_000 });
  assert.equal(await page.locator('[data-figure="contacts"]').textContent(), '100,000');
  t.diagnostic(`read, answered and drawn after ${((Date.now() - begun) / 1000).toFixed(1)} s`);
  clean(watch);
});
