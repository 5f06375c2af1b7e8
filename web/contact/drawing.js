// The cross-section across the feed: the cutter at two neighbouring passes to scale, and a detail of the scallop with the tolerance.
//
// Both show the cutter's exact profile over the surface. Heights over a curved surface are drawn on an arc of its radius.

import { el, svg } from '../dom.js';
import { factorOf, formatRound, formatWithUnit, roundStep } from '../units.js';
import { Profile, grooveCurvature } from './profile.js';

const EXAGGERATIONS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000];

// A length of at most `most` that is round in the units in use.
const roundBar = (most, kind) => roundStep(most * factorOf(kind)) / factorOf(kind);

const line = (points) => points.map(([x, y], index) => `${index ? 'L' : 'M'}${x.toFixed(2)} ${y.toFixed(2)}`).join('');

/** What both drawings show. `stepOver` and heights in mm; `curvature` as {along, across, twist}. */
export function section({ frame, diameter, arcs, stepOver, curvature, height, stepOverHeight, tolerance }) {
  const R = diameter / 2;
  const profile = new Profile(frame, arcs);
  return { frame, R, profile, stepOver, across: curvature.across ?? 0, groove: grooveCurvature(frame, arcs, curvature), height, stepOverHeight, tolerance };
}

// A point at the arc length x along the surface and the height w over it, in the plane of the drawing.
function bent(across, x, w) {
  if (Math.abs(across) < 1e-9) return [x, w];
  const turn = x * across;
  const radius = 1 / across;
  return [(radius + w) * Math.sin(turn), (radius + w) * Math.cos(turn) - radius];
}

/** The overview: true to scale, turned so that the tool axis stands upright. */
export function overview(section, width, height) {
  const { profile, R, stepOver, across, groove } = section;
  const [axisX, axisY] = profile.axis;
  const tilt = Math.hypot(axisX, axisY) > 1e-6 ? Math.atan2(axisX, axisY) : 0;
  const reach = 2.6 * R + stepOver;
  const scale = Math.min(width / reach, height / (2.5 * R));
  const place = ([x, y]) => {
    const [turnedX, turnedY] = [x * Math.cos(tilt) - y * Math.sin(tilt), x * Math.sin(tilt) + y * Math.cos(tilt)];
    return [width / 2 + turnedX * scale, height * 0.66 - turnedY * scale];
  };
  const outline = profile.points();
  const cutterAt = (offset) => {
    // The cutter translates without turning.
    const [cx, cy] = bent(across, offset, 0);
    const side = (end) => [end[0] + axisX * 4 * R, end[1] + axisY * 4 * R];
    return line([side(outline[0]), ...outline, side(outline.at(-1))].map(([x, y]) => place([x + cx, y + cy])));
  };
  const axisAt = (offset) => {
    const [cx, cy] = bent(across, offset, 0);
    const [x, y] = [cx + profile.centre[0], cy + profile.centre[1]];
    return line([place([x, y]), place([x + axisX * 4 * R, y + axisY * 4 * R])]);
  };
  const ground = [];
  const floor = (x) => {
    const before = Math.floor(x / stepOver - 0.5) + 0.5;
    return Math.max(0, Math.min(...[before, before + 1].map((pass) => profile.heightOver(x - pass * stepOver, groove))));
  };
  const far = Math.abs(across) > 1e-9 ? Math.min(reach * 1.5, 1.5 / Math.abs(across)) : reach * 1.5;
  for (let i = 0; i <= 240; i += 1) {
    const x = far * (i / 120 - 1);
    const w = floor(x);
    ground.push(place(bent(across, x, Number.isFinite(w) ? Math.min(w, R) : R)));
  }
  // The part is below the surface: down along its normal at both ends.
  const down = (x) => place(bent(across, x, -6 * R * (Math.abs(across) > 1e-9 ? Math.min(1, 0.9 / (6 * R * Math.abs(across))) : 1)));
  const label = `Cross-section across the feed, to scale: two passes of the cutter ${formatWithUnit(stepOver, 'length')} apart.`;
  const bar = roundBar((width * 0.28) / scale, 'length');
  return svg(
    'svg',
    { viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'aria-label': label },
    svg('path', { class: 'part', d: `${line([...ground, down(far), down(0), down(-far)])}Z` }),
    svg('path', { class: 'cutter other', d: cutterAt(-stepOver / 2) }),
    svg('path', { class: 'cutter', d: cutterAt(stepOver / 2) }),
    svg('path', { class: 'axis', d: axisAt(stepOver / 2) }),
    scaleBar(width - 12, height - 10, bar * scale, formatRound(bar, 'length')),
    svg('text', { x: 10, y: height - 10 }, 'scale 1 : 1 in both axes'),
  );
}

function scaleBar(right, y, length, text) {
  return [svg('path', { class: 'dimension', d: `M${right - length} ${y - 4}v4h${length}v-4` }), svg('text', { x: right - length / 2, y: y - 6, 'text-anchor': 'middle' }, text)];
}

