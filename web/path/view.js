// The tool path view: a table of contacts in; feed, step-over or height along the path as a chart, and the table with them added.

import { LineChart } from '../charts.js';
import { addressOf, post, Unreachable } from '../service.js';
import { copy, curlOfJson, save } from '../clipboard.js';
import { debounced, el, fileButton } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { figure, term, warningList } from '../figures.js';
import { TERMS } from '../terms.js';
import { factorOf, formatTime, formatWithUnit, unitOf } from '../units.js';
import { cutterOf, fieldAt } from '../contact/request.js';
import { examplePath } from './example.js';
import { TableFault, contactsOf, readTable, withColumns } from './table.js';

const FIELDS = [
  { name: 'question', label: 'Find', help: 'What to find at each contact.', choices: [['feed', 'Largest feed'], ['step', 'Largest step-over'], ['height', 'Scallop height']], segmented: true, value: 'feed' },
  { name: 'type', choices: [['toroidal', 'Toroidal'], ['ball_end', 'Ball end'], ['flat_end', 'Flat end']], segmented: true, value: 'toroidal' },
  { name: 'diameter_mm', value: 10 },
  { name: 'corner_radius_mm', value: 2 },
  { name: 'teeth', value: 4 },
  { name: 'spindle_speed_rpm', value: 8000 },
  { name: 'scallop_tolerance_mm', value: 0.01 },
  { name: 'step_over_mm', value: 0.6, help: 'Step-over of contacts whose row states none.' },
  { name: 'feed_per_tooth_mm', value: 0.1, help: 'Feed per tooth of contacts whose row states none.' },
  { name: 'max_feed_per_tooth_mm', value: 0.4 },
  { name: 'max_feed_rate_mm_min', optional: 'no limit' },
  { name: 'model', choices: [['envelope', 'Exact shape'], ['analytic', 'Published']], segmented: true, value: 'envelope' },
];

const ENDPOINTS = { feed: 'v1/max-feed/batch', step: 'v1/step-over/batch', height: 'v1/scallop-height/batch' };
const COLUMNS = { feed: ['feed_per_tooth_mm', 'feed_rate_mm_min', 'scallop_height_mm'], step: ['step_over_mm', 'step_over_xy_mm', 'scallop_height_mm'], height: ['scallop_height_mm', 'step_over_height_mm', 'feed_height_mm'] };
const NEEDS = { scallop_tolerance_mm: ['feed', 'step'], spindle_speed_rpm: ['feed'], max_feed_per_tooth_mm: ['feed'], max_feed_rate_mm_min: ['feed'], step_over_mm: ['feed', 'height'], feed_per_tooth_mm: ['step', 'height'] };
const SHOWN_CHARACTERS = 200_000;

export class PathView {
  name = 'path';
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

