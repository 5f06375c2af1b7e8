// The part view's fields, and the request that they make.

import { FIELDS_OF_SHAPES, SHAPE_NAMES, cutterOf } from '../contact/request.js';
import { CUTTER_TYPES } from '../terms.js';
import { ROUGHNESS_FIELDS, toleranceOf } from '../tolerance.js';
import { EXAMPLES } from './examples.js';

/** Candidate cutters to begin with. */
// Carbide in tool steel, 250 m/min at the diameter.
export const CUTTERS = [
  { name: 'T16', type: 'toroidal', diameter_mm: 16, corner_radius_mm: 3, teeth: 4, spindle_speed_rpm: 5000, max_feed_per_tooth_mm: 0.2 },
  { name: 'T10', type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2, teeth: 4, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.15 },
  { name: 'B10', type: 'ball_end', diameter_mm: 10, teeth: 4, spindle_speed_rpm: 8000, max_feed_per_tooth_mm: 0.15 },
  { name: 'B6', type: 'ball_end', diameter_mm: 6, teeth: 4, spindle_speed_rpm: 13000, max_feed_per_tooth_mm: 0.1 },
  { name: 'B4', type: 'ball_end', diameter_mm: 4, teeth: 4, spindle_speed_rpm: 20000, max_feed_per_tooth_mm: 0.07 },
];

// The same in inches: cutters with round sizes, 800 ft/min.
const inches = (name, type, diameter, corner, speed, feed) => ({ name, type, diameter_mm: diameter * 25.4, corner_radius_mm: corner && corner * 25.4, teeth: 4, spindle_speed_rpm: speed, max_feed_per_tooth_mm: Number((feed * 25.4).toPrecision(6)) });
export const INCH_CUTTERS = [
  inches('5/8 R1/8', 'toroidal', 0.625, 0.125, 5000, 0.008), inches('3/8 R1/16', 'toroidal', 0.375, 0.0625, 8000, 0.006),
  inches('3/8 ball', 'ball_end', 0.375, undefined, 8000, 0.006), inches('1/4 ball', 'ball_end', 0.25, undefined, 12000, 0.004), inches('5/32 ball', 'ball_end', 0.15625, undefined, 20000, 0.003),
];

export const UNITS = [['', 'mm (3MF: its own)'], ...['mm', 'cm', 'm', 'inch', 'foot', 'um'].map((unit) => [unit, unit === 'um' ? 'µm' : unit])];

// Names of the fields of the cutter before begin with it.
const REST = 'rest_of_';

/** The fields of the cutter before. */
export const REST_NAMES = ['type', ...SHAPE_NAMES].map((name) => REST + name);

/** The fields of a program's zero point, whose names begin with `prefix`. */
export function originFields(prefix = '') {
  return ['x', 'y', 'z'].map((axis) => ({ name: `${prefix}origin_${axis}_mm`, optional: '0' }));
}

/** The values of these fields for a zero point. */
export function originValues(origin = []) {
  return Object.fromEntries(originFields().map(({ name }, i) => [name, origin[i]]));
}

/** The zero point that these fields state, if one does. */
export function originOf(values, prefix = '') {
  const origin = originFields(prefix).map(({ name }) => values[name]);
  return origin.some((side) => side !== undefined) ? origin.map((side) => side ?? 0) : undefined;
}

