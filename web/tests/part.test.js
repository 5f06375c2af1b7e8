// The part view: surfaces, cutters and libraries in; the ranking, the map and downloads out.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { assertFigure, clean, downloaded, field, fileOf, folder, graveFaults, longestFrame, shell, startForTests, writeStl } from './harness.js';

const { bench, visit } = startForTests();

const INCH = 25.4;

/** Finds the cutter; returns the request and the service's answer to it. */
async function find(page, timeout = 120_000) {
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

const choose = (page, name) => page.locator('#view-part [data-field="example"] select').selectOption(name);

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
  ['ra_um', (candidate) => candidate.ra_um, 1, 1000 / INCH, 3],
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
    for (const [name, read, metric, inch, digits] of FIGURES) assertFigure(shown[name], read(candidates[i]), isInch ? inch : metric, `${name} of row ${i}`, digits);
    for (const [name, read] of TIMES) assert.equal(Number(shown[name][0]), read(candidates[i]), name);
  });
}

test('the first view of a part shows a computed example', async () => {
  const { page, watch } = await visit('#part');
  await page.locator('.ranking tbody tr').first().waitFor({ timeout: 60_000 });
  assert.ok(await page.locator('#view-part .map canvas:not(.solid)').isVisible());
  clean(watch);
});

test('the ranking, the map and the downloads of an example are the service’s', async () => {
  const { page, watch } = await visit('#part?method=surface');
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
  await page.locator('#view-part .map canvas:not(.solid)').focus();
  await page.keyboard.press('ArrowRight');
  const [column, row] = [Math.floor(columns / 2) + 1, Math.floor(count / 2)];
  const index = row * columns + column;
  const readout = await page.locator('#view-part .map .readout').textContent();
  const [, x, y, height, angle, ridge] = /^X ([\d.-]+), Y ([\d.-]+), Z ([\d.-]+) mm · slope ([\d.]+)° · scallop ([\d.]+) µm/.exec(readout).map(Number);
  for (const [shown, expected] of [[x, origin[0] + (column + 0.5) * cell], [y, origin[1] + (row + 0.5) * cell], [height, z[index]], [angle, slope[index]], [ridge, scallop[index] * 1000]]) {
    assert.ok(Math.abs(shown - expected) <= 5.1e-4 * Math.abs(expected), `${readout}: ${expected}`);
  }
  for (const layer of ['Slope', 'Uncut', 'Height']) await page.locator('#view-part .map').getByText(layer, { exact: true }).click();
  await page.locator('#view-part .map').getByText('3D', { exact: true }).click();
  await page.locator('#view-part canvas.solid[data-shown]').waitFor();
  assert.deepEqual(JSON.parse(await downloaded(page, () => page.getByRole('button', { name: 'Download JSON' }).first().click())), answer);
  const csv = await downloaded(page, () => page.getByRole('button', { name: 'Download CSV', exact: true }).click());
  assert.equal(csv.trim().split('\n').length, answer.candidates.length + answer.not_ranked.length + 1);
  clean(watch);
});

test('cutters that are not ranked state why, and show what they cannot reach', async () => {
  const { page, watch } = await visit('#part?method=surface');
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
  assert.ok((await page.locator('#view-part .map > .muted').textContent()).startsWith(answer.not_ranked[0].name));
  assert.ok(await page.locator('#view-part .map [data-field="layer"] input[value="uncut_mm"]').isChecked());
  // Back to the recommended cutter, without another request.
  await page.getByRole('button', { name: `Show the map of ${answer.recommended.name}` }).click();
  await page.locator('.ranking tbody tr').first().getByText('shown').waitFor();
  clean(watch);
});