  constructor(onChange) {
    this.#form = new Form(FIELDS, () => {
      this.#arrange();
      onChange();
      this.#askSoon();
    });
    this.element = el('section', { class: 'view', id: 'view-path', 'aria-label': 'Tool path' }, this.#panel(), this.#output());
    this.#area.addEventListener('input', () => this.#readSoon(this.#area.value));
    this.#fileInput.addEventListener('change', () => this.#readFile(this.#fileInput.files[0]));
    this.element.addEventListener('dragover', (event) => event.preventDefault());
    this.element.addEventListener('drop', (event) => {
      event.preventDefault();
      if (event.dataTransfer.files[0]) this.#readFile(event.dataTransfer.files[0]);
    });
    this.#arrange();
  }

  #panel() {
    const form = this.#form;
    const copyButton = el('button', { type: 'button', onclick: () => this.#path && copy(curlOfJson(addressOf(ENDPOINTS[form.value('question')]), this.#request()), copyButton) }, 'Copy as curl');
    const linkButton = el('button', { type: 'button', onclick: () => copy(location.href, linkButton) }, 'Copy link');
    return el(
      'form',
      { class: 'panel', 'aria-label': 'Tool path', onsubmit: (event) => event.preventDefault() },
      form.element('question'),
      el('h2', {}, 'Cutter'), el('div', { class: 'grid' }, form.elements('type', 'diameter_mm', 'corner_radius_mm', 'teeth', 'spindle_speed_rpm')),
      el('h2', {}, 'Passes'), el('div', { class: 'grid' }, form.elements('scallop_tolerance_mm', 'step_over_mm', 'feed_per_tooth_mm', 'max_feed_per_tooth_mm', 'max_feed_rate_mm_min')),
      form.element('model'),
      el('div', { class: 'actions' }, copyButton, linkButton),
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

  #arrange() {
    const { question, type } = this.#form.values();
    for (const [name, questions] of Object.entries(NEEDS)) this.#form.element(name).hidden = !questions.includes(question);
    this.#form.element('corner_radius_mm').hidden = type !== 'toroidal';
  }

  values() {
    return this.#form.values();
  }

  take(values) {
    this.#form.take({ ...Object.fromEntries(FIELDS.filter(({ choices }) => choices).map(({ name, value }) => [name, value])), ...values });
    this.#arrange();
  }

  show() {
    this.#form.show();
    this.#showAnswer();
  }

  /** Sets a table and the values of some fields. */
  open(text, values) {
    for (const [name, value] of Object.entries(values)) this.#form.field(name).set(value);
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
    const given = Object.fromEntries(Object.keys(NEEDS).filter((name) => NEEDS[name].includes(question) && values[name] !== undefined).map((name) => [name, values[name]]));
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
      this.#message.hidden = true;
      this.#last = answer ? { question, answer } : null;
      if (problem) this.#showProblem(problem);
      this.#showAnswer();
    } catch (error) {
      if (error.name !== 'AbortError' && !(error instanceof Unreachable)) throw error;
    }
  }

  // A pointer into the contacts becomes a line of the table.
  #lineOf(pointer) {
    const found = /^\/contacts\/(?:\w+\/)?(\d+)/.exec(pointer ?? '');
    return found ? this.#table.numbers[found[1]] : undefined;
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
    const { question, answer } = this.#last;
    return Object.fromEntries(COLUMNS[question].filter((name) => answer[name]).map((name) => [this.#table.columns[name] ? `answer_${name}` : name, answer[name]]));
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
    const time = this.#timeAtFeed(answer);
    const entry = (name, value, label = TERMS[name].label) => el('div', {}, el('dt', {}, term(name, label)), el('dd', {}, value));
    const whole = (name, count) => entry(name, el('data', { value: count, 'data-figure': name }, count.toLocaleString('en')));
    return el(
      'div',
      {},
      el('dl', { class: 'figures' },
        whole('contacts', this.#path.count),
        values.length > 0 && entry(main, figure(main, least), `${TERMS[main].label}, least`),
        values.length > 0 && entry(main, figure(main, most), `${TERMS[main].label}, most`),
        time !== null && entry('time_at_feeds_s', formatTime(time)),
        whole('failures', failed)),
      failures.length > 0 && el('details', {}, el('summary', {}, `Rows without an answer (${failed})`), el('ul', {}, failures.slice(0, 50).map(({ index, detail }) => el('li', {}, `Line ${this.#table.numbers[index]}: ${detail}`)), failed > 50 && el('li', {}, `and ${failed - 50} more; they are empty in the download.`))),
      warningList(answer.warnings),
    );
  }

  #timeAtFeed({ feed_rate_mm_min: rates }) {
    const { distance } = this.#path;
    if (!rates || !distance) return null;
    let minutes = 0;
    for (let i = 1; i < distance.length; i += 1) if (rates[i] > 0) minutes += (distance[i] - distance[i - 1]) / rates[i];
    return minutes * 60;
  }

  #draw(chart, name, label) {
    const { answer } = this.#last;
    const { distance, count } = this.#path;
    const { kind } = TERMS[name];
    chart.show(() => {
      const marks = [];
      const tolerance = this.#form.value('scallop_tolerance_mm');
      if (name === 'scallop_height_mm' && typeof tolerance === 'number') marks.push({ y: tolerance * factorOf('height'), colour: 'tolerance' });
      const x = distance ? distance.map((value) => value * factorOf('length')) : Array.from({ length: count }, (_, i) => this.#table.numbers[i]);
      return {
        x, xLabel: distance ? `Distance along the path (${unitOf('length')})` : 'Line of the table', yLabel: `${label} (${unitOf(kind)})`, marks,
        series: [{ label, colour: 'envelope', values: answer[name].map((value) => (value === null ? null : value * factorOf(kind))) }],
      };
    });
  }

  #showRow(index) {
    const { answer, question } = this.#last;
    const parts = COLUMNS[question].filter((name) => answer[name]).map((name) => `${TERMS[name].label.toLowerCase()} ${formatWithUnit(answer[name][index], TERMS[name].kind)}`);
    this.#row.textContent = `Line ${this.#table.numbers[index]}: ${parts.join(' · ')}`;
  }
}
