// Units: values are held in the service's units (mm, degrees, seconds); this module converts and formats them for the page.

const INCH = 25.4;

// For each kind of quantity: [unit, displayed value per service value, significant digits], metric and inch.
const KINDS = {
  length: { mm: ['mm', 1, 4], inch: ['in', 1 / INCH, 4] },
  height: { mm: ['µm', 1000, 4], inch: ['thou', 1000 / INCH, 4] },
  roughness: { mm: ['µm', 1, 3], inch: ['µin', 1000 / INCH, 3] },
  curvature: { mm: ['1/mm', 1, 4], inch: ['1/in', INCH, 4] },
  feedRate: { mm: ['mm/min', 1, 4], inch: ['in/min', 1 / INCH, 4] },
  area: { mm: ['mm²', 1, 4], inch: ['in²', 1 / INCH ** 2, 4] },
  areaRate: { mm: ['mm²/min', 1, 4], inch: ['in²/min', 1 / INCH ** 2, 4] },
  acceleration: { mm: ['m/s²', 1, 4] },
  jerk: { mm: ['m/s³', 1, 4] },
  angle: { mm: ['°', 1, 4] },
  speed: { mm: ['rpm', 1, 5] },
  share: { mm: ['%', 100, 3] },
  time: { mm: ['s', 1, 4] },
  count: { mm: ['', 1, 0] },
  number: { mm: ['', 1, 4] },
};

let system = 'mm';

/** The system of units in use: "mm" or "inch". */
export const units = () => system;

export function setUnits(name) {
  system = name === 'inch' ? 'inch' : 'mm';
}

function measure(kind) {
  const [unit, factor, digits] = KINDS[kind][system] ?? KINDS[kind].mm;
  return { unit, factor, digits };
}

export const unitOf = (kind) => measure(kind).unit;
export const factorOf = (kind) => measure(kind).factor;

/** A number with `digits` significant digits, never in exponent form unless it is very small. */
export function plainNumber(value, digits) {
  if (value === 0) return '0';
  // Uses the rounded value: 0.99999 is shown as 1.000.
  const magnitude = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(digits)))));
  if (magnitude < -7 || magnitude > 14) return value.toExponential(digits - 1);
  return value.toFixed(Math.max(0, digits - 1 - magnitude));
}

/** A value of the service as the page shows it, without its unit. */
export function format(value, kind) {
  if (value === null || value === undefined) return '–';
  const { factor, digits } = measure(kind);
  // A count is a whole number, except the quotients of method rectangle.
  if (kind === 'count') return String(Number(value.toFixed(2)));
  // Directions are stated to two decimals at most, and most of them are whole.
  if (kind === 'angle') return String(Number(value >= 100 ? value.toFixed(2) : value.toPrecision(digits)));
  return plainNumber(value * factor, digits);
}

/** The same with its unit. */
export function formatWithUnit(value, kind) {
  const unit = unitOf(kind);
  return `${format(value, kind)}${unit === '' || unit === '°' ? unit : ` ${unit}`}`;
}

/** A round value with its unit, without trailing zeros. */
export function formatRound(value, kind) {
  return `${Number((value * factorOf(kind)).toPrecision(4))} ${unitOf(kind)}`;
}

/** The text of a value in an input: as many digits as were stated, at most seven. */
export function formatInput(value, kind) {
  if (typeof value !== 'number') return value ?? '';
  return String(Number((value * factorOf(kind)).toPrecision(7)));
}

// Service values per typed unit, by kind.
const LENGTHS = { um: 1e-3, µm: 1e-3, μm: 1e-3, mm: 1, cm: 10, m: 1000, in: INCH, inch: INCH, '"': INCH, '″': INCH, mil: INCH / 1000, thou: INCH / 1000 };
const TYPED = {
  length: LENGTHS,
  height: LENGTHS,
  roughness: { um: 1, µm: 1, μm: 1, uin: 0.0254, µin: 0.0254 },
  feedRate: { 'mm/min': 1, 'm/min': 1000, 'in/min': INCH, ipm: INCH, 'mm/s': 60 },
  curvature: { '1/mm': 1, '1/m': 1e-3, '1/in': 1 / INCH },
  angle: { '°': 1, deg: 1, rad: 180 / Math.PI },
  share: { '%': 0.01 },
  speed: { rpm: 1, '1/min': 1, 'rev/min': 1 },
  acceleration: { 'm/s²': 1, 'm/s2': 1, 'mm/s2': 1e-3, g: 9.80665 },
  jerk: { 'm/s³': 1, 'm/s3': 1 },
};

