// Reading a table of contacts from CSV text: comma, semicolon, tab or blanks; a header that names the columns; decimal comma where
// the separator allows it; `#` lines are comments. Reading is done in slices, so that a long table does not stop the page.

const SLICE_MS = 12;

const ALIASES = {
  slope: 'slope_deg', s: 'slope_deg', alpha: 'feed_angle_deg', feed_angle: 'feed_angle_deg',
  x_mm: 'x', y_mm: 'y', z_mm: 'z', normal_x: 'nx', normal_y: 'ny', normal_z: 'nz', feed_x: 'fx', feed_y: 'fy', feed_z: 'fz',
  i: 'nx', j: 'ny', k: 'nz', step_over: 'step_over_mm', stepover: 'step_over_mm', radius: 'surface_radius_mm',
};
const USED = new Set(['slope_deg', 'feed_angle_deg', 'x', 'y', 'z', 'nx', 'ny', 'nz', 'fx', 'fy', 'fz', 'run', 'step_over_mm', 'step_over_xy_mm', 'feed_per_tooth_mm', 'surface_radius_mm', 'along_per_mm', 'across_per_mm', 'twist_per_mm', 'feed_rate_mm_min']);

/** A fault of a table, described for people. */
export class TableFault extends Error {}

function separatorOf(line) {
  for (const candidate of [';', '\t', ',']) if (line.includes(candidate)) return candidate;
  return /\s+/;
}

const split = (line, separator) => line.trim().split(separator).map((cell) => cell.trim().replace(/^"(.*)"$/, '$1'));

/**
 * Reads `text` into {header, lines, numbers, columns}: the original lines, their numbers in the text, and one array for each column that
 * is used, with null for an empty cell.
 */
export async function readTable(text) {
  const all = text.replace(/^\uFEFF/, '').split(/\r\n|\n|\r/);
  const first = all.findIndex((line) => line.trim() !== '' && !line.trim().startsWith('#'));
  if (first < 0) throw new TableFault('The table is empty.');
  const separator = separatorOf(all[first]);
  const decimalComma = separator !== ',';
  const header = split(all[first].replace(/^\uFEFF/, ''), separator);
  const names = header.map((name) => {
    const plain = name.toLowerCase().replaceAll(/[ .-]+/g, '_');
    return ALIASES[plain] ?? plain;
  });
  if (names.every((name) => name === '' || Number.isFinite(Number(name.replace(',', '.'))))) {
    throw new TableFault(`Line ${first + 1}: the first line must name the columns, such as slope_deg,feed_angle_deg or x,y,z,nx,ny,nz.`);
  }
  const wanted = names.map((name, at) => [name, at]).filter(([name], index) => USED.has(name) && names.indexOf(name) === index);
  const columns = Object.fromEntries(wanted.map(([name]) => [name, []]));
  const [lines, numbers] = [[], []];
  let sliceEnd = performance.now() + SLICE_MS;
  for (let at = first + 1; at < all.length; at += 1) {
    const line = all[at];
    if (line.trim() === '' || line.trimStart().startsWith('#')) continue;
    const cells = split(line, separator);
    for (const [name, index] of wanted) {
      const cell = cells[index] ?? '';
      const value = cell === '' ? null : Number(decimalComma ? cell.replace(',', '.') : cell);
      if (Number.isNaN(value)) throw new TableFault(`Line ${at + 1}, column ${header[index]}: “${cell}” is not a number.`);
      columns[name].push(value);
    }
    lines.push(line);
    numbers.push(at + 1);
    if (performance.now() > sliceEnd) {
      await new Promise((resolve) => setTimeout(resolve));
      sliceEnd = performance.now() + SLICE_MS;
    }
  }
  if (lines.length === 0) throw new TableFault('The table has a header but no rows.');
  return { header, headerLine: all[first], separator: typeof separator === 'string' ? separator : ' ', lines, numbers, columns, decimalComma };
}

/**
 * The contacts as the service's columns, `rows` with the index of each contact's row, and the distance along the path where the table has
 * positions. A row whose normal is empty is a move off the surface, not a contact. Without feed vectors the feed runs from each position to
 * the next of its run.
 */
