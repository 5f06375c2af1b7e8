// A program against a part: what it leaves, where it cuts into the part, how long it takes, and the same program with new feeds where the
// service answers them.

import { save } from '../clipboard.js';
import { SHAPE_NAMES, arrangeShape, cutterOf } from '../contact/request.js';
import { el } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { EXAMPLES, fileOfSurface } from '../part/examples.js';
import { PartMap } from '../part/map.js';
import { originFields, originOf } from '../part/request.js';
import { stlOf } from '../part/sending.js';
import { get, upload, Unreachable } from '../service.js';
import { arrangeTolerance, heightOf, toleranceFields, toleranceOf } from '../tolerance.js';
import { excerpt, placesTable, summaryOf } from './check_answer.js';
import { FIELDS, fieldNameOf, parametersOf } from './check_request.js';

const PROGRAMS = 'G-code, Heidenhain\'s Klartext, APT, or CSV with x, y, z and feed rate';
const SURFACES = 'STL, OBJ, PLY, PCD, 3MF, CSV, XYZ';

export class ProgramCheck {
  #form;
  #onChange;
  #onAsk;
  #surface = null;
  #program = null;
  #text = '';
  // Members of a plan's request that the form has no field for, and the text of its program, which the page can draw.
  #given = {};
  #plan = null;
  #last = null;
  #run = null;
  #files = {
    surface: el('input', { type: 'file', id: 'check-surface', class: 'visually-hidden', 'aria-label': 'Surface file' }),
    program: el('input', { type: 'file', id: 'check-program', class: 'visually-hidden', 'aria-label': 'Program file' }),
  };
  #names = { surface: el('span', { class: 'muted' }, SURFACES), program: el('span', { class: 'muted' }, PROGRAMS) };
  #faults = { surface: el('p', { class: 'fault', role: 'alert', hidden: true }), program: el('p', { class: 'fault', role: 'alert', hidden: true }) };
  #message = el('p', { class: 'problem', role: 'alert', hidden: true });
  #progress = el('p', { class: 'muted', role: 'status', hidden: true });
  #hint = el('section', { class: 'card hint' }, el('h2', {}, 'What comes out'), el('p', {}, 'What the program leaves on the part and where it cuts into it, each place with its line, and the time of the program.'), el('p', { class: 'muted' }, 'Choose the part and the program, or come here from a plan in the part view.'));
  #summary = el('section', { class: 'card', 'aria-label': 'Check', hidden: true });
  #places = el('section', { class: 'card', 'aria-label': 'Places', hidden: true });
  #excerpt = el('div', {});
  #map = new PartMap(null);
  #mapCard = el('section', { class: 'card', 'aria-label': 'Map of the check', hidden: true }, el('h2', {}, 'The part'), this.#map.element);

  constructor(onChange, onAsk) {
    [this.#onChange, this.#onAsk] = [onChange, onAsk];
    this.#form = new Form(FIELDS, () => {
      this.#arrange();
      onChange();
    });
    this.element = el('section', { class: 'view', id: 'path-check', 'aria-label': 'Program on a part' }, this.#panel(), el('div', { class: 'results' }, this.#message, this.#hint, this.#summary, el('div', { class: 'columns halves' }, this.#mapCard, this.#places)));
    for (const kind of ['surface', 'program']) this.#files[kind].addEventListener('change', () => this.#files[kind].files[0] && this.takeFile(this.#files[kind].files[0], kind));
    this.#arrange();
  }

  #panel() {
    const form = this.#form;
    const drop = (kind, id, words) => [this.#files[kind], el('label', { class: 'drop', for: id }, el('b', {}, words), ' or drop it', this.#names[kind]), this.#faults[kind]];
    return el('form', { class: 'panel', 'aria-label': 'Program on a part', onsubmit: (event) => {
      event.preventDefault();
      this.check();
    } },
    el('h2', {}, 'Part'), form.element('example'), drop('surface', 'check-surface', 'Choose the part'),
    el('div', { class: 'grid' }, form.elements('unit', 'facing')),
    el('h2', {}, 'Program'), drop('program', 'check-program', 'Choose the program'), form.element('tip'), el('div', { class: 'grid' }, form.elements(...originFields().map(({ name }) => name))),
    el('h2', {}, 'Cutter'), el('div', { class: 'grid' }, form.elements('type', ...SHAPE_NAMES, 'teeth', 'spindle_speed_rpm', 'max_feed_per_tooth_mm')),
    el('h2', {}, 'Finish and machine'), el('div', { class: 'grid' }, form.elements(...toleranceFields('scallop_tolerance_mm'), 'machine', 'machine_feed_rate_mm_min', 'path_tolerance_mm')),
    el('div', { class: 'actions' }, el('button', { type: 'submit', class: 'primary' }, 'Check the program'), el('button', { type: 'button', onclick: () => {
      this.take({});
      this.#onChange();
    } }, 'Reset')), this.#progress);
  }

  /** Loads the machines. */
  async start() {
    try {
      const { answer } = await get('v1/machines');
      if (answer) this.#form.field('machine').offer([...answer.machines.map(({ name, description }) => [name, description]), ['', 'Own values']]);
    } catch (error) {
      if (!(error instanceof Unreachable)) throw error;
    }
  }

  #arrange() {
    const { example, type } = this.#form.values();
    for (const name of ['unit', 'facing']) this.#form.element(name).hidden = example !== 'file';
    arrangeShape(this.#form, type);
    arrangeTolerance(this.#form, 'scallop_tolerance_mm');
    this.element.querySelector('.drop').classList.toggle('unused', example !== 'file');
  }

  values() {
    return this.#form.values();
  }

  state() {
    return this.#form.state();
  }

  useUnits(isInch) {
    this.#form.useUnits(isInch, this.#last === null);
  }

  take(values) {
    const unknown = this.#form.take(values);
    this.#arrange();
    return unknown;
  }

  show() {
    this.#form.show();
    this.#showAnswer();
  }

  /** Takes the file of a part or of a program. */
  takeFile(file, kind) {
    if (kind === 'surface') {
      [this.#surface, this.#given] = [file, {}];
      this.#form.field('example').set('file');
    } else {
      // The tools of a plan are not those of another program.
      [this.#program, this.#plan, this.#given] = [file, null, { ...this.#given, cutters: undefined }];
    }
    this.#names[kind].textContent = `${file.name}, ${(file.size / 1e6).toPrecision(3)} MB`;
    this.#faults[kind].hidden = true;
    this.#arrange();
    this.#onChange();
  }

  /** Takes a plan's program with its part, and checks it: {program: File, text, surface?: File, values, given}. */
  open({ program, text, surface, values, given }) {
    this.#form.takeKnown(values);
    if (surface) this.takeFile(surface, 'surface');
    this.takeFile(program, 'program');
    [this.#given, this.#plan] = [given, text];
    this.#arrange();
    return this.check();
  }

  #fault(kind, text) {
    this.#faults[kind].textContent = text;
    this.#faults[kind].hidden = false;
  }

  // The scallop height in mm that the form states, by itself or by a roughness.
  #tolerance() {
    const values = this.#form.values();
    return heightOf(toleranceOf(values, values.scallop_tolerance_mm));
  }

  #parameters() {
    return parametersOf(this.#form.values(), this.#given, this.#text);
  }

  async #send(signal) {
    const example = EXAMPLES.find(([name]) => name === this.#form.value('example'));
    const form = new FormData();
    form.append('parameters', new Blob([JSON.stringify(this.#parameters())], { type: 'application/json' }));
    form.append('surface', example ? fileOfSurface(await example[2](), example[0]) : this.#surface);
    form.append('path', this.#program);
    return upload('v1/path-check/upload', form, (share) => {
      this.#progress.textContent = share < 1 ? `${Math.floor(share * 100)} % sent` : 'Milling…';
    }, signal);
  }

  async check() {
    this.#form.clearFaults();
    this.#form.markTexts();
    for (const element of [this.#message, ...Object.values(this.#faults)]) element.hidden = true;
    if (this.#form.value('example') === 'file' && !this.#surface) return this.#fault('surface', 'Choose the part.');
    if (!this.#program) return this.#fault('program', 'Choose the program.');
    this.#run?.abort();
    const run = (this.#run = new AbortController());
    this.#progress.textContent = '';
    this.#progress.hidden = false;
    try {
      this.#text = await this.#program.text();
      const result = await this.#send(run.signal);
      this.#last = result.answer ?? null;
      if (result.problem) this.#showProblem(result.problem);
      this.#excerpt.replaceChildren();
      this.#showMap();
      this.#showAnswer();
      this.#onAsk();
    } catch (error) {
      if (error instanceof Unreachable) this.#tell('The service cannot be reached; ask again when it is back.');
      else if (error.name !== 'AbortError') throw error;
    } finally {
      if (this.#run === run) this.#progress.hidden = true;
    }
    return undefined;
  }

  #tell(text) {
    this.#message.textContent = text;
    this.#message.hidden = false;
  }

  #showProblem(problem) {
    const rest = (problem.errors ?? []).filter(({ pointer, detail }) => {
      const kind = /^\/(surface|path)/.exec(pointer)?.[1];
      if (kind) this.#fault(kind === 'path' ? 'program' : kind, detail);
      return !kind;
    });
    if (problem.errors?.length && rest.length === 0) return;
    const elsewhere = placeFaults({ ...problem, errors: rest }, (pointer) => this.#form.field(fieldNameOf(pointer)));
    if (elsewhere.length > 0) this.#tell(`${problem.title}. ${elsewhere.join('; ')}`);
  }

  #showMap() {
    const map = this.#last?.map;
    this.#mapCard.hidden = !map;
    if (this.#mapCard.hidden) return;
    this.#map.show(map, { tolerance: this.#tolerance(), places: this.#last.places, program: this.#plan, origin: originOf(this.#form.values()), cutter: cutterOf(this.#form.values()), file: stlOf(this.#surface, this.#form.value('unit') || 'mm'), caption: 'What the program leaves, and its worst places.' });
  }

  #showAnswer() {
    const answer = this.#last;
    this.#hint.hidden = answer !== null;
    this.#summary.hidden = this.#places.hidden = !answer;
    if (!answer) return;
    const refed = answer.program?.text ?? answer.program;
    this.#summary.replaceChildren(
      summaryOf(answer, this.#tolerance()),
      el('div', { class: 'actions' },
        el('button', { type: 'button', onclick: () => save('check.json', `${JSON.stringify(answer, null, 1)}\n`, 'application/json') }, 'Download JSON'),
        typeof refed === 'string' && el('button', { type: 'button', class: 'primary', onclick: () => save(this.#program.name.replace(/(\.[^.]*)?$/, '-new-feeds$1'), refed, 'text/plain') }, 'Download program with new feeds')));
    this.#places.replaceChildren(el('h2', {}, 'Worst places'), this.#excerpt, placesTable(answer.places ?? [], (line) => this.#excerpt.replaceChildren(excerpt(this.#text, line))));
    this.#map.draw();
  }
}
