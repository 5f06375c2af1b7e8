// The part view: a surface, candidate cutters, a tolerance and a machine in; the ranking, times over direction and a map out.

import { LineChart } from '../charts.js';
import { copy, csvOf, curlOfForm, curlOfJson, save } from '../clipboard.js';
import { el, fileButton } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { addressOf, get, post, upload, Unreachable } from '../service.js';
import { formatInput, formatWithUnit } from '../units.js';
import { SERIES, headline, nameOf, notRanked, passRows, rankingRows, rankingTable, surfaceFigures } from './answer.js';
import { CutterTable } from './cutters.js';
import { EXAMPLES, fileOfSurface } from './examples.js';
import { PartMap } from './map.js';
import { CUTTERS, FIELDS, SELECTION, fieldNameOf, parametersOf } from './request.js';

const FORMATS = 'STL, OBJ, PLY, PCD, 3MF, CSV, XYZ; up to 1 GB';
const LIBRARY_FORMATS = 'Fusion .json or .tools, FreeCAD .fctb or a zip of them, CSV';
const LIMITS = ['machine_feed_rate_mm_min', 'acceleration_m_s2', 'jerk_m_s3', 'rapid_rate_mm_min', 'max_spindle_speed_rpm', 'clearance_height_mm'];
const METHOD = ['max_slope_deg', 'max_uncut_share', 'directions_deg', 'model', 'method'];
// The chart shows the fastest cutters, each in a colour of its own.
const CHARTED = SERIES.length;
// These are not parameters of method rectangle.
const OF_SURFACE_METHOD = ['pattern', 'max_slope_deg', 'max_uncut_share', 'directions_deg', 'passes_wanted'];

