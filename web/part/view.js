// The part view: a surface, candidate cutters, a tolerance and a machine in; the ranking, times over direction and a map out.

import { LineChart } from '../charts.js';
import { copy, csvOf, curlOfForm, curlOfJson, save } from '../clipboard.js';
import { el } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { addressOf, get, post, upload, Unreachable } from '../service.js';
import { formatInput, formatWithUnit } from '../units.js';
import { SERIES, headline, nameOf, notRanked, passRows, rankingRows, rankingTable, surfaceFigures } from './answer.js';
import { CutterTable } from './cutters.js';
import { EXAMPLES } from './examples.js';
import { PartMap } from './map.js';

const CUTTERS = [
  { name: 'T10', type: 'toroidal', diameter_mm: 10, corner_radius_mm: 2 },
  { name: 'T16', type: 'toroidal', diameter_mm: 16, corner_radius_mm: 3 },
  { name: 'B10', type: 'ball_end', diameter_mm: 10 },
  { name: 'B6', type: 'ball_end', diameter_mm: 6 },
];

const FIELDS = [
  { name: 'example', label: 'Surface', help: 'A file of yours, or an example to try the page with.', choices: [['file', 'A file'], ...EXAMPLES.map(([name, label]) => [name, label])], value: 'surface_1' },
  { name: 'unit', choices: [['mm', 'mm'], ['cm', 'cm'], ['m', 'm'], ['inch', 'inch']], value: 'mm' },
  { name: 'facing', choices: [['up', 'Up'], ['any', 'Any']], value: 'up' },
  { name: 'tolerance_of_plan', value: 0.01 },
  { name: 'pattern', choices: [['zigzag', 'Zigzag'], ['one_way', 'One way']], segmented: true, value: 'zigzag' },
  { name: 'method', choices: [['surface', 'Surface'], ['rectangle', 'Rectangle']], segmented: true, value: 'surface' },
  { name: 'model', choices: [['', 'Method’s own'], ['envelope', 'Exact shape'], ['analytic', 'Published']], value: '' },
  { name: 'max_slope_deg', optional: '85' },
  { name: 'max_uncut_share', optional: '0.5' },
  { name: 'machine', choices: [['', 'Own values']], value: 'five_axis_vmc' },
  { name: 'machine_feed_rate_mm_min' },
  { name: 'acceleration_m_s2' },
  { name: 'jerk_m_s3' },
  { name: 'rapid_rate_mm_min' },
  { name: 'clearance_height_mm', optional: '5 mm' },
  { name: 'passes_wanted', label: 'Passes', help: 'Also ask for the passes of the recommended plan, point by point: for the map and for download.', choices: [['no', 'No'], ['yes', 'Point by point']], segmented: true, value: 'no' },
];

const FIELD_OF = { '/scallop_height_mm': 'tolerance_of_plan', '/machine/preset': 'machine', '/machine/feed_rate_mm_min': 'machine_feed_rate_mm_min' };

export class PartView {
  name = 'part';
  #form;
  #cutters;
  #file = null;
  #libraries = [];
  #run = null;
  #last = null;
  #request = null;
  #mapped = null;
  #machines = [];
  #drop = el('label', { class: 'drop', for: 'surface-file' });
  #fileInput = el('input', { type: 'file', id: 'surface-file', class: 'visually-hidden', 'aria-label': 'Surface file' });
  #libraryInput = el('input', { type: 'file', id: 'library-file', class: 'visually-hidden', multiple: true, 'aria-label': 'Tool libraries' });
  #libraryList = el('span', { class: 'muted' });
  #fileFault = el('p', { class: 'fault', id: 'file-fault', role: 'alert', hidden: true });
  #libraryFault = el('p', { class: 'fault', role: 'alert', hidden: true });
  #message = el('div', { class: 'problem', role: 'alert', hidden: true });
  #progress = el('progress', { max: '1', value: '0', 'aria-label': 'Upload' });
  #progressText = el('span', { role: 'status' });
  #progressBox = el('div', { class: 'progress', hidden: true });
  #go = el('button', { type: 'submit', class: 'primary' }, 'Find the cutter');
  #answer = el('div', {});
  #ranking = el('div', {});
  #surface = el('div', {});
  #results;
  #map = new PartMap();
  #times = new LineChart('Machining time over direction', { height: 250 });

