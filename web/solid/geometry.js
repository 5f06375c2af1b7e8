// Vertices, colours and triangles of the 3D view. The part's Z points up on the screen: (x, y, z) of the part is (x, z, -y) of the scene, about
// the middle of the part.

import { OPERATIONS, hex } from '../part/palette.js';
import { arcsOf, outlineOf } from '../contact/profile.js';

// Facets of a piece: its arrays are filled and sent to the graphics card in some milliseconds.
const PIECE = 40_000;
const [STL_HEAD, STL_FACET] = [84, 50];
/** The colour of facets that are not seen from above, to which no cell of the map belongs. */
const HIDDEN = [150, 158, 163];

const pause = () => new Promise((resolve) => setTimeout(resolve));

/** The middle of the map's surface and its reach, the largest distance of a corner from the middle. */
export function frameOf({ columns, rows, cell_mm: cell, origin_mm: origin, z_mm: z }) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of z) {
    if (value === null) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  const [width, depth] = [columns * cell, rows * cell];
  return { x: origin[0] + width / 2, y: origin[1] + depth / 2, z: (low + high) / 2, reach: Math.hypot(width, depth, high - low) / 2 };
}

/** Writes the point (x, y, z) of the part at `at` of `positions`. */
export function place(positions, at, frame, x, y, z) {
  positions[at] = x - frame.x;
  positions[at + 1] = z - frame.z;
  positions[at + 2] = frame.y - y;
}

function paint(colours, at, colour) {
  colours[at] = colour[0];
  colours[at + 1] = colour[1];
  colours[at + 2] = colour[2];
  colours[at + 3] = 255;
}

/** Every `step`-th point of the map's raster as a surface: {position, colour, index}. */
export function surfaceOfMap({ columns, rows, cell_mm: cell, origin_mm: origin, z_mm: z }, frame, colourOf, step) {
  const [position, colour] = [new Float32Array(3 * columns * rows), new Uint8Array(4 * columns * rows)];
  const index = new Uint32Array(6 * (columns - 1) * (rows - 1));
  let count = 0;
  for (let row = 0; row < rows; row += step) {
    for (let column = 0; column < columns; column += step) {
      const at = row * columns + column;
      if (z[at] === null) continue;
      place(position, 3 * at, frame, origin[0] + (column + 0.5) * cell, origin[1] + (row + 0.5) * cell, z[at]);
      paint(colour, 4 * at, colourOf(at));
      const corners = [at, at + step, at + step * (columns + 1), at + step * columns];
      if (column + step >= columns || row + step >= rows || corners.some((corner) => z[corner] === null)) continue;
      index.set([corners[0], corners[1], corners[2], corners[0], corners[2], corners[3]], count);
      count += 6;
    }
  }
  return { position, colour, index: index.subarray(0, count) };
}

/** The facets that the head of a binary STL counts. */
export const facetsOfStl = (bytes) => new DataView(bytes).getUint32(80, true);

/** Whether the bytes are a binary STL: its length is that of the facets that it counts. */
export const isBinaryStl = (bytes) => bytes.byteLength > STL_HEAD && STL_HEAD + STL_FACET * facetsOfStl(bytes) === bytes.byteLength;

/**
 * The facets of a binary STL in mm by `unit`, piece by piece: {position, colour}, three vertices for each facet. A vertex has the colour of the
 * map's cell over it, if it is no farther below that than `depth`. The page answers between pieces.
 */
export async function* piecesOfStl(bytes, unit, map, frame, colourOf, depth) {
  const view = new DataView(bytes);
  const facets = facetsOfStl(bytes);
  const { columns, rows, cell_mm: cell, origin_mm: origin, z_mm: z } = map;
  const within = (value, most) => Math.min(most, Math.max(0, Math.floor(value)));
  for (let first = 0; first < facets; first += PIECE) {
    const vertices = 3 * Math.min(PIECE, facets - first);
    const [position, colour] = [new Float32Array(3 * vertices), new Uint8Array(4 * vertices)];
    for (let vertex = 0; vertex < vertices; vertex += 1) {
      const at = STL_HEAD + STL_FACET * (first + Math.floor(vertex / 3)) + 12 + 12 * (vertex % 3);
      const x = unit * view.getFloat32(at, true);
      const y = unit * view.getFloat32(at + 4, true);
      const height = unit * view.getFloat32(at + 8, true);
      place(position, 3 * vertex, frame, x, y, height);
      const index = within((y - origin[1]) / cell, rows - 1) * columns + within((x - origin[0]) / cell, columns - 1);
      paint(colour, 4 * vertex, z[index] !== null && height > z[index] - depth ? colourOf(index) : HIDDEN);
    }
    yield { position, colour };
    await pause();
  }
}

const RAPID = [190, 90, 20];
const FEED = OPERATIONS.map(hex);

/** The tip's path as lines: {position, colour}, two vertices for each move. */
export function linesOf({ x, y, z, isRapid, operation, count }, frame) {
  const moves = Math.max(0, count - 1);
  const [position, colour] = [new Float32Array(6 * moves), new Uint8Array(8 * moves)];
  for (let i = 0; i < moves; i += 1) {
    for (const end of [0, 1]) {
      place(position, 6 * i + 3 * end, frame, x[i + end], y[i + end], z[i + end]);
      paint(colour, 8 * i + 4 * end, isRapid[i + 1] ? RAPID : FEED[operation[i + 1]]);
    }
  }
  return { position, colour };
}

/** Places [{code, point_mm}] as points, with the colours `hexOf[code]`. */
export function pointsOf(places, hexOf, frame) {
  const [position, colour] = [new Float32Array(3 * places.length), new Uint8Array(4 * places.length)];
  places.forEach(({ code, point_mm: [x, y, z] }, i) => {
    place(position, 3 * i, frame, x, y, z);
    paint(colour, 4 * i, hex(hexOf[code]));
  });
  return { position, colour };
}

const [AROUND, ALONG_ARC] = [40, 12];
const TOOL = [15, 111, 135];

/** The cutter with its tip at the origin, turned about the scene's upright axis: {position, colour, index}. */
export function toolOf({ corner_radius_mm: corner = 0, ...cutter }) {
  const below = outlineOf(arcsOf({ ...cutter, corner_radius_mm: corner }), ALONG_ARC);
  const [radius, height] = below.at(-1);
  const top = Math.max(6 * radius, height + 2 * radius);
  const outline = [...below, [radius, top], [0, top]];
  const position = new Float32Array(3 * outline.length * AROUND);
  const colour = new Uint8Array(4 * outline.length * AROUND);
  const index = [];
  for (let turn = 0; turn < AROUND; turn += 1) {
    const angle = (2 * Math.PI * turn) / AROUND;
    outline.forEach(([rho, height], i) => {
      const at = turn * outline.length + i;
      position.set([rho * Math.cos(angle), height, rho * Math.sin(angle)], 3 * at);
      paint(colour, 4 * at, TOOL);
      if (i + 1 === outline.length) return;
      const next = ((turn + 1) % AROUND) * outline.length + i;
      index.push(at, at + 1, next, next, at + 1, next + 1);
    });
  }
  return { position, colour, index: new Uint32Array(index) };
}
