// Plans that are kept while a value changes: side by side with the present one, with the differences in time and finish.

import { el } from '../dom.js';
import { term, valueOf } from '../figures.js';
import { TERMS, nameOf } from '../terms.js';
import { formatTime, formatWithUnit, unitOf } from '../units.js';

const ROWS = [
  ['machining_time_s', ({ machining_time_s: time }) => time],
  ['scallop_p99_mm', ({ scallop_height_mm: height }) => height?.p99],
  ['over_tolerance_share', ({ over_tolerance_share: share }) => share],
  ['uncut_share', ({ uncut_share: share }) => share],
  ['passes', ({ passes }) => passes],
  ['step_over_xy_mm', ({ step_over_xy_mm: step }) => step?.median],
  ['feed_rate_mm_min', ({ feed_rate_mm_min: rate }) => rate],
  ['direction_deg', ({ direction_deg: direction }) => direction],
];
// Members of a request that say nothing about the plan.
const ASIDE = new Set(['include', 'program']);
const MOST = 4;

/** The members in which two requests differ, in words. */
function differences(one, other) {
  const names = [...new Set([...Object.keys(one), ...Object.keys(other)])].filter((name) => !ASIDE.has(name) && JSON.stringify(one[name]) !== JSON.stringify(other[name]));
  return names.map((name) => (name === 'scallop_tolerance_mm' ? `tolerance ${formatWithUnit(one[name], 'height')}` : (TERMS[name]?.label ?? name.replaceAll(/_(deg|mm|share)\b|_/g, ' ').trim()).toLowerCase()));
}

export class KeptPlans {
  #plans = [];
  #present = null;
  #onMap;
  #body = el('div', {});

  /** `onMap(plan)` shows a kept plan's map. */
  constructor(onMap) {
    this.#onMap = onMap;
    this.element = el('section', { class: 'card', 'aria-label': 'Kept plans', hidden: true }, el('h2', {}, 'Plans side by side'), this.#body);
  }

  /** Keeps a plan {parameters, candidate, map}; the oldest one goes when there are too many. */
  keep(plan) {
    this.#plans = [...this.#plans, plan].slice(-MOST);
    this.show(this.#present);
  }

  /** Shows the kept plans beside the present one, which may be null. */
  show(present) {
    this.#present = present;
    this.element.hidden = this.#plans.length === 0;
    if (this.element.hidden) return;
    const plans = present && !this.#plans.includes(present) ? [present, ...this.#plans] : this.#plans;
    const heading = (plan) => el('th', { scope: 'col' }, plan === present ? 'Present' : `Kept ${this.#plans.indexOf(plan) + 1}`, el('span', { class: 'muted' }, ` ${nameOf(plan.candidate)}`));
    const others = (plan) => plan !== present && el('span', { class: 'buttons' },
      plan.map && el('button', { type: 'button', class: 'quiet', onclick: () => this.#onMap(plan) }, 'map'),
      el('button', { type: 'button', class: 'quiet', 'aria-label': `Forget the kept plan ${this.#plans.indexOf(plan) + 1}`, onclick: () => this.#forget(plan) }, '×'));
    this.#body.replaceChildren(el('div', { class: 'scroll', tabindex: '0', role: 'region', 'aria-label': 'Plans side by side' }, el('table', { class: 'ranking kept' },
      el('thead', {}, el('tr', {}, el('td', {}), plans.map(heading), el('td', {}))),
      el('tbody', {},
        ROWS.filter(([, read]) => plans.some(({ candidate }) => read(candidate) !== undefined)).map(([name, read]) => el('tr', { 'data-row': name }, el('th', { scope: 'row' }, term(name)), plans.map((plan) => this.#cell(name, read, plan)), el('td', { class: 'unit' }, TERMS[name].kind === 'time' ? '' : unitOf(TERMS[name].kind)))),
        el('tr', {}, el('th', { scope: 'row' }, 'Differs in'), plans.map((plan) => el('td', { class: 'words' }, plan === present || !present ? '' : differences(plan.parameters, present.parameters).join(', ') || 'nothing')), el('td', {})),
        el('tr', {}, el('th', { scope: 'row' }, ''), plans.map((plan) => el('td', {}, others(plan))), el('td', {}))))));
  }

  #cell(name, read, plan) {
    const [value, base] = [read(plan.candidate), this.#present && read(this.#present.candidate)];
    const shown = TERMS[name].kind === 'time' ? el('data', { value, 'data-figure': name }, formatTime(value)) : valueOf(name, value);
    const change = plan !== this.#present && value > 0 && base > 0 && ['machining_time_s', 'scallop_p99_mm'].includes(name) ? value / base - 1 : null;
    return el('td', {}, shown, change !== null && el('span', { class: 'change' }, ` ${change < 0 ? '−' : '+'}${Math.abs(100 * change).toFixed(1)} %`));
  }

  #forget(plan) {
    this.#plans = this.#plans.filter((each) => each !== plan);
    this.show(this.#present);
  }
}
