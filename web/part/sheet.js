// The setup sheet: one page with part, cutter, plan, figures and drawing, to be printed.

import { el } from '../dom.js';
import { reasonList, warningList } from '../figures.js';
import { TERMS, inWords, nameOf } from '../terms.js';
import { heightOf } from '../tolerance.js';
import { formatRound, formatTime, formatWithUnit } from '../units.js';
import { cutterDrawing } from './cutter_drawing.js';
import { operationsTable, severalOf } from './operations.js';
import { checkList, checksOf } from './verdict.js';

const PROGRAM_LINES = 7;

const listOf = (rows) => el('table', { class: 'sheet-list' }, el('tbody', {}, rows.filter(([, value]) => value !== undefined && value !== '').map(([label, value]) => el('tr', {}, el('th', { scope: 'row' }, label), el('td', {}, value)))));
const round = (value, kind) => (value === undefined ? undefined : formatRound(value, kind));
const figure = (value, kind) => (value === undefined ? undefined : formatWithUnit(value, kind));

function partRows({ part, answer }) {
  const { bounds_mm: { min, max }, area_mm2: area, facets, pieces } = answer.surface;
  const size = [0, 1, 2].map((axis) => formatWithUnit(max[axis] - min[axis], 'length')).join(' × ');
  return [['Part', part], [TERMS.bounds_mm.label, size], ['Lowest, highest Z', `${figure(min[2], 'length')}, ${figure(max[2], 'length')}`], [TERMS.area_mm2.label, figure(area, 'area')], [TERMS.facets.label, facets.toLocaleString('en')], [TERMS.pieces.label, String(pieces)]];
}

function cutterRows(cutter, candidate) {
  const kinds = { diameter_mm: 'length', corner_radius_mm: 'length', lens_radius_mm: 'length', tip_radius_mm: 'length', side_radius_mm: 'length', taper_deg: 'angle', shank_diameter_mm: 'length', flute_length_mm: 'length', spindle_speed_rpm: 'speed', max_feed_per_tooth_mm: 'length' };
  return [['Cutter', nameOf(candidate)], ['Shape', inWords(candidate.type)], ['Teeth', cutter.teeth && String(cutter.teeth)], ...Object.entries(kinds).map(([name, kind]) => [TERMS[name].label, round(cutter[name], kind)])];
}

// The cutters of several operations, each once with its shape and sizes.
function toolRows({ operations }, cutters) {
  const shapeOf = ({ type, diameter_mm, corner_radius_mm, teeth }) => [inWords(type), round(diameter_mm, 'length'), corner_radius_mm && `R ${round(corner_radius_mm, 'length')}`, teeth && `${teeth} teeth`].filter(Boolean).join(', ');
  const used = new Map(operations.map((operation) => [operation.cutter, operation]));
  return [...used].map(([cutter, operation]) => [nameOf(operation), cutters[cutter] ? shapeOf(cutters[cutter]) : 'of a library']);
}

function planRows({ candidate, parameters, machine }) {
  return [
    ['Tolerance', round(heightOf(parameters), 'height')], ['Pattern', inWords(parameters.pattern ?? 'zigzag')], ['Direction', figure(candidate.direction_deg, 'angle')], ['Passes', candidate.passes && String(candidate.passes)],
    ['Step-over in XY', figure(candidate.step_over_xy_mm?.median, 'length')], ['Feed rate', candidate.feed_rate_mm_min && `${figure(candidate.feed_rate_mm_min, 'feedRate')}${candidate.feed === 'assumed' ? ' (assumed)' : ''}`], ['Feed per tooth', figure(candidate.feed_per_tooth_mm, 'length')],
    ['Ra of the drawing', round(parameters.roughness?.ra_um, 'roughness')], ['Time', formatTime(candidate.machining_time_s)], ['Path length', figure(candidate.path_length_mm, 'length')], ['Lifts', candidate.links && String(candidate.links.lifts)], ['Machine', machine],
  ];
}

function figureRows(candidate) {
  const { scallop_height_mm: height } = candidate;
  return [['Scallop height, median', figure(height?.p50, 'height')], ['Scallop height, p99', figure(height?.p99, 'height')], ['Scallop height, most', figure(height?.max, 'height')], ['Over tolerance', figure(candidate.over_tolerance_share, 'share')], ['Uncut', figure(candidate.uncut_share, 'share')], ['Uncut height', figure(candidate.uncut_height_mm, 'height')], ['Deepest gouge', figure(candidate.gouge_mm, 'height')]];
}

/**
 * Shows the sheet of a plan: {part, answer, candidate, cutter, parameters, machine, drawing, program}; `drawing` is the map as the address of an
 * image, `program` a text.
 */
export function showSheet(plan) {
  const { answer, candidate, cutter, parameters, drawing, program } = plan;
  const several = severalOf(answer);
  const dialog = el('dialog', { class: 'sheet', 'aria-labelledby': 'sheet-title' },
    el('div', { class: 'sheet-buttons' }, el('button', { type: 'button', class: 'primary', onclick: () => print() }, 'Print'), el('button', { type: 'button', onclick: () => dialog.close() }, 'Close')),
    el('header', {}, el('h1', { id: 'sheet-title' }, 'Setup sheet'), el('p', {}, `${plan.part} · ${nameOf(candidate)} · ${new Date().toISOString().slice(0, 16).replace('T', ' ')} UTC`)),
    el('div', { class: 'sheet-columns' },
      el('section', {}, el('h2', {}, 'Part'), listOf(partRows(plan))),
      several
        ? el('section', {}, el('h2', {}, 'Cutters'), listOf(toolRows(several, parameters.cutters ?? [])))
        : el('section', { class: 'sheet-tool' }, el('h2', {}, 'Cutter'), listOf(cutterRows(cutter, candidate)), cutter.type && cutterDrawing(cutter)),
      el('section', {}, el('h2', {}, 'Plan'), listOf(planRows(plan))),
      el('section', {}, el('h2', {}, 'What it leaves'), listOf(figureRows(candidate)), checkList(checksOf(candidate, parameters, answer.confidence)))),
    several && el('section', {}, el('h2', {}, 'Operations'), operationsTable(several, answer.recommended)),
    drawing && el('figure', {}, el('img', { src: drawing, alt: 'The part from above, coloured by scallop height' }), el('figcaption', {}, 'The part from above, coloured by what the plan leaves; the arrow is the direction of the passes.')),
    el('section', {}, el('h2', {}, `Confidence: ${answer.confidence.level}`), reasonList(answer.confidence.reasons), warningList(answer.warnings)),
    program && el('section', {}, el('h2', {}, 'Program, first blocks'), el('pre', {}, program.split('\n').slice(0, PROGRAM_LINES).join('\n'))),
    el('footer', {}, 'Computed by scallopd. Simulate the program before running it.'));
  dialog.addEventListener('close', () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
}
