// Pass or fail of a plan at the tolerance, and what to do where no cutter can be ranked.

import { el } from '../dom.js';
import { figure } from '../figures.js';
import { heightOf } from '../tolerance.js';
import { formatRound, formatWithUnit } from '../units.js';

// Of the area that the cutter reaches, a plan may leave this share over the tolerance.
const MOST_OVER = 0.005;
const MAX_UNCUT = 0.005;

/** The checks of a candidate's plan, [{passes, text}]; none where its figures are estimates. */
export function checksOf(candidate, parameters, confidence) {
  if (candidate.over_tolerance_share === undefined) return [];
  const tolerance = formatRound(heightOf(parameters), 'height');
  const allowed = parameters.max_uncut_share ?? MAX_UNCUT;
  const gouges = confidence.reasons.some(({ code }) => code === 'gouge');
  return [
    { passes: candidate.over_tolerance_share <= MOST_OVER, text: `${formatWithUnit(1 - candidate.over_tolerance_share, 'share')} of the area that the cutter reaches is within the tolerance of ${tolerance}` },
    { passes: candidate.uncut_share <= allowed, text: `${formatWithUnit(candidate.uncut_share, 'share')} of the area is uncut; ${formatRound(allowed, 'share')} may be` },
    { passes: !gouges, text: candidate.gouge_mm > 0 ? `the deepest cut into the part is ${formatWithUnit(candidate.gouge_mm, 'height')}` : 'nothing is cut into the part' },
  ];
}

/** The list of checks {passes, text} under the word that sums them up; null if there are none. */
export function checkList(checks) {
  if (checks.length === 0) return null;
  const passes = checks.every((check) => check.passes);
  return el('div', { class: `verdict ${passes ? 'pass' : 'fail'}` },
    el('b', { 'data-verdict': passes ? 'pass' : 'fail' }, passes ? 'Within tolerance' : 'Not within tolerance'),
    el('ul', {}, checks.map((check) => el('li', { class: check.passes ? 'pass' : 'fail' }, el('span', { 'aria-hidden': 'true' }, check.passes ? '✓ ' : '✗ '), !check.passes && el('span', { class: 'visually-hidden' }, 'Fails: '), check.text))));
}

// A ball this much smaller than the tightest hollow fits into it.
const INTO_HOLLOW = 0.95;

// The share rounded up to two digits, so that the cutter passes.
function roundedUp(share) {
  const step = 10 ** (Math.floor(Math.log10(share)) - 1);
  return Number((Math.ceil(share / step + 1e-6) * step).toPrecision(2));
}

// A ball end that fits into the tightest hollow, else one of half the smallest cutter's diameter; null where neither is known.
function ballFor(hollow, cutters) {
  const smallest = Math.min(...cutters.map(({ diameter_mm: diameter }) => diameter).filter((diameter) => diameter > 0));
  const diameter = hollow > 0 ? 2 * hollow * INTO_HOLLOW : smallest / 2;
  if (!Number.isFinite(diameter)) return null;
  const step = 10 ** (Math.floor(Math.log10(diameter)) - 1);
  const round = Number((Math.floor(diameter / step + 1e-9) * step).toPrecision(2));
  return { name: `B${round}`, type: 'ball_end', diameter_mm: round };
}

/**
 * What to do where no cutter can be ranked: `problem` as answered, `parameters` as sent; `take(changes)` sets {max_uncut_share} or adds
 * {cutter} and asks again. Null where the service names no remedy.
 */
export function remedies(problem, { max_uncut_share: limit = MAX_UNCUT, cutters = [] }, take) {
  const { not_ranked: entries, needed_max_uncut_share: needed, smallest_concave_radius_mm: hollow } = problem;
  const nearest = entries.filter(({ code }) => code === 'cannot-reach').sort((a, b) => a.uncut_share - b.uncut_share)[0];
  if (!nearest) return null;
  const share = roundedUp(needed ?? nearest.uncut_share);
  const ball = ballFor(hollow, cutters);
  return el('div', { class: 'remedies' },
    el('p', {}, `A ranked cutter may leave ${formatRound(limit, 'share')} of the area uncut (Max uncut, under Method and limits). The nearest, ${nearest.name ?? `cutter ${nearest.cutter + 1}`}, leaves `, figure('needed_max_uncut_share', needed ?? nearest.uncut_share), '.',
      hollow > 0 && [' The tightest hollow has a radius of ', figure('smallest_concave_radius_mm', hollow), '.']),
    el('div', { class: 'actions' },
      el('button', { type: 'button', onclick: () => take({ max_uncut_share: share }) }, `Allow ${formatRound(share, 'share')} uncut`),
      ball && el('button', { type: 'button', onclick: () => take({ cutter: ball }) }, hollow > 0 ? `Add a ball under R ${formatRound(hollow, 'length')}: ${formatRound(ball.diameter_mm, 'length')}` : `Add a ball end of ${formatRound(ball.diameter_mm, 'length')}`)));
}
