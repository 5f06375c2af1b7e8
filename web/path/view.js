// The tool path view: a program against a part, or a table of contacts.

import { el } from '../dom.js';
import { Field } from '../fields.js';
import { ContactTable } from './contacts.js';
import { ProgramCheck } from './check.js';

const MODES = [['check', 'Program on a part'], ['contacts', 'Table of contacts']];

export class PathView {
  name = 'path';
  #mode;
  #shown;

  constructor(onChange, onAsk) {
    this.#mode = new Field({ name: 'mode', label: 'Tool path', help: 'A program checked against its part, or contacts of which each gets its feed, step-over or height.', choices: MODES, segmented: true, value: 'check' }, () => {
      this.#arrange();
      this.show();
      onChange();
    });
    this.views = { check: new ProgramCheck(onChange, onAsk), contacts: new ContactTable(onChange) };
    this.element = el('div', { id: 'view-path' }, Object.values(this.views).map(({ element }) => element));
    this.#arrange();
  }

  #arrange() {
    this.#shown = this.views[this.#mode.value] ?? this.views.check;
    for (const view of Object.values(this.views)) view.element.hidden = view !== this.#shown;
    this.#shown.element.querySelector('.panel').prepend(this.#mode.element);
  }

  start() {
    return this.views.check.start();
  }

  state() {
    return { mode: this.#mode.value, ...this.#shown.state() };
  }

  useUnits(isInch) {
    for (const view of Object.values(this.views)) view.useUnits(isInch);
  }

  #use(mode) {
    this.#mode.set(mode);
    this.#arrange();
  }

  take({ mode = 'check', ...values }) {
    const isKnown = this.#mode.accepts(mode);
    this.#use(isKnown ? mode : 'check');
    return [...(isKnown ? [] : [`mode=${mode}`]), ...this.#shown.take(values)];
  }

  takeFiles(kind, files) {
    this.#use(kind === 'contacts' ? 'contacts' : 'check');
    return kind === 'contacts' ? this.#shown.takeFiles(files) : this.#shown.takeFile(files[0], kind);
  }

  show() {
    this.#mode.show();
    this.#shown.show();
  }

  ask() {
    return this.#shown === this.views.contacts ? this.#shown.ask() : undefined;
  }

  /** Shows a table of contacts with the values of some fields, or {check}: a program and its part. */
  open(content, values) {
    this.#use(content.check ? 'check' : 'contacts');
    return content.check ? this.#shown.open(content.check) : this.#shown.open(content, values);
  }
}