test('where no cutter fits, the reasons and the maps are there', async () => {
  const { page, watch } = await visit('#part?method=surface');
  await keepCutters(page, 0, 1);
  const { status, answer } = await find(page);
  assert.equal(status, 422);
  await page.locator('.problem .not-ranked li').nth(1).waitFor();
  await page.getByRole('button', { name: `Show the map of ${answer.not_ranked[1].name}` }).click();
  await page.locator('#view-part .map canvas:not(.solid)').waitFor();
  await page.locator('.problem .not-ranked li').nth(1).getByText('shown').waitFor();
  // The limit and the tightest hollow are stated, and one click takes the nearest cutter.
  const least = answer.needed_max_uncut_share;
  assert.equal(await page.locator('.remedies [data-figure="needed_max_uncut_share"]').getAttribute('value'), String(least));
  assert.equal(await page.locator('.remedies [data-figure="smallest_concave_radius_mm"]').getAttribute('value'), String(answer.smallest_concave_radius_mm));
  const ball = await page.getByRole('button', { name: /^Add a ball under R / }).textContent();
  assert.ok(Number.parseFloat(/: ([\d.]+)/.exec(ball)[1]) < 2 * answer.smallest_concave_radius_mm, ball);
  const remedy = page.getByRole('button', { name: /^Allow [\d.]+ % uncut/ });
  assert.match(await page.locator('.remedies').textContent(), /may leave 0\.5 %/);
  assert.ok(Number.parseFloat((await remedy.textContent()).slice(6)) >= 100 * least);
  const again = page.waitForResponse((response) => response.url().includes('cutter-recommendation'));
  await remedy.click();
  assert.equal((await again).status(), 200);
  await page.locator('.ranking tbody tr').first().waitFor();
  clean(watch, { refused: true });
});

test('a file is sent once for the maps of all its cutters, ranked or not', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.05');
  // A slope with a groove of radius 4 mm at its bottom, into which the larger cutters do not fit.
  const height = (x, y) => 0.2 * y - 2 * Math.exp(-(((x - 20) / 4) ** 2));
  const side = 41;
  const points = Array.from({ length: side * 21 }, (_, i) => [i % side, Math.floor(i / side)]);
  await page.locator('#surface-file').setInputFiles(fileOf('groove.csv', `x,y,z\n${points.map(([x, y]) => [x, y, height(x, y)].join(',')).join('\n')}\n`));
  const { answer } = await find(page);
  assert.ok(answer.not_ranked.length > 0 && answer.candidates.length > 1, JSON.stringify(answer.not_ranked));
  const asked = [];
  page.on('request', (each) => each.url().includes('cutter-recommendation') && asked.push(each));
  for (const { name, cutter } of [...answer.candidates.slice(1), ...answer.not_ranked]) {
    await page.getByRole('button', { name: `Show the map of ${name}` }).click();
    await page.locator(`[data-cutter="${cutter}"]`).getByText('shown').waitFor();
    assert.ok((await page.locator('#view-part .map > .muted').textContent()).startsWith(name));
    assert.ok(await page.locator('#view-part .map [data-field="layer"] input[value="uncut_mm"]').isChecked());
  }
  assert.deepEqual(asked, []);
  // The values under the cross are those of the cutter's map.
  const { cutter } = answer.not_ranked.at(-1);
  const { columns, rows } = answer.map;
  const middle = Math.floor(rows / 2) * columns + Math.floor(columns / 2);
  await page.locator('#view-part .map canvas:not(.solid)').focus();
  for (const key of ['ArrowRight', 'ArrowLeft']) await page.keyboard.press(key);
  const uncut = answer.maps.find((map) => map.cutter === cutter).uncut_mm[middle];
  assert.ok(uncut > 0.05, String(uncut));
  assert.ok((await page.locator('#view-part .readout').textContent()).includes(`uncut ${Number((1000 * uncut).toPrecision(4)).toFixed(uncut >= 1 ? 0 : 1)}`), await page.locator('#view-part .readout').textContent());
  clean(watch);
});

test('a plan of several operations has its table, its colours, its program with tool calls, and its check', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.2&operations=2&tool_change_s=0&directions_deg=0&max_uncut_share=0.1');
  const height = (x, y) => Math.min(9, Math.max(0, 1.3 * (12 - Math.hypot(x - 20, y - 20))));
  const side = 41;
  const points = Array.from({ length: side * side }, (_, i) => [i % side, Math.floor(i / side)]);
  await page.locator('#surface-file').setInputFiles(fileOf('cone.csv', `x,y,z\n${points.map(([x, y]) => [x, y, height(x, y)].join(',')).join('\n')}\n`));
  await keepCutters(page, 1, 3);
  const { answer } = await find(page);
  const { plan } = answer;
  assert.equal(plan.operations.length, 2, JSON.stringify(plan));
  const rows = page.locator('.operations tbody tr');
  assert.equal(await rows.count(), 2);
  for (const [i, operation] of plan.operations.entries()) {
    const shown = rows.nth(i);
    assert.equal(Number(await shown.locator('[data-figure="machining_time_s"]').getAttribute('value')), operation.machining_time_s);
    assert.ok((await shown.textContent()).includes(operation.family.replace('_', ' ')));
  }
  assert.equal(Number(await page.locator('[data-figure="operations_time"]').getAttribute('value')), plan.machining_time_s);
  await page.locator('#view-part [data-field="path"]').getByText('On', { exact: true }).click();
  assert.equal(await page.locator('#view-part .map-legend .colour-key').filter({ hasText: /^[12]: / }).count(), 2);
  const program = await downloaded(page, () => page.getByRole('button', { name: 'Download program' }).click());
  assert.equal(program, answer.program.text);
  assert.equal([...program.matchAll(/^T\d+ M6$/gm)].length, 2);
  const checked = page.waitForResponse((response) => response.url().includes('path-check'), { timeout: 120_000 });
  await page.getByRole('button', { name: 'Check the program' }).click();
  const response = await checked;
  assert.equal(response.status(), 200, await response.text());
  // Another operation is checked with its own tool: nothing is cut into the part.
  assert.ok((await response.json()).gouge.depth_mm < 0.05);
  clean(watch);
});

