// The kinds of cutters by the names of catalogues, and lengths with units, as the service reads them from tool libraries.

const NAMES = {
  ball_end: ['ball', 'ballend', 'ballnose'],
  toroidal: ['toroidal', 'toroid', 'torus', 'bull', 'bullend', 'bullnose', 'cornerradius'],
  flat_end: ['flat', 'flatend', 'square', 'squareend', ''],
  tapered_ball: ['taperedball', 'taperedballend', 'taperedballnose'],
  lens: ['lens', 'circlesegmentlens'],
  oval: ['oval', 'circlesegmentoval'],
  conical_barrel: ['conicalbarrel'],
};
const MILLIMETRES = { um: 1e-3, µm: 1e-3, μm: 1e-3, mm: 1, millimeter: 1, millimeters: 1, millimetre: 1, millimetres: 1, cm: 10, m: 1000, in: 25.4, inch: 25.4, inches: 25.4, '"': 25.4, mil: 0.0254, thou: 0.0254 };

/** The service's type of a cutter of this kind, in any case and with any separators; null for a tool that is no finishing cutter. */
export function typeNamed(kind) {
  const name = kind.toLowerCase().replaceAll(/[\s_-]+/g, '').replace('nosed', 'nose');
  if (['mill', 'cutter', ''].includes(name)) return null;
  const bare = name.replace(/(?:endmill|mill|cutter)$/, '');
  return Object.keys(NAMES).find((type) => NAMES[type].includes(bare)) ?? null;
}

export const millimetresOf = (unit) => MILLIMETRES[String(unit).toLowerCase()];

/** The number of a text with a decimal point or comma; other text is returned as it is, for the service to report. Empty: undefined. */
export function numberOf(value) {
  if (value === null || value === undefined || value === '') return undefined;
  const number = Number(String(value).trim().replace(',', '.'));
  return Number.isFinite(number) ? number : String(value);
}

/** A length in mm of a number in `unit`, the factor to mm; 0 means unknown. */
export function lengthOf(value, unit) {
  const number = numberOf(value);
  if (typeof number !== 'number') return number;
  return number === 0 ? undefined : number * unit;
}

/** `cutter` as the service takes it: a bull nose whose corner is half the diameter is a ball, one with the corner 0 is flat. */
export function shaped({ type, diameter_mm: diameter, corner_radius_mm: corner, cornerIsStated, ...rest }) {
  if (type === 'lens') return { ...rest, type, diameter_mm: diameter, corner_radius_mm: corner };
  if (type !== 'toroidal') return { ...rest, type, diameter_mm: diameter };
  if (corner === undefined && cornerIsStated) return { ...rest, type: 'flat_end', diameter_mm: diameter };
  if (Math.abs(2 * corner - diameter) <= 1e-9 * diameter) return { ...rest, type: 'ball_end', diameter_mm: diameter };
  return { ...rest, type, diameter_mm: diameter, corner_radius_mm: corner };
}

/** A speed or a number of teeth; 0 means unknown. */
export const countOf = (value) => numberOf(value) || undefined;
