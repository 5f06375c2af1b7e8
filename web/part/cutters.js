// The table of candidate cutters: one form for each row.

import { el } from '../dom.js';
import { Form } from '../fields.js';
import { cutterOf } from '../contact/request.js';

const NAMES = ['name', 'type', 'diameter_mm', 'corner_radius_mm', 'teeth', 'spindle_speed_rpm', 'max_feed_per_tooth_mm', 'flute_length_mm'];
const HEADS = ['Name', 'Shape', 'Diameter', 'Corner', 'Teeth', 'Speed', 'Max feed/tooth', 'Flutes'];

const fieldsOf = (cutter) => [
  { name: 'name', label: 'Name', help: 'Any name; the answer repeats it.', text: true, value: cutter.name },
  { name: 'type', choices: [['toroidal', 'Toroidal'], ['ball_end', 'Ball end'], ['flat_end', 'Flat end']], value: cutter.type },
  ...NAMES.slice(2).map((name) => ({ name, value: cutter[name] })),
];

export class CutterTable {
  #rows = [];
  #body = el('div', { class: 'cutter-rows' });
  #onChange;

  /** `onEnter` is called for the Enter key in a field, as a form would submit. */
  constructor(onChange, onEnter) {
    this.#onChange = onChange;
    const add = el('button', { type: 'button', onclick: () => this.#add({ ...this.#rows.at(-1)?.form.values(), name: `T${this.#rows.length + 1}` }, true) }, 'Add a cutter');
    this.element = el('div', { class: 'cutters', role: 'group', 'aria-label': 'Cutters' }, el('div', { class: 'cutter-head', 'aria-hidden': 'true' }, HEADS.map((head) => el('span', {}, head)), el('span', {})), this.#body, el('div', { class: 'actions' }, add));
    this.#body.addEventListener('keydown', ({ key, target }) => key === 'Enter' && target.matches('input') && onEnter());
  }

  #add(cutter, focus) {
    const form = new Form(fieldsOf({ type: 'ball_end', ...cutter }), () => {
      this.#arrange(row);
      this.#onChange();
    });
    const remove = el('button', { type: 'button', class: 'quiet', 'aria-label': `Remove the cutter ${cutter.name ?? ''}`, onclick: () => this.#remove(row) }, '×');
    const row = { form, element: el('div', { class: 'cutter-row', role: 'group', 'aria-label': `Cutter ${this.#rows.length + 1}` }, form.elements(...NAMES), remove) };
    this.#rows.push(row);
    this.#body.append(row.element);
    this.#arrange(row);
    if (focus) {
      form.field('name').focus();
      this.#onChange();
    }
  }

  #remove(row) {
    this.#rows = this.#rows.filter((each) => each !== row);
    row.element.remove();
    this.#onChange();
  }

  #arrange({ form }) {
    form.element('corner_radius_mm').classList.toggle('unused', form.value('type') !== 'toroidal');
  }

  /** The cutters as the service takes them. */
  cutters() {
    return this.#rows.map(({ form }) => {
      const { name, spindle_speed_rpm, max_feed_per_tooth_mm, flute_length_mm, ...rest } = form.values();
      return JSON.parse(JSON.stringify({ name, ...cutterOf(rest), spindle_speed_rpm, max_feed_per_tooth_mm, flute_length_mm }));
    });
  }

  take(cutters) {
    this.#rows = [];
    this.#body.replaceChildren();
    for (const cutter of cutters) this.#add(cutter, false);
  }

  /** The field that a pointer such as /cutters/2/diameter_mm names. */
  field(pointer) {
    const found = /^\/cutters\/(\d+)(?:\/(\w+))?$/.exec(pointer);
    return found && this.#rows[found[1]]?.form.field(found[2] ?? 'name');
  }

  clearFaults() {
    for (const { form } of this.#rows) form.clearFaults();
  }

  show() {
    for (const { form } of this.#rows) form.show();
  }
}
