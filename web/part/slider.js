// A slider for the tolerance, shown where an answer takes under a second.

import { debounced, el } from '../dom.js';
import { formatRound } from '../units.js';

const [FINEST_MM, COARSEST_MM, STEPS, SOON_MS] = [0.001, 0.2, 60, 1000];
const SETTLES_MS = 120;

export class ToleranceSlider {
  #input;
  #text = el('output', {});

  /** `onChange(tolerance in mm)` is called when the slider rests. */
  constructor(onChange) {
    const changed = debounced(SETTLES_MS, () => onChange(this.#value));
    this.#input = el('input', { type: 'range', min: '0', max: String(STEPS), 'aria-label': 'Tolerance', oninput: () => {
      this.#showText();
      changed();
    } });
    this.element = el('div', { class: 'slider', hidden: true }, this.#input, 'Try tolerances: ', this.#text);
  }

  get #value() {
    return Number((FINEST_MM * (COARSEST_MM / FINEST_MM) ** (this.#input.value / STEPS)).toPrecision(2));
  }

  #showText() {
    this.#text.textContent = formatRound(this.#value, 'height');
    this.#input.setAttribute('aria-valuetext', this.#text.textContent);
  }

  /** Shows the slider at a tolerance, if the answer took less than a second. */
  show(tolerance, milliseconds) {
    this.element.hidden = !(milliseconds < SOON_MS && tolerance > 0);
    if (this.element.hidden || document.activeElement === this.#input) return;
    this.#input.value = String(Math.round((STEPS * Math.log(tolerance / FINEST_MM)) / Math.log(COARSEST_MM / FINEST_MM)));
    this.#text.textContent = formatRound(tolerance, 'height');
    this.#input.setAttribute('aria-valuetext', this.#text.textContent);
  }
}
