// The part view: a surface, candidate cutters, a tolerance and a machine in; the ranking, times over direction and a map out.

import { LineChart } from '../charts.js';
import { copy, csvOf, save } from '../clipboard.js';
import { arrangeShape, valuesOfCutter } from '../contact/request.js';
import { el, fileButton } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { get, Unreachable } from '../service.js';
import { nameOf } from '../terms.js';
import { arrangeTolerance, heightOf, toleranceFields } from '../tolerance.js';
import { readLibrary } from '../tooling/library.js';
import { formatInput, formatTime, formatWithUnit } from '../units.js';
import { SERIES, headline, notRanked, passRows, rankingRows, rankingTable, surfaceFigures } from './answer.js';
import { CutterTable } from './cutters.js';
import { EXAMPLES } from './examples.js';
import { KeptPlans } from './kept.js';
import { PartMap } from './map.js';
import { cuttersByNumber, operationKeys, severalOf } from './operations.js';
import { isKlartext } from './program.js';
import { CUTTERS, FIELDS, INCH_CUTTERS, PROGRAM, REST_NAMES, SELECTION, fieldNameOf, originValues, parametersOf, programOf } from './request.js';
import { alone, compose, curlOf, send, stlOf } from './sending.js';
import { ToleranceSlider } from './slider.js';
import { showSheet } from './sheet.js';
import { remedies } from './verdict.js';

// What the service says when it is asked is shown in place of this.
const FORMATS = 'STL, OBJ, PLY, PCD, 3MF, CSV, XYZ; up to 1 GB';
const LIBRARY_FORMATS = 'Fusion .json or .tools, FreeCAD .fctb or a zip of them, CSV';
const LIMITS = ['machine_feed_rate_mm_min', 'acceleration_m_s2', 'jerk_m_s3', 'rapid_rate_mm_min', 'max_spindle_speed_rpm', 'clearance_height_mm', 'path_tolerance_mm', 'time_factor', 'tool_change_s'];
const METHOD = ['operations', ...REST_NAMES, 'max_slope_deg', 'max_uncut_share', 'directions_deg', 'model', 'method'];
// The chart shows the fastest cutters, each in a colour of its own.
const CHARTED = SERIES.length;
// These are not parameters of method rectangle.
const OF_SURFACE_METHOD = ['operations', 'rest_of_type', 'pattern', 'max_slope_deg', 'max_uncut_share', 'directions_deg'];

