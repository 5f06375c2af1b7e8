// The legend of the map: the scale of colours with its ticks, the tolerance, and what grey means.

import { el, svg } from '../dom.js';
import { factorOf, formatWithUnit, ticks, unitOf } from '../units.js';
import { NO_VALUE } from './palette.js';

const HEIGHT = 36;
const EDGE = 14;
const SLICES = 120;

const css = ([red, green, blue]) => `rgb(${red | 0} ${green | 0} ${blue | 0})`;

/** The legend of a layer {label, kind, grey} with its colour scale, at most `width` pixels wide; `hasGrey` where cells have no value. */
export function legendOf({ label, kind, grey }, { low, high, tolerance, colourOf, note }, width, hasGrey) {
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
    el('span', {}, `${label} (${unitOf(kind)})${tolerance ? `; the mark is the scallop height asked for, ${formatWithUnit(tolerance, 'height')}` : ''}`),
    note && el('span', {}, note),
    hasGrey && el('span', { class: 'grey-key' }, svg('svg', { width: 12, height: 12, 'aria-hidden': 'true' }, svg('rect', { width: 12, height: 12, rx: 2, fill: css(NO_VALUE) })), grey),
  ].filter(Boolean);
}
