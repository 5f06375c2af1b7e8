// The contact view's requests: the form's values as bodies of the service's calculations, and which field a pointer names.

import { toleranceOf } from '../tolerance.js';

export const ENDPOINTS = { height: 'v1/scallop-height', step: 'v1/step-over', feed: 'v1/max-feed', fastest: 'v1/cutting-parameters' };

// Numbers with blanks or commas between them; another text stays, for the service to report.
const wordsOf = (text) => text.split(/[\s,;]+/).filter(Boolean).map((word) => (Number.isFinite(Number(word)) ? Number(word) : word));
const vector = (text) => (text === undefined ? undefined : wordsOf(String(text)));

/** Members without a value are left out. */
function stated(members) {
  const entries = Object.entries(members).filter(([, value]) => value !== undefined);
  return entries.length > 0 ? Object.fromEntries(entries) : undefined;
}

/** The dimensions of each type of cutter. */
const DIMENSIONS = {
  toroidal: ['diameter_mm', 'corner_radius_mm'], ball_end: ['diameter_mm'], flat_end: ['diameter_mm'], tapered_ball: ['diameter_mm', 'taper_deg', 'shank_diameter_mm'],
  lens: ['diameter_mm', 'lens_radius_mm', 'corner_radius_mm'], oval: ['diameter_mm', 'tip_radius_mm', 'side_radius_mm'],
  conical_barrel: ['diameter_mm', 'tip_radius_mm', 'side_radius_mm', 'taper_deg'], profile: ['arcs'],
};

// The members of an arc in the order of a line.
const ARC = ['radius_mm', 'centre_offset_mm', 'centre_height_mm', 'from_deg', 'to_deg'];

/** The arcs of a text with one arc a line. */
const arcsOfText = (text) => text.split('\n').filter((line) => line.trim()).map((line) => Object.fromEntries(wordsOf(line).map((word, i) => [ARC[i] ?? `number_${i + 1}`, word])));

const textOfArcs = (arcs) => arcs.map((arc) => ARC.map((name) => arc[name]).join(' ')).join('\n');

/** The fields of these dimensions, but for diameter and corner radius, which forms have with values of their own. */
export const FIELDS_OF_SHAPES = [
  { name: 'taper_deg', value: 5 },
  { name: 'shank_diameter_mm', value: 16, inch: 15.875 },
  { name: 'lens_radius_mm', value: 40, inch: 38.1 },
  { name: 'tip_radius_mm', value: 2, inch: 1.5875 },
  { name: 'side_radius_mm', value: 80, inch: 76.2 },
  { name: 'arcs', text: 'lines', value: '2 0 2 0 60\n40 -32.90897 21 60 85' },
];
export const SHAPE_NAMES = ['diameter_mm', 'corner_radius_mm', ...FIELDS_OF_SHAPES.map(({ name }) => name)];

/** Whether a cutter of this type has the dimension. */
export const hasDimension = (type, name) => (DIMENSIONS[type] ?? []).includes(name);

/** Shows the fields of the dimensions that a cutter of this type has; those of a cutter in another role have names with a prefix. */
export function arrangeShape(form, type, prefix = '') {
  for (const name of SHAPE_NAMES) form.element(prefix + name).hidden = !hasDimension(type, name);
}

/** The cutter of a form's values, as the service takes it. */
export function cutterOf({ type, teeth, ...values }) {
  const dimensions = SHAPE_NAMES.filter((name) => hasDimension(type, name)).map((name) => [name, name === 'arcs' ? arcsOfText(values.arcs ?? '') : values[name]]);
  return stated({ type, ...Object.fromEntries(dimensions), teeth });
}

/** The values of a form for a cutter, as the service takes it. */
export const valuesOfCutter = ({ arcs, ...cutter }) => stated({ ...cutter, arcs: arcs && textOfArcs(arcs) }) ?? {};

export function contactOf(values) {
  if (values.contact_form === 'vectors') return stated({ normal: vector(values.normal), feed: vector(values.feed), tool_axis: vector(values.tool_axis) }) ?? {};
  return stated({ slope_deg: values.slope_deg, feed_angle_deg: values.feed_angle_deg }) ?? {};
}

export function surfaceOf(values) {
  if (values.surface_form === 'radius') return { surface_radius_mm: values.surface_radius_mm };
  if (values.surface_form === 'curvature') return { surface_curvature: stated({ along_per_mm: values.along_per_mm, across_per_mm: values.across_per_mm, twist_per_mm: values.twist_per_mm }) };
  return {};
}

const stepOverOf = (values) => (values.step_form === 'xy' ? { step_over_xy_mm: values.step_over_xy_mm } : { step_over_mm: values.step_over_mm });

/** The cutter, contact and surface of any calculation, for one model. */
export function setting(values, model) {
  return stated({
    cutter: cutterOf(values),
    contact: contactOf(values),
    ...surfaceOf(values),
    runout: stated({ radial_mm: values.radial_mm, axial_mm: values.axial_mm }),
    model,
  });
}

/** The body of the calculation that answers the form's question by `model`. */
export function requestOf(values, model) {
  const { question, feed_per_tooth_mm, scallop_tolerance_mm, spindle_speed_rpm, max_feed_per_tooth_mm, max_feed_rate_mm_min } = values;
  const tolerance = toleranceOf(values, scallop_tolerance_mm);
  const limits = { spindle_speed_rpm, max_feed_per_tooth_mm, max_feed_rate_mm_min };
  const members = {
    height: { ...stepOverOf(values), feed_per_tooth_mm },
    step: { ...tolerance, feed_per_tooth_mm },
    feed: { ...stepOverOf(values), ...tolerance, ...limits },
    fastest: { ...tolerance, ...limits, min_step_over_mm: values.min_step_over_mm, max_step_over_mm: values.max_step_over_mm },
  }[question];
  return { ...setting(values, model), ...stated(members) };
}

/** The name of the field that a pointer into a request names. */
export function fieldAt(pointer) {
  const parts = pointer.split('/').filter((part) => part !== '' && !/^\d+$/.test(part));
  // All arcs have one field.
  if (parts.includes('arcs')) return 'arcs';
  // A roughness without Ra.
  return parts.at(-1) === 'roughness' ? 'ra_um' : parts.at(-1);
}