export const FIELDS = [
  { name: 'example', label: 'Surface', help: 'Your own file, or an example to try the page with.', choices: [['file', 'A file'], ...EXAMPLES.map(([name, label]) => [name, label])], value: 'grooved' },
  { name: 'unit', choices: UNITS, value: '' },
  { name: 'facing', choices: [['up', 'Up'], ['any', 'Any']], value: 'up' },
  { name: 'tolerance_of_plan', value: 0.01, inch: 0.01016 },
  ...ROUGHNESS_FIELDS,
  { name: 'pattern', choices: [['zigzag', 'Zigzag'], ['one_way', 'One way']], segmented: true, value: 'zigzag' },
  { name: 'method', choices: [['surface', 'Surface'], ['rectangle', 'Rectangle']], segmented: true, value: 'surface' },
  { name: 'model', choices: [['', 'Method’s own'], ['envelope', 'Exact'], ['analytic', 'Published']], value: '' },
  { name: 'operations', label: 'Operations', help: 'The most operations of the plan: level parts to and fro, steep ones by waterlines, what one cutter leaves by a smaller one.', choices: [['1', '1'], ['2', '2'], ['3', '3']], segmented: true, value: '1' },
  { name: 'rest_of_type', label: 'Only the rest of', help: 'A cutter that has machined everything before: only what it could not reach is planned.', choices: [['', 'No cutter before'], ...CUTTER_TYPES], value: '' },
  { name: 'rest_of_diameter_mm', value: 10, inch: 9.525 },
  { name: 'rest_of_corner_radius_mm', value: 2, inch: 1.5875 },
  ...FIELDS_OF_SHAPES.map(({ name, ...field }) => ({ name: REST + name, ...field })),
  { name: 'max_slope_deg', optional: '85' },
  { name: 'max_uncut_share', optional: '0.5' },
  { name: 'directions_deg', text: true, optional: 'all' },
  { name: 'select_slope_from_deg', optional: '0' },
  { name: 'select_slope_to_deg', optional: '90' },
  ...['x', 'y', 'z'].flatMap((axis) => ['min', 'max'].map((end) => ({ name: `box_${end}_${axis}_mm`, optional: 'any' }))),
  { name: 'pieces_selected', text: true, optional: 'all' },
  { name: 'machine', choices: [['', 'Own values']], value: 'five_axis_vmc' },
  { name: 'machine_feed_rate_mm_min' },
  { name: 'acceleration_m_s2' },
  { name: 'jerk_m_s3' },
  { name: 'rapid_rate_mm_min', optional: 'feed rate' },
  { name: 'max_spindle_speed_rpm', optional: 'no limit' },
  { name: 'clearance_height_mm', optional: '5' },
  { name: 'path_tolerance_mm', optional: 'none' },
  { name: 'time_factor', optional: '1' },
  { name: 'tool_change_s', optional: '10' },
  { name: 'program_dialect', label: 'Language', help: 'Language of the program: G-code, or Klartext of Heidenhain’s controls.', choices: [['iso', 'G-code'], ['klartext', 'Klartext']], value: 'iso' },
  { name: 'program_unit', label: 'Unit', help: 'Unit of the program.', choices: [['mm', 'mm'], ['inch', 'inch']], value: 'mm' },
  { name: 'program_decimals', optional: '4' },
  { name: 'program_tool', optional: '1' },
  { name: 'program_number_lines', label: 'Block numbers', help: 'A number at each block.', choices: [['no', 'No'], ['yes', 'Yes']], value: 'no' },
  { name: 'program_tool_length_offset', label: 'Length offset', help: 'G43 H at the first Z after each tool call of G-code; for controls whose tool call does not set the length.', choices: [['no', 'No'], ['yes', 'G43 H']], value: 'no' },
  ...originFields('program_'),
  { name: 'program_coolant', label: 'Coolant', help: 'M8 after the spindle starts.', choices: [['no', 'Off'], ['yes', 'M8']], value: 'no' },
  { name: 'program_spindle_speed_rpm', optional: 'cutter’s' },
  { name: 'program_header', text: 'lines', optional: '(PART 4711)' },
  { name: 'program_footer', text: 'lines', optional: 'G91 G28 Z0' },
];

/** The fields of the program. */
export const PROGRAM = FIELDS.map(({ name }) => name).filter((name) => name.startsWith('program_'));

/** The fields that select the part of the surface to machine. */
export const SELECTION = ['select_slope_from_deg', 'select_slope_to_deg', 'box_min_x_mm', 'box_max_x_mm', 'box_min_y_mm', 'box_max_y_mm', 'box_min_z_mm', 'box_max_z_mm', 'pieces_selected'];

// A missing side of the box is set farther than any part.
const BEYOND_MM = 1e9;

// Numbers with commas or blanks between them; other text is sent as it is, for the service to report.
const numbersOf = (text) => String(text).split(/[\s,;]+/).filter(Boolean).map((word) => (Number.isFinite(Number(word)) ? Number(word) : word));

function selectionOf(values) {
  const select = {};
  const { select_slope_from_deg: from, select_slope_to_deg: to } = values;
  if (from !== undefined || to !== undefined) select.slope_deg = [from ?? 0, to ?? 90];
  const corner = (end, absent) => ['x', 'y', 'z'].map((axis) => values[`box_${end}_${axis}_mm`] ?? absent);
  const box = { min: corner('min', -BEYOND_MM), max: corner('max', BEYOND_MM) };
  if ([...box.min, ...box.max].some((side) => Math.abs(side) !== BEYOND_MM)) select.box_mm = box;
  if (values.pieces_selected !== undefined) select.pieces = numbersOf(values.pieces_selected);
  return Object.keys(select).length > 0 ? select : undefined;
}

