// The part view: surfaces, cutters and libraries in; the ranking, the map and downloads out.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { assertFigure, clean, downloaded, field, fileOf, folder, shell, startForTests, writeStl } from './harness.js';

const { visit } = startForTests();

const INCH = 25.4;

/** Finds the cutter; returns the request and the service's answer to it. */
async function find(page, timeout = 60_000) {
  const answered = page.waitForResponse((response) => response.url().includes('cutter-recommendation'), { timeout });
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const response = await answered;
  const answer = await response.json();
  await page.locator('.progress').waitFor({ state: 'hidden' });
  return { request: response.request(), status: response.status(), answer };
}

/** Leaves only the cutters in the rows `kept` of the table. */
async function keepCutters(page, ...kept) {
  await page.locator('.cutter-row').first().waitFor();
  for (let row = (await page.locator('.cutter-row').count()) - 1; row >= 0; row -= 1) {
    if (!kept.includes(row)) await page.locator('.cutter-row').nth(row).getByRole('button').click();
  }
}

const choose = (page, name) => page.locator('[data-field="example"] select').selectOption(name);

/** The rows of the ranking: [cutter, {figure: [full precision, text]}]. */
const ranking = (page) =>
  page.locator('.ranking tbody tr').evaluateAll((rows) => rows.map((row) => [Number(row.dataset.cutter), Object.fromEntries([...row.querySelectorAll('data')].map((data) => [data.dataset.figure, [data.value, data.textContent]]))]));

// [figure, value of a candidate, displayed value per mm, s, 1 or degree in mm, in inch]
const FIGURES = [
  ['direction_deg', (candidate) => candidate.direction_deg, 1, 1],
  ['passes', (candidate) => candidate.passes, 1, 1],
  ['step_over_xy_mm', (candidate) => candidate.step_over_xy_mm?.median, 1, 1 / INCH],
  ['feed_rate_mm_min', (candidate) => candidate.feed_rate_mm_min, 1, 1 / INCH],
  ['scallop_p99_mm', (candidate) => candidate.scallop_height_mm?.p99, 1000, 1000 / INCH],
  ['scallop_max_mm', (candidate) => candidate.scallop_height_mm?.max, 1000, 1000 / INCH],
  ['over_tolerance_share', (candidate) => candidate.over_tolerance_share, 100, 100],
  ['uncut_share', (candidate) => candidate.uncut_share, 100, 100],
  ['uncut_height_mm', (candidate) => candidate.uncut_height_mm, 1000, 1000 / INCH],
  ['gouge_mm', (candidate) => candidate.gouge_mm, 1000, 1000 / INCH],
  ['used_share', (candidate) => candidate.used_share, 100, 100],
];
const TIMES = [['machining_time_s', (candidate) => candidate.machining_time_s], ['least_time_s', (candidate) => candidate.least_time_s], ['rectangle_time_s', (candidate) => candidate.rectangle.machining_time_s]];

/** The ranking shown is that of the answer; the texts are right in mm or inch. */
function assertRanking(rows, { candidates }, isInch) {
  assert.deepEqual(rows.map(([cutter]) => cutter), candidates.map(({ cutter }) => cutter));
  rows.forEach(([, shown], i) => {
    for (const [name, read, metric, inch] of FIGURES) assertFigure(shown[name], read(candidates[i]), isInch ? inch : metric, `${name} of row ${i}`);
    for (const [name, read] of TIMES) assert.equal(Number(shown[name][0]), read(candidates[i]), name);
  });
}

