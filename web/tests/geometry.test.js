// The page's own mathematics and text handling, without a browser: the cutter's profile, frames, units, links and tables.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { test } from 'node:test';
import { anglesOf, dot, frameOfAngles, frameOfVectors } from '../contact/frame.js';
import { Profile, arcsOf, grooveCurvature, outlineOf } from '../contact/profile.js';
import { fragmentOf, readFragment } from '../link.js';
import { EXAMPLES, fileOfSurface } from '../part/examples.js';
import { Placement } from '../part/overlays.js';
import { fieldNameOf, parametersOf } from '../part/request.js';
import { examplePath } from '../path/example.js';
import { TableFault, contactsOf, readTable, withColumns } from '../path/table.js';
import { format, formatInput, formatTime, parseInput, setUnits } from '../units.js';

const torus = (R, r) => arcsOf({ type: 'toroidal', diameter_mm: 2 * R, corner_radius_mm: r });

// R = 5, r = 2: [slope, feed angle, step-over, height in um], computed by brute-force simulation to 1 nm.
const CUSPS = [[40, 0, 0.73, 10.006], [40, 90, 0.4, 10.025], [5, 0, 2, 14.065], [1, 0, 3.7, 10.958], [0.5, 0, 5.27, 13.42], [0.2, 0, 5.9, 8.295], [0.01, 0, 6.4, 10.548], [85, 90, 0.4, 9.936], [89, 90, 0.4, 4.371]];

test('the drawn cusp has the height that a simulation of the cutter gives', () => {
  for (const [slope, angle, stepOver, expected] of CUSPS) {
    const { height } = new Profile(frameOfAngles(slope, angle), torus(5, 2)).cusp(stepOver);
    // The published values are rounded to 0.001 um.
    assert.ok(Math.abs(height * 1000 - expected) < 0.00051, `${slope} ${angle}: ${height * 1000}`);
  }
});

test('a ball end draws a circle in every direction', () => {
  for (const [slope, angle] of [[0, 0], [30, 70], [60, 10], [90, 0]]) {
    const profile = new Profile(frameOfAngles(slope, angle), torus(4, 4));
    for (const x of [-0.5, 0, 0.3]) assert.ok(Math.abs(profile.heightAt(x) - (4 - Math.sqrt(16 - x * x))) < 1e-12, `${slope} ${angle} ${x}`);
  }
});

test('the drawn cusps of other shapes have the heights of their solids', () => {
  const { cases } = JSON.parse(readFileSync(new URL('../../tests/data/profile_cutters.json', import.meta.url), 'utf8'));
  const onPlanes = cases.filter(({ along_per_mm: along, across_per_mm: across }) => along === 0 && across === 0);
  for (const { cutter, slope_deg: slope, feed_angle_deg: angle, step_over_mm: stepOver, step_over_height_mm: height } of onPlanes) {
    const drawn = new Profile(frameOfAngles(slope, angle), arcsOf(cutter)).cusp(stepOver).height;
    // The file states 0.1 %.
    assert.ok(Math.abs(drawn / height - 1) < 1e-3, `${cutter.type} ${slope} ${angle}: ${drawn} for ${height}`);
  }
  assert.ok(onPlanes.length >= 10);
});

test('the outline of every shape ends at its radius and does not fall', () => {
  const shapes = [
    [{ type: 'tapered_ball', diameter_mm: 2, taper_deg: 5, shank_diameter_mm: 6 }, 3], [{ type: 'lens', diameter_mm: 16, lens_radius_mm: 40, corner_radius_mm: 1 }, 8],
    [{ type: 'oval', diameter_mm: 10, tip_radius_mm: 2, side_radius_mm: 80 }, 5], [{ type: 'conical_barrel', diameter_mm: 10, tip_radius_mm: 2, side_radius_mm: 250, taper_deg: 20 }, 5], [{ type: 'flat_end', diameter_mm: 6 }, 3],
    [{ type: 'profile', arcs: [{ radius_mm: 2, centre_offset_mm: 0, centre_height_mm: 2, from_deg: 0, to_deg: 60 }, { radius_mm: 0, centre_offset_mm: 4, centre_height_mm: 4.0221, from_deg: 60, to_deg: 90 }] }, 4],
  ];
  for (const [cutter, radius] of shapes) {
    const outline = outlineOf(arcsOf(cutter));
    assert.ok(Math.abs(outline.at(-1)[0] - radius) < 1e-12, cutter.type);
    for (let i = 1; i < outline.length; i += 1) assert.ok([0, 1].every((axis) => outline[i][axis] >= outline[i - 1][axis] - 1e-9), `${cutter.type} ${i}`);
  }
});