// The cutter before, whose rest is machined.
function restOf(values) {
  if (!values.rest_of_type) return undefined;
  return { cutter: cutterOf(Object.fromEntries(REST_NAMES.map((name) => [name.slice(REST.length), values[name]]))) };
}

const linesOf = (text) => text?.split('\n').map((line) => line.trim()).filter(Boolean);

/** The options of the program; members at their defaults are left out. */
export function programOf(values) {
  const options = {
    dialect: values.program_dialect === 'klartext' ? 'klartext' : undefined,
    unit: values.program_unit === 'inch' ? 'inch' : undefined,
    decimals: values.program_decimals,
    tool: values.program_tool,
    number_lines: values.program_number_lines === 'yes' || undefined,
    tool_length_offset: values.program_tool_length_offset === 'yes' || undefined,
    origin_mm: originOf(values, 'program_'),
    coolant: values.program_coolant === 'yes' || undefined,
    spindle_speed_rpm: values.program_spindle_speed_rpm,
    header: linesOf(values.program_header),
    footer: linesOf(values.program_footer),
  };
  const stated = Object.entries(options).filter(([, value]) => value !== undefined);
  return stated.length > 0 ? Object.fromEntries(stated) : undefined;
}

/** The parameters of a request, all but its surface, of the form's values and the cutters. */
export function parametersOf(values, cutters) {
  const isSurface = values.method === 'surface';
  const isFile = values.example === 'file';
  const parameters = {
    cutters: cutters.length > 0 ? cutters : undefined,
    ...toleranceOf(values, values.tolerance_of_plan),
    machine: {
      preset: values.machine || undefined,
      feed_rate_mm_min: values.machine_feed_rate_mm_min,
      acceleration_m_s2: values.acceleration_m_s2,
      jerk_m_s3: values.jerk_m_s3,
      rapid_rate_mm_min: values.rapid_rate_mm_min,
      max_spindle_speed_rpm: values.max_spindle_speed_rpm,
      clearance_height_mm: values.clearance_height_mm,
      path_tolerance_mm: values.path_tolerance_mm,
      time_factor: values.time_factor,
      tool_change_s: Number(values.operations) > 1 ? values.tool_change_s : undefined,
    },
    method: values.method,
    model: values.model || undefined,
    select: selectionOf(values),
    unit: (isFile && values.unit) || undefined,
    facing: isFile ? values.facing : undefined,
    ...(isSurface && {
      pattern: values.pattern,
      max_slope_deg: values.max_slope_deg,
      max_uncut_share: values.max_uncut_share,
      directions_deg: values.directions_deg === undefined ? undefined : numbersOf(values.directions_deg),
      operations: Number(values.operations) > 1 ? { max: Number(values.operations) } : undefined,
      rest_of: restOf(values),
      // A file is sent once: the maps of all cutters come with it.
      include: [isFile ? 'maps' : 'map', 'program'],
      program: programOf(values),
    }),
  };
  // Members without a value are left out.
  return JSON.parse(JSON.stringify(parameters));
}

const FIELD_OF = {
  '/scallop_tolerance_mm': 'tolerance_of_plan',
  '/roughness': 'ra_um',
  '/operations/max': 'operations',
  '/rest_of': 'rest_of_type',
  '/machine': 'machine',
  '/machine/preset': 'machine',
  '/machine/feed_rate_mm_min': 'machine_feed_rate_mm_min',
  '/select/slope_deg/0': 'select_slope_from_deg',
  '/select/slope_deg': 'select_slope_to_deg',
  '/select/slope_deg/1': 'select_slope_to_deg',
};

/** The name of the field that a pointer into the request names. */
export function fieldNameOf(pointer) {
  if (FIELD_OF[pointer]) return FIELD_OF[pointer];
  const box = /^\/select\/box_mm(?:\/(min|max)(?:\/(\d))?)?$/.exec(pointer);
  if (box) return `box_${box[1] ?? 'max'}_${'xyz'[box[2] ?? 0]}_mm`;
  if (/^\/select\/?$/.test(pointer)) return 'select_slope_from_deg';
  if (/^\/select\/pieces/.test(pointer)) return 'pieces_selected';
  if (/^\/directions_deg/.test(pointer)) return 'directions_deg';
  const rest = /^\/rest_of\/cutter\/(\w+)/.exec(pointer);
  if (rest) return REST + rest[1];
  const origin = /^\/program\/origin_mm(?:\/(\d))?/.exec(pointer);
  if (origin) return `program_origin_${'xyz'[origin[1] ?? 0]}_mm`;
  const program = /^\/program\/(\w+)/.exec(pointer);
  if (program) return `program_${program[1]}`;
  return pointer.split('/').at(-1);
}
