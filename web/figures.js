// Figures of an answer: a value with its unit, its full precision in the `value` of a data element, and a tooltip from the glossary.

import { el } from './dom.js';
import { TERMS, inWords } from './terms.js';
import { format, inUnits, unitOf } from './units.js';

/** The value alone, as `<data value="full precision" data-figure="name">`. */
export function valueOf(name, value, kind = TERMS[name]?.kind) {
  return el('data', { value: value ?? '', 'data-figure': name }, format(value, kind));
}

/** A value with its unit. */
export function figure(name, value, kind = TERMS[name]?.kind) {
  const unit = unitOf(kind);
  return el('span', { class: 'figure', 'data-help': TERMS[name]?.help }, valueOf(name, value, kind), unit && el('span', { class: 'unit' }, unit));
}

/** A label with an explanation under the pointer and with the keyboard. */
export function term(name, label = TERMS[name].label) {
  return el('span', { class: 'term', tabindex: '0', role: 'note', 'data-help': TERMS[name].help }, label);
}

/** A list of labelled figures: `[[name, value], ...]`; entries without a value are left out. */
export function figureList(entries) {
  return el(
    'dl',
    { class: 'figures' },
    entries.filter(([, value]) => value !== undefined && value !== null).map(([name, value]) => el('div', {}, el('dt', {}, term(name)), el('dd', {}, figure(name, value)))),
  );
}

const capitalized = (text) => text[0].toUpperCase() + text.slice(1);

/** The reasons of a confidence: what each is about, and what was found. */
export function reasonList(reasons) {
  if (!reasons?.length) return null;
  return el('ul', { class: 'reasons' }, reasons.map(({ code, level, detail }) => el('li', { class: level }, el('b', {}, `${capitalized(inWords(code))}.`), ` ${capitalized(inUnits(detail))}.`)));
}

/** The warnings of an answer; nothing where there are none. */
export function warningList(warnings) {
  if (!warnings?.length) return null;
  return el(
    'ul',
    { class: 'warnings' },
    warnings.map(({ code, detail, contacts }) => el('li', {}, el('b', {}, `${capitalized(inWords(code))}.`), ` ${capitalized(inUnits(detail))}${contacts > 1 ? ` (${contacts} contacts)` : ''}.`)),
  );
}