export class PartView {
  name = 'part';
  #form;
  #cutters;
  #file = null;
  #libraries = [];
  #run = null;
  #last = null;
  #request = null;
  // The requested maps, by the cutter's number: {map, shown}.
  #maps = new Map();
  #mapped = null;
  #unranked = [];
  #machines = [];
  #drop = el('label', { class: 'drop', for: 'surface-file' });
  #fileInput = el('input', { type: 'file', id: 'surface-file', class: 'visually-hidden', 'aria-label': 'Surface file' });
  #libraryInput = el('input', { type: 'file', id: 'library-file', class: 'visually-hidden', multiple: true, 'aria-label': 'Tool libraries' });
  #libraryList = el('span', { class: 'muted' });
  #fileFault = el('p', { class: 'fault', id: 'file-fault', role: 'alert', hidden: true });
  #libraryFault = el('p', { class: 'fault', role: 'alert', hidden: true });
  #message = el('div', { class: 'problem', role: 'alert', hidden: true });
  #stale = el('p', { class: 'stale', role: 'status', hidden: true }, 'The fields have changed. The answer below is that of the earlier request.');
  #progress = el('progress', { max: '1', value: '0', 'aria-label': 'Upload' });
  #progressText = el('span', { role: 'status' });
  #progressBox = el('div', { class: 'progress', hidden: true });
  #go = el('button', { type: 'submit', class: 'primary' }, 'Find the cutter');
  #hint = el('section', { class: 'card hint' });
  #answer = el('div', {});
  #ranking = el('div', {});
  #surface = el('div', {});
  #passesButtons = el('span', { class: 'buttons' },
    el('button', { type: 'button', onclick: () => save('passes.csv', csvOf(...passRows(this.#last.passes)), 'text/csv') }, 'Download passes as CSV'),
    el('button', { type: 'button', onclick: () => this.#openPasses() }, 'Open passes as a tool path'));
  #map = new PartMap((box) => this.#selectBox(box));
  #times = new LineChart('Machining time over direction', { height: 290, onPick: (index) => this.#takeDirection(index) });
  // The directions of the chart's points.
  #directions = [];
  #onChange;
  #showPath;
  // The cards of the results.
  #cards;
  #groups = {};

  /** `showPath(text, cutter)` shows a table of contacts in the tool path view. */
  constructor(onChange, showPath) {
    this.#showPath = showPath;
    this.#onChange = onChange;
    this.#form = new Form(FIELDS, (field) => {
      if (field.name === 'machine') this.#showPreset();
      this.#arrange();
      this.#changed();
    });
    this.#cutters = new CutterTable(() => this.#changed(), () => this.ask());
    this.#cutters.take(CUTTERS);
    this.element = el('section', { class: 'view', id: 'view-part', 'aria-label': 'Part' }, this.#panel(), this.#output());
    this.#fileInput.addEventListener('change', () => this.#choose(this.#fileInput.files[0]));
    this.#libraryInput.addEventListener('change', () => this.#addLibraries(this.#libraryInput.files));
    this.#acceptDrops();
    this.#arrange();
    this.#addLibraries([]);
  }

  /** Loads the data that the view needs first: the machines. */
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
    const group = (name, title, fields) => (this.#groups[name] = el('details', { class: 'group' }, el('summary', {}, title, el('span', { class: 'badge', hidden: true })), el('div', { class: 'grid' }, form.elements(...fields))));
    const submitted = (event) => {
      event.preventDefault();
      this.ask();
    };
    return el(
      'form',
      { class: 'panel', 'aria-label': 'Part', onsubmit: submitted },
      el('h2', {}, 'Part'), form.element('example'), this.#fileInput, this.#drop, this.#fileFault,
      el('div', { class: 'grid' }, form.elements('unit', 'facing')),
      group('selection', 'Machine only a part of it', SELECTION),
      el('h2', {}, 'Finish'), el('div', { class: 'grid' }, form.elements('tolerance_of_plan', 'pattern', 'passes_wanted')),
      group('method', 'Method and limits', METHOD),
      el('h2', {}, 'Machine'), form.element('machine'),
      group('limits', 'Limits of the machine', LIMITS),
      el('div', { class: 'actions' }, this.#go, copyButton, linkButton), this.#progressBox,
    );
  }

  #output() {
    const library = el('p', { class: 'library' }, this.#libraryInput, fileButton('library-file', 'Add a tool library'), ' ', this.#libraryList);
    const downloads = el('div', { class: 'actions' },
      el('button', { type: 'button', onclick: () => save('recommendation.json', `${JSON.stringify(this.#last, null, 1)}\n`, 'application/json') }, 'Download JSON'),
      el('button', { type: 'button', onclick: () => save('ranking.csv', csvOf(...rankingRows(this.#last)), 'text/csv') }, 'Download CSV'),
      this.#passesButtons);
    this.#hint.append(el('h2', {}, 'What comes out'), el('p', {}, 'The fastest cutter and direction for the part, the other cutters ranked behind it with what each leaves, the machining time over every direction, and the part from above with its scallops.'), el('p', { class: 'muted' }, 'Choose a surface, or stay with the example, and find the cutter.'));
    const card = (label, ...children) => el('section', { class: 'card', 'aria-label': label, hidden: true }, ...children);
    this.#cards = {
      ranking: card('Recommendation', this.#answer, this.#ranking, downloads),
      map: card('Map', el('h2', {}, 'The part from above'), this.#map.element),
      times: card('Times', this.#times.element, el('p', { class: 'muted' }, 'Click a direction to plan in it alone.')),
      surface: card('Surface', el('h2', {}, 'Surface'), this.#surface),
    };
    const { ranking, map, times, surface } = this.#cards;
    return el(
      'div',
      { class: 'results' },
      el('section', { class: 'card' }, el('h2', {}, 'Cutters'), this.#cutters.element, library, this.#libraryFault),
      this.#message,
      this.#hint,
      el('div', { class: 'part-results' }, this.#stale, ranking, el('div', { class: 'columns' }, map, el('div', { class: 'stack' }, times, surface))),
    );
  }

  // Marks the shown answer as no longer that of the fields.
  #changed() {
    this.#stale.hidden = this.#last === null;
    this.#onChange();
  }

  #acceptDrops() {
    this.#drop.append(el('b', {}, 'Choose a file'), ' or drop it here', el('span', { class: 'muted', 'data-file': '' }, FORMATS));
    this.element.addEventListener('dragover', (event) => {
      event.preventDefault();
      this.#drop.classList.add('over');
    });
    this.element.addEventListener('dragleave', () => this.#drop.classList.remove('over'));
    this.element.addEventListener('drop', (event) => {
      event.preventDefault();
      this.#drop.classList.remove('over');
      const { files } = event.dataTransfer;
      // A Fusion or FreeCAD library is detected by its name; other files are sent as the part on which they were dropped.
      const areLibraries = event.target.closest('.card') || [...files].every(({ name }) => /\.(json|tools|fctb)$/i.test(name));
      if (areLibraries) this.#addLibraries(files);
      else if (files[0]) this.#choose(files[0]);
    });
  }

  #choose(file) {
    this.#file = file ?? null;
    this.#fileFault.hidden = true;
    if (file) this.#form.field('example').set('file');
    this.#drop.querySelector('[data-file]').textContent = file ? `${file.name}, ${(file.size / 1e6).toPrecision(3)} MB` : FORMATS;
    this.#changed();
    this.#arrange();
  }

  #addLibraries(files) {
    this.#libraries.push(...files);
    this.#libraryFault.hidden = true;
    if (files.length > 0) this.#changed();
    const remove = (index) => {
      this.#libraries.splice(index, 1);
      this.#changed();
      this.#addLibraries([]);
    };
    const chips = this.#libraries.map((file, i) => el('span', { class: 'chip' }, file.name, el('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${file.name}`, onclick: () => remove(i) }, '×')));
    this.#libraryList.replaceChildren(...(chips.length > 0 ? chips : [LIBRARY_FORMATS]));
    // The same file may be chosen again after it was removed.
    this.#libraryInput.value = '';
  }

  // A box that was dragged over the map becomes the selection.
  #selectBox({ min, max }) {
    for (const [i, axis] of ['x', 'y'].entries()) {
      this.#form.field(`box_min_${axis}_mm`).set(Number(min[i].toFixed(3)));
      this.#form.field(`box_max_${axis}_mm`).set(Number(max[i].toFixed(3)));
    }
    this.#groups.selection.open = true;
    this.#arrange();
    this.#changed();
  }

  // A direction that was clicked in the chart becomes the only one to try.
  #takeDirection(index) {
    this.#form.field('directions_deg').set(String(this.#directions[index]));
    this.#groups.method.open = true;
    this.#arrange();
    this.#changed();
  }

  // The recommended cutter is passed on with its passes, as far as the page knows it. Without teeth and speed the step-over takes up the whole
  // scallop height, so that heights without feed are of interest; with them the largest feed is.
  #openPasses() {
    const { recommended, passes, model } = this.#last;
    const { cutters, scallop_height_mm: tolerance } = this.#request.parameters;
    const { type, diameter_mm, corner_radius_mm, teeth, spindle_speed_rpm } = cutters?.[recommended.cutter] ?? {};
    const question = passes.feed_per_tooth_mm ? { question: 'feed' } : { question: 'height', feed_per_tooth_mm: 0 };
    const known = Object.entries({ type, diameter_mm, corner_radius_mm, teeth, spindle_speed_rpm, scallop_tolerance_mm: tolerance, model, ...question });
    return this.#showPath(csvOf(...passRows(passes)), Object.fromEntries(known.filter(([, value]) => value !== undefined)));
  }

  // The values of the preset are shown in the fields as hints; a stated value overrides its hint.
  #showPreset() {
    const preset = this.#machines.find(({ name }) => name === this.#form.value('machine'));
    for (const [field, member, kind] of [['machine_feed_rate_mm_min', 'feed_rate_mm_min', 'feedRate'], ['acceleration_m_s2', 'acceleration_m_s2', 'acceleration'], ['jerk_m_s3', 'jerk_m_s3', 'jerk']]) {
      const value = preset?.[member];
      this.#form.element(field).querySelector('input').placeholder = value === undefined ? '' : formatInput(value, kind);
    }
    if (!this.#form.value('machine')) this.#groups.limits.open = true;
  }

  #arrange() {
    const values = this.#form.values();
    const isFile = values.example === 'file';
    this.#form.element('unit').hidden = !isFile;
    this.#form.element('facing').hidden = !isFile;
    this.#drop.classList.toggle('unused', !isFile);
    for (const name of OF_SURFACE_METHOD) this.#form.element(name).hidden = values.method !== 'surface';
    // A closed group shows how many of its fields have a value.
    const defaults = Object.fromEntries(FIELDS.map(({ name, value }) => [name, value]));
    for (const [group, fields] of [['selection', SELECTION], ['method', METHOD], ['limits', LIMITS]]) {
      const stated = fields.filter((name) => values[name] !== defaults[name]).length;
      const badge = this.#groups[group].querySelector('.badge');
      badge.hidden = stated === 0;
      badge.textContent = `${stated} set`;
    }
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
    this.#showAnswer();
  }

  async #copyCurl(button) {
    const { parameters, surface, file, libraries } = await this.#compose();
    if (surface && libraries.length === 0) return copy(curlOfJson(addressOf('v1/cutter-recommendation'), { surface, ...parameters }), button);
    const parts = [['surface', { file: file?.name ?? 'part.stl' }], ['parameters', JSON.stringify(parameters)], ...libraries.map(({ name }) => ['library', { file: name }])];
    return copy(curlOfForm(addressOf('v1/cutter-recommendation/upload'), parts), button);
  }

  // The parts of the last request, kept for the maps of other cutters.
  async #compose() {
    const values = this.#form.values();
    const example = EXAMPLES.find(([name]) => name === values.example);
    const surface = example ? await example[2]() : null;
    const libraries = [...this.#libraries];
    const file = surface && libraries.length > 0 ? fileOfSurface(surface, example[0]) : this.#file;
    return { parameters: parametersOf(values, this.#cutters.cutters()), surface, file, libraries };
  }

  #send({ parameters, surface, file, libraries }, signal) {
    if (surface && libraries.length === 0) {
      this.#working('Computing…');
      return post('v1/cutter-recommendation', { surface, ...parameters }, signal);
    }
    const form = new FormData();
    form.append('parameters', new Blob([JSON.stringify(parameters)], { type: 'application/json' }));
    for (const library of libraries) form.append('library', library);
    form.append('surface', file);
    return upload('v1/cutter-recommendation/upload', form, (share) => {
      this.#progress.value = share;
      if (share < 1) this.#progressText.textContent = `${Math.floor(share * 100)} % sent`;
      else this.#working('Computing…');
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
    [this.#request, this.#last, this.#mapped] = [request, result.answer ?? null, null];
    this.#maps.clear();
    this.#stale.hidden = true;
    this.#hint.hidden = true;
    this.#unranked = (result.answer ?? result.problem).not_ranked ?? [];
    if (result.problem) {
      this.#showProblem(result.problem);
    } else if (result.answer.map) {
      this.#keepMap(result.answer.recommended.cutter, result.answer);
    }
    this.#showAnswer();
    // On a narrow screen the answer is far below the button.
    const shown = this.#last ? this.#cards.ranking : this.#message;
    if (shown.getBoundingClientRect().top > innerHeight - 120) shown.scrollIntoView();
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
      if (error instanceof Unreachable) this.#tell('The service cannot be reached; ask again when it is back.');
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

  #tell(...lines) {
    this.#message.replaceChildren(...lines.map((line) => el('p', {}, line)));
    this.#message.hidden = false;
  }

  #showProblem(problem) {
    if (problem.not_ranked) {
      // The list of reasons follows.
      this.#tell(`${problem.title}.`);
      return;
    }
    const inFiles = (pointer) => (/^\/surface/.test(pointer) ? this.#fileFault : /^\/library/.test(pointer) ? this.#libraryFault : null);
    const rest = [];
    for (const error of problem.errors ?? []) {
      const place = inFiles(error.pointer);
      if (place) this.#fault(place, error.detail);
      else rest.push(error);
    }
    if (problem.errors?.length && rest.length === 0) return;
    const elsewhere = placeFaults({ ...problem, errors: rest }, (pointer) => this.#cutters.field(pointer) ?? this.#form.field(fieldNameOf(pointer)));
    this.element.querySelector('[aria-invalid]')?.focus();
    if (elsewhere.length > 0) this.#tell(`${problem.title}.`, ...elsewhere);
  }

  #showAnswer() {
    const answer = this.#last;
    const { ranking, map, times, surface } = this.#cards;
    ranking.hidden = times.hidden = surface.hidden = !answer;
    map.hidden = this.#mapped === null;
    const mapFor = (cutter) => (this.#canMap(cutter) ? () => this.#mapOf(cutter) : null);
    const unranked = notRanked(this.#unranked, this.#mapped, mapFor);
    if (answer) {
      this.#answer.replaceChildren(headline(answer));
      this.#ranking.replaceChildren(rankingTable(answer, this.#mapped, mapFor), unranked ?? '');
      this.#surface.replaceChildren(surfaceFigures(answer));
      this.#passesButtons.hidden = !answer.passes;
      this.#drawTimes();
    } else if (unranked) {
      this.#message.replaceChildren(this.#message.firstChild, unranked);
    }
    if (this.#mapped !== null) this.#map.draw();
  }

  #keepMap(cutter, answer, layer) {
    const candidate = answer.candidates[0];
    const named = { ...candidate, cutter };
    const direction = formatWithUnit(candidate.direction_deg, 'angle');
    const uncut = candidate.uncut_share > 0 ? `, ${formatWithUnit(candidate.uncut_share, 'share')} uncut` : '';
    const { parameters } = this.#request;
    const box = parameters.select?.box_mm;
    const shown = { tolerance: parameters.scallop_height_mm, direction: candidate.direction_deg, passes: answer.passes, box, layer, caption: `${nameOf(named)} at ${direction}${uncut}${answer.passes ? ', with its passes' : ''}.` };
    this.#maps.set(cutter, { map: answer.map, shown });
    this.#mapped = cutter;
    this.#map.show(answer.map, shown);
  }

  // A cutter of a library cannot be requested alone, because the page does not know its dimensions.
  #canMap({ cutter }) {
    return this.#maps.has(cutter) || (this.#request.parameters.method === 'surface' && cutter < (this.#request.parameters.cutters?.length ?? 0));
  }

  // The map of another cutter: the same request with this cutter alone, in its direction, with any uncut share allowed.
  async #mapOf({ cutter, direction_deg: direction, machining_time_s: time }) {
    const kept = this.#maps.get(cutter);
    if (kept) {
      this.#mapped = cutter;
      this.#map.show(kept.map, kept.shown);
    } else {
      const { parameters } = this.#request;
      const alone = { ...parameters, cutters: [parameters.cutters[cutter]], max_uncut_share: 1, ...(direction !== undefined && { directions_deg: [direction] }) };
      const result = await this.#while((signal) => this.#send({ ...this.#request, libraries: [], parameters: alone }, signal));
      if (!result) return;
      if (result.problem) this.#showProblem(result.problem);
      else this.#keepMap(cutter, result.answer, time === undefined ? 'uncut_mm' : undefined);
    }
    this.#showAnswer();
    this.#cards.map.scrollIntoView({ block: 'nearest' });
  }

  #drawTimes() {
    const listed = this.#last.candidates.filter(({ by_direction: found }) => found).slice(0, CHARTED);
    this.#cards.times.hidden = listed.length === 0;
    if (listed.length === 0) return;
    this.#directions = [...new Set(listed.flatMap(({ by_direction: found }) => found.direction_deg))].sort((a, b) => a - b);
    this.#times.show(() => {
      const x = this.#directions;
      const series = listed.map((candidate, i) => {
        const times = new Map(candidate.by_direction.direction_deg.map((angle, at) => [angle, candidate.by_direction.machining_time_s[at]]));
        return { label: nameOf(candidate), colour: SERIES[i], values: x.map((angle) => times.get(angle) ?? null), gaps: true };
      });
      const all = series.flatMap(({ values }) => values).filter((value) => value !== null);
      const [least, most] = all.reduce(([low, high], value) => [Math.min(low, value), Math.max(high, value)], [Infinity, -Infinity]);
      const best = listed.map((candidate, i) => ({ x: candidate.direction_deg, y: candidate.machining_time_s, colour: SERIES[i] }));
      return { x, xLabel: 'Direction (°)', yLabel: 'Time (s)', series, marks: best, yRange: () => [least * 0.96, most * 1.02] };
    });
  }
}
