// A table of contacts in; feed, step-over or height along the path as a chart, and the table with them added.

import { LineChart } from '../charts.js';
import { addressOf, post, Unreachable } from '../service.js';
import { copy, curlOfJson, save } from '../clipboard.js';
import { debounced, el, fileButton } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { figure, term, warningList } from '../figures.js';
import { TERMS } from '../terms.js';
import { factorOf, formatRound, formatTime, formatWithUnit, unitOf } from '../units.js';
import { CUTTER_FIELDS, CUTTER_NAMES, arrangeByQuestion } from '../contact/fields.js';
import { cutterOf, fieldAt } from '../contact/request.js';
import { examplePath } from './example.js';
import { TableFault, contactsOf, readTable, withColumns } from './table.js';

const FIELDS = [
  { name: 'question', label: 'Find', help: 'What to find at each contact.', choices: [['feed', 'Largest feed'], ['step', 'Largest step-over'], ['height', 'Scallop height']], segmented: true, value: 'feed' },
  ...CUTTER_FIELDS,
  { name: 'scallop_tolerance_mm', value: 0.01, inch: 0.01016 },
  { name: 'step_over_mm', value: 0.6, inch: 0.635, help: 'Step-over of contacts whose row states none.' },
  { name: 'feed_per_tooth_mm', value: 0.1, inch: 0.1016, help: 'Feed per tooth of contacts whose row states none.' },
  { name: 'max_feed_per_tooth_mm', value: 0.4, inch: 0.4064 },
  { name: 'max_feed_rate_mm_min', optional: 'no limit' },
  { name: 'model', choices: [['envelope', 'Exact'], ['analytic', 'Published']], segmented: true, value: 'envelope' },
];

const ENDPOINTS = { feed: 'v1/max-feed/batch', step: 'v1/step-over/batch', height: 'v1/scallop-height/batch' };
const COLUMNS = { feed: ['feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm'], step: ['step_over_mm', 'step_over_xy_mm', 'scallop_height_mm'], height: ['scallop_height_mm', 'step_over_height_mm', 'feed_height_mm'] };
const NEEDS = { spindle_speed_rpm: ['feed'], max_feed_per_tooth_mm: ['feed'], max_feed_rate_mm_min: ['feed'], step_over_mm: ['feed', 'height'], feed_per_tooth_mm: ['step', 'height'] };
const SHOWN_CHARACTERS = 200_000;

export class ContactTable {
  #form;
  #text = '';
  #table = null;
  #path = null;
  #last = null;
  #asked = new AbortController();
  #area = el('textarea', { id: 'path-table', rows: '9', spellcheck: 'false', autocomplete: 'off', 'aria-describedby': 'path-fault', placeholder: 'slope_deg,feed_angle_deg,step_over_mm\n12.5,30,0.6\n…' });
  #fault = el('p', { class: 'fault', id: 'path-fault', role: 'alert', hidden: true });
  #fileInput = el('input', { type: 'file', id: 'path-file', class: 'visually-hidden', 'aria-label': 'Table of contacts' });
  #message = el('p', { class: 'problem', role: 'alert', hidden: true });
  #summary = el('div', {});
  #row = el('p', { class: 'readout', role: 'status' });
  #main = new LineChart('Along the path', { height: 260, onPick: (index) => this.#showRow(index) });
  #heights = new LineChart('Scallop height along the path', { height: 200, onPick: (index) => this.#showRow(index) });
  #charts;
  #download = el('button', { type: 'button', class: 'primary', disabled: true, onclick: () => save('tool-path.csv', withColumns(this.#table, this.#addedColumns()), 'text/csv') }, 'Download CSV with the answer');
  #downloadJson = el('button', { type: 'button', disabled: true, onclick: () => save('tool-path.json', `${JSON.stringify(this.#last.answer)}\n`, 'application/json') }, 'Download JSON');

  #onChange;

