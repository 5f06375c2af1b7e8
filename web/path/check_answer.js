// Tables of a program's check: pass or fail, figures with their errors, and the worst places with their lines.

import { el } from '../dom.js';
import { term, valueOf, figure, warningList, reasonList } from '../figures.js';
import { checkList } from '../part/verdict.js';
import { TERMS, inWords } from '../terms.js';
import { format, formatRound, formatTime, formatWithUnit, unitOf } from '../units.js';

const MOST_OVER = 0.005;

function verdictOf({ reachable_over_tolerance_share: over, uncut_share: uncut, gouge, standard_error: error }, tolerance) {
  // Two standard errors: 95 % of samples are within them.
  const percent = (value) => Number((100 * value).toPrecision(2));
  const share = (value, spread) => `${percent(value)} ± ${percent(2 * spread)} %`;
  return checkList([
    { passes: over <= MOST_OVER, text: `${share(over, error.reachable_over_tolerance_share)} of the area is left over the tolerance of ${formatRound(tolerance, 'height')} where the cutter can reach` },
    { passes: uncut <= MOST_OVER, text: `no move comes over ${share(uncut, error.uncut_share)} of the area` },
    { passes: gouge.share === 0, text: gouge.share === 0 ? `no cut into the part is deeper than the limit; the deepest is ${formatWithUnit(gouge.depth_mm, 'height')}` : `${share(gouge.share, error.gouge_share)} of the area is cut into, up to ${formatWithUnit(gouge.depth_mm, 'height')} deep` },
    { passes: gouge.rapid_depth_mm === 0, text: gouge.rapid_depth_mm === 0 ? 'no rapid move cuts into the part' : `rapid moves cut ${formatWithUnit(gouge.rapid_depth_mm, 'height')} deep into the part` },
  ]);
}

/** Verdict, figures, warnings and reasons of an answer. */
export function summaryOf(answer, tolerance) {
  const { residual_mm: residual, feeds } = answer;
  const entry = (name, value) => value !== undefined && el('div', {}, el('dt', {}, term(name)), el('dd', {}, value));
  const time = (name, seconds) => seconds !== undefined && entry(name, el('data', { value: seconds, 'data-figure': name }, formatTime(seconds)));
  const shown = (name, value) => value !== undefined && entry(name, figure(name, value));
  return el('div', {},
    verdictOf(answer, tolerance),
    el('dl', { class: 'figures lead' },
      time('machining_time_s', answer.machining_time_s), time('time_with_new_feeds_s', feeds?.machining_time_s),
      shown('residual_p99_mm', residual?.p99), shown('residual_max_mm', residual?.max), shown('scallop_with_marks_mm', answer.scallop_height_with_marks_mm?.p99), shown('ra_um', answer.ra_um), shown('never_kept_share', feeds?.never_kept_share)),
    el('dl', { class: 'figures' },
      shown('moves', answer.moves), shown('cutting_length_mm', answer.cutting_length_mm), shown('rapid_length_mm', answer.rapid_length_mm), shown('idle_length_mm', answer.idle_length_mm),
      shown('residual_p50_mm', residual?.p50), shown('residual_p90_mm', residual?.p90), shown('used_share', answer.used_share)),
    answer.confidence && el('div', { class: `confidence ${answer.confidence.level}` }, el('p', {}, 'Confidence: ', el('b', {}, answer.confidence.level)), reasonList(answer.confidence.reasons)),
    warningList(answer.warnings));
}

/** The table of the worst places; `onLine(line)` shows a line of the program. */
export function placesTable(places, onLine) {
  if (places.length === 0) return el('p', { class: 'muted' }, 'No place is cut into, left over the tolerance or uncut.');
  const kind = TERMS.residual_max_mm.kind;
  return el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Places' }, el('table', { class: 'ranking places' },
    el('thead', {},
      el('tr', {}, ['Place', 'X', 'Y', 'Z', 'Left', 'Line'].map((head) => el('th', { scope: 'col' }, head))),
      el('tr', { class: 'units' }, el('td', {}), [0, 1, 2].map(() => el('td', {}, unitOf('length'))), el('td', {}, unitOf(kind)), el('td', {}))),
    el('tbody', {}, places.map((place) => el('tr', { 'data-code': place.code },
      el('th', { scope: 'row' }, el('span', { class: `dot ${place.code}`, 'aria-hidden': 'true' }), inWords(place.code)),
      place.point_mm.map((part) => el('td', {}, format(part, 'length'))),
      el('td', {}, place.value_mm === undefined ? '–' : valueOf('place_value_mm', place.value_mm, kind)),
      el('td', {}, place.line === undefined ? '–' : el('button', { type: 'button', class: 'quiet', 'aria-label': `Show line ${place.line}`, onclick: () => onLine(place.line) }, String(place.line))))))));
}

/** Some lines of a program around `line`, which is marked. */
export function excerpt(text, line) {
  const lines = text.split('\n');
  const first = Math.max(0, line - 4);
  return el('pre', { class: 'excerpt', tabindex: '0' }, lines.slice(first, line + 3).map((each, i) => el(first + i + 1 === line ? 'mark' : 'span', {}, `${String(first + i + 1).padStart(7)}  ${each.trimEnd()}\n`)));
}