export class PartView {
  name = 'part';
  #form;
  #cutters;
  #file = null;
  // Tool libraries: {file, others} of those whose tools are in the table, {file, isSent} of those that the page cannot read.
  #libraries = [];
  #run = null;
  #last = null;
  #request = null;
  // The requested maps, by the cutter's number: {map, shown}.
  #maps = new Map();
  #mapped = null;
  #unranked = [];
  #exampleCutters = CUTTERS;
  #isBegun = false;
  // What was asked of the recommended plan beside its figures: {program, options, passes}.
  #plan = {};
  #machines = [];
  #formats = FORMATS;
  #drop = el('label', { class: 'drop', for: 'surface-file' }, el('b', {}, 'Choose a file'), ' or drop it here', el('span', { class: 'muted', 'data-file': '' }, FORMATS));
  #fileInput = el('input', { type: 'file', id: 'surface-file', class: 'visually-hidden', 'aria-label': 'Surface file' });
  #libraryInput = el('input', { type: 'file', id: 'library-file', class: 'visually-hidden', multiple: true, 'aria-label': 'Tool libraries' });
  #libraryList = el('span', { class: 'muted' });
  #fileFault = el('p', { class: 'fault', id: 'file-fault', role: 'alert', hidden: true });
  #libraryFault = el('p', { class: 'fault', role: 'alert', hidden: true });
  #message = el('div', { class: 'problem', role: 'alert', hidden: true });
  #stale = el('p', { class: 'stale', role: 'status', hidden: true }, 'The fields have changed. The answer below is that of the earlier request.');
  #progress = el('progress', { max: '1', value: '0', 'aria-label': 'Upload' });
  #progressText = el('span', { role: 'status' });
  // Not announced, as it changes every second.
  #seconds = el('span', { class: 'muted', 'aria-hidden': 'true' });
  #progressBox = el('div', { class: 'progress', hidden: true });
  #go = el('button', { type: 'submit', class: 'primary' }, 'Find the cutter');
  #hint = el('section', { class: 'card hint' });
  #answer = el('div', {});
  #ranking = el('div', {});
  #surface = el('div', {});
  #announced = el('p', { class: 'visually-hidden', role: 'status' });
  #openButton = el('button', { type: 'button', onclick: () => this.#openPasses() }, 'Open passes as a tool path');
  #planButtons = el('span', { class: 'buttons' },
    el('button', { type: 'button', class: 'primary', onclick: () => this.#saveProgram() }, 'Download program'),
    el('button', { type: 'button', onclick: () => this.#checkProgram() }, 'Check the program'),
    el('button', { type: 'button', onclick: () => this.#kept.keep(this.#presentPlan) }, 'Keep this plan'),
    el('button', { type: 'button', onclick: () => this.#showSheet() }, 'Setup sheet'),
    el('button', { type: 'button', onclick: () => this.#savePasses() }, 'Download passes as CSV'),
    this.#openButton);
  #kept = new KeptPlans((plan) => {
    this.#mapped = null;
    this.#map.show(plan.map.map, { ...plan.map.shown, caption: `Kept: ${plan.map.shown.caption}` });
    this.#showAnswer();
    this.#cards.map.hidden = false;
  });
  #slider = new ToleranceSlider((tolerance) => {
    this.#form.field('tolerance_of_plan').set(tolerance);
    this.#changed();
    this.ask({ isOwn: true });
  });
  #map = new PartMap((box) => this.#selectBox(box));
  #times = new LineChart('Machining time over direction', { height: 290, onPick: (index) => this.#takeDirection(index) });
  // The directions of the chart's points.
  #directions = [];
  #onChange;
  #showPath;
  #onAsk;
  // The cards of the results.
  #cards;
  #groups = {};

  /** `showPath(text, cutter)` shows a table of contacts in the tool path view; `onAsk` is called when an answer is shown. */
  constructor(onChange, showPath, onAsk) {
    this.#showPath = showPath;
    this.#onChange = onChange;
    this.#onAsk = onAsk;
    this.#form = new Form(FIELDS, (field) => {
      if (field.name === 'machine') this.#showPreset();
      this.#arrange();
      if (PROGRAM.includes(field.name)) this.#onChange();
      else this.#changed();
    });
    this.#cutters = new CutterTable(() => this.#changed(), () => this.ask());
    this.#cutters.take(this.#exampleCutters, 'example');
    this.element = el('section', { class: 'view', id: 'view-part', 'aria-label': 'Part' }, this.#panel(), this.#output());
    this.#fileInput.addEventListener('change', () => this.#choose(this.#fileInput.files[0]));
    this.#libraryInput.addEventListener('change', () => this.#addLibraries(this.#libraryInput.files));
    this.#arrange();
    this.#addLibraries([]);
  }

  /** Loads the data that the view needs first: the machines. */
  async start() {
    try {
      const [{ answer }, { answer: about }] = await Promise.all([get('v1/machines'), get('v1/about')]);
      if (about) this.#showFormats(about);
      if (!answer) return;
      this.#machines = answer.machines;
      this.#form.field('machine').offer([...answer.machines.map(({ name, description }) => [name, description]), ['', 'Own values']]);
      this.#showPreset();
    } catch (error) {
      if (!(error instanceof Unreachable)) throw error;
    }
  }

  // The formats and the limit of the service.
  #showFormats({ surface_formats: surfaces, limits }) {
    this.#formats = `${surfaces.map((format) => format.toUpperCase()).join(', ')}; up to ${Number((limits.upload_bytes / 2 ** 30).toPrecision(2))} GB, ${limits.facets.toLocaleString('en')} facets kept`;
    if (!this.#file) this.#drop.querySelector('[data-file]').textContent = this.#formats;
  }

  #panel() {
    const form = this.#form;
    const cancel = el('button', { type: 'button', onclick: () => this.#run?.abort() }, 'Cancel');
    this.#progressBox.append(this.#progress, this.#progressText, this.#seconds, cancel);
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
      el('h2', {}, 'Finish'), el('div', { class: 'grid' }, form.elements(...toleranceFields('tolerance_of_plan'), 'pattern')), this.#slider.element,
      group('method', 'Method and limits', METHOD),
      el('h2', {}, 'Machine'), form.element('machine'),
      group('limits', 'Limits of the machine', LIMITS),
      group('program', 'Program', PROGRAM),
      el('div', { class: 'actions' }, this.#go, copyButton, linkButton, el('button', { type: 'button', onclick: () => {
        this.take({});
        this.#changed();
      } }, 'Reset')), this.#progressBox,
    );
  }

  #output() {
    const library = el('p', { class: 'library' }, this.#libraryInput, fileButton('library-file', 'Add a tool library'), ' ', this.#libraryList);
    const downloads = el('div', { class: 'actions' },
      el('button', { type: 'button', onclick: () => save('recommendation.json', `${JSON.stringify(this.#last, null, 1)}\n`, 'application/json') }, 'Download JSON'),
      el('button', { type: 'button', onclick: () => save('ranking.csv', csvOf(...rankingRows(this.#last)), 'text/csv') }, 'Download CSV'),
      this.#planButtons);
    this.#hint.append(el('h2', {}, 'What comes out'), el('p', {}, 'The fastest cutter and direction for the part, the other cutters ranked behind it with what each leaves, the machining time over every direction, and the part from above with its scallops.'), el('p', { class: 'muted' }, 'Choose a surface, or stay with the example, and find the cutter.'));
    const card = (label, ...children) => el('section', { class: 'card', 'aria-label': label, hidden: true }, ...children);
    this.#cards = {
      ranking: card('Recommendation', this.#answer, this.#ranking, downloads),
      map: card('Map', el('h2', {}, 'The part'), this.#map.element),
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
      this.#announced,
      el('div', { class: 'part-results' }, this.#stale, ranking, this.#kept.element, el('div', { class: 'columns' }, map, el('div', { class: 'stack' }, times, surface))),
    );
  }

  // Marks the shown answer as no longer that of the fields.
  #changed() {
    this.#stale.hidden = this.#last === null;
    this.#onChange();
  }

  #choose(file) {
    this.#file = file ?? null;
    this.#fileFault.hidden = true;
    if (file) this.#form.field('example').set('file');
    this.#drop.querySelector('[data-file]').textContent = file ? `${file.name}, ${(file.size / 1e6).toPrecision(3)} MB` : this.#formats;
    this.#changed();
    this.#arrange();
  }

  async #addLibraries(files) {
    this.#libraryFault.hidden = true;
    for (const file of [...files]) {
      const read = await readLibrary(file);
      this.#libraries.push({ file, isSent: !read, others: read?.others ?? [] });
      if (read) this.#cutters.addTools(read.tools, file.name);
    }
    // The same file may be chosen again after it was removed.
    this.#libraryInput.value = '';
    if (files.length > 0) this.#changed();
    this.#showLibraries();
  }

  #showLibraries() {
    const remove = (library) => {
      this.#libraries = this.#libraries.filter((each) => each !== library);
      this.#cutters.removeTools(library.file.name);
      this.#changed();
      this.#showLibraries();
    };
    const about = ({ isSent, others }) => [isSent && 'sent as it is', others.length > 0 && `no finishing cutters: ${others.map(([kind, count]) => `${count} ${kind}`).join(', ')}`].filter(Boolean).join('; ');
    const chips = this.#libraries.map((library) => el('span', { class: 'chip' }, library.file.name, about(library) && el('span', { class: 'muted' }, ` (${about(library)})`), el('button', { type: 'button', class: 'quiet', 'aria-label': `Remove ${library.file.name}`, onclick: () => remove(library) }, '×')));
    this.#libraryList.replaceChildren(...(chips.length > 0 ? chips : [LIBRARY_FORMATS]));
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

  // The recommended plan with a further part of the answer, `member`: asked for once, for its cutter alone where the page knows it.
  async #planWith(member, options) {
    const plan = this.#plan;
    if (plan[member] && JSON.stringify(plan.options) === JSON.stringify(options)) return plan[member];
    const { candidates, recommended } = this.#last;
    const changes = { include: [member], program: member === 'program' ? options : undefined };
    const single = severalOf(this.#last) ? null : alone(this.#request, candidates.find(({ cutter }) => cutter === recommended.cutter), changes);
    const request = single ?? { ...this.#request, parameters: { ...this.#request.parameters, ...changes } };
    const result = await this.#while((signal) => this.#send({ ...request, parameters: JSON.parse(JSON.stringify(request.parameters)) }, signal));
    if (result?.problem) this.#showProblem(result.problem);
    if (!result?.answer) return null;
    plan[member] = result.answer[member];
    if (member === 'program') plan.options = options;
    return plan[member];
  }

  get #programName() {
    const { recommended } = this.#last;
    const several = severalOf(this.#last);
    const ending = isKlartext(this.#plan.program.text) ? 'h' : 'nc';
    if (several) return `plan-${several.operations.length}-operations.${ending}`;
    return `${nameOf(recommended)}-${Math.round(recommended.direction_deg)}deg.${ending}`.replaceAll(/[^\w.-]+/g, '_');
  }

  async #saveProgram() {
    this.#clearFaults();
    const program = await this.#planWith('program', programOf(this.#form.values()));
    if (program) save(this.#programName, program.text, 'text/plain');
  }

  // The program is checked against its part in the tool path view.
  #checkProgram() {
    const { parameters, file } = this.#request;
    const { select, max_slope_deg: maxSlope, machine } = parameters;
    const several = severalOf(this.#last);
    const cutters = several ? cuttersByNumber(several, this.#plan.program.text, parameters.cutters ?? []) : undefined;
    const { example, unit, facing } = this.#form.values();
    const { name: _name, flute_length_mm: _flutes, ...cutter } = parameters.cutters?.[this.#last.recommended.cutter] ?? {};
    return this.#showPath({ check: {
      program: new File([this.#plan.program.text], this.#programName),
      text: this.#plan.program.text,
      surface: example === 'file' ? file : null,
      values: { example, unit, facing, teeth: undefined, spindle_speed_rpm: undefined, max_feed_per_tooth_mm: undefined, ...valuesOfCutter(cutter), tip: 'lowest_point', ...originValues(this.#plan.options?.origin_mm), tolerance_form: 'height', scallop_tolerance_mm: heightOf(parameters), machine: machine.preset ?? '', machine_feed_rate_mm_min: machine.feed_rate_mm_min, path_tolerance_mm: machine.path_tolerance_mm },
      given: { select, max_slope_deg: maxSlope, machine, cutters },
    } });
  }

  async #savePasses() {
    const passes = await this.#planWith('passes', this.#plan.options);
    if (passes) save('passes.csv', csvOf(...passRows(passes)), 'text/csv');
  }

  // The recommended cutter is passed on with its passes. Without teeth and speed the step-over takes up the whole tolerance, so that heights
  // without feed are of interest; with them the largest feed is.
  async #openPasses() {
    const passes = await this.#planWith('passes', this.#plan.options);
    if (!passes) return null;
    const { recommended, model } = this.#last;
    const { cutters, machine } = this.#request.parameters;
    const { name: _name, flute_length_mm: _length, ...cutter } = cutters?.[recommended.cutter] ?? {};
    const feed = passes.feed_per_tooth_mm;
    const machineRate = machine.feed_rate_mm_min ?? this.#machines.find(({ name }) => name === machine.preset)?.feed_rate_mm_min;
    return this.#showPath(csvOf(...passRows(passes)), { ...valuesOfCutter(cutter), scallop_tolerance_mm: heightOf(this.#request.parameters), model, max_feed_rate_mm_min: machineRate, question: feed ? 'feed' : 'height', feed_per_tooth_mm: feed ? undefined : 0 });
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
    arrangeTolerance(this.#form, 'tolerance_of_plan');
    const hasRest = values.method === 'surface' && values.rest_of_type !== '';
    arrangeShape(this.#form, hasRest ? values.rest_of_type : null, 'rest_of_');
    this.#form.element('tool_change_s').hidden = values.method !== 'surface' || values.operations === '1';
    // A closed group shows how many of its fields have a value.
    const defaults = Object.fromEntries(FIELDS.map(({ name, value }) => [name, value]));
    for (const [group, fields] of [['selection', SELECTION], ['method', METHOD], ['limits', LIMITS], ['program', PROGRAM]]) {
      const stated = fields.filter((name) => values[name] !== defaults[name]).length;
      const badge = this.#groups[group].querySelector('.badge');
      badge.hidden = stated === 0;
      badge.textContent = `${stated} set`;
    }
  }

  state() {
    return { ...this.#form.state(), cutters: this.#cutters.cutters() };
  }

  useUnits(isInch) {
    this.#form.useUnits(isInch, this.#last === null);
    this.#exampleCutters = isInch ? INCH_CUTTERS : CUTTERS;
    if (this.#cutters.areExamples && this.#last === null) this.#cutters.take(this.#exampleCutters, 'example');
  }

  take({ cutters, ...values }) {
    this.#isBegun = true;
    const unknown = this.#form.take(values);
    if (Array.isArray(cutters)) this.#cutters.take(cutters);
    else this.#cutters.take(this.#exampleCutters, 'example');
    this.#showPreset();
    this.#arrange();
    this.#stale.hidden = this.#last === null;
    return unknown;
  }

  takeFiles(kind, files) {
    this.#isBegun = true;
    return kind === 'library' ? this.#addLibraries(files) : this.#choose(files[0]);
  }

  show() {
    this.#form.show();
    this.#cutters.show();
    this.#showPreset();
    this.#showAnswer();
  }

  async #copyCurl(button) {
    return copy(curlOf(await this.#compose()), button);
  }

  #compose() {
    const values = this.#form.values();
    const sent = this.#libraries.filter(({ isSent }) => isSent).map(({ file }) => file);
    return compose(parametersOf(values, this.#cutters.cutters()), EXAMPLES.find(([name]) => name === values.example), this.#file, sent);
  }

  #send(request, signal) {
    const onProgress = (share) => {
      this.#progress.value = share;
      // A moving bar would take time from a service on the same computer.
      this.#progress.hidden = share >= 1;
      this.#progressText.textContent = share < 1 ? `${Math.floor(share * 100)} % sent` : 'Computing…';
    };
    return send(request, onProgress, signal);
  }

  /** Computes the example once, so that the first view of a part shows what comes out. */
  begin() {
    if (this.#isBegun) return;
    this.#isBegun = true;
    if (!this.#file && this.#libraries.length === 0) this.ask({ isOwn: true });
  }

  /** Asks for the recommendation; `isOwn` if the page asks by itself. */
  async ask({ isOwn = false } = {}) {
    this.#isBegun = true;
    this.#clearFaults();
    if (this.#form.value('example') === 'file' && !this.#file) {
      this.#fault(this.#fileFault, 'Choose a surface file, or one of the examples.');
      this.#fileInput.focus();
      return;
    }
    const request = await this.#compose();
    this.#cutters.markSent();
    const begun = performance.now();
    const result = await this.#while((signal) => this.#send(request, signal));
    if (!result) return;
    this.#slider.show(request.parameters.scallop_tolerance_mm ?? 0, performance.now() - begun);
    [this.#request, this.#last, this.#mapped] = [request, result.answer ?? null, null];
    this.#plan = { program: this.#last?.program, options: request.parameters.program };
    this.#maps.clear();
    this.#stale.hidden = true;
    this.#hint.hidden = true;
    this.#unranked = (result.answer ?? result.problem).not_ranked ?? [];
    if (result.problem) {
      this.#showProblem(result.problem);
    } else if (result.answer.map) {
      this.#keepMaps(result.answer);
      this.#showMap(result.answer.recommended.cutter);
    }
    this.#showAnswer();
    this.#announce();
    if (!isOwn) this.#onAsk();
    // On a narrow screen the answer is far below the button.
    const shown = this.#last ? this.#cards.ranking : this.#message;
    if (!isOwn && shown.getBoundingClientRect().top > innerHeight - 120) shown.scrollIntoView();
  }

  // Runs a request with the progress shown and the button off.
  async #while(request) {
    this.#run?.abort();
    const run = (this.#run = new AbortController());
    this.#progress.value = 0;
    this.#progressText.textContent = '';
    this.#progressBox.hidden = false;
    const begun = performance.now();
    const showSeconds = () => (this.#seconds.textContent = `${Math.round((performance.now() - begun) / 1000)} s`);
    showSeconds();
    const clock = setInterval(showSeconds, 1000);
    try {
      return await request(run.signal);
    } catch (error) {
      if (error instanceof Unreachable) this.#tell('The service cannot be reached; ask again when it is back.');
      else if (error.name !== 'AbortError') throw error;
      return null;
    } finally {
      clearInterval(clock);
      if (this.#run === run) this.#progressBox.hidden = true;
    }
  }

  #clearFaults() {
    this.#form.clearFaults();
    this.#form.markTexts();
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
      this.#message.append(remedies(problem, this.#request.parameters, (change) => this.#remedy(change)) ?? '');
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
    this.#offerWithout(rest);
  }

  // Where all faults are faults of some cutters, the others can be ranked.
  #offerWithout(errors) {
    const faulty = [...new Set(errors.map(({ pointer }) => Number(/^\/cutters\/(\d+)/.exec(pointer)?.[1])))];
    const count = this.#request?.parameters.cutters?.length ?? 0;
    if (faulty.length === 0 || faulty.some(Number.isNaN) || faulty.length >= count) return;
    if (this.#message.hidden) this.#tell(`${faulty.length === 1 ? 'One cutter has' : `${faulty.length} cutters have`} a fault.`);
    this.#message.append(el('div', { class: 'actions' }, el('button', { type: 'button', onclick: () => {
      this.#cutters.untick(faulty);
      this.ask();
    } }, 'Rank the others')));
  }

  // A remedy becomes a value of the form or a further cutter, and the question is asked again.
  #remedy({ max_uncut_share: share, cutter }) {
    if (share !== undefined) {
      this.#form.field('max_uncut_share').set(share);
      this.#groups.method.open = true;
    }
    if (cutter) this.#cutters.add(cutter);
    this.#arrange();
    this.#changed();
    return this.ask();
  }

  // The result in a sentence, for who does not see it appear.
  #announce() {
    const { recommended, candidates } = this.#last ?? {};
    this.#announced.textContent = recommended ? `${candidates.length} cutters ranked: ${nameOf(candidates[0])} comes first with ${formatTime(recommended.machining_time_s)}.` : '';
  }

  #showAnswer() {
    const answer = this.#last;
    const { ranking, map, times, surface } = this.#cards;
    ranking.hidden = times.hidden = surface.hidden = !answer;
    map.hidden = this.#mapped === null;
    const mapFor = (cutter) => (this.#canMap(cutter) ? () => this.#mapOf(cutter) : null);
    const unranked = notRanked(this.#unranked, this.#mapped, mapFor);
    if (answer) {
      this.#answer.replaceChildren(headline(answer, this.#request.parameters));
      this.#ranking.replaceChildren(rankingTable(answer, this.#mapped, mapFor), unranked ?? '');
      this.#surface.replaceChildren(surfaceFigures(answer));
      this.#planButtons.hidden = !answer.program;
      this.#openButton.hidden = severalOf(answer) !== null;
      this.#drawTimes();
    } else if (unranked) {
      this.#message.querySelector('.not-ranked')?.remove();
      this.#message.append(unranked);
    }
    if (this.#mapped !== null) this.#map.draw();
    this.#kept.show(this.#presentPlan);
  }

  // The recommended plan as it is kept and compared; null without an answer.
  get #presentPlan() {
    if (!this.#last) return null;
    const { recommended, candidates } = this.#last;
    // The same object as long as it is the same answer.
    if (this.#plan.answer !== this.#last) {
      const single = candidates.find(({ cutter }) => cutter === recommended.cutter);
      const several = severalOf(this.#last);
      const candidate = several ? { name: `${several.operations.length} operations`, type: single.type, cutter: single.cutter, feed: single.feed, ...several } : single;
      Object.assign(this.#plan, { answer: this.#last, kept: { parameters: this.#request.parameters, candidate, map: this.#maps.get(recommended.cutter) } });
    }
    return this.#plan.kept;
  }

  #showSheet() {
    const { candidate, parameters, map } = this.#presentPlan;
    const { example } = this.#form.values();
    const part = this.#request.surface ? EXAMPLES.find(([name]) => name === example)?.[1] : this.#request.file?.name;
    if (map) this.#map.show(map.map, map.shown);
    const machine = this.#machines.find(({ name }) => name === parameters.machine.preset)?.description ?? 'own values';
    showSheet({ part: part ?? 'example', answer: this.#last, candidate, cutter: parameters.cutters?.[candidate.cutter] ?? {}, parameters, machine, drawing: map && this.#map.image(), program: this.#plan.program?.text });
  }

  // The maps of an answer, by the cutter's number; that of a plan of several operations stands under the recommended cutter's.
  #keepMaps(answer) {
    const { map, maps = [], candidates, not_ranked: others = [], recommended } = answer;
    const ofAll = [...candidates, ...others];
    for (const { cutter, uncut_mm } of maps) this.#keepMap(ofAll.find((each) => each.cutter === cutter), { ...map, scallop_height_mm: undefined, uncut_mm });
    const several = severalOf(answer);
    this.#keepMap(candidates.find(({ cutter }) => cutter === recommended.cutter), map, { program: answer.program?.text, several });
  }

  #keepMap(named, map, { program, several } = {}) {
    const { cutter, direction_deg: direction, uncut_share: share, machining_time_s: time } = named;
    const { parameters, file } = this.#request;
    const uncut = share > 0 ? `, ${formatWithUnit(share, 'share')} uncut` : '';
    const plan = several ? `${several.operations.length} operations` : `${nameOf(named)}${direction === undefined ? '' : ` at ${formatWithUnit(direction, 'angle')}`}${uncut}`;
    const isPlan = map.scallop_height_mm !== undefined;
    const caption = isPlan ? `${plan}.` : `${nameOf(named)}${uncut}: where it does not fit.`;
    const shown = {
      tolerance: heightOf(parameters), direction: several ? undefined : direction, program, origin: parameters.program?.origin_mm, operations: several ? operationKeys(several) : undefined, cutter: parameters.cutters?.[cutter],
      file: stlOf(file, parameters.unit), box: parameters.select?.box_mm, layer: time === undefined || !isPlan ? 'uncut_mm' : undefined, caption,
      more: isPlan || time === undefined || !parameters.cutters?.[cutter] ? undefined : ['Show its plan, which sends the part again', () => this.#planOf(named)],
    };
    this.#maps.set(cutter, { map, shown });
  }

  #showMap(cutter) {
    const { map, shown } = this.#maps.get(cutter);
    this.#mapped = cutter;
    this.#map.show(map, shown);
  }

  // A cutter of a library that the page cannot read cannot be requested alone.
  #canMap({ cutter }) {
    return this.#maps.has(cutter) || (this.#request.parameters.method === 'surface' && cutter < (this.#request.parameters.cutters?.length ?? 0));
  }

  // The map of another cutter. Those of a file's cutters have come with its answer, if there is one; where there is none, all come with one more
  // request, in which any share may be uncut. An example is asked for again.
  async #mapOf(named) {
    const { parameters } = this.#request;
    if (!this.#maps.has(named.cutter)) {
      if (!parameters.include.includes('maps') || this.#last) return this.#planOf(named);
      const result = await this.#while((signal) => this.#send({ ...this.#request, parameters: { ...parameters, max_uncut_share: 1 } }, signal));
      if (result?.problem) this.#showProblem(result.problem);
      if (result?.answer) this.#keepMaps(result.answer);
    }
    return this.#showMapped(named.cutter);
  }

  // The plan of another cutter: the same request with this cutter alone, in its direction, with any uncut share allowed.
  async #planOf(named) {
    const result = await this.#while((signal) => this.#send(alone(this.#request, named, { max_uncut_share: 1, include: ['map'] }), signal));
    if (result?.problem) this.#showProblem(result.problem);
    if (result?.answer) {
      const [plan] = result.answer.candidates;
      this.#keepMap({ ...plan, ...named, direction_deg: plan.direction_deg, machining_time_s: named.machining_time_s }, result.answer.map);
    }
    return this.#showMapped(named.cutter);
  }

  #showMapped(cutter) {
    if (this.#maps.has(cutter)) this.#showMap(cutter);
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
