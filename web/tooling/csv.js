// Tools of a table: a header with the columns of the service or of a catalogue, `Dia (mm)`, `Flutes`; Fusion's own table too.

import { countOf, lengthOf, millimetresOf, numberOf, shaped, typeNamed } from './shape.js';

const LENGTHS = {
  diameter_mm: ['diameter', 'dia', 'dc', 'cutting_diameter', 'cutter_diameter'],
  corner_radius_mm: ['corner_radius', 'corner_rad', 're'],
  max_feed_per_tooth_mm: ['max_feed_per_tooth', 'feed_per_tooth', 'fz', 'chipload', 'chip_load'],
  flute_length_mm: ['flute_length', 'length_of_cut', 'loc', 'lcf'],
};
// Dimensions of other shapes. Other tables may have such columns without a unit, which are not read.
const FURTHER = {
  shank_diameter_mm: ['shank_diameter', 'shaft_diameter', 'sfdm'],
  lens_radius_mm: ['lens_radius'],
  tip_radius_mm: ['tip_radius', 'lower_radius'],
  side_radius_mm: ['side_radius', 'profile_radius'],
};
const OTHERS = {
  name: ['name', 'description', 'tool_name'], type: ['type', 'tool_type', 'kind'], number: ['number', 'tool_number', 'tool_no'],
  teeth: ['teeth', 'flutes', 'number_of_flutes', 'number_of_teeth', 'no_of_flutes'], spindle_speed_rpm: ['spindle_speed_rpm', 'spindle_speed', 'rpm'], preset: ['preset', 'preset_name'], unit: ['unit', 'units'], taper_deg: ['taper_deg', 'taper', 'taper_angle'],
};
const named = (names, quantity) => Object.keys(names).find((name) => names[name].includes(quantity));

// {name, unit?} of a column's title such as `diameter_mm`, `Diameter (mm)` or `Corner Radius (tool_cornerRadius)`.
function columnOf(title) {
  const plain = (text) => text.trim().toLowerCase().replaceAll(/[ .-]/g, '_').replace(/_+$/, '');
  const [, before, inner] = /^(.*)[([]([^()[\]]*)[)\]]$/.exec(title.trim()) ?? [];
  let [quantity, unit] = before === undefined ? [plain(title)] : [plain(before), inner.trim().toLowerCase()];
  if (/^(?:tool|preset)_/.test(inner ?? '')) [quantity, unit] = [inner.replace(/^tool_/, '').replaceAll(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`)];
  const suffix = before === undefined && /^(.*)_(mm|in|inch|inches)$/.exec(quantity);
  if (suffix) [, quantity, unit] = suffix;
  const length = named(LENGTHS, quantity) ?? named(FURTHER, quantity);
  return length ? { name: length, unit } : { name: named(OTHERS, quantity) };
}

/** The cells of a text in CSV, row by row, with cells in quotation marks. */
function rowsOf(text, separator) {
  const rows = [[]];
  const cell = new RegExp(`(?:"((?:[^"]|"")*)"|([^${separator}\\n]*))(${separator}|\\n|$)`, 'g');
  for (const [whole, quotedCell, plainCell, end] of text.matchAll(cell)) {
    if (whole === '' && end === '') break;
    rows.at(-1).push((quotedCell?.replaceAll('""', '"') ?? plainCell).trim());
    if (end === '\n') rows.push([]);
  }
  return rows.filter((row) => row.some((field) => field !== '') && !row[0].startsWith('#'));
}

/** {tool} or {other: kind} for each line; null if the text is no such table. */
export function csvTools(text) {
  const stated = /^sep=(.)\r?\n/i.exec(text);
  const body = text.slice(stated?.[0].length ?? 0).replaceAll('\r', '');
  const first = body.split('\n').find((line) => line.trim() && !line.startsWith('#')) ?? '';
  const separator = stated?.[1] ?? [';', '\t', ','].reduce((best, candidate) => (first.split(candidate).length > first.split(best).length ? candidate : best));
  const [header, ...rows] = rowsOf(body, separator);
  const columns = (header ?? []).map(columnOf);
  const has = (name) => columns.some((column) => column.name === name);
  // A length needs a unit, in its title or in a column of its own.
  if (!has('type') || !has('diameter_mm') || columns.some(({ name, unit }) => name in LENGTHS && !millimetresOf(unit) && !has('unit'))) return null;
  return rows.map((row) => {
    const cells = Object.fromEntries(columns.map(({ name }, i) => [name, row[i] || undefined]).filter(([name]) => name));
    const type = typeNamed(cells.type ?? '');
    if (!type) return { other: cells.type ?? 'tool without a type' };
    const lengths = Object.fromEntries(columns.filter(({ name }) => name in LENGTHS).map(({ name, unit }) => [name, lengthOf(cells[name], millimetresOf(unit ?? cells.unit) ?? 1)]));
    const further = columns.filter(({ name, unit }) => name in FURTHER && millimetresOf(unit ?? cells.unit)).map(({ name, unit }) => [name, lengthOf(cells[name], millimetresOf(unit ?? cells.unit))]);
    const { diameter_mm, corner_radius_mm, ...rest } = lengths;
    const dimensions = { ...Object.fromEntries(further), taper_deg: numberOf(cells.taper_deg) };
    return { tool: { name: cells.name, number: numberOf(cells.number), ...shaped({ type, diameter_mm, corner_radius_mm, cornerIsStated: cells.corner_radius_mm !== undefined, ...dimensions }), teeth: countOf(cells.teeth), spindle_speed_rpm: countOf(cells.spindle_speed_rpm), ...rest, preset: cells.preset } };
  });
}