/** The detail: one scallop and its two grooves, heights exaggerated by a stated factor, with the tolerance and the dimensions. */
export function detail(section, width, height) {
  const { profile, stepOver, groove, across, stepOverHeight, tolerance } = section;
  const total = section.height;
  const [left, right, top, bottom] = [4, 132, 26, 58];
  const inner = { width: width - left - right, height: height - top - bottom };
  const half = stepOver * 0.8;
  const scale = inner.width / (2 * half);
  const tallest = Math.max(total, stepOverHeight, tolerance ?? 0, 1e-9);
  // A convex surface falls away at the sides of the drawing.
  const fall = Math.abs(across) * half * half * 0.5;
  const exaggeration = EXAGGERATIONS.filter((factor) => (tallest + fall) * scale * factor <= inner.height * 0.8).at(-1) ?? 1;
  const vertical = scale * exaggeration;
  const baseline = height - bottom - (across > 0 ? fall * vertical : 0);
  const middle = left + inner.width / 2;
  const place = (x, w) => [middle + x * scale, baseline - (w - (across * x * x) / 2) * vertical];
  const cusp = profile.cusp(stepOver, groove);
  const cuspX = cusp ? cusp.x - stepOver / 2 : 0;
  const samples = Array.from({ length: 161 }, (_, i) => half * (i / 80 - 1));
  if (cusp) samples.push(cuspX, cuspX - stepOver, cuspX + stepOver);
  samples.sort((a, b) => a - b);
  const roof = (inner.height + 40) / vertical;
  const passAt = (offset) => samples.map((x) => [x, profile.heightOver(x - offset, groove)]).filter(([, w]) => w <= roof && Number.isFinite(w));
  const floor = samples.filter((x) => Math.abs(x) <= half).map((x) => {
    const w = Math.min(...[-1.5, -0.5, 0.5, 1.5].map((pass) => profile.heightOver(x - pass * stepOver, groove)));
    return [x, Math.min(Number.isFinite(w) ? Math.max(0, w) : roof, roof)];
  });
  const at = (points) => line(points.map(([x, w]) => place(x, w)));
  const level = (w) => line(samples.filter((x) => Math.abs(x) <= half).map((x) => place(x, w)));
  const [cuspLeft, cuspTop] = place(cuspX, cusp ? cusp.height : stepOverHeight);
  const foot = place(cuspX, 0)[1];
  const [passLeft, passRight] = [place(-stepOver / 2, 0), place(stepOver / 2, 0)];
  const dimensionY = height - 30;
  const edge = left + inner.width;
  // Labels at the right are at least a line apart.
  const labels = [
    { w: total, text: `height ${formatWithUnit(total, 'height')}`, class: 'total' },
    total - stepOverHeight > tallest * 1e-3 && { w: stepOverHeight, text: `scallop ${formatWithUnit(stepOverHeight, 'height')}`, class: 'cusp' },
    tolerance !== undefined && { w: tolerance, text: `tolerance ${formatWithUnit(tolerance, 'height')}`, class: 'tolerance' },
    { w: 0, text: 'nominal surface', class: 'nominal' },
  ].filter(Boolean).map((entry) => ({ ...entry, y: place(half, entry.w)[1] })).sort((a, b) => b.y - a.y);
  let free = Infinity;
  for (const entry of labels) free = (entry.textY = Math.min(entry.y + 4, free)) - 14;
  const bar = roundBar((inner.height * 0.3) / vertical, 'height');
  const barLength = bar * vertical;
  // The bar of heights stands at the top of the right margin, or at its foot where labels are at the top.
  const barTop = Math.min(...labels.map(({ textY }) => textY)) - 14 > top + barLength ? top : height - 20 - barLength;
  return svg(
    'svg',
    { viewBox: `0 0 ${width} ${height}`, width, height, role: 'img', 'data-exaggeration': exaggeration, 'data-cusp-mm': cusp?.height ?? '',
      'aria-label': `Detail of the scallop: height ${formatWithUnit(total, 'height')}, step-over ${formatWithUnit(stepOver, 'length')}, heights drawn ${exaggeration} times larger than widths.` },
    svg(
      'svg',
      { x: left, y: top, width: inner.width, height: height - top - 20, viewBox: `${left} ${top} ${inner.width} ${height - top - 20}` },
      svg('path', { class: 'part', d: `${at(floor)}L${edge} ${height - 20}L${left} ${height - 20}Z` }),
      tolerance !== undefined && svg('path', { class: 'tolerance', d: level(tolerance) }),
      svg('path', { class: 'nominal', d: level(0) }),
      total - stepOverHeight > tallest * 1e-3 && svg('path', { class: 'total', d: level(total) }),
      svg('path', { class: 'pass other', d: at(passAt(-stepOver / 2)) }),
      svg('path', { class: 'pass', d: at(passAt(stepOver / 2)) }),
      svg('path', { class: 'ground', d: at(floor) }),
    ),
    cusp && [svg('path', { class: 'height', d: `M${cuspLeft} ${foot}V${cuspTop}` }), svg('circle', { class: 'apex', cx: cuspLeft, cy: cuspTop, r: 3 })],
    svg('path', { class: 'dimension', d: `M${passLeft[0]} ${passLeft[1] + 4}V${dimensionY + 4}M${passRight[0]} ${passRight[1] + 4}V${dimensionY + 4}M${passLeft[0]} ${dimensionY}H${passRight[0]}` }),
    svg('path', { class: 'arrow', d: `M${passLeft[0]} ${dimensionY}l7 -3v6ZM${passRight[0]} ${dimensionY}l-7 -3v6Z` }),
    svg('text', { x: (passLeft[0] + passRight[0]) / 2, y: dimensionY - 5, 'text-anchor': 'middle', class: 'on-part' }, `step-over ${formatWithUnit(stepOver, 'length')}`),
    labels.map((entry) => svg('text', { x: edge + 6, y: entry.textY, class: entry.class }, entry.text)),
    svg('path', { class: 'dimension', d: `M${width - 6} ${barTop}h-4v${barLength}h4` }),
    svg('text', { x: width - 15, y: barTop + barLength / 2 + 4, 'text-anchor': 'end' }, formatRound(bar, 'height')),
    svg('text', { x: left, y: 14 }, exaggeration === 1 ? 'to scale in both axes' : `to scale across; heights × ${exaggeration}`),
  );
}

/** A sentence for a section that cannot be drawn. */
export const noSection = (reason) => el('p', { class: 'muted' }, reason);