test('the ranking, the map and the downloads of an example are the service’s', async () => {
  const { page, watch } = await visit('#part');
  await choose(page, 'surface_1');
  const { answer } = await find(page);
  await page.locator('.ranking tbody tr').first().waitFor();
  assertRanking(await ranking(page), answer, false);
  await page.locator('#settings').getByText('inch').click();
  assertRanking(await ranking(page), answer, true);
  await page.locator('#settings').getByText('mm', { exact: true }).click();
  assert.equal(await page.locator('.headline [data-figure="recommended_time"]').getAttribute('value'), String(answer.recommended.machining_time_s));
  assert.ok(await page.locator('#view-part .uplot').isVisible());
  const confidence = await page.locator('.confidence').textContent();
  assert.ok(confidence.includes(answer.confidence.level));
  for (const { detail } of answer.confidence.reasons) assert.ok(confidence.includes(detail.slice(1)), detail);
  // The value under the cross is the raster's.
  const { columns, rows: count, cell_mm: cell, origin_mm: origin, z_mm: z, slope_deg: slope, scallop_height_mm: scallop } = answer.map;
  await page.locator('.map canvas').focus();
  await page.keyboard.press('ArrowRight');
  const [column, row] = [Math.floor(columns / 2) + 1, Math.floor(count / 2)];
  const index = row * columns + column;
  const readout = await page.locator('.map .readout').textContent();
  const [, x, y, height, angle, ridge] = /^X ([\d.-]+), Y ([\d.-]+), Z ([\d.-]+) mm · slope ([\d.]+)° · scallop ([\d.]+) µm/.exec(readout).map(Number);
  for (const [shown, expected] of [[x, origin[0] + (column + 0.5) * cell], [y, origin[1] + (row + 0.5) * cell], [height, z[index]], [angle, slope[index]], [ridge, scallop[index] * 1000]]) {
    assert.ok(Math.abs(shown - expected) <= 5.1e-4 * Math.abs(expected), `${readout}: ${expected}`);
  }
  for (const layer of ['Slope', 'Uncut', 'Height']) await page.locator('.map').getByText(layer, { exact: true }).click();
  await page.locator('.map').getByText('Turned').click();
  assert.deepEqual(JSON.parse(await downloaded(page, () => page.getByRole('button', { name: 'Download JSON' }).first().click())), answer);
  const csv = await downloaded(page, () => page.getByRole('button', { name: 'Download CSV', exact: true }).click());
  assert.equal(csv.trim().split('\n').length, answer.candidates.length + answer.not_ranked.length + 1);
  clean(watch);
});

test('cutters that are not ranked state why, and show what they cannot reach', async () => {
  const { page, watch } = await visit('#part');
  const { answer } = await find(page);
  assert.ok(answer.not_ranked.length >= 2 && answer.candidates.length >= 2);
  for (const { name, uncut_share: share, uncut_height_mm: height } of answer.not_ranked) {
    const item = page.locator('.not-ranked li').filter({ hasText: name });
    assert.match(await item.textContent(), /cannot reach/);
    assert.equal(await item.locator('[data-figure="uncut_share"]').getAttribute('value'), String(share));
    assert.equal(await item.locator('[data-figure="uncut_height_mm"]').getAttribute('value'), String(height));
  }
  await page.getByRole('button', { name: `Show the map of ${answer.not_ranked[0].name}` }).click();
  await page.locator('.not-ranked li').first().getByText('shown').waitFor();
  assert.ok((await page.locator('.map > .muted').textContent()).startsWith(answer.not_ranked[0].name));
  assert.ok(await page.locator('.map [data-field="layer"] input[value="uncut_mm"]').isChecked());
  // Back to the recommended cutter, without another request.
  await page.getByRole('button', { name: `Show the map of ${answer.recommended.name}` }).click();
  await page.locator('.ranking tbody tr').first().getByText('shown').waitFor();
  clean(watch);
});

test('where no cutter fits, the reasons and the maps are there', async () => {
  const { page, watch } = await visit('#part');
  await keepCutters(page, 0, 1);
  const { status, answer } = await find(page);
  assert.equal(status, 422);
  await page.locator('.problem .not-ranked li').nth(1).waitFor();
  await page.getByRole('button', { name: `Show the map of ${answer.not_ranked[1].name}` }).click();
  await page.locator('.map canvas').waitFor();
  await page.locator('.problem .not-ranked li').nth(1).getByText('shown').waitFor();
  clean(watch, { refused: true });
});

