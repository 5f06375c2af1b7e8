// Colour scales of the map: a value to red, green and blue, and the ticks of the legend.

/** Red, green and blue of a colour such as #a9aeb2. */
export const hex = (text) => [1, 3, 5].map((at) => Number.parseInt(text.slice(at, at + 2), 16));
const SLOPE = ['#f4f1de', '#b9dcc0', '#6bb8ad', '#35859b', '#2b4f81', '#2a2050'].map(hex);
const WITHIN = ['#f3f8f7', '#c0e0dd', '#78bbbe'].map(hex);
const OVER = ['#f0a93f', '#d9622b', '#8f1d2c'].map(hex);
/** The colour of cells of the uncut layer that the cutter reaches. */
export const REACHED = hex('#cfe3ea');
/** The colour of cells where nothing is machined. Grey has no other meaning. */
export const NO_VALUE = hex('#a9aeb2');
/** The colour of uncut cells, which have no scallop height. */
export const UNCUT_CELL = hex('#7a2f86');
/** The colour of cells that are cut into. */
export const CUT = hex('#c01457');
const UNCUT = ['#f2cf63', '#dd6f4f', '#a22a6d', '#4b1a6b'].map(hex);

function blend(stops, share) {
  const at = Math.min(Math.max(share, 0), 1) * (stops.length - 1);
  const below = Math.min(Math.floor(at), stops.length - 2);
  return stops[below].map((part, i) => part + (stops[below + 1][i] - part) * (at - below));
}

// The service counts heights as over the tolerance if they exceed it by more than 2 %.
const OVER_FROM = 1.02;

/** A height below this is a cut into the part, as the service counts them. */
export const cutBelow = (tolerance) => -(0.002 + tolerance / 5);

/** The scale of a map's layer: {low, high, colourOf(value), tolerance?, note?}. */
export function scaleOf(layer, values, tolerance) {
  const most = values.reduce((found, value) => (value !== null && value > found ? value : found), 0);
  const least = values.reduce((found, value) => (value !== null && value < found ? value : found), most);
  if (layer === 'scallop_height_mm') {
    const high = Math.max(most, tolerance * 1.25);
    return { low: 0, high, tolerance, colourOf: (value) => (value < cutBelow(tolerance) ? CUT : value <= tolerance * OVER_FROM ? blend(WITHIN, value / tolerance) : blend(OVER, (value - tolerance) / Math.max(high - tolerance, 1e-12))) };
  }
  if (layer === 'uncut_mm') {
    const high = Math.max(most, 2 * tolerance);
    return { low: 0, high, note: most > tolerance ? undefined : 'Nothing is left over the tolerance.', colourOf: (value) => (value <= tolerance ? REACHED : blend(UNCUT, value / high)) };
  }
  if (layer === 'slope_deg') {
    const high = Math.max(5, Math.ceil(most / 5) * 5);
    return { low: 0, high, colourOf: (value) => blend(SLOPE, value / high) };
  }
  return { low: least, high: Math.max(most, least + 1e-6), colourOf: (value) => blend(SLOPE, (value - least) / Math.max(most - least, 1e-9)) };
}

/** The colours of the paths of a plan's operations. */
export const OPERATIONS = ['#141e28', '#b0127b', '#0b6a8f'];