test('on a wall, the side of the cutter leaves no scallop', () => {
  const profile = new Profile(frameOfAngles(90, 90), torus(5, 2));
  const towardsTheShank = profile.axis[0] > 0 ? 3 : -3;
  assert.ok(Math.abs(profile.heightAt(towardsTheShank)) < 1e-12);
});

test('a flat floor lies under the flat of a toroidal cutter', () => {
  const profile = new Profile(frameOfAngles(0, 30), torus(5, 2));
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
  assert.equal(grooveCurvature(frameOfAngles(40, 30), torus(5, 2), { across: 0.02 }), 0.02);
  // Curvature along the feed changes an oblique groove, and one along the steepest line not.
  assert.notEqual(grooveCurvature(frameOfAngles(40, 30), torus(5, 2), { across: 0.02, along: 0.05 }), 0.02);
  assert.ok(Math.abs(grooveCurvature(frameOfAngles(40, 0), torus(5, 2), { across: 0.02, along: 0.05 }) - 0.02) < 1e-15);
});

// The groove of a surface curved in all directions, without the second-order step: for each slope q across the feed the slope p along it
// is solved for at which the height over the surface is least.
function exactCusp(frame, R, r, { along, across, twist }, stepOver) {
  const a = R - r;
  const boundary = (p, q) => {
    const length = Math.hypot(p, q, 1);
    const m = [0, 1, 2].map((i) => (p * frame.F[i] + q * frame.T[i] - frame.n[i]) / length);
    const level = Math.hypot(m[0], m[1]);
    const point = [(a / level + r) * m[0], (a / level + r) * m[1], r * m[2]];
    return [frame.F, frame.T, frame.n].map((axis) => dot(point, axis));
  };
  const origin = boundary(0, 0);
  const from = (p, q) => boundary(p, q).map((part, i) => part - origin[i]);
  const bisect = (low, high, below) => {
    for (let i = 0; i < 80; i += 1) {
      const middle = (low + high) / 2;
      if (below(middle)) low = middle;
      else high = middle;
    }
    return low;
  };
  const groove = (q) => {
    const p = bisect(-2, 2, (guess) => {
      const [x, y] = from(guess, q);
      return guess + along * x + twist * y < 0;
    });
    const [x, y, w] = from(p, q);
    return [y, w + (along * x * x + across * y * y) / 2 + twist * x * y];
  };
  const height = (y) => groove(bisect(-3, 3, (q) => groove(q)[0] < y))[1];
  return height(bisect(0, stepOver, (y) => height(y) < height(y - stepOver)));
}

test('the drawn cusp on a surface curved in all directions is within 1 % of the exact one', () => {
  for (const [R, r, slope, angle, curvature, stepOver] of [
    [8.4, 5.5, 27.7, 32.3, { along: -0.011, across: -0.026, twist: 0 }, 0.63],
    [6.1, 4.4, 50, 92.1, { along: 0.036, across: -0.007, twist: 0.013 }, 0.61],
    [4.3, 2.25, 66.4, 65.4, { along: 0.005, across: 0.007, twist: -0.01 }, 0.44],
  ]) {
    const frame = frameOfAngles(slope, angle);
    const drawn = new Profile(frame, torus(R, r)).cusp(stepOver, grooveCurvature(frame, torus(R, r), curvature)).height;
    const exact = exactCusp(frame, R, r, curvature, stepOver);
    assert.ok(Math.abs(drawn / exact - 1) < 0.01, `${slope} ${angle}: drawn ${drawn}, exact ${exact}`);
  }
});