test('a tool library joins the cutters, beside an example and beside a file', async () => {
  const { page, watch } = await visit('#part');
  const library = fileOf('tools.csv', 'name,type,diameter_mm,corner_radius_mm\nL8,ball end,8,\nL12,bull nose,12,1\nD5,drill,5,\n');
  await page.locator('#library-file').setInputFiles(library);
  await page.locator('.chip').waitFor();
  await keepCutters(page);
  await choose(page, 'surface_2');
  const { answer } = await find(page);
  assert.deepEqual(new Set(answer.candidates.map(({ name }) => name)), new Set(['L8', 'L12']));
  assertRanking(await ranking(page), answer, false);
  // The drill is counted; of the example's file there is nothing to say.
  assert.deepEqual(answer.warnings.map(({ code }) => code), ['other-tools']);
  assert.match(await page.locator('.headline .warnings').textContent(), /Other tools/);
  // The second cutter of a library cannot be asked for alone.
  assert.equal(await page.locator('.ranking tbody tr').nth(1).getByRole('button').count(), 0);
  const surface = fileOf('hill.csv', `x,y,z\n${Array.from({ length: 900 }, (_, i) => [i % 30, Math.floor(i / 30), 4 * Math.sin((i % 30) / 9)].join(',')).join('\n')}\n`);
  await page.locator('#surface-file').setInputFiles(surface);
  const ofFile = (await find(page)).answer;
  assert.equal(ofFile.surface.source, 'text');
  await page.getByRole('button', { name: 'Copy as curl' }).click();
  const command = await page.evaluate(() => navigator.clipboard.readText());
  assert.equal(JSON.parse(await shell(`cd ${folder}; ${command}`)).recommended.machining_time_s, ofFile.recommended.machining_time_s);
  const broken = fileOf('tools.json', '{"data": [{"type": "ball end mill"');
  await page.locator('#library-file').setInputFiles(broken);
  assert.equal((await find(page)).status, 400);
  await page.locator('.library + .fault').waitFor();
  clean(watch, { refused: true });
});

test('slope band, box and pieces select what is machined', async () => {
  const { page, watch } = await visit('#part');
  await keepCutters(page, 4);
  const whole = await find(page);
  await page.getByText('Machine only a part of it').click();
  await field(page, 'select_slope_to_deg').fill('20');
  await field(page, 'pieces_selected').fill('0');
  // A drag over the map chooses the box.
  await page.locator('.map canvas').scrollIntoViewIfNeeded();
  const canvas = await page.locator('.map canvas').boundingBox();
  await page.locator('.map canvas').hover({ position: { x: canvas.width * 0.2, y: canvas.height * 0.2 } });
  await page.mouse.down();
  await page.mouse.move(canvas.x + canvas.width * 0.6, canvas.y + canvas.height * 0.7, { steps: 4 });
  await page.mouse.up();
  await page.locator('.stale').waitFor();
  const { request, answer } = await find(page);
  const { slope_deg: band, pieces, box_mm: box } = request.postDataJSON().select;
  assert.deepEqual([band, pieces], [[0, 20], [0]]);
  for (const [axis, low, high] of [[0, 18, 54], [1, 18, 48]]) {
    assert.ok(Math.abs(box.min[axis] - low) < 2 && Math.abs(box.max[axis] - high) < 2, `${JSON.stringify(box)}`);
  }
  assert.ok(answer.recommended.machining_time_s < whole.answer.recommended.machining_time_s / 2);
  assert.ok(!(await page.locator('.stale').isVisible()));
  await page.getByText('not machined, or uncut').waitFor();
  await field(page, 'select_slope_from_deg').fill('50');
  await find(page);
  await page.locator('[data-field="select_slope_to_deg"] .fault').waitFor();
  clean(watch, { refused: true });
});

test('the link and the curl command of the part view hold fields and cutters', async () => {
  const { page } = await visit('#part');
  await keepCutters(page, 1, 3);
  await page.getByText('Method and limits').click();
  await field(page, 'directions_deg').fill('0, 45');
  await page.waitForFunction(() => location.hash.includes('directions_deg=0'));
  const { request, answer } = await find(page);
  const { page: other } = await visit(await page.evaluate(() => location.hash));
  await other.locator('.cutter-row').nth(1).waitFor();
  assert.deepEqual((await find(other)).request.postDataJSON(), request.postDataJSON());
  assert.deepEqual(request.postDataJSON().directions_deg, [0, 45]);
  // The command states all points of the example, and can be run.
  await page.getByRole('button', { name: 'Copy as curl' }).click();
  const command = fileOf('request.sh', await page.evaluate(() => navigator.clipboard.readText()));
  assert.equal(JSON.parse(await shell(`sh ${command}`)).recommended.machining_time_s, answer.recommended.machining_time_s);
});

