// The contact's frame: surface normal n, feed F in the tangent plane, T = n x F, and tool axis Z, from angles or vectors.

const DEGREE = Math.PI / 180;

// Exact at multiples of 90 degrees, where the formulas change case.
export function cosineOf(degrees) {
  const turned = ((degrees % 360) + 360) % 360;
  return turned === 90 || turned === 270 ? 0 : Math.cos(turned * DEGREE);
}
export const sineOf = (degrees) => cosineOf(degrees - 90);

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scaled = (a, k) => [a[0] * k, a[1] * k, a[2] * k];
const sum = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

function unit(a) {
  const length = Math.hypot(...a);
  return length > 0 ? scaled(a, 1 / length) : null;
}

/** Angle in the tangent plane, in radians, from the uphill steepest line to a feed at `feedAngle` degrees seen from above. */
export function tangentAngle(slope, feedAngle) {
  const [x, y] = [cosineOf(feedAngle), sineOf(feedAngle) * cosineOf(slope)];
  // On a wall only the feed along it has a part seen from above.
  return x === 0 && y === 0 ? Math.PI / 2 : Math.atan2(y, x);
}

/** The frame {n, F, T, Z} of a contact with the angles `slope` and `feedAngle` in degrees. */
export function frameOfAngles(slope, feedAngle) {
  const n = [sineOf(slope), 0, cosineOf(slope)];
  const uphill = [-cosineOf(slope), 0, sineOf(slope)];
  const omega = tangentAngle(slope, feedAngle);
  const left = cross(n, uphill);
  const F = sum(scaled(uphill, Math.cos(omega)), scaled(left, Math.sin(omega)));
  return { n, F, T: cross(n, F), Z: [0, 0, 1] };
}

/** The frame of a contact with the given vectors, or null where they have none. */
export function frameOfVectors(normal, feed, toolAxis = [0, 0, 1]) {
  const [n, Z] = [unit(normal), unit(toolAxis)];
  if (!n || !Z) return null;
  const F = unit(sum(feed, scaled(n, -dot(feed, n))));
  return F && { n, F, T: cross(n, F), Z };
}

/** Slope and feed angle in degrees of a frame. */
export function anglesOf({ n, F, Z }) {
  const slope = Math.acos(Math.min(1, Math.max(-1, dot(n, Z)))) / DEGREE;
  const uphill = unit(sum(scaled(n, -1), scaled(Z, dot(n, Z))));
  const feed = unit(sum(F, scaled(Z, -dot(F, Z))));
  if (!uphill || !feed) return { slope, feedAngle: 0 };
  return { slope, feedAngle: Math.atan2(dot(cross(uphill, feed), Z), dot(uphill, feed)) / DEGREE };
}