test('Ra of the drawing stands for the tolerance, and what another cutter leaves is planned alone', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_form=ra&ra_um=6.4&allowance=2');
  await choose(page, 'surface_1');
  const { answer, request } = await find(page);
  assert.deepEqual(request.postDataJSON().roughness, { ra_um: 6.4, allowance: 2 });
  assert.equal(request.postDataJSON().scallop_tolerance_mm, undefined);
  assert.equal(await page.locator('.headline [data-figure="ra_um"]').getAttribute('value'), String(answer.candidates[0].ra_um));
  // Ra = 4 h/(9 sqrt 3), with half of it for the real surface: 12.47 um.
  assert.match(await page.locator('.verdict').textContent(), /tolerance of 12\.47 µm/);
  const { page: other, watch: ofOther } = await visit('#part?method=surface&tolerance_of_plan=0.1&rest_of_type=ball_end&rest_of_diameter_mm=16');
  await keepCutters(other, 4);
  const rest = await find(other);
  assert.deepEqual(rest.request.postDataJSON().rest_of, { cutter: { type: 'ball_end', diameter_mm: 16 } });
  assert.equal(await other.locator('.headline [data-figure="rest_area_share"]').getAttribute('value'), String(rest.answer.rest_area_share));
  // The cutter before may have any shape.
  await other.locator('details', { has: other.locator('[data-field="rest_of_type"]') }).evaluate((group) => group.setAttribute('open', ''));
  await other.locator('[data-field="rest_of_type"] select').selectOption('lens');
  await field(other, 'rest_of_lens_radius_mm').fill('30');
  const { request: afterLens } = await find(other);
  assert.deepEqual(afterLens.postDataJSON().rest_of, { cutter: { type: 'lens', diameter_mm: 16, lens_radius_mm: 30, corner_radius_mm: 2 } });
  clean(watch);
  clean(ofOther);
});

test('the page states the service’s version, formats and limits', async () => {
  const { page, watch } = await visit('#part?method=surface');
  const about = await (await fetch(`${bench().address}v1/about`)).json();
  await page.getByText(`Version ${about.version}`).waitFor();
  const drop = await page.locator('.drop [data-file]').first().textContent();
  for (const format of about.surface_formats) assert.ok(drop.includes(format.toUpperCase()), drop);
  assert.ok(drop.includes(about.limits.facets.toLocaleString('en')));
  clean(watch);
});

