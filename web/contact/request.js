// The contact view's requests: the form's values as bodies of the service's calculations, and which field a pointer names.

import { toleranceOf } from '../tolerance.js';

export const ENDPOINTS = { height: 'v1/scallop-height', step: 'v1/step-over', feed: 'v1/max-feed', fastest: 'v1/cutting-parameters' };

const vector = (text) =>
  text === undefined ? undefined : String(text).split(/[\s,;]+/).filter(Boolean).map((part) => (Number.isFinite(Number(part)) ? Number(part) : part));

/** Members without a value are left out. */
function stated(members) {
  const entries = Object.entries(members).filter(([, value]) => value !== undefined);
  return entries.length > 0 ? Object.fromEntries(entries) : undefined;
}

/** The dimensions of each type of cutter, beside its diameter. */
const DIMENSIONS = {
  toroidal: ['corner_radius_mm'], ball_end: [], flat_end: [], tapered_ball: ['taper_deg', 'shank_diameter_mm'], lens: ['lens_radius_mm', 'corner_radius_mm'],
  oval: ['tip_radius_mm', 'side_radius_mm'], conical_barrel: ['tip_radius_mm', 'side_radius_mm', 'taper_deg'],
};

/** The fields of these dimensions, but for the corner radius, which forms have with a value of their own. */
export const FIELDS_OF_SHAPES = [
  { name: 'taper_deg', value: 5 },
  { name: 'shank_diameter_mm', value: 16, inch: 15.875 },
  { name: 'lens_radius_mm', value: 40, inch: 38.1 },
  { name: 'tip_radius_mm', value: 2, inch: 1.5875 },
  { name: 'side_radius_mm', value: 80, inch: 76.2 },
];
export const SHAPE_NAMES = ['corner_radius_mm', ...FIELDS_OF_SHAPES.map(({ name }) => name)];

/** Whether a cutter of this type has the dimension. */
export const hasDimension = (type, name) => (DIMENSIONS[type] ?? []).includes(name);

export function cutterOf({ type, diameter_mm, teeth, ...values }) {
  const dimensions = SHAPE_NAMES.filter((name) => hasDimension(type, name)).map((name) => [name, values[name]]);
  return stated({ type, diameter_mm, ...Object.fromEntries(dimensions), teeth });
}

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
  // A roughness without Ra.
  return parts.at(-1) === 'roughness' ? 'ra_um' : parts.at(-1);
}
