// The requests of the contact view's charts: heights over step-over and feed, and the largest step-over by direction.

import { post } from '../service.js';
import { tangentAngle } from './frame.js';
import { setting } from './request.js';

export const MODELS = ['envelope', 'analytic'];
const STEPS = 40;
const EVERY_DEG = 3;

const repeated = (value, count) => Array.from({ length: count }, () => value);

// A batch of both models: [envelope's column, analytic's column], null where all contacts fail.
async function both(path, values, members, column, signal) {
  const count = members.contacts.slope_deg.length;
  const asked = MODELS.map(async (model) => {
    const { contact, ...rest } = setting(values, model);
    const { answer } = await post(path, { ...rest, ...members, columns: [column] }, signal);
    return answer ? answer[column] : repeated(null, count);
  });
  return Promise.all(asked);
}

/** Heights at step-overs up to twice the one in use. */
export async function heightsOverStepOver(values, { slope, feedAngle, stepOver, feed }, signal) {
  const x = Array.from({ length: STEPS }, (_, i) => (2 * stepOver * (i + 1)) / STEPS);
  const contacts = { slope_deg: repeated(slope, STEPS), feed_angle_deg: repeated(feedAngle, STEPS), step_over_mm: x };
  return { x, columns: await both('v1/scallop-height/batch', values, { contacts, feed_per_tooth_mm: feed }, 'scallop_height_mm', signal) };
}

/** Heights at feeds per tooth up to twice the one in use, or up to the step-over where there is none. */
export async function heightsOverFeed(values, { slope, feedAngle, stepOver, feed }, signal) {
  const most = feed > 0 ? 2 * feed : stepOver;
  const x = Array.from({ length: STEPS + 1 }, (_, i) => (most * i) / STEPS);
  const contacts = { slope_deg: repeated(slope, STEPS + 1), feed_angle_deg: repeated(feedAngle, STEPS + 1), feed_per_tooth_mm: x };
  return { x, columns: await both('v1/scallop-height/batch', values, { contacts, step_over_mm: stepOver }, 'scallop_height_mm', signal) };
}

/** The largest step-over in each direction from 0 to under 180 degrees. The surface stays, so its curvature turns against the feed. */
export async function stepOverByDirection(values, { slope, feedAngle, feed, curvature }, tolerance, signal) {
  const angles = Array.from({ length: 180 / EVERY_DEG }, (_, i) => i * EVERY_DEG);
  const contacts = { slope_deg: repeated(slope, angles.length), feed_angle_deg: angles };
  if (values.surface_form !== 'plane') {
    const turned = angles.map((angle) => turn(curvature, tangentAngle(slope, angle) - tangentAngle(slope, feedAngle)));
    contacts.surface_curvature = Object.fromEntries(['along', 'across', 'twist'].map((name) => [`${name}_per_mm`, turned.map((each) => each[name])]));
  }
  const members = { contacts, feed_per_tooth_mm: feed, scallop_tolerance_mm: tolerance };
  return { angles, columns: await both('v1/step-over/batch', values, members, 'step_over_mm', signal) };
}

// The curvature about a feed turned counter-clockwise by `angle`.
function turn({ along, across, twist }, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return {
    along: c * c * along + 2 * c * s * twist + s * s * across,
    across: s * s * along - 2 * c * s * twist + c * c * across,
    twist: (c * c - s * s) * twist + c * s * (across - along),
  };
}