test('a tool library joins the cutters, beside an example and beside a file', async () => {
  const { page, watch } = await visit('#part?method=surface');
  const library = fileOf('tools.csv', 'name,type,diameter_mm,corner_radius_mm\nL8,ball end,8,\nL12,bull nose,12,1\nD5,drill,5,\n');
  await page.locator('#library-file').setInputFiles(library);
  await page.locator('.chip').waitFor();
  await choose(page, 'surface_2');
  const { answer } = await find(page);
  assert.deepEqual(new Set(answer.candidates.map(({ name }) => name)), new Set(['L8', 'L12']));
  assertRanking(await ranking(page), answer, false);
  assert.match(await page.locator('.chip').textContent(), /1 drill/);
  // The map of the second cutter is asked for alone.
  await page.locator('.ranking tbody tr').nth(1).getByRole('button').click();
  await page.locator('.ranking tbody tr').nth(1).getByText('shown').waitFor();
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
  const { page, watch } = await visit('#part?method=surface');
  await keepCutters(page, 4);
  const whole = await find(page);
  await page.getByText('Machine only a part of it').click();
  await field(page, 'select_slope_to_deg').fill('20');
  await field(page, 'pieces_selected').fill('0');
  // A drag over the map chooses the box.
  await page.locator('#view-part .map canvas:not(.solid)').scrollIntoViewIfNeeded();
  const canvas = await page.locator('#view-part .map canvas:not(.solid)').boundingBox();
  await page.locator('#view-part .map canvas:not(.solid)').hover({ position: { x: canvas.width * 0.2, y: canvas.height * 0.2 } });
  await page.mouse.down();
  await page.mouse.move(canvas.x + canvas.width * 0.6, canvas.y + canvas.height * 0.7, { steps: 4 });
  await page.mouse.up();
  await page.locator('.stale').waitFor();
  const { request, answer } = await find(page);
  const { slope_deg: band, pieces, box_mm: box } = request.postDataJSON().select;
  assert.deepEqual([band, pieces], [[0, 20], [0]]);
  for (const [axis, low, high] of [[0, 10.8, 32.4], [1, 10.8, 28.8]]) {
    assert.ok(Math.abs(box.min[axis] - low) < 2 && Math.abs(box.max[axis] - high) < 2, `${JSON.stringify(box)}`);
  }
  assert.ok(answer.recommended.machining_time_s < whole.answer.recommended.machining_time_s / 2);
  assert.ok(!(await page.locator('.stale').isVisible()));
  await page.locator('#view-part .map').getByText('not machined', { exact: true }).waitFor();
  await field(page, 'select_slope_from_deg').fill('50');
  await find(page);
  await page.locator('[data-field="select_slope_to_deg"] .fault').waitFor();
  clean(watch, { refused: true });
});