// A number with a decimal point or comma, a fraction such as 1/2, or a whole number with a fraction.
function numberOf(text) {
  const [, whole, over, under] = /^([+-]?\d+\s+)?([+-]?[\d.]+)\s*\/\s*([\d.]+)$/.exec(text) ?? [];
  if (under !== undefined) return Number(whole ?? 0) + (Math.sign(Number(whole ?? 1)) || 1) * (Number(over) / Number(under));
  return text === '' ? Number.NaN : Number(/^[^.]*,[^.,]*$/.test(text) ? text.replace(',', '.') : text);
}

/**
 * The service's value of a typed text: a number in the unit in use, or with a unit of its own such as 0.5in, 1/2 or 10um. Other text is returned
 * as it is, for the service to report.
 */
export function parseInput(text, kind) {
  const typed = text.trim();
  if (typed === '') return undefined;
  const plain = numberOf(typed);
  const factor = factorOf(kind);
  if (Number.isFinite(plain)) return factor === 1 ? plain : Number((plain / factor).toPrecision(12));
  for (const [unit, value] of Object.entries(TYPED[kind] ?? {})) {
    if (!typed.toLowerCase().endsWith(unit)) continue;
    const number = numberOf(typed.slice(0, -unit.length).trim());
    if (Number.isFinite(number)) return Number((number * value).toPrecision(12));
  }
  return typed;
}

const rounded = (value) => String(Number(value.toPrecision(4)));

/** A text of the service in the units in use: lengths in mm, and the bare numbers of a bound if the field's `kind` is known. */
export function inUnits(text, kind) {
  const lengths = kind === 'height' ? 'height' : 'length';
  const named = system === 'inch' || lengths === 'height' ? text.replaceAll(/(-?\d+(?:\.\d+)?) mm(?![²³/\w])/g, (_, number) => `${rounded(number * factorOf(lengths))} ${unitOf(lengths)}`).replaceAll(/(-?\d+(?:\.\d+)?) mm\/min/g, (_, number) => `${rounded(number * factorOf('feedRate'))} ${unitOf('feedRate')}`) : text;
  if (!kind || factorOf(kind) === 1) return named;
  return named.replace(/^must be from (-?[\d.]+) to (-?[\d.]+), found the number (-?[\d.e-]+)/, (_, low, high, found) => `must be from ${rounded(low * factorOf(kind))} to ${rounded(high * factorOf(kind))} ${unitOf(kind)}, found ${rounded(found * factorOf(kind))}`);
}

/** Seconds, or minutes and seconds, or hours, minutes and seconds, whichever suits `longest`, so that the times of a column have one form. */
export function formatTime(seconds, longest = seconds) {
  if (seconds === null || seconds === undefined) return '–';
  if (longest < 120) return `${plainNumber(seconds, 3)} s`;
  const whole = Math.round(seconds);
  const two = (number) => String(number).padStart(2, '0');
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  return Math.max(longest, seconds) < 3600 ? `${minutes}:${two(rest)} min` : `${hours}:${two(minutes)}:${two(rest)} h`;
}

/** Ticks at round numbers from `low` to `high`, about `count` of them. */
export function ticks(low, high, count) {
  const step = roundStep((high - low) / count);
  const found = [];
  for (let tick = Math.ceil(low / step - 1e-9); tick * step <= high * (1 + 1e-9); tick += 1) found.push(Number((tick * step).toPrecision(12)));
  return found;
}

/** The largest of 1, 2 and 5 times a power of ten that does not exceed `value`. */
export function roundStep(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  const lead = value / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}
