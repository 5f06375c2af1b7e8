// The profile of a cutter seen along the feed, exactly: the projection of its whole lower body (its lower outline turned about the axis, plus the
// upward ray along the tool axis) onto the plane normal to the feed.
//
// The outline is a chain of arcs {radius r, offset e and height z of the centre, from and to: angles of the normal, 0 straight down}. With
// m(p) = sin(p) T - cos(p) n the support function is H(p) = r + e |m_xy| + z m_z for the arc in whose range m is, m_xy being m's part normal to the
// tool axis, and the boundary point is H m + H' m'. The contact, p = 0, is the origin; x runs along T, y along n.

import { dot } from './frame.js';

const BISECTIONS = 80;
const TABLE = 96;

const RIGHT = Math.PI / 2;
const arc = (radius, offset, height, from, to) => ({ radius, offset, height, from, to });

const RADIANS = Math.PI / 180;

// The stated arcs, and the edge of the cylinder above the last one.
function arcsOfProfile(stated) {
  const arcs = stated.map(({ radius_mm: radius, centre_offset_mm: offset, centre_height_mm: height, from_deg: from, to_deg: to }) => arc(radius, offset, height, from * RADIANS, to * RADIANS));
  const { radius, offset, height, to } = arcs.at(-1);
  return to < RIGHT ? [...arcs, arc(0, offset + radius * Math.sin(to), height - radius * Math.cos(to), to, RIGHT)] : arcs;
}

/** The diameter of the cutter with these arcs. */
export const diameterOf = (arcs) => 2 * Math.max(...arcs.map(({ radius, offset, to }) => offset + radius * Math.sin(to)));

/** The arcs of a cutter as the service takes it, from the axis outwards. */
export function arcsOf({ type, diameter_mm: diameter, corner_radius_mm: corner, taper_deg, shank_diameter_mm: shank, lens_radius_mm: lens, tip_radius_mm: tip, side_radius_mm: side, arcs }) {
  if (type === 'profile') return arcsOfProfile(arcs);
  const R = diameter / 2;
  const taper = type === 'oval' ? 0 : (taper_deg ?? 0) * RADIANS;
  if (type === 'tapered_ball') {
    const top = R * (1 - Math.sin(taper)) + (shank / 2 - R * Math.cos(taper)) / Math.tan(taper);
    return [arc(R, 0, R, 0, RIGHT - taper), arc(0, shank / 2, top, RIGHT - taper, RIGHT)];
  }
  if (type === 'lens') {
    const end = Math.asin((R - corner) / (lens - corner));
    return [arc(lens, 0, lens, 0, end), arc(corner, R - corner, lens - (lens - corner) * Math.cos(end), end, RIGHT)];
  }
  if (type === 'oval' || type === 'conical_barrel') {
    const beyond = side * Math.cos(taper) - R;
    const joint = side > tip ? Math.min(Math.asin(Math.min(beyond / (side - tip), 1)), RIGHT - taper) : 0;
    const height = tip + (side - tip) * Math.cos(joint);
    return [arc(tip, 0, tip, 0, joint), arc(side, -beyond, height, joint, RIGHT - taper), arc(0, R, height - side * Math.sin(taper), RIGHT - taper, RIGHT)];
  }
  const r = { ball_end: R, flat_end: 0 }[type] ?? corner;
  return [arc(r, R - r, r, 0, RIGHT)];
}

/** The arc whose normals contain the angle. */
export const arcAt = (arcs, angle) => arcs.findLast(({ from }) => angle >= from) ?? arcs[0];

/** The outline's points [distance from the axis, height] from the axis outwards. */
export const outlineOf = (arcs, steps = 12) =>
  [[0, 0], ...arcs.flatMap(({ radius, offset, height, from, to }) => Array.from({ length: steps + 1 }, (_, i) => from + ((to - from) * i) / steps).map((angle) => [offset + radius * Math.sin(angle), height - radius * Math.cos(angle)]))];

export class Profile {
  #arcs;
  #origin;
  #lower;
  #table;
  #ends;

  /** `frame` as frame.js gives it, and the arcs of the cutter. */
  constructor(frame, arcs) {
    this.#arcs = arcs;
    const [across, up] = [dot(frame.T, frame.Z), dot(frame.n, frame.Z)];
    this.axis = [across, up];
    // m points down, m . Z <= 0, between these angles; beyond them runs the cutter's side.
    const turn = Math.hypot(across, up) > 1e-9 ? Math.atan2(across, up) : 0;
    this.low = -Math.PI / 2 - turn;
    this.high = Math.PI / 2 - turn;
    this.#origin = [0, 0];
    const [left, right] = [this.#at(0, -1), this.#at(0, 1)];
    // On a floor the contact is a flat of width 2 (R - r); its middle is the origin.
    this.#origin = [(left[0] + right[0]) / 2, right[1]];
    /** The tool axis passes here. */
    this.centre = this.#origin.map((part) => -part);
    // Beyond these angles the boundary turns back over itself.
    this.#lower = [Math.max(this.low, -RIGHT), Math.min(this.high, RIGHT)];
    this.#table = Float64Array.from({ length: TABLE + 1 }, (_, i) => this.#at(this.#angle(i))[0]);
    this.#ends = this.#lower.map((angle) => this.#at(angle));
  }

  // The angle of an entry of the table.
  #angle(i) {
    const [from, to] = this.#lower;
    return from + ((to - from) * i) / TABLE;
  }

