// The tool path view: tables in, figures along the path and a table with the answer out.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { assertFigure, clean, downloaded, field, fileOf, startForTests } from './harness.js';

const { bench, visit } = startForTests();

test('the tool path view adds the feed of the service to each row', async () => {
  const { page, watch } = await visit('#path?mode=contacts');
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg\n10,0\n35,45\n\n20,20\n');
  await page.locator('#path-contacts .uplot').first().waitFor();
  const csv = await downloaded(page, () => page.getByRole('button', { name: 'Download CSV with the answer' }).click());
  const [header, ...rows] = csv.trim().split('\n').map((line) => line.split(','));
  assert.deepEqual(header.slice(0, 5), ['slope_deg', 'feed_angle_deg', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm']);
  const feeds = [];
  for (const row of rows) {
    const answer = await bench().service.post('max-feed', { cutter: { type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4 }, contact: { slope_deg: Number(row[0]), feed_angle_deg: Number(row[1]) }, step_over_mm: 0.6, scallop_tolerance_mm: 0.01, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.4, model: 'envelope' });
    // The download has six digits.
    assert.ok(Math.abs(Number(row[3]) / answer.feed_rate_mm_min - 1) < 5e-6, `${row} against ${answer.feed_rate_mm_min}`);
    feeds.push(answer.feed_rate_mm_min);
  }
  const summary = () => page.locator('#path-contacts .figures data[data-figure="feed_rate_mm_min"]').evaluateAll((all) => all.map((data) => [data.value, data.textContent]));
  for (const [units, factor] of [['inch', 1 / 25.4], ['mm', 1]]) {
    await page.locator('#settings').getByText(units, { exact: true }).click();
    const [least, most] = await summary();
    assertFigure(least, Math.min(...feeds), factor, `least feed in ${units}`);
    assertFigure(most, Math.max(...feeds), factor, `largest feed in ${units}`);
  }
  clean(watch);
});

test('the example path, a broken table and rows without an answer are shown for what they are', async () => {
  const { page, watch } = await visit('#path?mode=contacts');
  await page.getByRole('button', { name: 'Try an example' }).click();
  await page.locator('[data-figure="contacts"]').waitFor();
  assert.equal(await page.locator('[data-figure="contacts"]').textContent(), '241');
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg\n10,0\nsteep,0\n');
  await page.locator('#path-fault').waitFor();
  assert.match(await page.locator('#path-fault').textContent(), /Line 3/);
  await page.locator('#path-table').fill('slope_deg,feed_angle_deg,step_over_mm\n40,0,0.5\n40,0,3\n');
  await page.getByText('Rows without an answer (1)').click();
  await page.getByText(/^Line 3:/).waitFor();
  // A row without an answer has no time: 1 of 3 mm at one feed.
  await page.locator('#path-table').fill('x,y,z,slope_deg,feed_angle_deg,step_over_mm\n0,0,0,40,0,0.5\n1,0,0,40,0,0.5\n3,0,0,40,0,3\n');
  await page.getByText('for 33.3 % of the path').waitFor();
  await field(page, 'diameter_mm').fill('-1');
  await page.locator('#path-contacts [data-field="diameter_mm"] .fault').waitFor();
  clean(watch, { refused: true });
});

test('a plan’s program is checked against its part, and a line that was changed by hand is found', async () => {
  const { page, watch } = await visit('#part?method=surface');
  await page.locator('#surface-file').setInputFiles(fileOf('slope.csv', `x,y,z\n${Array.from({ length: 400 }, (_, i) => [i % 20, Math.floor(i / 20), 3 * Math.sin((i % 20) / 9)].join(',')).join('\n')}\n`));
  // The zero point of the program is a corner of the stock; the check takes it over.
  await page.locator('#view-part summary').filter({ hasText: /^Program/ }).click();
  await field(page, 'program_origin_x_mm').fill('19');
  await field(page, 'program_origin_z_mm').fill('8');
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('.ranking tbody tr').first().waitFor({ timeout: 60_000 });
  const program = await downloaded(page, () => page.getByRole('button', { name: 'Download program' }).click());
  assert.match(program, /^%\nG17 G21/);
  const checked = page.waitForResponse((response) => response.url().includes('path-check') && response.ok());
  await page.locator('#view-part').getByRole('button', { name: 'Check the program' }).click();
  const answer = await (await checked).json();
  await page.locator('#path-check .verdict.pass').waitFor();
  assert.deepEqual(await Promise.all(['x', 'y', 'z'].map((axis) => field(page, `origin_${axis}_mm`).inputValue())), ['19', '0', '8']);
  for (const name of ['machining_time_s', 'cutting_length_mm', 'moves']) assert.equal(await page.locator(`#path-check [data-figure="${name}"]`).getAttribute('value'), String(answer[name]), name);
  assert.match(await page.locator('#path-check .verdict').textContent(), /± [\d.]+ %/);
  // The program's own text comes back with new feeds.
  assert.equal(await page.locator('#path-check [data-figure="time_with_new_feeds_s"]').getAttribute('value'), String(answer.feeds.machining_time_s));
  const refed = await downloaded(page, () => page.getByRole('button', { name: 'Download program with new feeds' }).click());
  assert.equal(refed, answer.program.text);
  // One line in the middle is lowered by half a millimetre.
  const lines = program.split('\n');
  const at = lines.findIndex((line, i) => i > lines.length / 2 && / Z/.test(line) && !line.startsWith('G'));
  lines[at] = lines[at].replace(/Z(-?[\d.]+)/, (_, z) => `Z${(Number(z) - 0.5).toFixed(4)}`);
  await page.locator('#check-program').setInputFiles(fileOf('edited.nc', lines.join('\n')));
  await page.locator('#path-check').getByRole('button', { name: 'Check the program' }).click();
  await page.locator('#path-check .verdict.fail').waitFor();
  const row = page.locator('.places tr[data-code="gouge"]').first();
  const line = Number(await row.getByRole('button').textContent());
  assert.ok(Math.abs(line - (at + 1)) <= 1, `${line} for ${at + 1}`);
  await row.getByRole('button').click();
  assert.match(await page.locator('.excerpt mark').textContent(), new RegExp(`^ *${line} `));
  assert.ok(await page.locator('[aria-label="Map of the check"] canvas:not(.solid)').isVisible());
  // Ra of a drawing stands for a height: 3.2 um for 12.47 um.
  await page.locator('#path-check [data-field="tolerance_form"]').getByText('Ra', { exact: true }).click();
  await page.locator('#path-check [data-field="ra_um"] input').fill('3.2');
  await page.locator('#path-check').getByRole('button', { name: 'Check the program' }).click();
  await page.locator('#path-check .verdict').getByText(/12\.47 µm/).waitFor();
  // A program that cannot be read is refused with its line, at the program.
  await page.locator('#check-program').setInputFiles(fileOf('cycle.nc', 'G21 G90\nG0 X0 Y0 Z10\nG81 X1 Y1 Z-1 R1 F100\n'));
  await page.locator('#path-check').getByRole('button', { name: 'Check the program' }).click();
  await page.locator('#check-program + .drop + .fault').getByText(/line 3/).waitFor();
  clean(watch, { refused: true });
});

test('a hundred thousand contacts from a file leave the page responsive', async (t) => {
  const { page, watch } = await visit('#path?mode=contacts');
  const file = fileOf('long.csv', `slope_deg,feed_angle_deg\n${Array.from({ length: 100_000 }, (_, i) => `${10 + (i % 700) / 10},${i % 180}`).join('\n')}\n`);
  const begun = Date.now();
  await page.locator('#path-file').setInputFiles(file);
  await page.locator('[data-figure="contacts"]').waitFor({ timeout: 60_000 });
  assert.equal(await page.locator('[data-figure="contacts"]').textContent(), '100,000');
  t.diagnostic(`read, answered and drawn after ${((Date.now() - begun) / 1000).toFixed(1)} s`);
  clean(watch);
});
