// The fields of a program's check, and the request that they make.

import { FIELDS_OF_SHAPES, cutterOf, fieldAt } from '../contact/request.js';
import { EXAMPLES } from '../part/examples.js';
import { UNITS, originFields, originOf } from '../part/request.js';
import { CUTTER_TYPES } from '../terms.js';
import { ROUGHNESS_FIELDS, toleranceOf } from '../tolerance.js';

export const FIELDS = [
  { name: 'example', label: 'Surface', help: 'Your own file, or an example to try the page with.', choices: [['file', 'A file'], ...EXAMPLES.map(([name, label]) => [name, label])], value: 'file' },
  { name: 'unit', choices: UNITS, value: '' },
  { name: 'facing', choices: [['up', 'Up'], ['any', 'Any']], value: 'up' },
  { name: 'type', choices: CUTTER_TYPES, segmented: true, value: 'ball_end' },
  { name: 'diameter_mm', value: 6, inch: 6.35 },
  { name: 'corner_radius_mm', value: 1, inch: 1.5875 },
  ...FIELDS_OF_SHAPES,
  { name: 'teeth', value: 4 },
  { name: 'spindle_speed_rpm', optional: 'S words' },
  { name: 'max_feed_per_tooth_mm', optional: 'no limit' },
  { name: 'tip', label: 'Program drives', help: 'The point of the cutter whose path the program states.', choices: [['lowest_point', 'Lowest point'], ['centre', 'Centre']], segmented: true, value: 'lowest_point' },
  ...originFields(),
  { name: 'scallop_tolerance_mm', value: 0.01, inch: 0.01016 },
  ...ROUGHNESS_FIELDS,
  { name: 'machine', choices: [['five_axis_vmc', 'five_axis_vmc']], value: 'five_axis_vmc' },
  { name: 'machine_feed_rate_mm_min', optional: 'preset’s' },
  { name: 'path_tolerance_mm', optional: 'none' },
];

// What the answer holds beside its figures. New feeds need teeth, and a speed or S words.
const includedOf = ({ teeth, spindle_speed_rpm: speed }, hasSpeeds) => ['map', 'places', ...(teeth !== undefined && (speed !== undefined || hasSpeeds) ? ['feeds', 'program'] : [])];

/**
 * The parameters of the form's values for the program `text`; `given` are further members, such as the selection of the plan that the program is
 * from.
 */
export function parametersOf(values, given, text) {
  const { spindle_speed_rpm, max_feed_per_tooth_mm } = values;
  return JSON.parse(JSON.stringify({
    ...given,
    cutter: given.cutters ? undefined : { ...cutterOf(values), spindle_speed_rpm, max_feed_per_tooth_mm },
    tip: values.tip === 'centre' ? 'centre' : undefined,
    origin_mm: originOf(values),
    ...toleranceOf(values, values.scallop_tolerance_mm),
    machine: { ...given.machine, preset: values.machine || undefined, feed_rate_mm_min: values.machine_feed_rate_mm_min, path_tolerance_mm: values.path_tolerance_mm },
    unit: (values.example === 'file' && values.unit) || undefined,
    facing: values.example === 'file' ? values.facing : undefined,
    include: includedOf(values, /\bS\d/i.test(text)),
  }));
}

const FIELD_OF = { ...Object.fromEntries(originFields().map(({ name }, i) => [`/origin_mm/${i}`, name])), '/origin_mm': 'origin_x_mm', '/machine/preset': 'machine', '/machine/feed_rate_mm_min': 'machine_feed_rate_mm_min' };

export const fieldNameOf = (pointer) => FIELD_OF[pointer] ?? fieldAt(pointer);
