// The fields that the contact view and the table of contacts share.

import { CUTTER_TYPES } from '../terms.js';
import { FIELDS_OF_SHAPES, arrangeShape } from './request.js';

/** The fields of a cutter with its speed. */
export const CUTTER_FIELDS = [
  { name: 'type', choices: CUTTER_TYPES, segmented: true, value: 'toroidal' },
  { name: 'diameter_mm', value: 10, inch: 9.525 },
  { name: 'corner_radius_mm', value: 2, inch: 1.5875 },
  ...FIELDS_OF_SHAPES,
  { name: 'teeth', value: 4 },
  { name: 'spindle_speed_rpm', value: 8000 },
];

/** Their names. */
export const CUTTER_NAMES = CUTTER_FIELDS.map(({ name }) => name);

/** Shows the fields that the question needs, by `needs`: {name: questions}, and the dimensions of the cutter's type. */
export function arrangeByQuestion(form, needs) {
  const { question, type } = form.values();
  for (const [name, questions] of Object.entries(needs)) form.element(name).hidden = !questions.includes(question);
  arrangeShape(form, type);
}