  constructor(onChange) {
    this.#onChange = onChange;
    this.#form = new Form(FIELDS, () => {
      this.#arrange();
      onChange();
      this.#askSoon();
    });
    this.element = el('section', { class: 'view', id: 'path-contacts', 'aria-label': 'Table of contacts' }, this.#panel(), this.#output());
    this.#area.addEventListener('input', () => this.#readSoon(this.#area.value));
    this.#fileInput.addEventListener('change', () => this.#readFile(this.#fileInput.files[0]));
    this.#arrange();
  }

  #panel() {
    const form = this.#form;
    const copyButton = el('button', { type: 'button', onclick: () => this.#path && copy(curlOfJson(addressOf(ENDPOINTS[form.value('question')]), this.#request()), copyButton) }, 'Copy as curl');
    const linkButton = el('button', { type: 'button', onclick: () => copy(location.href, linkButton) }, 'Copy link');
    return el(
      'form',
      { class: 'panel', 'aria-label': 'Table of contacts', onsubmit: (event) => event.preventDefault() },
      form.element('question'),
      el('h2', {}, 'Cutter'), el('div', { class: 'grid' }, form.elements(...CUTTER_NAMES)),
      el('h2', {}, 'Passes'), el('div', { class: 'grid' }, form.elements('scallop_tolerance_mm', 'step_over_mm', 'feed_per_tooth_mm', 'max_feed_per_tooth_mm', 'max_feed_rate_mm_min')),
      form.element('model'),
      el('div', { class: 'actions' }, copyButton, linkButton, el('button', { type: 'button', onclick: () => this.#reset() }, 'Reset')),
    );
  }

  #output() {
    const example = el('button', { type: 'button', onclick: () => this.setText(examplePath()) }, 'Try an example');
    const choose = fileButton('path-file', 'Choose a file');
    this.#charts = el('div', { hidden: true }, el('section', { class: 'card' }, this.#summary), el('section', { class: 'card' }, this.#main.element, this.#row), el('section', { class: 'card' }, this.#heights.element));
    return el(
      'div',
      { class: 'results' },
      el('section', { class: 'card', 'aria-label': 'Contacts' },
        el('h2', {}, el('label', { for: 'path-table' }, 'Contacts')),
        el('p', { class: 'muted' }, 'Paste or drop a CSV. Columns: slope_deg and feed_angle_deg, or nx, ny, nz with fx, fy, fz or x, y, z; also step_over_mm, feed_per_tooth_mm, surface_radius_mm, run. Lengths in mm.'),
        this.#area, this.#fault, el('div', { class: 'actions' }, this.#fileInput, choose, example, this.#download, this.#downloadJson)),
      this.#message,
      this.#charts,
    );
  }

  #reset() {
    this.take({});
    this.#onChange();
    return this.ask();
  }

  #arrange() {
    arrangeByQuestion(this.#form, NEEDS);
  }

  values() {
    return this.#form.values();
  }

  state() {
    return this.#form.state();
  }

  useUnits(isInch) {
    this.#form.useUnits(isInch, this.#path === null);
  }

  take(values) {
    const unknown = this.#form.take(values);
    this.#arrange();
    return unknown;
  }

  takeFiles([file]) {
    return this.#readFile(file);
  }

  show() {
    this.#form.show();
    this.#showAnswer();
  }

  /** Sets a table and the values of some fields. */
  open(text, values) {
    this.#form.takeKnown(values);
    this.#arrange();
    return this.setText(text);
  }

  async #readFile(file) {
    if (file) this.setText(await file.text());
  }

  /** Sets the text of a table. A long text is shown in part, but read completely. */
  setText(text) {
    this.#area.value = text.length > SHOWN_CHARACTERS ? `${text.slice(0, text.lastIndexOf('\n', SHOWN_CHARACTERS))}\n# … ${text.length.toLocaleString('en')} characters in all` : text;
    this.#area.readOnly = text.length > SHOWN_CHARACTERS;
    return this.#read(text);
  }

  #readSoon = debounced(150, (text) => this.#read(text));

  async #read(text) {
    this.#text = text;
    this.#fault.hidden = true;
    try {
      const table = await readTable(text);
      if (this.#text !== text) return;
      [this.#table, this.#path] = [table, contactsOf(table)];
      await this.ask();
    } catch (fault) {
      if (!(fault instanceof TableFault)) throw fault;
      if (this.#text !== text) return;
      [this.#table, this.#path, this.#last] = [null, null, null];
      this.#fault.hidden = text.trim() === '';
      this.#fault.textContent = fault.message;
      this.#showAnswer();
    }
  }

  #request() {
    const values = this.#form.values();
    const { question, model } = values;
    if (question === 'height') delete values.scallop_tolerance_mm;
    const given = Object.fromEntries(['scallop_tolerance_mm', ...Object.keys(NEEDS)].filter((name) => NEEDS[name]?.includes(question) !== false && values[name] !== undefined).map((name) => [name, values[name]]));
    const { contacts } = this.#path;
    if (contacts.step_over_xy_mm) delete given.step_over_mm;
    // Columns that the question does not need are not sent.
    const { step_over_mm: stepOvers, step_over_xy_mm: stepOversXy, feed_per_tooth_mm: feeds, ...rest } = contacts;
    const columns = { ...rest, ...(question !== 'step' && stepOvers && { step_over_mm: stepOvers }), ...(question !== 'step' && stepOversXy && { step_over_xy_mm: stepOversXy }), ...(question !== 'feed' && feeds && { feed_per_tooth_mm: feeds }) };
    const wanted = COLUMNS[question].filter((name) => name !== 'feed_rate_mm_min' || (values.teeth !== undefined && values.spindle_speed_rpm !== undefined));
    return { cutter: cutterOf(values), model, ...given, contacts: columns, columns: wanted };
  }

  #askSoon = debounced(60, () => this.ask());

  async ask() {
    if (!this.#path) return;
    this.#asked.abort();
    this.#asked = new AbortController();
    const { signal } = this.#asked;
    const { question } = this.#form.values();
    try {
      const { answer, problem } = await post(ENDPOINTS[question], this.#request(), signal);
      if (signal.aborted) return;
      this.#form.clearFaults();
      this.#form.markTexts();
      this.#message.hidden = true;
      this.#last = answer ? { question, answer, columns: this.#byRow(answer) } : null;
      if (problem) this.#showProblem(problem);
      this.#showAnswer();
    } catch (error) {
      if (error.name !== 'AbortError' && !(error instanceof Unreachable)) throw error;
    }
  }

  // The answer's columns with a value for each row of the table; rows off the surface have none.
  #byRow(answer) {
    const { rows, count } = this.#path;
    const spread = (column) => {
      const whole = new Array(count).fill(null);
      rows.forEach((row, i) => {
        whole[row] = column[i];
      });
      return whole;
    };
    return Object.fromEntries([...new Set(Object.values(COLUMNS).flat())].filter((name) => answer[name]).map((name) => [name, spread(answer[name])]));
  }

  // The line of the table with a contact.
  #lineAt(index) {
    return this.#table.numbers[this.#path.rows[index]];
  }

  // A pointer into the contacts becomes a line of the table.
  #lineOf(pointer) {
    const found = /^\/contacts\/(?:\w+\/)*(\d+)/.exec(pointer ?? '');
    return found ? this.#lineAt(found[1]) : undefined;
  }

  #showProblem(problem) {
    const inTable = [];
    const rest = (problem.errors ?? []).filter(({ pointer, detail }) => {
      const line = this.#lineOf(pointer);
      if (line !== undefined) inTable.push(`Line ${line}: ${detail}`);
      return line === undefined;
    });
    this.#fault.hidden = inTable.length === 0;
    this.#fault.textContent = inTable.slice(0, 5).join(' ') + (inTable.length > 5 ? ` And ${inTable.length - 5} more.` : '');
    if (problem.errors?.length && rest.length === 0) return;
    const elsewhere = placeFaults({ ...problem, errors: rest }, (pointer) => this.#form.field(fieldAt(pointer)));
    this.#message.hidden = elsewhere.length === 0;
    this.#message.textContent = elsewhere.join('; ');
  }

  #addedColumns() {
    const { question, columns } = this.#last;
    return Object.fromEntries(COLUMNS[question].filter((name) => columns[name]).map((name) => [name, columns[name]]));
  }

  #showAnswer() {
    this.#charts.hidden = !this.#last;
    this.#download.disabled = this.#downloadJson.disabled = !this.#last;
    if (!this.#last) return;
    const { question, answer } = this.#last;
    const main = COLUMNS[question].find((name) => answer[name] && (question !== 'feed' || name === 'feed_rate_mm_min')) ?? COLUMNS[question][0];
    this.#summary.replaceChildren(this.#summaryOf(main, answer));
    this.#draw(this.#main, main, TERMS[main].label);
    this.#heights.element.closest('section').hidden = main === 'scallop_height_mm';
    if (main !== 'scallop_height_mm') this.#draw(this.#heights, 'scallop_height_mm', 'Scallop height');
    this.#row.textContent = 'Click the chart to read a row.';
  }

  #summaryOf(main, answer) {
    const values = answer[main].filter((value) => value !== null);
    const [least, most] = values.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
    const failures = answer.failures ?? [];
    const failed = answer.summary?.failures ?? failures.length;
    const time = this.#timeAtFeeds();
    const off = this.#path.count - this.#path.rows.length;
    const entry = (name, value, label = TERMS[name].label) => el('div', {}, el('dt', {}, term(name, label)), el('dd', {}, value));
    const whole = (name, count) => entry(name, el('data', { value: count, 'data-figure': name }, count.toLocaleString('en')));
    return el(
      'div',
      {},
      el('dl', { class: 'figures' },
        whole('contacts', this.#path.rows.length),
        off > 0 && whole('moves_off', off),
        values.length > 0 && entry(main, figure(main, least), `${TERMS[main].label}, least`),
        values.length > 0 && entry(main, figure(main, most), `${TERMS[main].label}, most`),
        time && entry('time_at_feeds_s', [el('data', { value: time.seconds, 'data-figure': 'time_at_feeds_s' }, formatTime(time.seconds)), time.share < 0.9995 && ` for ${formatWithUnit(time.share, 'share')} of the path`]),
        whole('failures', failed)),
      this.#withinTolerance(),
      failures.length > 0 && el('details', {}, el('summary', {}, `Rows without an answer (${failed})`), el('ul', {}, failures.slice(0, 50).map(({ index, detail }) => el('li', {}, `Line ${this.#lineAt(index)}: ${detail}`)), failed > 50 && el('li', {}, `and ${failed - 50} more; they are empty in the download.`))),
      warningList(answer.warnings),
    );
  }

  // Pass or fail: how many contacts are within the tolerance.
  #withinTolerance() {
    const tolerance = this.#form.value('scallop_tolerance_mm');
    const heights = this.#last.columns.scallop_height_mm?.filter((height) => height !== null) ?? [];
    if (typeof tolerance !== 'number' || heights.length === 0) return null;
    const over = heights.filter((height) => height > tolerance * (1 + 1e-6)).length;
    const passes = over === 0;
    return el('p', { class: `verdict ${passes ? 'pass' : 'fail'}` }, el('b', { 'data-verdict': passes ? 'pass' : 'fail' }, passes ? 'Within tolerance' : 'Over tolerance'), passes ? ` – at every contact with an answer, ${formatRound(tolerance, 'height')}.` : ` – at ${over.toLocaleString('en')} of ${heights.length.toLocaleString('en')} contacts, ${formatRound(tolerance, 'height')}.`);
  }

  // The time of the moves with a feed rate, {seconds, share of the path's length}: the answer's, off the surface the table's own. Null
  // where no move has one.
  #timeAtFeeds() {
    const { distance } = this.#path;
    const { feed_rate_mm_min: rates } = this.#last.columns;
    const stated = this.#table.columns.feed_rate_mm_min;
    if (!rates || !distance) return null;
    const isContact = new Set(this.#path.rows);
    let [minutes, timed, length] = [0, 0, 0];
    for (let i = 1; i < distance.length; i += 1) {
      const step = distance[i] - distance[i - 1];
      const rate = rates[i] ?? (isContact.has(i) ? null : stated?.[i]);
      length += step;
      if (!(rate > 0)) continue;
      timed += step;
      minutes += step / rate;
    }
    return timed > 0 ? { seconds: minutes * 60, share: timed / length } : null;
  }

  #draw(chart, name, label) {
    const { columns } = this.#last;
    const { distance, count } = this.#path;
    const { kind } = TERMS[name];
    chart.show(() => {
      const marks = [];
      const tolerance = this.#form.value('scallop_tolerance_mm');
      if (name === 'scallop_height_mm' && typeof tolerance === 'number') marks.push({ y: tolerance * factorOf('height'), colour: 'tolerance' });
      const x = distance ? distance.map((value) => value * factorOf('length')) : Array.from({ length: count }, (_, i) => this.#table.numbers[i]);
      return {
        x, xLabel: distance ? `Distance along the path (${unitOf('length')})` : 'Line of the table', yLabel: `${label} (${unitOf(kind)})`, marks,
        series: [{ label, colour: 'envelope', values: columns[name].map((value) => (value === null ? null : value * factorOf(kind))) }],
      };
    });
  }

  #showRow(index) {
    const { columns, question } = this.#last;
    const parts = COLUMNS[question].filter((name) => columns[name]).map((name) => `${TERMS[name].label.toLowerCase()} ${formatWithUnit(columns[name][index], TERMS[name].kind)}`);
    this.#row.textContent = `Line ${this.#table.numbers[index]}: ${parts.join(' · ')}`;
  }
}
