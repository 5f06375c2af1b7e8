// The contact view's requests: the form's values as bodies of the service's calculations, and which field a pointer names.

export const ENDPOINTS = { height: 'v1/scallop-height', step: 'v1/step-over', feed: 'v1/max-feed', fastest: 'v1/cutting-parameters' };

const vector = (text) =>
  text === undefined ? undefined : String(text).split(/[\s,;]+/).filter(Boolean).map((part) => (Number.isFinite(Number(part)) ? Number(part) : part));

/** Members without a value are left out. */
function stated(members) {
  const entries = Object.entries(members).filter(([, value]) => value !== undefined);
  return entries.length > 0 ? Object.fromEntries(entries) : undefined;
}

export function cutterOf({ type, diameter_mm, corner_radius_mm, teeth }) {
  return stated({ type, diameter_mm, corner_radius_mm: type === 'toroidal' ? corner_radius_mm : undefined, teeth });
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
  const limits = { spindle_speed_rpm, max_feed_per_tooth_mm, max_feed_rate_mm_min };
  const members = {
    height: { ...stepOverOf(values), feed_per_tooth_mm },
    step: { scallop_tolerance_mm, feed_per_tooth_mm },
    feed: { ...stepOverOf(values), scallop_tolerance_mm, ...limits },
    fastest: { scallop_tolerance_mm, ...limits, min_step_over_mm: values.min_step_over_mm, max_step_over_mm: values.max_step_over_mm },
  }[question];
  return { ...setting(values, model), ...stated(members) };
}

/** The name of the field that a pointer into a request names. */
export function fieldAt(pointer) {
  const parts = pointer.split('/').filter((part) => part !== '' && !/^\d+$/.test(part));
  return parts.at(-1);
}
