// Tables and lists of a recommendation's answer.

import { el } from '../dom.js';
import { figure, figureList, reasonList, term, valueOf, warningList } from '../figures.js';
import { TERMS, inWords, nameOf } from '../terms.js';
import { formatTime, formatWithUnit, unitOf } from '../units.js';
import { operationsTable, severalOf } from './operations.js';
import { checkList, checksOf } from './verdict.js';

/** The colours of the fastest cutters. */
export const SERIES = ['series-1', 'series-2', 'series-3', 'series-4', 'series-5', 'series-6'];

// Cutters beyond those in the chart have no colour.
const swatch = (i) => el('span', { class: `swatch ${SERIES[i] ?? ''}` });
const timeOf = (name, seconds, longest) => el('data', { value: seconds ?? '', 'data-figure': name }, formatTime(seconds, longest));

// [name in the glossary, figure of a candidate]; step-overs are a distribution, of which the median is shown. A candidate whose time is an estimate has no
// figures of a path.
const COLUMNS = [
  ['machining_time_s', (candidate) => candidate.machining_time_s],
  ['direction_deg', (candidate) => candidate.direction_deg],
  ['passes', (candidate) => candidate.passes],
  ['step_over_xy_mm', (candidate) => candidate.step_over_xy_mm?.median],
  ['feed_rate_mm_min', (candidate) => candidate.feed_rate_mm_min],
  ['scallop_p99_mm', (candidate) => candidate.scallop_height_mm?.p99],
  ['scallop_max_mm', (candidate) => candidate.scallop_height_mm?.max],
  ['ra_um', (candidate) => candidate.ra_um],
  ['over_tolerance_share', (candidate) => candidate.over_tolerance_share],
  ['uncut_share', (candidate) => candidate.uncut_share],
  ['uncut_height_mm', (candidate) => candidate.uncut_height_mm],
  ['gouge_mm', (candidate) => candidate.gouge_mm],
  ['used_share', (candidate) => candidate.used_share],
  ['links_lifts', (candidate) => candidate.links?.lifts],
  ['least_time_s', (candidate) => candidate.least_time_s],
  ['rectangle_time_s', (candidate) => candidate.rectangle?.machining_time_s],
];

// Marks of a candidate whose feed is the machine's, or whose figures are estimates.
const marksOf = ({ feed, figures }) => [
  feed === 'assumed' && el('span', { class: 'mark', 'data-help': 'The cutter states no teeth or no speed: it is timed at the machine’s feed rate, without tooth marks.' }, 'feed assumed'),
  figures === 'estimated' && el('span', { class: 'mark', 'data-help': 'The cutter’s estimated time is over 1.5 times the shortest, so its path was not milled.' }, 'estimated'),
].filter(Boolean);

// A word where cutters with stated and with assumed feeds are compared.
function mixedFeeds(candidates) {
  const assumed = candidates.filter(({ feed }) => feed === 'assumed');
  if (assumed.length === 0 || assumed.length === candidates.length) return null;
  const names = assumed.map((candidate) => nameOf(candidate)).join(', ');
  return el('p', { class: 'mixed-feeds' }, el('b', {}, `The feed of ${names} is assumed. `), `${assumed.length === 1 ? 'It is' : 'They are'} timed at the machine’s feed rate without tooth marks, the others at their own feed: state teeth and speed before comparing them.`);
}

const isTime = (name) => TERMS[name].kind === 'time';

function timeBar(seconds, longest) {
  const bar = el('span', { class: 'time-bar', 'aria-hidden': 'true' });
  bar.style.width = `${(100 * seconds) / longest}%`;
  return bar;
}

/** The button that shows a cutter's map, or a word if the map is shown. `onMap` is null if there is no map. */
function mapButton(cutter, isShown, onMap) {
  if (isShown) return el('span', { class: 'muted' }, 'shown');
  if (!onMap) return el('span', { class: 'muted', 'data-help': 'The page cannot read this cutter’s library. Add the cutter by hand to see its map.' }, '–');
  return el('button', { type: 'button', class: 'quiet', 'aria-label': `Show the map of ${nameOf(cutter)}`, onclick: () => onMap(cutter) }, 'show');
}

