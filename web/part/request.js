// The part view's fields, and the request that they make.

import { EXAMPLES } from './examples.js';

/** Candidate cutters to begin with. */
export const CUTTERS = [
  { name: 'T16', type: 'toroidal', diameter_mm: 16, corner_radius_mm: 3 },
  { name: 'T10', type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2 },
  { name: 'B10', type: 'ball_end', diameter_mm: 10 },
  { name: 'B6', type: 'ball_end', diameter_mm: 6 },
  { name: 'B4', type: 'ball_end', diameter_mm: 4 },
];

const UNITS = [['', 'mm (3MF: its own)'], ...['mm', 'cm', 'm', 'inch', 'foot', 'um'].map((unit) => [unit, unit === 'um' ? 'µm' : unit])];

export const FIELDS = [
  { name: 'example', label: 'Surface', help: 'Your own file, or an example to try the page with.', choices: [['file', 'A file'], ...EXAMPLES.map(([name, label]) => [name, label])], value: 'grooved' },
  { name: 'unit', choices: UNITS, value: '' },
  { name: 'facing', choices: [['up', 'Up'], ['any', 'Any']], value: 'up' },
  { name: 'tolerance_of_plan', value: 0.01 },
  { name: 'pattern', choices: [['zigzag', 'Zigzag'], ['one_way', 'One way']], segmented: true, value: 'zigzag' },
  { name: 'method', choices: [['surface', 'Surface'], ['rectangle', 'Rectangle']], segmented: true, value: 'surface' },
  { name: 'model', choices: [['', 'Method’s own'], ['envelope', 'Exact shape'], ['analytic', 'Published']], value: '' },
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
  { name: 'passes_wanted', label: 'Passes', help: 'Also ask for the passes of the recommended plan, point by point: for the map and for download.', choices: [['no', 'No'], ['yes', 'Point by point']], segmented: true, value: 'no' },
];

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

/** The parameters of a request, all but its surface, of the form's values and the cutters. */
export function parametersOf(values, cutters) {
  const isSurface = values.method === 'surface';
  const isFile = values.example === 'file';
  const parameters = {
    cutters: cutters.length > 0 ? cutters : undefined,
    scallop_height_mm: values.tolerance_of_plan,
    machine: {
      preset: values.machine || undefined,
      feed_rate_mm_min: values.machine_feed_rate_mm_min,
      acceleration_m_s2: values.acceleration_m_s2,
      jerk_m_s3: values.jerk_m_s3,
      rapid_rate_mm_min: values.rapid_rate_mm_min,
      max_spindle_speed_rpm: values.max_spindle_speed_rpm,
      clearance_height_mm: values.clearance_height_mm,
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
      include: values.passes_wanted === 'yes' ? ['map', 'passes'] : ['map'],
    }),
  };
  // Members without a value are left out.
  return JSON.parse(JSON.stringify(parameters));
}

const FIELD_OF = {
  '/scallop_height_mm': 'tolerance_of_plan',
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
  return pointer.split('/').at(-1);
}
