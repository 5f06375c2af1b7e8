// The table of candidate cutters, typed or read from tool libraries: ticked ones are sent. Each row is a form; what the cutter lacks is noted
// at it, and so are the service's faults.

import { el } from '../dom.js';
import { Form } from '../fields.js';
import { CUTTER_TYPES, inWords } from '../terms.js';
import { FIELDS_OF_SHAPES, cutterOf, hasDimension, valuesOfCutter } from '../contact/request.js';

const NAMES = ['name', 'type', 'diameter_mm', 'corner_radius_mm', 'teeth', 'spindle_speed_rpm', 'max_feed_per_tooth_mm', 'flute_length_mm'];
// Dimensions of some shapes, in a line of their own.
const FURTHER = FIELDS_OF_SHAPES.map(({ name }) => name);
const HEADS = ['Name', 'Shape', 'Diameter', 'Corner', 'Teeth', 'Speed', 'Max feed/tooth', 'Flute length'];
// The service takes this many.
const MOST = 200;

const fieldsOf = (cutter) => [
  { name: 'name', label: 'Name', help: 'Any name; the answer repeats it.', text: true, value: cutter.name },
  { name: 'type', choices: CUTTER_TYPES, value: cutter.type },
  ...NAMES.slice(2).map((name) => ({ name, value: cutter[name] })),
  ...FIELDS_OF_SHAPES.map(({ name, text }) => ({ name, text, value: valuesOfCutter(cutter)[name] })),
];

/** What a cutter lacks for a feed of its own; null if it lacks nothing. */
export function feedLack({ teeth, spindle_speed_rpm: speed }) {
  const missing = [teeth === undefined && 'teeth', speed === undefined && 'speed'].filter(Boolean);
  return missing.length > 0 ? `feed assumed: no ${missing.join(', no ')}` : null;
}

const stated = (cutter) => JSON.parse(JSON.stringify(cutter));

export class CutterTable {
  // {cutter, source, tick, form, element, note}; `source` is the library's file name, or "example" while the row is as the page made it.
  #rows = [];
  #sent = [];
  #body = el('div', { class: 'cutter-rows' });
  #filter = el('input', { type: 'search', class: 'filter', placeholder: 'Filter: ball, 6, 4-12, name', 'aria-label': 'Filter the cutters', oninput: () => this.#arrange() });
  #count = el('span', { class: 'muted', role: 'status' });
  #onChange;

  /** `onEnter` is called for the Enter key in a field, as a form would submit. */
  constructor(onChange, onEnter) {
    this.#onChange = onChange;
    const add = el('button', { type: 'button', onclick: () => this.#addTyped() }, 'Add a cutter');
    const tick = (isOn, text) => el('button', { type: 'button', class: 'quiet', onclick: () => this.#tickShown(isOn) }, text);
    this.tools = el('div', { class: 'actions cutter-tools' }, this.#filter, tick(true, 'Tick shown'), tick(false, 'Untick shown'), this.#count);
    this.element = el('div', { class: 'cutters', role: 'group', 'aria-label': 'Cutters' }, this.tools, el('div', { class: 'cutter-head', 'aria-hidden': 'true' }, el('span', {}), HEADS.map((head) => el('span', {}, head)), el('span', {})), this.#body, el('div', { class: 'actions' }, add));
    this.#body.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || !event.target.matches('input')) return;
      event.preventDefault();
      onEnter();
    });
  }

  #addTyped() {
    const last = this.#rows.at(-1);
    const row = this.#add({ ...(last && this.#valuesOf(last)), name: `T${this.#rows.length + 1}` });
    this.#arrange();
    row.form.field('name').focus();
    this.#onChange();
  }

  #add(cutter, source = null, isOn = true) {
    const row = { cutter: { type: 'ball_end', ...cutter }, source, form: null, element: null };
    row.tick = el('input', { type: 'checkbox', onchange: () => this.#changed(row) });
    row.tick.checked = isOn;
    this.#rows.push(row);
    return row;
  }

  // The row's form, made when the row is first shown.
  #build(row) {
    row.form = new Form(fieldsOf(row.cutter), () => this.#changed(row));
    row.note = el('span', { class: 'note' });
    row.further = el('div', { class: 'grid further' }, row.form.elements(...FURTHER));
    const name = row.cutter.name ?? 'cutter';
    row.tick.setAttribute('aria-label', `Use ${name}`);
    const remove = el('button', { type: 'button', class: 'quiet', 'aria-label': `Remove the cutter ${name}`, onclick: () => this.#remove(row) }, '×');
    row.element = el('div', { class: 'cutter-row', role: 'group', 'aria-label': `Cutter ${name}` }, row.tick, row.form.elements(...NAMES), remove, row.further, row.note);
  }

  #changed(row) {
    if (row.source === 'example') row.source = null;
    this.#arrange();
    this.#onChange();
  }

  #remove(row) {
    this.#rows = this.#rows.filter((each) => each !== row);
    this.#arrange();
    this.#onChange();
  }

  #tickShown(isOn) {
    for (const row of this.#shown()) row.tick.checked = isOn;
    this.#arrange();
    this.#onChange();
  }

  #valuesOf({ form, cutter }) {
    if (!form) return cutter;
    const { name, spindle_speed_rpm, max_feed_per_tooth_mm, flute_length_mm, ...rest } = form.values();
    return stated({ name, ...cutterOf(rest), spindle_speed_rpm, max_feed_per_tooth_mm, flute_length_mm });
  }

  // The rows that the filter names: by a diameter or a range of them, or by words of name, shape and library.
  #shown() {
    const text = this.#filter.value.trim().toLowerCase();
    const [, low, high] = /^([\d.]+)(?:\s*-\s*([\d.]+))?$/.exec(text) ?? [];
    return this.#rows.filter((row) => {
      const cutter = this.#valuesOf(row);
      if (low !== undefined) return cutter.diameter_mm >= Number(low) && cutter.diameter_mm <= Number(high ?? low);
      const words = `${cutter.name} ${cutter.type} ${inWords(cutter.type)} ${row.source ?? ''}`.toLowerCase();
      return text.split(/\s+/).every((word) => words.includes(word));
    });
  }