test('the link and the curl command of the part view hold fields and cutters', async () => {
  const { page } = await visit('#part?method=surface');
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

test('the passes of a library’s cutter are drawn, downloaded, and read by the tool path view', async () => {
  const { page, watch } = await visit('#part?method=surface');
  await choose(page, 'surface_2');
  await keepCutters(page, 2);
  await page.locator('#library-file').setInputFiles(fileOf('mills.csv', 'name,type,diameter_mm,teeth,spindle_speed_rpm,max_feed_per_tooth_mm\nL8,ball end,8,3,9000,0.12\n'));
  await page.locator('.chip').waitFor();
  // A library takes the place of the example cutters.
  assert.equal(await page.locator('.cutter-row').count(), 1);
  await field(page, 'tolerance_of_plan').fill('50');
  const { answer } = await find(page);
  await page.locator('#view-part .map [data-field="path"]').getByText('On').click();
  const asked = page.waitForResponse((response) => response.url().includes('cutter-recommendation'));
  const text = await downloaded(page, () => page.getByRole('button', { name: 'Download passes as CSV' }).click());
  const { passes } = await (await asked).json();
  const [header, ...rows] = text.trim().split('\n').map((line) => line.split(','));
  assert.equal(rows.length, passes.tip_mm.length);
  assert.equal(new Set(header).size, header.length);
  // The passes asked for apart are those of the program.
  assert.equal(answer.program.text.match(/^(?:G[01] )?[XYZ]/gm).length > passes.tip_mm.length * 0.9, true);
  await page.getByRole('button', { name: 'Open passes as a tool path' }).click();
  await page.locator('[data-figure="contacts"]').waitFor();
  const contacts = passes.contact_mm.filter((contact) => contact !== null).length;
  assert.equal(await page.locator('[data-figure="contacts"]').getAttribute('value'), String(contacts));
  assert.equal(await page.locator('[data-figure="moves_off"]').getAttribute('value'), String(passes.tip_mm.length - contacts));
  assert.equal(await page.locator('[data-figure="failures"]').getAttribute('value'), '0');
  // The library's cutter came along, with its speed and limits.
  assert.ok(await page.locator('#path-contacts [data-field="type"] input[value="ball_end"]').isChecked());
  for (const [name, value] of [['diameter_mm', '8'], ['teeth', '3'], ['spindle_speed_rpm', '9000'], ['max_feed_per_tooth_mm', '0.12'], ['max_feed_rate_mm_min', '5000']]) assert.equal(await field(page, name).inputValue(), value, name);
  // The feeds and heights along the path are the plan's.
  const csv = await downloaded(page, () => page.getByRole('button', { name: 'Download CSV with the answer' }).click());
  const [names, ...lines] = csv.trim().split('\n').map((line) => line.split(','));
  assert.equal(new Set(names).size, names.length);
  for (const [mine, theirs] of [['answer_feed_rate_mm_min', 'feed_rate_mm_min'], ['answer_scallop_height_mm', 'scallop_height_mm']]) {
    const [a, b] = [names.indexOf(mine), names.indexOf(theirs)];
    const off = lines.filter((cells) => cells[a] !== '' && Math.abs(cells[a] / cells[b] - 1) > 1e-3);
    assert.deepEqual(off.slice(0, 3), [], mine);
    assert.equal(lines.filter((cells) => cells[a] !== '').length, contacts);
  }
  clean(watch);
});

test('a cutter without teeth or speed is marked in the table and in the ranking', async () => {
  const { page, watch } = await visit('#part?method=surface');
  await choose(page, 'surface_2');
  await keepCutters(page, 2, 3);
  await page.locator('.cutter-row').nth(0).locator('[data-field="teeth"] input').fill('');
  await page.locator('.cutter-row').nth(0).getByText('feed assumed: no teeth').waitFor();
  const { answer } = await find(page);
  const assumed = answer.candidates.filter(({ feed }) => feed === 'assumed');
  assert.deepEqual(assumed.map(({ name }) => name), ['B10']);
  assert.ok(await page.locator('.ranking tbody tr').filter({ hasText: 'B10' }).getByText('feed assumed').isVisible());
  assert.match(await page.locator('.mixed-feeds').textContent(), /B10/);
  clean(watch);
});

test('an unticked cutter is not sent, a filter finds tools, and the others are ranked beside a faulty one', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.1');
  await choose(page, 'surface_2');
  const tools = Array.from({ length: 12 }, (_, i) => `M${i + 1},${i % 2 ? 'bull nose' : 'ball end'},${i + 3},${i % 2 ? 1 : ''},4,8000`);
  await page.locator('#library-file').setInputFiles(fileOf('many.csv', `name,type,diameter_mm,corner_radius_mm,teeth,spindle_speed_rpm\n${tools.join('\n')}\nBad,ball end,-4,,2,\n`));
  await page.locator('.chip').waitFor();
  await page.getByRole('button', { name: 'Untick shown' }).click();
  await page.getByLabel('Filter the cutters').fill('6-8');
  assert.equal(await page.locator('.cutter-row').count(), 3);
  await page.getByRole('button', { name: 'Tick shown', exact: true }).click();
  assert.match(await page.locator('.cutter-tools').textContent(), /3 of 13 ticked/);
  await page.getByLabel('Filter the cutters').fill('bad');
  await page.getByRole('button', { name: 'Tick shown', exact: true }).click();
  assert.equal((await find(page)).status, 422);
  await page.locator('.cutter-row').filter({ has: page.locator('.fault:visible') }).waitFor();
  const answered = page.waitForResponse((response) => response.url().includes('cutter-recommendation'), { timeout: 240_000 });
  await page.getByRole('button', { name: 'Rank the others' }).click();
  assert.deepEqual((await answered).request().postDataJSON().cutters.map(({ name }) => name), ['M4', 'M5', 'M6']);
  await page.locator('.ranking tbody tr').first().waitFor();
  clean(watch, { refused: true });
});

test('tools that the page reads from libraries are ranked as the service ranks the libraries', async () => {
  const { page, watch } = await visit('#part?method=surface');
  const surface = fileOf('slope.csv', `x,y,z\n${Array.from({ length: 400 }, (_, i) => [i % 20, Math.floor(i / 20), 3 * Math.sin((i % 20) / 9)].join(',')).join('\n')}\n`);
  await page.locator('#surface-file').setInputFiles(surface);
  const fusion = { data: [
    { type: 'ball end mill', unit: 'inches', description: '3/8 ball', geometry: { DC: 0.375, NOF: 4, LCF: 1 }, 'start-values': { presets: [{ name: 'Rough', n: 4000, v_f: 40, f_z: 0.0025 }, { name: 'Finishing', n: 9000, v_f: 90 }] } },
    { type: 'bull nose end mill', unit: 'millimeters', description: 'D10 R1', geometry: { DC: 10, RE: 1, NOF: 4, LCF: 22 }, 'start-values': { presets: [{ name: 'Default', n: 8000, f_z: 0.08 }] } },
    { type: 'bull nose end mill', unit: 'millimeters', description: 'D8 R4', geometry: { DC: 8, RE: 4, NOF: 2 } },
    { type: 'face mill', unit: 'millimeters', description: 'F50', geometry: { DC: 50 } },
  ] };
  const freecad = { name: 'T10', 'shape-type': 'torus', parameter: { Diameter: '10.00 mm', FlatRadius: '3.00 mm', Flutes: '4', Chipload: '0.05 mm' } };
  const csv = 'sep=;\nTool name;Tool type;Dia (mm);Corner Radius [mm];Flutes;RPM\n"B 6; long";Ball Nose;6,0;;2;12000\n';
  const files = [['tools.json', JSON.stringify(fusion)], ['t10.fctb', JSON.stringify(freecad)], ['mills.csv', csv]].map(([name, text]) => fileOf(name, text));
  await page.locator('#library-file').setInputFiles(files);
  await page.locator('.chip').nth(2).waitFor();
  const { answer } = await find(page);
  const parameters = { scallop_tolerance_mm: 0.01, machine: { preset: 'five_axis_vmc' } };
  const sent = JSON.parse(await shell(`curl -sS ${bench().address}v1/cutter-recommendation/upload -F surface=@${surface} ${files.map((file) => `-F library=@${file}`).join(' ')} --form-string 'parameters=${JSON.stringify(parameters)}'`));
  const essence = ({ candidates, not_ranked: others }) => [candidates.map(({ name, type, feed, machining_time_s: time }) => [name, type, feed, Number(time.toPrecision(9))]), others.map(({ name }) => name)];
  assert.deepEqual(essence(answer), essence(sent));
  assert.match(await page.locator('.library').textContent(), /1 face mill/);
  clean(watch);
});

test('a plan that is kept stands beside the next one, with the difference in time, and the slider tries tolerances', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.1');
  await choose(page, 'surface_2');
  await keepCutters(page, 2);
  const first = (await find(page)).answer.candidates[0];
  await page.getByRole('button', { name: 'Keep this plan' }).click();
  await field(page, 'tolerance_of_plan').fill('200');
  const second = (await find(page)).answer.candidates[0];
  const row = page.locator('.kept tr[data-row="machining_time_s"]');
  assert.deepEqual(await row.locator('data').evaluateAll((all) => all.map(({ value }) => Number(value))), [second.machining_time_s, first.machining_time_s]);
  assert.match(await row.textContent(), new RegExp(`\\+${(100 * (first.machining_time_s / second.machining_time_s - 1)).toFixed(1)} %`));
  assert.match(await page.locator('.kept').textContent(), /tolerance 100\.0 µm/);
  await page.locator('.kept').getByRole('button', { name: 'map' }).click();
  await page.locator('.map').getByText(/^Kept: B10/).waitFor();
  // The slider is there where an answer takes under a second.
  if (await page.locator('.slider input').isVisible()) {
    const answered = page.waitForResponse((response) => response.url().includes('cutter-recommendation'));
    await page.locator('.slider input').focus();
    await page.keyboard.press('ArrowLeft');
    const { scallop_tolerance_mm: tolerance } = (await answered).request().postDataJSON();
    assert.ok(tolerance < 0.2, `${tolerance}`);
    assert.equal(await field(page, 'tolerance_of_plan').inputValue(), String(Number((tolerance * 1000).toPrecision(7))));
  }
  clean(watch);
});

