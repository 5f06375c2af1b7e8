// The colours of a map's cells by a layer, for the map from above and for the 3D view.

import { CUT, NO_VALUE, REACHED, UNCUT_CELL, cutBelow, scaleOf } from './palette.js';

/** {scale, colourOf(index) as [red, green, blue], keys: [[text, colour]]} of the layer `layer` of `map` at a tolerance in mm. */
export function colouringOf(map, layer, tolerance) {
  const { z_mm: z, uncut_mm: uncut } = map;
  const values = map[layer];
  const scale = scaleOf(layer, values, tolerance);
  const isUncut = (index) => layer === 'scallop_height_mm' && uncut?.[index] > 0;
  const has = (test) => values.some((value, index) => z[index] !== null && test(value, index));
  const colourOf = (index) => (values[index] !== null ? scale.colourOf(values[index]) : isUncut(index) ? UNCUT_CELL : NO_VALUE);
  const keys = [
    layer === 'scallop_height_mm' && has((value) => value !== null && value < cutBelow(tolerance)) && ['cut into the part', CUT],
    layer === 'uncut_mm' && ['within the tolerance', REACHED],
    has((value, index) => value === null && isUncut(index)) && ['uncut', UNCUT_CELL],
    has((value, index) => value === null && !isUncut(index)) && ['not machined', NO_VALUE],
  ].filter(Boolean);
  return { scale, colourOf, keys };
}