  constructor(onChange) {
    this.#form = new Form(FIELDS, (field) => {
      if (field.name === 'machine') this.#showPreset();
      this.#arrange();
      onChange();
    });
    this.#cutters = new CutterTable(onChange);
    this.#cutters.take(CUTTERS);
    this.element = el('section', { class: 'view', id: 'view-part', 'aria-label': 'Part' }, this.#panel(), this.#output());
    this.#fileInput.addEventListener('change', () => this.#choose(this.#fileInput.files[0]));
    this.#libraryInput.addEventListener('change', () => this.#addLibraries(this.#libraryInput.files));
    this.#acceptDrops();
    this.#arrange();
  }

  /** Asks for what the view needs at first: the machines. */
  async start() {
    try {
      const { answer } = await get('v1/machines');
      if (!answer) return;
      this.#machines = answer.machines;
      this.#form.field('machine').offer([...answer.machines.map(({ name, description }) => [name, description]), ['', 'Own values']]);
      this.#showPreset();
    } catch (error) {
      if (!(error instanceof Unreachable)) throw error;
    }
  }

  #panel() {
    const form = this.#form;
    const cancel = el('button', { type: 'button', onclick: () => this.#run?.abort() }, 'Cancel');
    this.#progressBox.append(this.#progress, this.#progressText, cancel);
    const copyButton = el('button', { type: 'button', onclick: () => this.#copyCurl(copyButton) }, 'Copy as curl');
    const linkButton = el('button', { type: 'button', onclick: () => copy(location.href, linkButton) }, 'Copy link');
    return el(
      'form',
      { class: 'panel', 'aria-label': 'Part', onsubmit: (event) => {
        event.preventDefault();
        this.ask();
      } },
      el('h2', {}, 'Part'), form.element('example'), this.#fileInput, this.#drop, this.#fileFault,
      el('div', { class: 'grid' }, form.elements('unit', 'facing')),
      el('h2', {}, 'Finish'), el('div', { class: 'grid' }, form.elements('tolerance_of_plan', 'max_slope_deg', 'max_uncut_share', 'model', 'pattern', 'method', 'passes_wanted')),
      el('h2', {}, 'Machine'), form.element('machine'), el('div', { class: 'grid' }, form.elements('machine_feed_rate_mm_min', 'acceleration_m_s2', 'jerk_m_s3', 'rapid_rate_mm_min', 'clearance_height_mm')),
      el('div', { class: 'actions sticky' }, this.#go, copyButton, linkButton), this.#progressBox,
    );
  }

  #output() {
    const library = el('p', { class: 'library' }, this.#libraryInput, el('label', { for: 'library-file', class: 'button', tabindex: '0', role: 'button', onkeydown: (event) => (event.key === 'Enter' || event.key === ' ') && (event.preventDefault(), this.#libraryInput.click()) }, 'Add a tool library'), ' ', this.#libraryList);
    this.#results = el(
      'div',
      { class: 'part-results', hidden: true },
      el('section', { class: 'card', 'aria-label': 'Recommendation' }, this.#answer, this.#ranking),
      el('div', { class: 'columns' },
        el('section', { class: 'card grow', 'aria-label': 'Map' }, el('h2', {}, 'The part'), this.#map.element),
        el('div', { class: 'stack' }, el('section', { class: 'card' }, this.#times.element), el('section', { class: 'card', 'aria-label': 'Surface' }, el('h2', {}, 'Surface'), this.#surface))),
      el('div', { class: 'actions' }, el('button', { type: 'button', onclick: () => save('recommendation.json', `${JSON.stringify(this.#last, null, 1)}\n`, 'application/json') }, 'Download JSON'), el('button', { type: 'button', onclick: () => save('ranking.csv', csvOf(...rankingRows(this.#last)), 'text/csv') }, 'Download CSV'), this.#passesButton()),
    );
    return el('div', { class: 'results' }, el('section', { class: 'card' }, el('h2', {}, 'Cutters'), this.#cutters.element, library, this.#libraryFault), this.#message, this.#results);
  }

  #passesButton() {
    this.passesButton = el('button', { type: 'button', hidden: true, onclick: () => save('passes.csv', csvOf(...passRows(this.#last.passes)), 'text/csv') }, 'Download passes as CSV');
    return this.passesButton;
  }

  #acceptDrops() {
    this.#drop.append(el('b', {}, 'Choose a file'), ' or drop it here', el('span', { class: 'muted', 'data-file': '' }, 'STL, OBJ, PLY, 3MF, CSV, XYZ'));
    this.element.addEventListener('dragover', (event) => {
      event.preventDefault();
      this.#drop.classList.add('over');
    });
    this.element.addEventListener('dragleave', () => this.#drop.classList.remove('over'));
    this.element.addEventListener('drop', (event) => {
      event.preventDefault();
      this.#drop.classList.remove('over');
      if (event.target.closest('.library, .cutters')) this.#addLibraries(event.dataTransfer.files);
      else if (event.dataTransfer.files[0]) this.#choose(event.dataTransfer.files[0]);
    });
  }

  #choose(file) {
    this.#file = file ?? null;
    this.#fileFault.hidden = true;
    this.#form.field('example').set(file ? 'file' : this.#form.value('example'));
    this.#drop.querySelector('[data-file]').textContent = file ? `${file.name}, ${(file.size / 1e6).toPrecision(3)} MB` : 'STL, OBJ, PLY, 3MF, CSV, XYZ';
  }

  #addLibraries(files) {
    this.#libraries.push(...files);
    this.#libraryFault.hidden = true;
    this.#libraryList.replaceChildren(...this.#libraries.map((file, i) => el('span', { class: 'chip' }, file.name, el('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${file.name}`, onclick: () => {
      this.#libraries.splice(i, 1);
      this.#addLibraries([]);
    } }, '×'))));
    if (this.#libraries.length === 0) this.#libraryList.textContent = 'Fusion .json or .tools, FreeCAD .fctb, CSV';
  }

  // The values of the preset stand in the fields as hints; a stated value overrides one.
  #showPreset() {
    const preset = this.#machines.find(({ name }) => name === this.#form.value('machine'));
    for (const [field, member, kind] of [['machine_feed_rate_mm_min', 'feed_rate_mm_min', 'feedRate'], ['acceleration_m_s2', 'acceleration_m_s2', 'acceleration'], ['jerk_m_s3', 'jerk_m_s3', 'jerk'], ['rapid_rate_mm_min', 'rapid_rate_mm_min', 'feedRate']]) {
      const value = preset?.[member];
      this.#form.element(field).querySelector('input').placeholder = value === undefined || value === null ? '' : formatInput(value, kind);
    }
  }

  #arrange() {
    const file = this.#form.value('example') === 'file';
    this.#form.element('unit').hidden = !file;
    this.#form.element('facing').hidden = !file;
    this.#drop.classList.toggle('unused', !file);
    this.#addLibraries([]);
  }

  values() {
    return { ...this.#form.values(), cutters: this.#cutters.cutters() };
  }

  take({ cutters, ...values }) {
    this.#form.take({ ...Object.fromEntries(FIELDS.filter(({ choices }) => choices).map(({ name, value }) => [name, value])), ...values });
    this.#cutters.take(Array.isArray(cutters) ? cutters : CUTTERS);
    this.#showPreset();
    this.#arrange();
  }

  show() {
    this.#form.show();
    this.#cutters.show();
    this.#showPreset();
    if (this.#last) this.#showAnswer();
  }

  /** The request without its surface. */
  #parameters() {
    const values = this.#form.values();
    const parameters = {
      cutters: this.#cutters.cutters(),
      scallop_height_mm: values.tolerance_of_plan,
      machine: { preset: values.machine || undefined, feed_rate_mm_min: values.machine_feed_rate_mm_min, acceleration_m_s2: values.acceleration_m_s2, jerk_m_s3: values.jerk_m_s3, rapid_rate_mm_min: values.rapid_rate_mm_min, clearance_height_mm: values.clearance_height_mm },
      pattern: values.pattern,
      method: values.method,
      model: values.model || undefined,
      max_slope_deg: values.max_slope_deg,
      max_uncut_share: values.max_uncut_share,
      include: values.passes_wanted === 'yes' ? ['map', 'passes'] : ['map'],
    };
    if (values.method === 'rectangle') for (const name of ['include', 'pattern', 'max_slope_deg', 'max_uncut_share']) delete parameters[name];
    return JSON.parse(JSON.stringify(values.example === 'file' ? { ...parameters, unit: values.unit, facing: values.facing } : parameters));
  }

  async #copyCurl(button) {
    const surface = await this.#exampleSurface();
    if (surface && this.#libraries.length === 0) return copy(curlOfJson(addressOf('v1/cutter-recommendation'), { surface, ...this.#parameters() }), button);
    const parts = [['surface', `@${this.#file?.name ?? 'part.stl'}`], ['parameters', JSON.stringify(this.#parameters())], ...this.#libraries.map((file) => ['library', `@${file.name}`])];
    return copy(curlOfForm(addressOf('v1/cutter-recommendation/upload'), parts), button);
  }

  async #exampleSurface() {
    const example = EXAMPLES.find(([name]) => name === this.#form.value('example'));
    return example ? example[2]() : null;
  }

  // What a request is made of, kept for the maps of other candidates.
  async #compose() {
    return { parameters: this.#parameters(), surface: await this.#exampleSurface(), file: this.#file, libraries: [...this.#libraries] };
  }

  async #send({ parameters, surface, file, libraries }, signal) {
    if (surface && libraries.length === 0) {
      this.#working('Computing…');
      return post('v1/cutter-recommendation', { surface, ...parameters }, signal);
    }
    const form = new FormData();
    if (surface) return { problem: { errors: [{ pointer: '/library', detail: 'Tool libraries go with a file: choose a surface file.' }] } };
    form.append('parameters', new Blob([JSON.stringify(parameters)], { type: 'application/json' }));
    for (const library of libraries) form.append('library', library);
    form.append('surface', file);
    return upload('v1/cutter-recommendation/upload', form, (share) => {
      this.#progress.value = share;
      this.#progressText.textContent = share < 1 ? `${Math.floor(share * 100)} % sent` : 'Computing…';
      if (share >= 1) this.#progress.removeAttribute('value');
    }, signal);
  }

  #working(text) {
    this.#progress.removeAttribute('value');
    this.#progressText.textContent = text;
  }

  async ask() {
    this.#clearFaults();
    if (this.#form.value('example') === 'file' && !this.#file) {
      this.#fault(this.#fileFault, 'Choose a surface file, or one of the examples.');
      this.#fileInput.focus();
      return;
    }
    const request = await this.#compose();
    const result = await this.#while((signal) => this.#send(request, signal));
    if (!result) return;
    if (result.problem) {
      this.#showProblem(result.problem);
      return;
    }
    this.#last = result.answer;
    this.#request = request;
    this.#mapped = result.answer.recommended?.cutter ?? null;
    this.#showAnswer();
    this.#showMap(result.answer);
  }

  // Runs a request with the progress shown and the button off.
  async #while(request) {
    this.#run?.abort();
    const run = (this.#run = new AbortController());
    this.#progress.value = 0;
    this.#progressText.textContent = '';
    this.#progressBox.hidden = false;
    this.#go.disabled = true;
    try {
      return await request(run.signal);
    } catch (error) {
      if (error instanceof Unreachable) this.#tell(['The service cannot be reached; ask again when it is back.']);
      else if (error.name !== 'AbortError') throw error;
      return null;
    } finally {
      if (this.#run === run) {
        this.#progressBox.hidden = true;
        this.#go.disabled = false;
      }
    }
  }

  #clearFaults() {
    this.#form.clearFaults();
    this.#cutters.clearFaults();
    for (const element of [this.#fileFault, this.#libraryFault, this.#message]) element.hidden = true;
  }

  #fault(element, text) {
    element.textContent = element.textContent && !element.hidden ? `${element.textContent}; ${text}` : text;
    element.hidden = false;
  }

  #tell(lines, entries) {
    this.#message.replaceChildren(...lines.map((line) => el('p', {}, line)), notRanked(entries) ?? '');
    this.#message.hidden = false;
  }

  #showProblem(problem) {
    this.#results.hidden = true;
    const inFiles = (pointer) => (/^\/surface/.test(pointer) ? this.#fileFault : /^\/library/.test(pointer) ? this.#libraryFault : null);
    const rest = [];
    for (const error of problem.errors ?? []) {
      const place = inFiles(error.pointer);
      if (place) this.#fault(place, error.detail);
      else rest.push(error);
    }
    if (problem.errors?.length && rest.length === 0) return;
    const elsewhere = placeFaults({ ...problem, errors: rest }, (pointer) => this.#cutters.field(pointer) ?? this.#form.field(FIELD_OF[pointer] ?? pointer.split('/').at(-1)));
    if (elsewhere.length > 0 || problem.not_ranked) this.#tell([problem.title, ...elsewhere].filter(Boolean), problem.not_ranked);
  }

  #showAnswer() {
    const answer = this.#last;
    this.#results.hidden = false;
    this.#answer.replaceChildren(headline(answer));
    this.#ranking.replaceChildren(rankingTable(answer, this.#mapped, (candidate) => this.#mapOf(candidate)), notRanked(answer.not_ranked) ?? '');
    this.#surface.replaceChildren(surfaceFigures(answer));
    this.passesButton.hidden = !answer.passes;
    this.#drawTimes();
    this.#map.draw();
  }

  #showMap(answer) {
    const candidate = answer.candidates.find(({ cutter }) => cutter === answer.recommended.cutter);
    this.#map.element.closest('section').hidden = !answer.map;
    if (answer.map) this.#map.show(answer.map, this.#request.parameters.scallop_height_mm, answer.passes, `${nameOf(candidate)} at ${formatWithUnit(candidate.direction_deg, 'angle')}${answer.passes ? ', with its passes' : ''}.`);
  }

  // The map of another candidate: the same request with this cutter and its direction alone.
  async #mapOf(candidate) {
    const all = this.#last;
    const { parameters } = this.#request;
    const cutter = parameters.cutters[candidate.cutter];
    if (!cutter) {
      this.#tell(['The map of a library’s cutter cannot be asked for alone. Add the cutter by hand to see its map.']);
      return;
    }
    const request = { ...this.#request, libraries: [], parameters: { ...parameters, cutters: [cutter], directions_deg: [candidate.direction_deg] } };
    const result = await this.#while((signal) => this.#send(request, signal));
    if (!result) return;
    if (result.problem) {
      this.#showProblem(result.problem);
      this.#results.hidden = false;
      return;
    }
    this.#last = all;
    this.#mapped = candidate.cutter;
    this.#showAnswer();
    this.#showMap({ ...result.answer, candidates: [candidate], recommended: { cutter: candidate.cutter } });
  }

  #drawTimes() {
    const listed = this.#last.candidates.filter(({ by_direction: found }) => found);
    if (listed.length === 0) {
      this.#times.clear('The rectangle’s method gives one direction for each cutter.');
      return;
    }
    this.#times.show(() => {
      const x = [...new Set(listed.flatMap(({ by_direction: found }) => found.direction_deg))].sort((a, b) => a - b);
      const series = listed.map((candidate, i) => {
        const times = new Map(candidate.by_direction.direction_deg.map((angle, at) => [angle, candidate.by_direction.machining_time_s[at]]));
        return { label: nameOf(candidate), colour: SERIES[i % SERIES.length], values: x.map((angle) => times.get(angle) ?? null), gaps: true };
      });
      const all = series.flatMap(({ values }) => values).filter((value) => value !== null);
      const [least, most] = [Math.min(...all), Math.max(...all)];
      const best = listed.map((candidate, i) => ({ x: candidate.direction_deg, y: candidate.machining_time_s, colour: SERIES[i % SERIES.length] }));
      return { x, xLabel: 'Direction (°)', yLabel: 'Time (s)', series, marks: best, yRange: () => [least * 0.96, most * 1.02] };
    });
  }
}