test('the passes are drawn, downloaded, and read by the tool path view', async () => {
  const { page, watch } = await visit('#part');
  await choose(page, 'surface_2');
  await keepCutters(page, 2);
  // Few passes: each point has its own step-over and height.
  await field(page, 'tolerance_of_plan').fill('200');
  await page.locator('#view-part').getByText('Point by point').click();
  const { passes } = (await find(page)).answer;
  const text = await downloaded(page, () => page.getByRole('button', { name: 'Download passes as CSV' }).click());
  assert.equal(text.trim().split('\n').length, passes.tip_mm.length + 1);
  await page.getByRole('button', { name: 'Open passes as a tool path' }).click();
  await page.locator('[data-figure="contacts"]').waitFor();
  assert.equal(await page.locator('[data-figure="contacts"]').getAttribute('value'), String(passes.tip_mm.length));
  // A point whose tip was raised has no contact, and no answer.
  const raised = passes.contact_mm.filter((contact) => contact === null).length;
  assert.ok(Number(await page.locator('[data-figure="failures"]').getAttribute('value')) >= raised);
  // The cutter came along: B10.
  assert.ok(await page.locator('#view-path [data-field="type"] input[value="ball_end"]').isChecked());
  assert.equal(await field(page, 'diameter_mm').inputValue(), '10');
  assert.ok(await page.locator('#view-path [data-field="question"] input[value="height"]').isChecked());
  clean(watch);
});

test('a direction that is clicked in the chart is planned alone', async () => {
  const { page, watch } = await visit('#part');
  await choose(page, 'surface_1');
  await keepCutters(page, 2);
  const { answer } = await find(page);
  const chart = page.locator('#view-part .u-over');
  const { width, height } = await chart.boundingBox();
  await chart.click({ position: { x: width / 2, y: height / 2 } });
  const { request, answer: again } = await find(page);
  const [direction] = request.postDataJSON().directions_deg;
  assert.ok(direction > 60 && direction < 120, `${direction}`);
  assert.equal(again.recommended.direction_deg, direction);
  const { by_direction: { direction_deg: directions, machining_time_s: times } } = answer.candidates[0];
  // Alone it is milled; together with others only the best three are, and its time is an estimate.
  assert.ok(Math.abs(again.recommended.machining_time_s / times[directions.indexOf(direction)] - 1) < 0.15);
  clean(watch);
});

test('a wrong cutter is marked in its row', async () => {
  const { page } = await visit('#part');
  await page.locator('.cutter-row').nth(1).locator('[data-field="corner_radius_mm"] input').fill('9');
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  const fault = page.locator('.cutter-row').nth(1).locator('[data-field="corner_radius_mm"] .fault');
  await fault.waitFor();
  assert.match(await fault.textContent(), /corner radius/);
  assert.ok(await page.locator('.cutter-row').nth(1).locator('[data-field="corner_radius_mm"] input').evaluate((input) => input === document.activeElement));
});

test('a fault of a field in a closed group opens the group', async () => {
  const { page } = await visit('#part?max_slope_deg=120&tolerance_of_plan=0.01&machine=vmc');
  assert.ok(!(await field(page, 'max_slope_deg').isVisible()));
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('[data-field="max_slope_deg"] .fault').waitFor();
  assert.ok(await field(page, 'max_slope_deg').isVisible());
});

test('a broken file is refused with the line, at the file', async () => {
  const { page } = await visit('#part');
  await page.locator('#surface-file').setInputFiles(fileOf('broken.csv', 'x,y,z\n1,2,3\n1,broken,3\n'));
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('#file-fault').waitFor();
  assert.match(await page.locator('#file-fault').textContent(), /line 3/);
  assert.ok(!(await page.locator('.ranking').isVisible()));
});

test('a file of a million facets leaves the page responsive, and its upload can be cancelled', async (t) => {
  const { page, watch } = await visit('#part');
  await page.locator('#surface-file').setInputFiles(writeStl(1_000_000));
  // Ball ends small enough for its valleys.
  await keepCutters(page, 3, 4);
  await page.evaluate(() => {
    globalThis.tasks = [];
    new PerformanceObserver((list) => globalThis.tasks.push(...list.getEntries().map(({ duration }) => duration))).observe({ entryTypes: ['longtask'] });
    globalThis.progress = [];
    new MutationObserver(() => globalThis.progress.push(document.querySelector('.progress span').textContent)).observe(document.querySelector('.progress'), { childList: true, subtree: true, characterData: true });
  });
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.getByRole('button', { name: 'Cancel' }).click();
  await page.locator('.progress').waitFor({ state: 'hidden' });
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
  const { tasks, progress } = await page.evaluate(() => ({ tasks: globalThis.tasks, progress: globalThis.progress }));
  const longest = Math.max(0, ...tasks);
  t.diagnostic(`answered after ${((Date.now() - begun) / 1000).toFixed(1)} s; longest task of the page ${longest.toFixed(0)} ms`);
  assert.ok(longest < 2000, `the page stood still for ${longest} ms`);
  assert.ok(progress.some((text) => /% sent/.test(text)), `progress: ${progress}`);
  clean(watch);
});