/** The table of the ranking. `mapped` is the cutter whose map is shown, `mapFor(candidate)` a function that shows a candidate's map, or null. */
export function rankingTable(answer, mapped, mapFor) {
  const { candidates, map } = answer;
  const present = COLUMNS.filter(([, read]) => candidates.some((candidate) => read(candidate) !== undefined));
  const longest = Math.max(...candidates.map(({ machining_time_s: time }) => time));
  const cell = (name, value) => (isTime(name) ? timeOf(name, value, longest) : valueOf(name, value));
  return el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Ranking' }, el(
    'table',
    { class: 'ranking' },
    el('thead', {},
      el('tr', {}, el('th', { scope: 'col' }, 'Cutter'), map && el('th', { scope: 'col' }, 'Map'), present.map(([name]) => el('th', { scope: 'col' }, term(name)))),
      el('tr', { class: 'units' }, el('td', {}), map && el('td', {}), present.map(([name]) => el('td', {}, isTime(name) ? '' : unitOf(TERMS[name].kind))))),
    el('tbody', {}, candidates.map((candidate, i) => el(
      'tr',
      { 'data-cutter': candidate.cutter, class: i === 0 ? 'best' : '' },
      el('th', { scope: 'row' }, swatch(i), nameOf(candidate), marksOf(candidate)),
      map && el('td', {}, mapButton(candidate, mapped === candidate.cutter, mapFor(candidate))),
      present.map(([name, read], at) => el('td', { class: at === 0 ? 'with-bar' : null }, cell(name, read(candidate)), at === 0 && timeBar(candidate.machining_time_s, longest))),
    ))),
  ));
}

/** The recommendation: the cutter, its main figures, its lead, and the confidence with its reasons. */
export function headline(answer, parameters) {
  const { recommended, confidence, candidates, warnings } = answer;
  const first = candidates.find(({ cutter }) => cutter === recommended.cutter);
  const several = severalOf(answer);
  const second = candidates.find(({ cutter }) => cutter !== recommended.cutter);
  const lead = second && recommended.machining_time_s > 0 ? second.machining_time_s / recommended.machining_time_s - 1 : null;
  const entry = (name, value) => value !== undefined && el('div', {}, el('dt', {}, term(name)), el('dd', {}, value));
  const shown = (name, value) => value !== undefined && entry(name, figure(name, value));
  return el(
    'div',
    { class: 'headline' },
    el('p', { class: 'choice' }, swatch(candidates.indexOf(first)), el('b', { 'data-figure': 'recommended' }, nameOf(first)), el('span', { class: 'muted' }, inWords(first.type)), marksOf(first)),
    mixedFeeds(candidates),
    el('dl', { class: 'figures lead' },
      entry('machining_time_s', timeOf('recommended_time', recommended.machining_time_s)),
      shown('direction_deg', recommended.direction_deg),
      shown('step_over_xy_mm', recommended.step_over_xy_mm),
      shown('feed_rate_mm_min', recommended.feed_rate_mm_min),
      shown('scallop_p99_mm', first.scallop_height_mm?.p99),
      shown('ra_um', first.ra_um),
      shown('uncut_share', first.uncut_share),
      shown('rest_area_share', answer.rest_area_share)),
    several && operationsTable(several, recommended),
    checkList(checksOf(several ?? first, parameters, confidence)),
    lead !== null && el('p', { class: 'muted' }, `${nameOf(second)} comes next and takes ${formatWithUnit(lead, 'share')} longer.`),
    el('div', { class: `confidence ${confidence.level}` }, el('p', {}, 'Confidence: ', el('b', {}, confidence.level), confidence.reasons.length === 0 && el('span', { class: 'muted' }, ' – no weakness of the method shows on this surface.')), reasonList(confidence.reasons)),
    warningList(warnings),
  );
}