  // The angle whose boundary point lies at x, between two neighbouring angles: [below, above]. The table brackets it; secant steps and bisections in turn narrow the bracket, bisections because x jumps at the flat.
  #bracket(x) {
    let [first, last] = [0, TABLE];
    while (last - first > 1) {
      const middle = (first + last) >> 1;
      if (this.#table[middle] < x) first = middle;
      else last = middle;
    }
    let [low, high, atLow, atHigh] = [this.#angle(first), this.#angle(last), this.#table[first] - x, this.#table[last] - x];
    for (let i = 0; i < BISECTIONS && high - low > 1e-15; i += 1) {
      const secant = low - (atLow * (high - low)) / (atHigh - atLow);
      const guess = i % 2 === 0 && secant > low && secant < high ? secant : (low + high) / 2;
      const found = this.#at(guess)[0] - x;
      if (Math.abs(found) < 1e-12) return [guess, guess];
      if (found < 0) [low, atLow] = [guess, found];
      else [high, atHigh] = [guess, found];
    }
    return [low, high];
  }

  // The boundary point at angle p. Where m is the tool axis H has a corner, and `side` chooses the end of the flat.
  #at(p, side = 1) {
    const [across, up] = this.axis;
    const [s, c] = [Math.sin(p), Math.cos(p)];
    // Parts along the tool axis of m and of its derivative by p.
    const mz = s * across - c * up;
    const tz = c * across + s * up;
    const level = Math.sqrt(Math.max(0, 1 - mz * mz));
    // d|m_xy|/dp = m_xy . m'_xy / |m_xy|, and m . m' = 0.
    const slope = level > 1e-12 ? (-mz * tz) / level : side * Math.sqrt(Math.max(0, 1 - tz * tz));
    const { radius, offset, height } = arcAt(this.#arcs, Math.atan2(level, -mz));
    const [h, dh] = [radius + offset * level + height * mz, offset * slope + height * tz];
    return [h * s + dh * c - this.#origin[0], -h * c + dh * s - this.#origin[1]];
  }

  /** The boundary as points from left to right, without the sides. */
  points(count = 240) {
    const found = [];
    for (let i = 0; i <= count; i += 1) {
      const p = this.low + ((this.high - this.low) * i) / count;
      found.push(this.#at(p));
      // Sides of a corner of H that falls between two samples.
      if (i < count && p < 0 && this.low + ((this.high - this.low) * (i + 1)) / count > 0) found.push(this.#at(-1e-13, -1), this.#at(1e-13, 1));
    }
    return found;
  }

  /** Height of the boundary over the tangent at the lateral offset x; infinite beyond a side along the normal. */
  heightAt(x) {
    const [first, last] = this.#ends;
    if (x <= first[0] || x >= last[0]) {
      const end = x <= first[0] ? first : last;
      if (x === end[0]) return end[1];
      const steps = (x - end[0]) / this.axis[0];
      return Math.abs(this.axis[0]) > 1e-12 && steps > 0 ? end[1] + steps * this.axis[1] : Infinity;
    }
    const [low, high] = this.#bracket(x);
    // At a flat the two ends differ, and the boundary between them is straight.
    const [a, b] = [this.#at(low, -1), this.#at(high, 1)];
    return b[0] > a[0] ? a[1] + ((b[1] - a[1]) * (x - a[0])) / (b[0] - a[0]) : a[1];
  }

  /** Height over a surface whose relative curvature across the feed is `curvature` (1/mm, positive where convex). */
  heightOver(x, curvature) {
    return this.heightAt(x) + (curvature * x * x) / 2;
  }

  /** The cusp {x, height} between passes at 0 and `stepOver`, or null where they do not meet. */
  cusp(stepOver, curvature = 0) {
    let [low, high] = [0, stepOver];
    for (let i = 0; i < BISECTIONS; i += 1) {
      const middle = (low + high) / 2;
      if (this.heightOver(middle, curvature) < this.heightOver(middle - stepOver, curvature)) low = middle;
      else high = middle;
    }
    const height = this.heightOver(low, curvature);
    return Number.isFinite(height) ? { x: low, height } : null;
  }
}

/**
 * The curvature across the feed that a groove along it sees, for the surface's curvature {along, across, twist} in the contact's frame:
 * the Schur complement of the relative curvature, less the cutter's own. For a surface curved only across the feed it is `across` itself and
 * exact; otherwise it holds in second order, and cusps drawn with it are within 1 % of the exact ones.
 */
export function grooveCurvature(frame, arcs, { along = 0, across = 0, twist = 0 }) {
  if (along === 0 && twist === 0) return across;
  const { n, F, T, Z } = frame;
  const sine = Math.sqrt(Math.max(0, 1 - dot(n, Z) ** 2));
  // Curvatures of the cutter along the steepest line and across it.
  const { radius: r, offset } = arcAt(arcs, Math.asin(Math.min(sine, 1)));
  const steep = r > 0 ? 1 / r : 1e9;
  const level = 1 / ((offset === 0 ? 0 : offset / Math.max(sine, 1e-9)) + r);
  const [f, t] = [dot(F, Z), dot(T, Z)];
  const length = Math.hypot(f, t);
  const [cosine, sineOmega] = length > 0 ? [f / length, t / length] : [1, 0];
  const c = steep * cosine ** 2 + level * sineOmega ** 2;
  const b = (steep - level) * cosine * sineOmega;
  const plane = -(b * b) / c;
  const curved = -((b + twist) ** 2) / (c + along);
  return across + curved - plane;
}
