// Forms: fields described by a name of the glossary, which hold values in the service's units and show the faults that the
// service reports. The page checks no value itself.

import { el } from './dom.js';
import { TERMS } from './terms.js';
import { factorOf, formatInput, inUnits, parseInput, roundStep, unitOf } from './units.js';

let lastId = 0;

/**
 * A field. `description` is {name, choices?, segmented?, text?, label?, value?, optional?}: with `choices` (pairs of value and
 * label) a select or a row of radio buttons, with `text` a plain text, which has several lines if it is "lines", otherwise a number of the
 * glossary's kind.
 */
export class Field {
  #kind;
  #fault;
  #unit;
  #inputs;
  #typed = false;
  #choices;
  // The defaults in the two systems of units, in the service's unit.
  #metric;
  #inch;

  constructor(description, onChange) {
    const { name, choices, segmented, text, optional } = description;
    const { label, kind, help } = { ...TERMS[name], ...(description.label && { label: description.label }), ...(description.help && { help: description.help }) };
    this.name = name;
    this.#kind = choices || text ? undefined : kind;
    this.value = this.initial = description.value;
    this.#choices = choices?.map(([choice]) => String(choice));
    this.#metric = description.value;
    this.#inch = description.inch;
    this.onChange = onChange;
    const id = `field-${(lastId += 1)}`;
    const faultId = `${id}-fault`;
    this.#fault = el('p', { class: 'fault', id: faultId, hidden: true });
    if (segmented) {
      this.#inputs = choices.map(([value, text], index) => el('input', { type: 'radio', name: id, id: `${id}-${index}`, value, 'aria-label': text, onchange: () => this.#take(value) }));
      const options = choices.map(([, text], index) => [this.#inputs[index], el('label', { for: `${id}-${index}` }, text)]);
      this.element = el('fieldset', { class: 'field segmented', 'data-field': name }, el('legend', { 'data-help': help }, label), el('div', { class: 'segments' }, options), this.#fault);
    } else {
      const control = choices
        ? el('select', { id, onchange: () => this.#take(control.value) }, choices.map(([value, text]) => el('option', { value }, text)))
        : el(text === 'lines' ? 'textarea' : 'input', { id, rows: text === 'lines' ? '2' : null, autocomplete: 'off', spellcheck: 'false', inputmode: text ? 'text' : 'decimal', placeholder: optional ?? null });
      if (!choices) {
        control.addEventListener('input', () => {
          this.#typed = true;
          this.#take(this.#parse(control.value));
        });
        control.addEventListener('blur', () => {
          this.#typed = false;
          this.show();
        });
        if (this.#kind) control.addEventListener('keydown', (event) => this.#step(event));
      }
      control.dataset.help = help ?? '';
      this.#inputs = [control];
      this.#unit = this.#kind ? el('span', { class: 'unit' }) : null;
      this.element = el('div', { class: 'field', 'data-field': name }, el('label', { for: id, 'data-help': help }, label), el('div', { class: 'control' }, control, this.#unit), this.#fault);
    }
    this.show();
  }

  #parse(text) {
    return this.#kind ? parseInput(text, this.#kind) : text.trim() || undefined;
  }

  #take(value) {
    this.value = value;
    this.onChange(this);
  }

  // Arrow keys change a number by one in its second digit, with Shift in its first.
  #step(event) {
    if ((event.key !== 'ArrowUp' && event.key !== 'ArrowDown') || typeof this.value !== 'number') return;
    event.preventDefault();
    const factor = factorOf(this.#kind);
    const shown = this.value * factor;
    const step = this.#kind === 'angle' || this.#kind === 'count' ? 1 : roundStep(Math.max(Math.abs(shown), 1e-3) / 10);
    const next = shown + (event.key === 'ArrowUp' ? 1 : -1) * step * (event.shiftKey ? 10 : 1);
    this.#typed = false;
    this.value = Number((next / factor).toPrecision(7));
    this.show();
    this.onChange(this);
  }

  /** Whether the field can have `value`. */
  accepts(value) {
    return !this.#choices || this.#choices.includes(String(value));
  }

  /** Whether the value is the default. */
  get isDefault() {
    return this.value === this.initial;
  }

  /** Makes the default that of inches or of millimetres, which `isTaken` if nothing was changed. */
  useUnits(isInch, isTaken) {
    this.initial = isInch && this.#inch !== undefined ? this.#inch : this.#metric;
    if (isTaken) this.set(this.initial);
  }

  set(value) {
    this.value = value;
    this.show();
  }

  /** Shows the value in the units in use; a text that is being typed is kept. */
  show() {
    if (this.#inputs.length > 1 || this.#inputs[0].type === 'radio') {
      for (const input of this.#inputs) input.checked = input.value === String(this.value);
      return;
    }
    if (!this.#typed) this.#inputs[0].value = this.#kind ? formatInput(this.value, this.#kind) : (this.value ?? '');
    if (this.#unit) this.#unit.textContent = unitOf(this.#kind);
  }

  /** Replaces the choices of a select. */
  offer(choices) {
    this.#choices = choices.map(([value]) => String(value));
    this.#inputs[0].replaceChildren(...choices.map(([value, text]) => el('option', { value }, text)));
    this.show();
  }

  /** Shows the fault `text`, or none. */
  fault(text) {
    this.#fault.hidden = !text;
    this.#fault.textContent = text ?? '';
    // Opens a closed group, so that the fault is visible.
    if (text) this.element.closest('details')?.setAttribute('open', '');
    for (const input of this.#inputs) {
      if (text) {
        input.setAttribute('aria-invalid', 'true');
        input.setAttribute('aria-errormessage', this.#fault.id);
      } else {
        input.removeAttribute('aria-invalid');
        input.removeAttribute('aria-errormessage');
      }
    }
  }

  get kind() {
    return this.#kind;
  }

  /** Marks a text where a number is expected, also one that no request contains. */
  markText() {
    if (this.#kind && typeof this.value === 'string' && this.shown) this.fault(`expected a number, found “${this.value}”`);
  }

  get shown() {
    return this.element.closest('[hidden]') === null;
  }

  focus() {
    this.#inputs[0].focus();
  }
}

/** Fields by their names. */
export class Form {
  #fields = new Map();

  constructor(descriptions, onChange) {
    for (const description of descriptions) this.#fields.set(description.name, new Field(description, onChange));
  }

  field(name) {
    return this.#fields.get(name);
  }

  element(name) {
    return this.#fields.get(name).element;
  }

  elements(...names) {
    return names.map((name) => this.element(name));
  }

  value(name) {
    return this.#fields.get(name).value;
  }

  /** The values that are stated. */
  values() {
    return Object.fromEntries([...this.#fields].filter(([, field]) => field.value !== undefined).map(([name, field]) => [name, field.value]));
  }

  /**
   * Takes the values of a link; a field that it does not name, or with a value that is no choice, has its default. Returns the members that are no
   * fields or no choices, as texts.
   */
  take(values) {
    const isKnown = ([name, value]) => value === undefined || this.#fields.get(name)?.accepts(value);
    const known = Object.fromEntries(Object.entries(values).filter(isKnown));
    for (const [name, field] of this.#fields) field.set(name in known ? known[name] : field.initial);
    return Object.entries(values).filter((entry) => !isKnown(entry)).map(([name, value]) => `${name}=${typeof value === 'object' ? JSON.stringify(value) : value}`);
  }

  /** The defaults. */
  initial() {
    return Object.fromEntries([...this.#fields].map(([name, field]) => [name, field.initial]));
  }

  /** Takes the values that are named; the other fields keep theirs. */
  takeKnown(values) {
    for (const [name, field] of this.#fields) if (name in values) field.set(values[name]);
  }

  show() {
    for (const field of this.#fields.values()) field.show();
  }

  /** Takes the defaults of inches or of millimetres, if nothing was changed: a value that was chosen is kept, and so are those around it. */
  useUnits(isInch, mayChange = true) {
    const isTaken = mayChange && [...this.#fields.values()].every(({ isDefault }) => isDefault);
    for (const field of this.#fields.values()) field.useUnits(isInch, isTaken);
  }

  /** Marks the texts in fields of numbers. */
  markTexts() {
    for (const field of this.#fields.values()) field.markText();
  }

  /** The state for a link: the values, and an empty text where a default was deleted. */
  state() {
    return Object.fromEntries([...this.#fields].filter(([, field]) => field.value !== undefined || field.initial !== undefined).map(([name, field]) => [name, field.value ?? '']));
  }

  clearFaults() {
    for (const field of this.#fields.values()) field.fault(null);
  }
}

/**
 * Shows the faults of a problem at the fields that their pointers name: `fieldFor(pointer)` gives a field or nothing.
 * Returns the texts that belong to no visible field.
 */
export function placeFaults(problem, fieldFor) {
  const faults = problem.errors?.length ? problem.errors : [{ pointer: '', detail: problem.detail }];
  const elsewhere = [];
  for (const { pointer, detail } of faults) {
    const field = fieldFor(pointer);
    if (field?.shown) field.fault(inUnits(detail, field.kind));
    else elsewhere.push(pointer ? `${pointer}: ${inUnits(detail)}` : inUnits(detail));
  }
  return elsewhere;
}