test('the setup sheet is a page with part, cutter, plan, figures and drawing', async () => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.1');
  await choose(page, 'surface_2');
  await keepCutters(page, 1);
  const { answer } = await find(page);
  await page.getByRole('button', { name: 'Setup sheet' }).click();
  const sheet = page.locator('dialog.sheet');
  const text = await sheet.textContent();
  for (const part of ['Wavy patch', 'T10', 'Bull nose', '10 mm', 'Within tolerance', 'G17 G21', `${answer.candidates[0].passes}`]) assert.ok(text.includes(part), part);
  assert.ok((await sheet.locator('img').evaluate((image) => image.naturalWidth)) > 200);
  assert.deepEqual(await graveFaults(page), []);
  // It fits on one sheet of paper.
  const pdf = (await page.pdf({ preferCSSPageSize: true, printBackground: true })).toString('latin1');
  assert.equal(pdf.match(/\/Type\s*\/Page\b/g).length, 1);
  await sheet.getByRole('button', { name: 'Close' }).click();
  // The dialog's event of closing removes it.
  await sheet.waitFor({ state: 'detached' });
  clean(watch);
});

test('from a part and a library to a program on disk in four clicks', async () => {
  const { page, watch } = await visit('#part?method=surface');
  // Choosing a file is a click on its button.
  await page.locator('#surface-file').setInputFiles(fileOf('slope.csv', `x,y,z\n${Array.from({ length: 400 }, (_, i) => [i % 20, Math.floor(i / 20), 3 * Math.sin((i % 20) / 9)].join(',')).join('\n')}\n`));
  await page.locator('#library-file').setInputFiles(fileOf('mills.csv', 'name,type,diameter_mm,teeth,spindle_speed_rpm\nL8,ball end,8,3,9000\nL6,ball end,6,3,12000\n'));
  await page.locator('.chip').waitFor();
  await find(page);
  const program = await downloaded(page, () => page.getByRole('button', { name: 'Download program' }).click());
  assert.match(program, /^%\nG17 G21 G90 G94\n\(L[68]\)\nT1 M6\n/);
  // Header and tool number are those of the shop; the plan is asked for once more, alone.
  await page.locator('#view-part summary').filter({ hasText: /^Program/ }).click();
  await field(page, 'program_tool').fill('7');
  await page.locator('[data-field="program_header"] textarea').fill('(PART 4711)\nG54');
  const again = await downloaded(page, () => page.getByRole('button', { name: 'Download program' }).click());
  assert.match(again, /\(PART 4711\)\nG54\n/);
  assert.match(again, /\nT7 M6\n/);
  assert.equal(again.split('\n').filter((line) => /^(G[01] )?[XYZ]/.test(line)).join('\n'), program.split('\n').filter((line) => /^(G[01] )?[XYZ]/.test(line)).join('\n'));
  // The same moves in Klartext, which the page reads as well.
  await page.locator('[data-field="program_header"] textarea').fill('; PART 4711');
  await page.locator('[data-field="program_dialect"] select').selectOption('klartext');
  const klartext = await downloaded(page, () => page.getByRole('button', { name: 'Download program' }).click());
  assert.match(klartext, /^BEGIN PGM FINISH MM\n; PART 4711\n; L[68]\nTOOL CALL 7 Z S\d+\nM3\n/);
  const moves = (text) => page.evaluate(async (program) => {
    const { movesOf, toolCalls } = await import('./workbench/part/program.js');
    const { x, y, z, isRapid, operation, count } = movesOf(program);
    return [toolCalls(program), ...[x, y, z, isRapid, operation].map((column) => [...column.slice(0, count)])];
  }, text);
  assert.deepEqual(await moves(klartext), await moves(again));
  clean(watch);
});