test('a value typed in inches is shown as typed', () => {
  setUnits('inch');
  for (const typed of ['0.25', '0.0625', '0.375']) assert.equal(formatInput(parseInput(typed, 'length'), 'length'), typed);
  assert.equal(parseInput('0.5', 'length'), 12.7);
  assert.equal(format(25.4, 'length'), '1.000');
  setUnits('mm');
  assert.equal(parseInput('0,5', 'length'), 0.5);
  assert.equal(parseInput('ten', 'length'), 'ten');
  assert.equal(parseInput(' ', 'length'), undefined);
});

test('the times of a column have one form', () => {
  assert.equal(formatTime(71.2), '71.2 s');
  assert.equal(formatTime(146.4), '2:26 min');
  assert.equal(formatTime(59.7, 146.4), '1:00 min');
  assert.equal(formatTime(3725, 8000), '1:02:05 h');
  assert.equal(formatTime(undefined), '–');
});

test('a link restores its values', () => {
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

test('the selection is sent where it is stated, and its faults find their fields', () => {
  const values = { example: 'grooved', method: 'surface', pattern: 'zigzag', machine: 'vmc', tolerance_of_plan: 0.01 };
  assert.deepEqual(parametersOf(values, []), { scallop_tolerance_mm: 0.01, machine: { preset: 'vmc' }, method: 'surface', pattern: 'zigzag', include: ['map', 'program'] });
  const { select } = parametersOf({ ...values, select_slope_to_deg: 30, box_min_y_mm: -5, pieces_selected: '0, 2 x' }, []);
  assert.deepEqual(select, { slope_deg: [0, 30], box_mm: { min: [-1e9, -5, -1e9], max: [1e9, 1e9, 1e9] }, pieces: [0, 2, 'x'] });
  assert.deepEqual(parametersOf({ ...values, program_origin_z_mm: 5 }, []).program, { origin_mm: [0, 0, 5] });
  for (const [pointer, field] of [['/program/origin_mm/2', 'program_origin_z_mm'], ['/select/slope_deg', 'select_slope_to_deg'], ['/select/box_mm/min/2', 'box_min_z_mm'], ['/select/pieces/1', 'pieces_selected'], ['/scallop_tolerance_mm', 'tolerance_of_plan'], ['/machine/jerk_m_s3', 'jerk_m_s3'], ['/directions_deg/3', 'directions_deg']]) {
    assert.equal(fieldNameOf(pointer), field);
  }
});

test('the files of examples have facets that face up', async () => {
  const patch = (corners) => ({ bezier: { control_points: corners }, samples: 4 });
  for (const surface of [await EXAMPLES.at(-1)[2](), patch([[[0, 0, 1], [0, 6, 1]], [[8, 0, 3], [8, 6, 3]]]), patch([[[0, 0, 1], [8, 0, 3]], [[0, 6, 1], [8, 6, 3]]])]) {
    const lines = (await fileOfSurface(surface, 'part').text()).trim().split('\n').map((line) => line.split(' '));
    const vertices = lines.filter(([kind]) => kind === 'v').map(([, ...point]) => point.map(Number));
    const faces = lines.filter(([kind]) => kind === 'f').map(([, ...corners]) => corners.map((corner) => vertices[corner - 1]));
    if (surface.bezier) {
      assert.deepEqual(vertices.at(-1), [8, 6, 3]);
      assert.equal(faces.length, 16);
      // A plane of slope 1 : 4.
      for (const [x, , z] of vertices) assert.ok(Math.abs(z - 1 - x / 4) < 1e-12);
    }
    for (const [a, b, c] of faces) assert.ok((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0);
  }
});

test('conversions of points to pixels and back are inverse', () => {
  const place = new Placement({ columns: 20, rows: 10, cell_mm: 0.5, origin_mm: [3, -2] }, 400, 300);
  // The corner of the first cell is at the lower left of the map, which is centred.
  assert.deepEqual(place.toScreen([3, -2]), [0, 250]);
  assert.deepEqual(place.toPart([400, 50]), [13, 3]);
  assert.deepEqual(place.cellAt([399, 51]), { column: 19, row: 9 });
  assert.equal(place.cellAt([399, 49]), null);
  assert.deepEqual(place.middleOf({ column: 0, row: 0 }), place.toScreen([3.25, -1.75]));
});