export function contactsOf({ columns, lines }) {
  const count = lines.length;
  const has = (...names) => names.every((name) => columns[name]);
  const contacts = {};
  const isOff = has('nx', 'ny', 'nz') ? (i) => columns.nx[i] === null && columns.ny[i] === null && columns.nz[i] === null : () => false;
  const rows = Array.from({ length: count }, (_, i) => i).filter((i) => !isOff(i));
  const positions = has('x', 'y', 'z') ? columns.x.map((x, i) => (x === null ? null : [x, columns.y[i], columns.z[i]])) : null;
  if (has('slope_deg', 'feed_angle_deg')) Object.assign(contacts, { slope_deg: columns.slope_deg, feed_angle_deg: columns.feed_angle_deg });
  else if (has('nx', 'ny', 'nz') && (has('fx', 'fy', 'fz') || positions)) {
    contacts.normal = vectors(columns, ['nx', 'ny', 'nz']);
    contacts.feed = has('fx', 'fy', 'fz') ? vectors(columns, ['fx', 'fy', 'fz']) : feedsOf(positions, columns.run);
  } else {
    throw new TableFault('The table needs slope_deg and feed_angle_deg, or the normal nx, ny, nz with the feed fx, fy, fz or positions x, y, z.');
  }
  for (const name of ['step_over_mm', 'step_over_xy_mm', 'feed_per_tooth_mm', 'surface_radius_mm']) if (has(name)) contacts[name] = columns[name];
  const curvature = ['along_per_mm', 'across_per_mm', 'twist_per_mm'].filter((name) => has(name));
  if (curvature.length > 0) contacts.surface_curvature = Object.fromEntries(curvature.map((name) => [name, columns[name]]));
  const selected = (column) => (Array.isArray(column) ? rows.map((i) => column[i]) : Object.fromEntries(Object.entries(column).map(([name, inner]) => [name, selected(inner)])));
  return { contacts: rows.length < count ? selected(contacts) : contacts, rows, distance: positions && distances(positions, columns.run), count };
}

const vectors = (columns, names) => columns[names[0]].map((_, i) => {
  const found = names.map((name) => columns[name][i]);
  return found.includes(null) ? null : found;
});

// From each position to the next of its run at another place; at the end of a run from the one before.
function feedsOf(positions, runs) {
  const feeds = positions.map(() => null);
  let next = null;
  for (let i = positions.length - 1; i >= 0; i -= 1) {
    const [here, after] = [positions[i], positions[i + 1]];
    if (!here || !after || (runs && runs[i] !== runs[i + 1])) next = null;
    else if (here.some((part, axis) => part !== after[axis])) next = after.map((part, axis) => part - here[axis]);
    feeds[i] = next;
  }
  for (let i = 1; i < positions.length; i += 1) if (feeds[i] === null && positions[i] && (!runs || runs[i] === runs[i - 1])) feeds[i] = feeds[i - 1];
  return feeds;
}

// Distances along the path; links between runs are not counted.
function distances(positions, runs) {
  let total = 0;
  return positions.map((here, i) => {
    const before = i > 0 ? positions[i - 1] : null;
    if (here && before && (!runs || runs[i] === runs[i - 1])) total += Math.hypot(...here.map((part, axis) => part - before[axis]));
    return total;
  });
}

// Six digits: more than any figure of milling is worth.
const digits = (value) => (typeof value === 'number' ? String(Number(value.toPrecision(6))) : String(value));

/** The table with columns of the answer added, with its own separator and its original lines. A name that the table has gets a prefix. */
export function withColumns({ header, headerLine, separator, lines, decimalComma }, added) {
  const names = Object.keys(added);
  const taken = new Set(header.map((name) => name.toLowerCase()));
  const unused = (name) => (taken.has(name) ? unused(`answer_${name}`) : name);
  const number = (value) => (value === null || value === undefined ? '' : decimalComma && separator === ';' && lines[0].includes(',') ? digits(value).replace('.', ',') : digits(value));
  const rows = lines.map((line, i) => [line.trimEnd(), ...names.map((name) => number(added[name][i]))].join(separator));
  return `${[headerLine.trimEnd(), ...names.map((name) => unused(name))].join(separator)}\n${rows.join('\n')}\n`;
}
