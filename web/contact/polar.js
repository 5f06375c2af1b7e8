// The polar chart: the largest step-over for each direction of the feed, for both models. A click takes a direction.

import { svg } from '../dom.js';
import { formatWithUnit, factorOf, ticks, unitOf, plainNumber } from '../units.js';
import { cosineOf, sineOf } from './frame.js';

// The rings' labels stand between two spokes.
const LABELS_AT_DEG = 345;

/**
 * `angles` in degrees from 0 to under 180 (the period is 180), `series` [{className, values}] in mm with null where there is no answer,
 * `feedAngle` the direction in use.
 */
export function polarChart({ angles, series, feedAngle, size, onPick }) {
  const radius = size / 2 - 34;
  const middle = size / 2;
  const known = series.flatMap(({ values }) => values).filter((value) => value !== null).sort((a, b) => a - b);
  if (known.length === 0) return null;
  // The published radii grow without bound on slight slopes, so the scale is that of the first series, the exact shape.
  const most = Math.max(...series[0].values.filter((value) => value !== null), known[0]);
  const scale = radius / (most * 1.05);
  // Uphill is at the top; angles run counter-clockwise, as seen from above.
  const place = (angle, value) => [middle - sineOf(angle) * value * scale, middle - cosineOf(angle) * value * scale];
  const factor = factorOf('length');
  const rings = ticks(0, most * factor, 3).filter((tick) => tick > 0);
  const path = (values) => {
    const both = [...angles.map((angle, i) => [angle, values[i]]), ...angles.map((angle, i) => [angle + 180, values[i]])];
    let d = '';
    let pen = false;
    for (const [angle, value] of [...both, both[0]]) {
      if (value === null) {
        pen = false;
        continue;
      }
      const [x, y] = place(angle, Math.min(value, most * 1.05));
      d += `${pen ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`;
      pen = true;
    }
    return d;
  };
  const rim = most * 1.05;
  const [fx, fy] = place(feedAngle, rim);
  const [bx, by] = place(feedAngle + 180, rim);
  const best = series[0].values.reduce((found, value, i) => (value !== null && (found < 0 || value > series[0].values[found]) ? i : found), -1);
  const chart = svg(
    'svg',
    { viewBox: `0 0 ${size} ${size}`, width: size, height: size, role: 'img', class: 'polar',
      'aria-label': best < 0 ? 'Largest step-over by feed direction' : `Largest step-over by feed direction: ${formatWithUnit(series[0].values[best], 'length')} at ${angles[best]}°.` },
    rings.map((ring) => svg('circle', { class: 'grid', cx: middle, cy: middle, r: (ring / factor) * scale })),
    [0, 30, 60, 90, 120, 150].map((angle) => {
      const [x1, y1] = place(angle, rim);
      const [x2, y2] = place(angle + 180, rim);
      return svg('path', { class: 'grid', d: `M${x1} ${y1}L${x2} ${y2}` });
    }),
    svg('path', { class: 'feed', d: `M${bx} ${by}L${fx} ${fy}` }),
    series.toReversed().map(({ className, values }) => svg('path', { class: `curve ${className}`, d: path(values) })),
    rings.map((ring) => {
      const [x, y] = place(LABELS_AT_DEG, ring / factor);
      return svg('text', { x, y: y + 4, 'text-anchor': 'middle' }, plainNumber(ring, 2));
    }),
    [[0, '0° uphill', 'middle', 0, -6], [90, '90°', 'end', -4, 4], [180, '180°', 'middle', 0, 14], [270, '270°', 'start', 4, 4]].map(([angle, text, anchor, dx, dy]) => {
      const [x, y] = place(angle, rim);
      return svg('text', { x: x + dx, y: y + dy, 'text-anchor': anchor }, text);
    }),
    svg('text', { x: size - 4, y: size - 4, 'text-anchor': 'end' }, unitOf('length')),
  );
  chart.addEventListener('click', (event) => {
    const box = chart.getBoundingClientRect();
    const k = size / box.width;
    const [x, y] = [(event.clientX - box.left) * k - middle, (event.clientY - box.top) * k - middle];
    onPick(Math.round((((Math.atan2(-x, -y) * 180) / Math.PI) + 180) % 180));
  });
  return chart;
}
