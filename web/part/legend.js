// The legend of the map: the scale of colours with its ticks, the tolerance, and the colours beside the scale.

import { el, svg } from '../dom.js';
import { factorOf, formatWithUnit, ticks, unitOf } from '../units.js';

const HEIGHT = 36;
const EDGE = 14;
const SLICES = 120;

const css = ([red, green, blue]) => `rgb(${red | 0} ${green | 0} ${blue | 0})`;

const key = ([text, colour]) => el('span', { class: 'colour-key' }, svg('svg', { width: 12, height: 12, 'aria-hidden': 'true' }, svg('rect', { width: 12, height: 12, rx: 2, fill: css(colour) })), text);

/** The legend of a layer {label, kind} with its colour scale, at most `width` pixels wide; `keys` are further colours, [text, colour]. */
export function legendOf({ label, kind }, { low, high, tolerance, colourOf, note }, width, keys) {
  const factor = factorOf(kind);
  const bar = width - 2 * EDGE;
  const at = (value) => EDGE + ((value - low) / (high - low)) * bar;
  const slices = Array.from({ length: SLICES }, (_, i) => svg('rect', { x: EDGE + (i * bar) / SLICES, y: 4, width: bar / SLICES + 0.6, height: 10, fill: css(colourOf(low + ((high - low) * (i + 0.5)) / SLICES)) }));
  return [
    svg(
      'svg',
      { width, height: HEIGHT, viewBox: `0 0 ${width} ${HEIGHT}`, role: 'img', 'aria-label': `${label} from ${formatWithUnit(low, kind)} to ${formatWithUnit(high, kind)}` },
      slices,
      ticks(low * factor, high * factor, 5).map((tick) => svg('text', { x: at(tick / factor), y: 27, 'text-anchor': 'middle' }, String(tick))),
      tolerance && svg('path', { class: 'tolerance-mark', d: `M${at(tolerance)} 1v16` }),
    ),
    el('span', {}, `${label} (${unitOf(kind)})${tolerance ? `; the mark is the tolerance, ${formatWithUnit(tolerance, 'height')}` : ''}`),
    note && el('span', {}, note),
    ...keys.map(key),
  ].filter(Boolean);
}
