// A cutter from the side with its dimensions, for the setup sheet.

import { svg } from '../dom.js';
import { arcsOf, diameterOf, outlineOf } from '../contact/profile.js';
import { formatRound } from '../units.js';

const [WIDTH, HEIGHT, WIDEST] = [165, 150, 66];

/** The drawing of a cutter as the service takes it. */
export function cutterDrawing({ corner_radius_mm: corner = 0, flute_length_mm: flutes, ...cutter }) {
  const arcs = arcsOf({ ...cutter, corner_radius_mm: corner });
  const diameter = diameterOf(arcs);
  const below = outlineOf(arcs);
  const [outer, top] = below.at(-1);
  const [middle, foot] = [WIDTH / 2 - 18, HEIGHT - 28];
  const scale = Math.min(WIDEST / (2 * outer), (foot - 16) / top);
  const r = arcs[0].radius;
  const [half, radius] = [outer * scale, Math.min(r * scale, foot - 40)];
  const right = below.map(([rho, height]) => [middle + rho * scale, foot - height * scale]);
  const left = below.map(([rho, height]) => [middle - rho * scale, foot - height * scale]).reverse();
  const outline = `M${middle - half} 12L${[...left, ...right].map((point) => point.join(' ')).join('L')}V12`;
  return svg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, width: WIDTH, height: HEIGHT, role: 'img', 'aria-label': `Cutter of ${formatRound(diameter, 'length')} diameter` },
    svg('path', { class: 'sheet-cutter', d: outline }),
    svg('path', { class: 'axis', d: `M${middle} 4V${foot + 6}` }),
    svg('path', { class: 'dimension', d: `M${middle - half} ${foot + 4}v10M${middle + half} ${foot + 4}v10M${middle - half} ${foot + 10}h${2 * half}` }),
    svg('text', { x: middle, y: HEIGHT - 4, 'text-anchor': 'middle' }, `⌀ ${formatRound(diameter, 'length')}`),
    r > 0 && svg('text', { x: middle + half + 4, y: foot - radius / 2 }, `R ${formatRound(r, 'length')}`),
    flutes && svg('text', { x: middle + half + 4, y: 24 }, `l ${formatRound(flutes, 'length')}`));
}
