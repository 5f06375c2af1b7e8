// The tolerance of a form: a scallop height, or in its place the roughness of a drawing.

// Ra of a profile of equal arcs over their height, 4/(9 sqrt 3), with micrometres over millimetres.
const RA_UM_OF_MM = (1000 * 4) / (9 * Math.sqrt(3));

/** The fields beside that of the height, whose name differs between the views. */
export const ROUGHNESS_FIELDS = [
  { name: 'tolerance_form', label: 'Tolerance as', help: 'A scallop height, or the Ra of the drawing, which stands for a height.', choices: [['height', 'Height'], ['ra', 'Ra']], segmented: true, value: 'height' },
  { name: 'ra_um', label: 'Ra', help: 'Ra that the drawing states. The geometry alone keeps Ra if its scallops are at most Ra/0.2566 high.', value: 0.8, inch: 0.8128 },
  { name: 'allowance', optional: '1' },
];

/** The names of all fields of a tolerance with the height `name`. */
export const toleranceFields = (name) => ['tolerance_form', name, 'ra_um', 'allowance'];

/** Shows the fields of the form that is chosen. */
export function arrangeTolerance(form, name, isNeeded = true) {
  const isRa = form.value('tolerance_form') === 'ra';
  form.element('tolerance_form').hidden = !isNeeded;
  form.element(name).hidden = !isNeeded || isRa;
  for (const other of ['ra_um', 'allowance']) form.element(other).hidden = !isNeeded || !isRa;
}

/** The members of a request that state the tolerance of the form's values; `height` is the value of the height. */
export function toleranceOf({ tolerance_form: form, ra_um, allowance }, height) {
  return form === 'ra' ? { roughness: { ra_um, allowance } } : { scallop_tolerance_mm: height };
}

/** The scallop height in mm for which the members stand. */
export function heightOf({ scallop_tolerance_mm: height, roughness }) {
  if (!roughness) return height;
  const { ra_um: ra, allowance = 1 } = roughness;
  return typeof ra === 'number' && typeof allowance === 'number' ? ra / allowance / RA_UM_OF_MM : undefined;
}