test('a direction that is clicked in the chart is planned alone', async () => {
  const { page, watch } = await visit('#part?method=surface');
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
  const { page } = await visit('#part?method=surface');
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
  const { page } = await visit('#part?method=surface');
  await page.locator('#surface-file').setInputFiles(fileOf('broken.csv', 'x,y,z\n1,2,3\n1,broken,3\n'));
  await page.getByRole('button', { name: 'Find the cutter' }).click();
  await page.locator('#file-fault').waitFor();
  assert.match(await page.locator('#file-fault').textContent(), /line 3/);
  assert.ok(!(await page.locator('.ranking').isVisible()));
});

test('a file of a million facets leaves the page responsive, and its upload can be cancelled', async (t) => {
  const { page, watch } = await visit('#part?method=surface&tolerance_of_plan=0.05');
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
  const answered = page.waitForResponse((response) => response.url().includes('/upload'), { timeout: 300_000 });
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
  const answer = `answered after ${((Date.now() - begun) / 1000).toFixed(1)} s`;
  const frame = await longestFrame(page, page.locator('#view-part .map canvas:not(.solid)').first());
  t.diagnostic(`${answer}; longest task of the page ${longest.toFixed(0)} ms; longest frame while the mouse moves over the map ${frame.toFixed(0)} ms`);
  assert.ok(longest < 2000, `the page stood still for ${longest} ms`);
  assert.ok(progress.some((text) => /% sent/.test(text)), `progress: ${progress}`);
  clean(watch);
});
