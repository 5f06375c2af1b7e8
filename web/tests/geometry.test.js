// The page's own mathematics and text handling, without a browser: the cutter's profile, frames, units, links and tables.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { anglesOf, frameOfAngles, frameOfVectors } from '../contact/frame.js';
import { Profile, grooveCurvature } from '../contact/profile.js';
import { fragmentOf, readFragment } from '../link.js';
import { examplePath } from '../path/example.js';
import { TableFault, contactsOf, readTable, withColumns } from '../path/table.js';
import { format, formatInput, parseInput, setUnits } from '../units.js';

// R = 5, r = 2: [slope, feed angle, step-over, height in um], computed by brute-force simulation to 1 nm.
const CUSPS = [[40, 0, 0.73, 10.006], [40, 90, 0.4, 10.025], [5, 0, 2, 14.065], [1, 0, 3.7, 10.958], [0.5, 0, 5.27, 13.42], [0.2, 0, 5.9, 8.295], [0.01, 0, 6.4, 10.548], [85, 90, 0.4, 9.936], [89, 90, 0.4, 4.371]];

test('the drawn cusp has the height that a simulation of the cutter gives', () => {
  for (const [slope, angle, stepOver, expected] of CUSPS) {
    const { height } = new Profile(frameOfAngles(slope, angle), 5, 2).cusp(stepOver);
    // The published values are rounded to 0.001 um.
    assert.ok(Math.abs(height * 1000 - expected) < 0.00051, `${slope} ${angle}: ${height * 1000}`);
  }
});

test('a ball end draws a circle in every direction', () => {
  for (const [slope, angle] of [[0, 0], [30, 70], [60, 10], [90, 0]]) {
    const profile = new Profile(frameOfAngles(slope, angle), 4, 4);
    for (const x of [-0.5, 0, 0.3]) assert.ok(Math.abs(profile.heightAt(x) - (4 - Math.sqrt(16 - x * x))) < 1e-12, `${slope} ${angle} ${x}`);
  }
});

test('on a wall the side of the cutter leaves nothing', () => {
  const profile = new Profile(frameOfAngles(90, 90), 5, 2);
  const towardsTheShank = profile.axis[0] > 0 ? 3 : -3;
  assert.ok(Math.abs(profile.heightAt(towardsTheShank)) < 1e-12);
});

test('a flat floor lies under the flat of a toroidal cutter', () => {
  const profile = new Profile(frameOfAngles(0, 30), 5, 2);
  assert.ok(Math.abs(profile.heightAt(2.9)) < 1e-6);
  assert.ok(Math.abs(profile.heightAt(4) - (2 - Math.sqrt(3))) < 1e-6);
});

test('angles and vectors give the same frame', () => {
  for (const [slope, angle] of [[40, 30], [10, 170], [80, 95], [0.5, 3]]) {
    const frame = frameOfAngles(slope, angle);
    const again = anglesOf(frameOfVectors(frame.n, frame.F.map((part, i) => part + 2 * frame.n[i])));
    assert.ok(Math.abs(again.slope - slope) < 1e-9 && Math.abs(((again.feedAngle - angle + 540) % 360) - 180) < 1e-9, `${slope} ${angle} ${JSON.stringify(again)}`);
  }
});

test('curvature across the feed alone enters the groove unchanged', () => {
  assert.equal(grooveCurvature(frameOfAngles(40, 30), 5, 2, { across: 0.02 }), 0.02);
  // Curvature along the feed changes an oblique groove, and one along the steepest line not.
  assert.notEqual(grooveCurvature(frameOfAngles(40, 30), 5, 2, { across: 0.02, along: 0.05 }), 0.02);
  assert.ok(Math.abs(grooveCurvature(frameOfAngles(40, 0), 5, 2, { across: 0.02, along: 0.05 }) - 0.02) < 1e-15);
});

test('what is typed in inches comes back as typed', () => {
  setUnits('inch');
  for (const typed of ['0.25', '0.0625', '0.375']) assert.equal(formatInput(parseInput(typed, 'length'), 'length'), typed);
  assert.equal(parseInput('0.5', 'length'), 12.7);
  assert.equal(format(25.4, 'length'), '1.000');
  setUnits('mm');
  assert.equal(parseInput('0,5', 'length'), 0.5);
  assert.equal(parseInput('ten', 'length'), 'ten');
  assert.equal(parseInput(' ', 'length'), undefined);
});

test('a link gives back the values that it was written from', () => {
  const values = { diameter_mm: 10, normal: '-0.64, 0, 0.77', cutters: [{ name: 'A & B', type: 'ball_end', diameter_mm: 6 }], type: 'toroidal' };
  const read = readFragment(fragmentOf('part', 'inch', values));
  assert.deepEqual(read, { view: 'part', units: 'inch', values });
});

test('tables are read with each separator, comments and decimal commas', async () => {
  for (const text of ['slope_deg,feed_angle_deg\n# note\n10.5,20\n', '\uFEFFslope_deg;feed_angle_deg\r\n10,5;20\r\n', 'slope_deg\tfeed_angle_deg\n10.5\t20\n', 'slope feed_angle\n10.5 20\n']) {
    const { contacts } = contactsOf(await readTable(text));
    assert.deepEqual(contacts, { slope_deg: [10.5], feed_angle_deg: [20] }, text);
  }
});

test('feeds come from positions within a run', async () => {
  const { contacts, distance } = contactsOf(await readTable('run,x,y,z,nx,ny,nz\n0,0,0,0,0,0,1\n0,3,4,0,0,0,1\n1,9,9,9,0,0,1\n1,9,9,8,0,0,1\n'));
  assert.deepEqual(contacts.feed, [[3, 4, 0], [3, 4, 0], [0, 0, -1], [0, 0, -1]]);
  assert.deepEqual(distance, [0, 5, 5, 6]);
});

test('faults of a table name the line', async () => {
  await assert.rejects(readTable('slope_deg,feed_angle_deg\n1,2\nx,3\n'), (fault) => fault instanceof TableFault && /Line 3, column slope_deg/.test(fault.message));
  await assert.rejects(readTable(''), TableFault);
  await assert.rejects(readTable('1,2\n3,4\n'), /first line must name the columns/);
  await assert.rejects(async () => contactsOf(await readTable('a,b\n1,2\n')), /needs slope_deg/);
});

test('a table gets its columns line by line', async () => {
  const table = await readTable('slope_deg,feed_angle_deg\n1,2\n\n3,4\n');
  assert.equal(withColumns(table, { feed_rate_mm_min: [100, null] }), 'slope_deg,feed_angle_deg,feed_rate_mm_min\n1,2,100\n3,4,\n');
  assert.equal((await readTable(examplePath())).lines.length, 241);
});