  // Shows the rows of the filter, at most as many as can be sent.
  #arrange() {
    const matched = this.#shown();
    const shown = matched.slice(0, MOST);
    for (const row of shown) {
      if (!row.form) this.#build(row);
      const type = row.form.value('type');
      for (const name of ['diameter_mm', 'corner_radius_mm']) row.form.element(name).classList.toggle('unused', !hasDimension(type, name));
      for (const name of FURTHER) row.form.element(name).hidden = !hasDimension(type, name);
      row.further.hidden = !FURTHER.some((name) => hasDimension(type, name));
      row.element.classList.toggle('off', !row.tick.checked);
      row.note.textContent = [feedLack(this.#valuesOf(row)), row.source !== 'example' && row.source].filter(Boolean).join(' · ');
    }
    const elements = shown.map(({ element }) => element);
    // Elements that stay keep the focus.
    if (elements.length !== this.#body.children.length || elements.some((element, i) => element !== this.#body.children[i])) this.#body.replaceChildren(...elements);
    const ticked = this.#rows.filter(({ tick }) => tick.checked);
    const hidden = ticked.filter((row) => !shown.includes(row)).length;
    this.tools.hidden = this.#rows.length < 8;
    this.#count.textContent = `${ticked.length} of ${this.#rows.length} ticked${hidden > 0 ? `, ${hidden} of them not shown` : ''}${ticked.length > MOST ? `; the service takes ${MOST}` : ''}`;
  }

  /** The ticked cutters as the service takes them. */
  cutters() {
    return this.#rows.filter(({ tick }) => tick.checked).map((row) => this.#valuesOf(row));
  }

  /** Whether the rows are the examples as the page made them. */
  get areExamples() {
    return this.#rows.every(({ source }) => source === 'example');
  }

  /** Marks the cutters as those of a request, to which the pointers of its faults refer. */
  markSent() {
    this.#sent = this.#rows.filter(({ tick }) => tick.checked);
  }

  take(cutters, source = null) {
    this.#rows = [];
    for (const cutter of cutters) this.#add(cutter, source);
    this.#arrange();
  }

  /** Adds a cutter of the page's making, such as a remedy. */
  add(cutter) {
    this.#add(cutter);
    this.#arrange();
  }

  /** Adds the tools of a library, which replace untouched example cutters; the first ones are ticked, as many as the service takes. */
  addTools(tools, source) {
    this.#rows = this.#rows.filter((row) => row.source !== 'example');
    let free = MOST - this.cutters().length;
    for (const { number: _number, preset: _preset, ...tool } of tools) this.#add(stated(tool), source, (free -= 1) >= 0);
    this.#arrange();
  }

  removeTools(source) {
    this.#rows = this.#rows.filter((row) => row.source !== source);
    this.#arrange();
  }

  /** Unticks the cutters of the last request whose positions are given. */
  untick(positions) {
    for (const position of positions) this.#sent[position].tick.checked = false;
    this.#arrange();
  }

  /** The field that a pointer such as /cutters/2/diameter_mm names. */
  field(pointer) {
    const found = /^\/cutters\/(\d+)(?:\/(\w+).*)?$/.exec(pointer);
    const row = found && this.#sent[found[1]];
    if (!row) return null;
    if (!row.element?.isConnected) {
      this.#filter.value = '';
      this.#arrange();
    }
    return row.form?.field(found[2] ?? 'name');
  }

  clearFaults() {
    for (const { form } of this.#rows) form?.clearFaults();
  }

  show() {
    for (const { form } of this.#rows) form?.show();
  }
}
