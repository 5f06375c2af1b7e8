// A plan of several operations: its table, its colours on the map, and its tools by their numbers in the program.

import { el } from '../dom.js';
import { figure, term, valueOf } from '../figures.js';
import { TERMS, inWords, nameOf } from '../terms.js';
import { formatTime, formatWithUnit, unitOf } from '../units.js';
import { OPERATIONS } from './palette.js';
import { toolCalls } from './program.js';

/** The plan of several operations; null where one operation is the plan. */
export const severalOf = (answer) => (answer?.plan?.operations.length > 1 ? answer.plan : null);

const COLUMNS = [
  ['machining_time_s', ({ machining_time_s: time }) => time],
  ['area_share', ({ region }) => region.area_share],
  ['passes', ({ passes }) => passes],
  ['step_over_xy_mm', ({ step_over_xy_mm: step }) => step?.median],
  ['step_down_mm', ({ step_down_mm: step }) => step?.median],
  ['feed_rate_mm_min', ({ feed_rate_mm_min: rate }) => rate],
  ['scallop_p99_mm', ({ scallop_height_mm: height }) => height.p99],
  ['gouge_mm', ({ gouge_mm: gouge }) => gouge],
];

const linesOf = ({ family, direction_deg: direction }) => `${inWords(family)}${direction === undefined ? '' : ` at ${formatWithUnit(direction, 'angle')}`}`;
const slopesOf = ({ region: { slope_deg: slopes, after } }) => `${slopes.map((slope) => formatWithUnit(slope, 'angle')).join(' to ')}${after === undefined ? '' : `, what ${after + 1} leaves`}`;

/** A word for each operation, in the colour of its path: [text, css colour]. */
export const operationKeys = ({ operations }) => operations.map((operation, i) => [`${i + 1}: ${nameOf(operation)}, ${linesOf(operation)}`, OPERATIONS[i]]);

/** The table of the operations; `single` is the best plan of one. */
export function operationsTable(plan, single) {
  const { operations, machining_time_s: time, tool_changes: changes } = plan;
  const present = COLUMNS.filter(([, read]) => operations.some((operation) => read(operation) !== undefined));
  const swatch = (i) => {
    const found = el('span', { class: 'swatch' });
    found.style.background = OPERATIONS[i];
    return found;
  };
  const cell = (name, value) => (name === 'machining_time_s' ? el('data', { value, 'data-figure': name }, formatTime(value, time)) : valueOf(name, value));
  const saved = 1 - time / single.machining_time_s;
  return el('div', { class: 'operations' },
    el('p', {}, el('b', {}, `In ${operations.length} operations: `), el('data', { value: time, 'data-figure': 'operations_time' }, formatTime(time)), ` with `, figure('tool_changes', changes), ` tool change${changes === 1 ? '' : 's'}; `,
      saved >= 0 ? `${formatWithUnit(saved, 'share')} less than the best plan of one, ${formatTime(single.machining_time_s)}.` : `the best plan of one takes ${formatTime(single.machining_time_s)} and leaves more.`),
    el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Operations' }, el('table', { class: 'ranking' },
      el('thead', {},
        el('tr', {}, el('th', { scope: 'col' }, 'Operation'), el('th', { scope: 'col' }, 'Lines'), el('th', { scope: 'col' }, 'Slopes'), present.map(([name]) => el('th', { scope: 'col' }, term(name)))),
        el('tr', { class: 'units' }, el('td', {}), el('td', {}), el('td', {}), present.map(([name]) => el('td', {}, name === 'machining_time_s' ? '' : unitOf(TERMS[name].kind))))),
      el('tbody', {}, operations.map((operation, i) => el('tr', { 'data-operation': i },
        el('th', { scope: 'row' }, swatch(i), `${i + 1} ${nameOf(operation)}`), el('td', { class: 'words' }, linesOf(operation)), el('td', { class: 'words' }, slopesOf(operation)),
        present.map(([name, read]) => el('td', {}, cell(name, read(operation))))))))));
}

/** The cutters of a plan of several operations by the numbers of its program's tool calls. */
export function cuttersByNumber({ operations }, program, cutters) {
  return Object.fromEntries(toolCalls(program).map((number, i) => [number, cutters[operations[i].cutter]]));
}
