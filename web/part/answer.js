// Tables and lists of a recommendation's answer.

import { el } from '../dom.js';
import { figure, figureList, term, valueOf, warningList } from '../figures.js';
import { TERMS, inWords } from '../terms.js';
import { formatTime, formatWithUnit, unitOf } from '../units.js';

export const SERIES = ['series-1', 'series-2', 'series-3', 'series-4', 'series-5', 'series-6'];

/** How a candidate is called: its name, or its shape and number. */
export const nameOf = (candidate) => candidate.name ?? `${inWords(candidate.type ?? 'cutter')} ${candidate.cutter + 1}`;

const time = (name, seconds) => el('data', { value: seconds ?? '', 'data-figure': name }, formatTime(seconds));

// [term, value of a candidate, header if it differs]
const COLUMNS = [
  ['direction_deg', (c) => c.direction_deg],
  ['machining_time_s', (c) => c.machining_time_s],
  ['passes', (c) => c.passes],
  ['step_over_xy_mm', (c) => c.step_over_xy_mm?.median],
  ['feed_rate_mm_min', (c) => c.feed_rate_mm_min],
  ['scallop_p99_mm', (c) => c.scallop_height_mm?.p99],
  ['scallop_max_mm', (c) => c.scallop_height_mm?.max],
  ['over_tolerance_share', (c) => c.over_tolerance_share],
  ['uncut_share', (c) => c.uncut_share],
  ['uncut_height_mm', (c) => c.uncut_height_mm],
  ['links_lifts', (c) => c.links?.lifts],
  ['least_time_s', (c) => c.least_time_s],
  ['rectangle_time_s', (c) => c.rectangle?.machining_time_s],
];

const isTime = (name) => name.endsWith('_time_s') || name === 'least_time_s';
// Feed rates of a simulated plan are a distribution; of a rectangle's one number.
const single = (value) => (value !== null && typeof value === 'object' ? value.median : value);

/** The table of the ranking. `onMap(candidate)` asks for a candidate's map; `mapped` is the cutter whose map is shown. */
export function rankingTable(answer, mapped, onMap) {
  const present = COLUMNS.filter(([, read]) => answer.candidates.some((candidate) => single(read(candidate)) !== undefined));
  return el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Ranking' }, el(
    'table',
    { class: 'ranking' },
    el('thead', {},
      el('tr', {}, el('th', { scope: 'col' }, 'Cutter'), answer.map && el('th', { scope: 'col' }, 'Map'), present.map(([name]) => el('th', { scope: 'col' }, term(name)))),
      el('tr', { class: 'units' }, el('td', {}), answer.map && el('td', {}), present.map(([name]) => el('td', {}, isTime(name) ? '' : unitOf(TERMS[name].kind))))),
    el('tbody', {}, answer.candidates.map((candidate, i) => el(
      'tr',
      { 'data-cutter': candidate.cutter, class: i === 0 ? 'best' : '' },
      el('th', { scope: 'row' }, el('span', { class: `swatch ${SERIES[i % SERIES.length]}` }), nameOf(candidate)),
      answer.map && el('td', {}, mapped === candidate.cutter ? el('span', { class: 'muted' }, 'shown') : el('button', { type: 'button', class: 'quiet', 'aria-label': `Show the map of ${nameOf(candidate)}`, onclick: () => onMap(candidate) }, 'show')),
      present.map(([name, read]) => el('td', {}, isTime(name) ? time(name, read(candidate)) : valueOf(name, single(read(candidate)), TERMS[name].kind))),
    ))),
  ));
}

/** The recommendation in one line, with the confidence and its reasons. */
export function headline(answer) {
  const { recommended, confidence, candidates } = answer;
  const second = candidates[1];
  const lead = second && recommended.machining_time_s > 0 ? second.machining_time_s / recommended.machining_time_s - 1 : null;
  return el(
    'div',
    { class: 'headline' },
    el('p', { class: 'choice' }, el('b', { 'data-figure': 'recommended' }, nameOf({ ...candidates.find(({ cutter }) => cutter === recommended.cutter), ...recommended })), ' at ', figure('direction_deg', recommended.direction_deg), ' in ', el('b', { 'data-help': TERMS.machining_time_s.help }, time('recommended_time', recommended.machining_time_s))),
    lead !== null && el('p', { class: 'muted' }, `${nameOf(second)} takes ${formatWithUnit(lead, 'share')} longer.`),
    confidence && el('div', { class: `confidence ${confidence.level}` }, el('p', {}, 'Confidence: ', el('b', {}, confidence.level)), confidence.reasons.length > 0 && el('ul', {}, confidence.reasons.map((reason) => el('li', {}, typeof reason === 'string' ? reason : (reason.detail ?? inWords(reason.code)))))),
    warningList(answer.warnings),
  );
}

/** Cutters that are listed but not ranked, with their reasons. */
export function notRanked(entries) {
  if (!entries?.length) return null;
  return el('div', { class: 'not-ranked' }, el('h3', {}, 'Not ranked'), el('ul', {}, entries.map(({ cutter, name, code, detail, uncut_share: uncut }) => el('li', {}, el('b', {}, name ?? `Cutter ${cutter + 1}`), ` ${inWords(code)}: ${detail}`, uncut !== undefined && uncut !== null ? [' (', figure('uncut_share', uncut), ' uncut)'] : null))));
}

/** The surface's figures. */
export function surfaceFigures({ surface, critical_slope_deg: criticalSlope }) {
  const names = ['area_mm2', 'points', 'facets', 'slope_deg', 'mean_slope_deg', 'principal_direction_deg', 'steepest_direction_deg', 'form_factor', 'characteristic_size_mm2', 'flatness', 'visible_area_share', 'steep_area_share', 'pieces'];
  return figureList([...names.map((name) => [name, surface[name]]), ['critical_slope_deg', criticalSlope]]);
}

/** The ranking as CSV: header and rows. */
export function rankingRows(answer) {
  const header = ['cutter', 'name', 'type', ...COLUMNS.map(([name]) => name)];
  return [header, answer.candidates.map((candidate) => [candidate.cutter, candidate.name, candidate.type, ...COLUMNS.map(([, read]) => single(read(candidate)))])];
}

/** The passes as CSV: header and rows, one for each point. */
export function passRows(passes) {
  const columns = ['step_over_mm', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm'].filter((name) => passes[name]);
  const header = ['run', 'x_mm', 'y_mm', 'z_mm', 'nx', 'ny', 'nz', 'tip_x_mm', 'tip_y_mm', 'tip_z_mm', ...columns];
  const rows = [];
  let run = 0;
  for (let i = 0; i < passes.tip_mm.length; i += 1) {
    while (run + 1 < passes.run_starts.length && passes.run_starts[run + 1] <= i) run += 1;
    const three = (vector) => vector ?? ['', '', ''];
    rows.push([run, ...three(passes.contact_mm[i]), ...three(passes.normal[i]), ...three(passes.tip_mm[i]), ...columns.map((name) => passes[name][i])]);
  }
  return [header, rows];
}