/** Cutters that are listed but not ranked, with their reasons. `mapFor` as for the ranking. */
export function notRanked(entries, mapped, mapFor) {
  if (!entries?.length) return null;
  return el('div', { class: 'not-ranked' },
    el('h3', {}, 'Not ranked'),
    el('ul', {}, entries.map((entry) => el('li', { 'data-cutter': entry.cutter },
      el('b', {}, nameOf(entry)), ' ', el('span', { class: 'code' }, inWords(entry.code)), ' ',
      entry.uncut_share === undefined ? `${entry.detail} ` : ['leaves ', figure('uncut_share', entry.uncut_share), ' of the area uncut, up to ', figure('uncut_height_mm', entry.uncut_height_mm), ' high '],
      // A map can show the uncut area of a cutter; a cutter that gouges everywhere has no plan to show.
      entry.code === 'cannot-reach' && mapFor(entry) && mapButton(entry, mapped === entry.cutter, mapFor(entry))))));
}

const SURFACE_FIGURES = ['area_mm2', 'points', 'facets', 'slope_deg', 'mean_slope_deg', 'principal_direction_deg', 'steepest_direction_deg', 'form_factor', 'characteristic_size_mm2', 'flatness', 'visible_area_share', 'steep_area_share', 'pieces'];

/** The surface's figures. */
export function surfaceFigures({ surface, critical_slope_deg: criticalSlope }) {
  const { min, max } = surface.bounds_mm;
  const size = el('div', {}, el('dt', {}, term('bounds_mm')), el('dd', {}, el('span', { class: 'figure' }, [0, 1, 2].map((axis) => [axis > 0 && ' × ', valueOf(`size_${'xyz'[axis]}`, max[axis] - min[axis], 'length')]), el('span', { class: 'unit' }, unitOf('length')))));
  const list = figureList([...SURFACE_FIGURES.map((name) => [name, surface[name]]), ['critical_slope_deg', criticalSlope]]);
  list.prepend(size);
  return list;
}

/** The ranking as CSV: header and rows. Cutters that are not ranked follow with the reason. */
export function rankingRows(answer) {
  const names = COLUMNS.map(([name]) => name);
  const header = ['cutter', 'name', 'type', ...names, 'not_ranked'];
  const ranked = answer.candidates.map((candidate) => [candidate.cutter, candidate.name, candidate.type, ...COLUMNS.map(([, read]) => read(candidate)), '']);
  const others = answer.not_ranked.map((entry) => [entry.cutter, entry.name, '', ...names.map((name) => entry[name]), `${entry.code}: ${entry.detail}`]);
  return [header, [...ranked, ...others]];
}

const CURVATURES = ['along_per_mm', 'across_per_mm', 'twist_per_mm'];
const rounded = (value, decimals) => Number(value.toFixed(decimals));
const significant = (value) => (value === null ? '' : Number(value.toPrecision(6)));

/** The passes as CSV: header and rows, one for each point of the tip's path. Points off the surface have no contact, normal and curvature. */
export function passRows(passes) {
  const columns = ['step_over_mm', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm'].filter((name) => passes[name]);
  const header = ['run', 'move', 'x_mm', 'y_mm', 'z_mm', 'contact_x_mm', 'contact_y_mm', 'contact_z_mm', 'nx', 'ny', 'nz', ...columns, ...CURVATURES];
  const three = (vector, decimals) => (vector ? vector.map((part) => rounded(part, decimals)) : ['', '', '']);
  let run = 0;
  const rows = passes.tip_mm.map((tip, i) => {
    while (run + 1 < passes.run_starts.length && passes.run_starts[run + 1] <= i) run += 1;
    return [run, passes.move[i], ...three(tip, 5), ...three(passes.contact_mm[i], 5), ...three(passes.normal[i], 7), ...columns.map((name) => significant(passes[name][i])), ...CURVATURES.map((name) => significant(passes.surface_curvature[name][i]))];
  });
  return [header, rows];
}
