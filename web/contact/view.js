// The contact view: one cutter at one contact. It requests both models while the user types, and draws their answers.

import { LineChart } from '../charts.js';
import { addressOf, post, Unreachable } from '../service.js';
import { copy, curlOfJson } from '../clipboard.js';
import { debounced, el, onWidth } from '../dom.js';
import { Form, placeFaults } from '../fields.js';
import { term, valueOf, warningList } from '../figures.js';
import { TERMS, inWords } from '../terms.js';
import { ROUGHNESS_FIELDS, arrangeTolerance, heightOf, toleranceFields, toleranceOf } from '../tolerance.js';
import { factorOf, formatWithUnit, unitOf } from '../units.js';
import { MODELS, heightsOverFeed, heightsOverStepOver, stepOverByDirection } from './curves.js';
import { detail, noSection, overview, section } from './drawing.js';
import { CUTTER_FIELDS, CUTTER_NAMES, arrangeByQuestion } from './fields.js';
import { anglesOf, frameOfAngles, frameOfVectors } from './frame.js';
import { polarChart } from './polar.js';
import { remediesOf, verdictOf } from './remedies.js';
import { arcsOf, diameterOf } from './profile.js';
import { ENDPOINTS, contactOf, cutterOf, fieldAt, requestOf } from './request.js';

const QUESTIONS = [['height', 'Scallop height'], ['step', 'Largest step-over'], ['feed', 'Largest feed'], ['fastest', 'Fastest step-over and feed']];

const FIELDS = [
  { name: 'question', label: 'Find', help: 'What to find: the height that a step-over and a feed leave, the largest step-over or feed under a tolerance, or the pair that finishes the most area per minute.', choices: QUESTIONS, segmented: true, value: 'height' },
  ...CUTTER_FIELDS,
  { name: 'contact_form', label: 'Contact by', help: 'State the contact by its angles or by vectors.', choices: [['angles', 'Angles'], ['vectors', 'Vectors']], segmented: true, value: 'angles' },
  { name: 'slope_deg', value: 40 },
  { name: 'feed_angle_deg', value: 30 },
  { name: 'normal', text: true, value: '-0.64, 0, 0.77' },
  { name: 'feed', text: true, value: '1, 0, 0.84' },
  { name: 'tool_axis', text: true, optional: '0, 0, 1' },
  { name: 'surface_form', label: 'Surface', help: 'Shape of the surface at the contact: plane, curved across the feed, or curved in all directions.', choices: [['plane', 'Plane'], ['radius', 'Radius'], ['curvature', 'Curvatures']], segmented: true, value: 'plane' },
  { name: 'surface_radius_mm', value: 120, inch: 127 },
  { name: 'along_per_mm', value: 0 },
  { name: 'across_per_mm', value: 0.01, inch: 0.25 / 25.4 },
  { name: 'twist_per_mm', value: 0 },
  { name: 'radial_mm', optional: 'none' },
  { name: 'axial_mm', optional: 'none' },
  { name: 'step_form', label: 'Measured', help: 'How the step-over is measured: along the surface, or between vertical planes seen from above.', choices: [['surface', 'On the surface'], ['xy', 'Seen from above']], segmented: true, value: 'surface' },
  { name: 'step_over_mm', value: 0.687, inch: 0.635 },
  { name: 'step_over_xy_mm', value: 0.65, inch: 0.635 },
  { name: 'feed_per_tooth_mm', value: 0.15, inch: 0.1524 },
  { name: 'scallop_tolerance_mm', value: 0.01, inch: 0.01016 },
  ...ROUGHNESS_FIELDS,
  { name: 'max_feed_per_tooth_mm', optional: 'no limit' },
  { name: 'max_feed_rate_mm_min', optional: 'no limit' },
  { name: 'min_step_over_mm', optional: 'no limit' },
  { name: 'max_step_over_mm', optional: 'no limit' },
];

// Which fields a question needs; the tolerance is also the line that a height is compared with.
const NEEDS = {
  step_form: ['height', 'feed'], step_over_mm: ['height', 'feed'], step_over_xy_mm: ['height', 'feed'], feed_per_tooth_mm: ['height', 'step'],
  spindle_speed_rpm: ['feed', 'fastest'], max_feed_per_tooth_mm: ['feed', 'fastest'], max_feed_rate_mm_min: ['feed', 'fastest'],
  min_step_over_mm: ['fastest'], max_step_over_mm: ['fastest'],
};

const ROWS = ['scallop_height_mm', 'step_over_height_mm', 'feed_height_mm', 'feed_share', 'ra_um', 'step_over_mm', 'step_over_xy_mm', 'feed_per_tooth_mm', 'feed_rate_mm_min', 'area_rate_mm2_min', 'limited_by', 'effective_radius_mm', 'transverse_effective_radius_mm', 'deviation'];
const MAIN_ROW = { height: ['scallop_height_mm'], step: ['step_over_mm', 'step_over_xy_mm'], feed: ['feed_per_tooth_mm', 'feed_rate_mm_min'], fastest: ['step_over_mm', 'feed_per_tooth_mm', 'area_rate_mm2_min'] };
const INFINITE_WHERE_NULL = new Set(['effective_radius_mm', 'transverse_effective_radius_mm']);
const MODEL_NAMES = { envelope: ['Exact', 'Model “envelope”: the cutter’s whole lower body. Nothing of the cutter is approximated.'], analytic: ['Published', 'Model “analytic”: circles of the effective radii (Segonds et al. 2017). Weak near floors, for oblique feeds and on walls.'] };

export class ContactView {
  name = 'contact';
  #form;
  #results = el('div', { class: 'answer', 'aria-live': 'polite' });
  #message = el('p', { class: 'problem', role: 'alert', hidden: true });
  // The answer in a line, which stays in sight on a narrow screen.
  #inSight = el('p', { class: 'in-sight', 'aria-hidden': 'true' });
  #overview = el('div', { class: 'drawing overview' });
  #detail = el('div', { class: 'drawing detail' });
  #polar = el('div', { class: 'drawing polar' });
  #polarCaption = el('p', { class: 'muted' });
  #overStepOver = new LineChart('Scallop height over step-over');
  #overFeed = new LineChart('Scallop height over feed per tooth');
  #asked = new AbortController();
  #charted = new AbortController();
  #last = null;
  // The last request with an answer, which stays in view while a value is typed.
  #good = null;
  #curves = {};
  #frame = 0;
  #sizes = { overview: 0, detail: 0, polar: 0 };

  #onChange;

  constructor(onChange) {
    this.#onChange = onChange;
    this.#form = new Form(FIELDS, () => {
      this.#arrange();
      onChange();
      this.ask();
    });
    this.element = el('section', { class: 'view', id: 'view-contact', 'aria-label': 'Contact' }, this.#panel(), this.#output());
    this.#arrange();
    for (const [name, element] of [['overview', this.#overview], ['detail', this.#detail], ['polar', this.#polar]]) {
      onWidth(element, (width) => {
        this.#sizes[name] = width;
        if (name === 'polar') this.#drawPolar();
        else this.#drawSection();
      });
    }
  }

  #panel() {
    const form = this.#form;
    const copyButton = el('button', { type: 'button', onclick: () => copy(this.#curl(), copyButton) }, 'Copy as curl');
    const linkButton = el('button', { type: 'button', onclick: () => copy(location.href, linkButton) }, 'Copy link');
    return el(
      'form',
      { class: 'panel', 'aria-label': 'Contact', onsubmit: (event) => event.preventDefault() },
      form.element('question'),
      el('h2', {}, 'Cutter'), el('div', { class: 'grid' }, form.elements(...CUTTER_NAMES)),
      el('h2', {}, 'Contact'), el('div', { class: 'grid' }, form.elements('contact_form', 'slope_deg', 'feed_angle_deg', 'normal', 'feed', 'tool_axis')),
      el('h2', {}, 'Passes'), el('div', { class: 'grid' }, form.elements('step_form', 'step_over_mm', 'step_over_xy_mm', 'feed_per_tooth_mm', ...toleranceFields('scallop_tolerance_mm'), 'max_feed_per_tooth_mm', 'max_feed_rate_mm_min', 'min_step_over_mm', 'max_step_over_mm')),
      el('h2', {}, 'Surface and runout'), el('div', { class: 'grid' }, form.elements('surface_form', 'surface_radius_mm', 'along_per_mm', 'across_per_mm', 'twist_per_mm', 'radial_mm', 'axial_mm')),
      el('div', { class: 'actions' }, copyButton, linkButton, el('button', { type: 'button', onclick: () => this.#set(this.#form.initial()) }, 'Reset')),
    );
  }

  // Sets fields as if they were typed.
  #set(values) {
    this.#form.takeKnown(values);
    this.#arrange();
    this.#onChange();
    return this.ask();
  }

  #output() {
    return el(
      'div',
      { class: 'results' },
      this.#message, this.#inSight,
      el('div', { class: 'contact-cards' },
        el('div', { class: 'stack' },
          el('section', { class: 'card', 'aria-label': 'Answer' }, el('h2', {}, 'Answer'), this.#results),
          el('section', { class: 'card', 'aria-label': 'Step-over by direction' }, el('h2', {}, 'Largest step-over by feed direction'), this.#polar, this.#polarCaption)),
        el('div', { class: 'stack' },
          el('section', { class: 'card', 'aria-label': 'Cusp' }, el('h2', {}, 'Cusp between two passes'), this.#detail),
          el('section', { class: 'card', 'aria-label': 'Cutter on the surface' }, el('h2', {}, 'Across the feed, to scale'), this.#overview))),
      el('div', { class: 'columns halves' }, el('section', { class: 'card' }, this.#overStepOver.element), el('section', { class: 'card' }, this.#overFeed.element)),
      el('p', { class: 'legend' }, el('span', { class: 'key envelope' }, 'Exact'), el('span', { class: 'key analytic' }, 'Published'), el('span', { class: 'key tolerance' }, 'Tolerance'), el('span', { class: 'key present' }, 'Values in use')),
    );
  }

  // Shows the fields that the choices need.
  #arrange() {
    const { question, contact_form, surface_form, step_form } = this.#form.values();
    const shown = (name, condition) => {
      this.#form.element(name).hidden = !condition;
    };
    arrangeByQuestion(this.#form, NEEDS);
    arrangeTolerance(this.#form, 'scallop_tolerance_mm');
    for (const name of ['slope_deg', 'feed_angle_deg']) shown(name, contact_form !== 'vectors');
    for (const name of ['normal', 'feed', 'tool_axis']) shown(name, contact_form === 'vectors');
    shown('surface_radius_mm', surface_form === 'radius');
    for (const name of ['along_per_mm', 'across_per_mm', 'twist_per_mm']) shown(name, surface_form === 'curvature');
    const stepOver = NEEDS.step_form.includes(question);
    shown('step_over_mm', stepOver && step_form !== 'xy');
    shown('step_over_xy_mm', stepOver && step_form === 'xy');
  }

  /** The form's values, the tolerance as a height too where it is stated as Ra. */
  values() {
    const values = this.#form.values();
    return { ...values, scallop_tolerance_mm: heightOf(toleranceOf(values, values.scallop_tolerance_mm)) };
  }

  state() {
    return this.#form.state();
  }

  useUnits(isInch) {
    this.#form.useUnits(isInch);
  }

  /** Takes the values of a link; returns those that it does not know. */
  take(values) {
    const unknown = this.#form.take(values);
    this.#arrange();
    return unknown;
  }

  /** Draws everything again, in other units or colours. */
  show() {
    this.#form.show();
    this.#showAnswers();
    this.#drawSection();
    this.#drawPolar();
    this.#drawCurves();
  }

  #curl() {
    const values = this.values();
    return curlOfJson(addressOf(ENDPOINTS[values.question]), requestOf(values, 'envelope'));
  }

  async ask() {
    this.#asked.abort();
    this.#charted.abort();
    this.#asked = new AbortController();
    const { signal } = this.#asked;
    const values = this.values();
    this.#results.setAttribute('aria-busy', 'true');
    try {
      const results = await Promise.all(MODELS.map((model) => post(ENDPOINTS[values.question], requestOf(values, model), signal)));
      if (signal.aborted) return;
      const answers = results.map(({ answer }) => answer);
      this.#last = { values, results, answers };
      if (answers.some(Boolean)) this.#good = this.#last;
      this.#showFaults();
      this.#showAnswers();
      this.#results.setAttribute('aria-busy', 'false');
      // Figures are shown first; the drawing follows in the next frame.
      cancelAnimationFrame(this.#frame);
      this.#frame = requestAnimationFrame(() => this.#drawSection());
      if (this.#good === this.#last) this.#chart();
    } catch (error) {
      if (error.name !== 'AbortError' && !(error instanceof Unreachable)) throw error;
    }
  }

  // A fault of one model alone belongs to that model's column; faults of both belong to the fields.
  #showFaults() {
    this.#form.clearFaults();
    this.#form.markTexts();
    const problems = this.#last.results.map(({ problem }) => problem);
    this.#message.hidden = true;
    if (!problems.every(Boolean)) return;
    const elsewhere = placeFaults(problems[0], (pointer) => this.#form.field(fieldAt(pointer)));
    this.#message.hidden = elsewhere.length === 0;
    this.#message.textContent = elsewhere.join('; ');
  }

  #showAnswers() {
    if (!this.#last) return;
    const isGood = this.#last.answers.some(Boolean);
    this.element.classList.toggle('is-stale', !isGood);
    const { results, answers, values } = isGood ? this.#last : (this.#good ?? this.#last);
    const take = (changes) => this.#set(changes);
    const { problem: fault } = this.#last.results[0];
    const trouble = isGood ? [] : [el('p', { class: 'trouble' }, el('b', {}, `${fault.title}. `), this.#good && 'Below is the last answer.'), el('div', { class: 'actions' }, remediesOf(fault, take))];
    this.#inSight.textContent = this.#lineOf(isGood ? answers.find(Boolean) : null, fault);
    if (answers.every((answer) => !answer)) {
      this.#results.replaceChildren(...trouble);
      return;
    }
    const cell = (answer, row) => {
      if (!answer) return '–';
      if (row === 'limited_by') return answer.limited_by ? [answer.limited_by].flat().map(inWords).join(', ') : '–';
      const value = row === 'deviation' ? answer.check?.deviation : answer[row];
      if (value === undefined) return '–';
      if (value === null && INFINITE_WHERE_NULL.has(row)) return el('data', { value: 'infinite', 'data-figure': row }, '∞');
      return valueOf(row, value);
    };
    const present = ROWS.filter((row) => answers.some((answer) => answer && (row === 'deviation' ? answer.check : answer[row] !== undefined)));
    const table = el(
      'table',
      { class: 'models' },
      el('thead', {}, el('tr', {}, el('td', {}), MODELS.map((model) => el('th', { scope: 'col', class: model }, el('span', { class: 'term', tabindex: '0', role: 'note', 'data-help': MODEL_NAMES[model][1] }, MODEL_NAMES[model][0]))), el('td', {}))),
      el('tbody', {}, present.map((row) => el('tr', { class: MAIN_ROW[values.question].includes(row) ? 'main' : '', 'data-row': row },
        el('th', { scope: 'row' }, term(row)), answers.map((answer, i) => el('td', { 'data-model': MODELS[i], class: row === 'limited_by' ? 'words' : '' }, cell(answer, row))), el('td', { class: 'unit' }, TERMS[row].kind ? unitOf(TERMS[row].kind) : '')))),
    );
    const notes = MODELS.flatMap((model, i) => {
      const { problem } = results[i];
      if (problem) return [el('p', { class: 'note' }, el('b', {}, `${MODEL_NAMES[model][0]}: no answer. `), problem.detail)];
      return answers[i].warnings?.length ? [el('p', { class: 'note' }, el('b', {}, `${MODEL_NAMES[model][0]}:`)), warningList(answers[i].warnings)] : [];
    });
    const shown = el('div', { class: isGood ? null : 'dimmed' }, isGood && verdictOf({ values, answer: answers.find(Boolean) }, take), table, notes);
    this.#results.replaceChildren(...trouble, shown);
  }

  // The main figures of an answer in one line.
  #lineOf(answer, problem) {
    if (!answer) return problem?.title ?? '';
    const rows = MAIN_ROW[this.#last.values.question].filter((row) => answer[row] !== undefined && answer[row] !== null);
    return rows.map((row) => `${TERMS[row].label} ${formatWithUnit(answer[row], TERMS[row].kind)}`).join(' · ');
  }

  // The geometry of the last answer, for drawings and charts; null where it has none.
  #geometry() {
    const { values, answers } = this.#good ?? {};
    const answer = answers?.find(Boolean);
    if (!answer) return null;
    const contact = contactOf(values);
    const frame = contact.normal ? frameOfVectors(contact.normal, contact.feed, contact.tool_axis) : frameOfAngles(contact.slope_deg, contact.feed_angle_deg);
    if (!frame) return null;
    const { slope, feedAngle } = contact.normal ? anglesOf(frame) : { slope: contact.slope_deg, feedAngle: contact.feed_angle_deg };
    const arcs = arcsOf(cutterOf(values));
    const curvature = { along: 0, across: 0, twist: 0 };
    if (values.surface_form === 'radius' && values.surface_radius_mm) curvature.across = 1 / values.surface_radius_mm;
    if (values.surface_form === 'curvature') Object.assign(curvature, { along: values.along_per_mm ?? 0, across: values.across_per_mm ?? 0, twist: values.twist_per_mm ?? 0 });
    return {
      frame, slope, feedAngle, diameter: diameterOf(arcs), arcs, curvature, stepOver: answer.step_over_mm, feed: answer.feed_per_tooth_mm ?? values.feed_per_tooth_mm ?? 0,
      height: answer.scallop_height_mm, stepOverHeight: answer.step_over_height_mm, tolerance: typeof values.scallop_tolerance_mm === 'number' ? values.scallop_tolerance_mm : undefined,
    };
  }

  #drawSection() {
    const geometry = this.#geometry();
    if (!geometry || !(geometry.stepOver > 0)) {
      for (const element of [this.#overview, this.#detail]) element.replaceChildren(noSection('The drawing appears with an answer.'));
      return;
    }
    const shown = section(geometry);
    if (this.#sizes.overview) this.#overview.replaceChildren(overview(shown, this.#sizes.overview, 300));
    if (this.#sizes.detail) this.#detail.replaceChildren(detail(shown, this.#sizes.detail, 340));
  }

  #chart = debounced(120, async () => {
    this.#charted.abort();
    this.#charted = new AbortController();
    const { signal } = this.#charted;
    const geometry = this.#geometry();
    if (!geometry || !(geometry.stepOver > 0)) {
      this.#curves = {};
      this.#drawCurves();
      this.#drawPolar();
      return;
    }
    const { values } = this.#good;
    const { tolerance } = geometry;
    try {
      const [overStepOver, overFeed, byDirection] = await Promise.all([
        heightsOverStepOver(values, geometry, signal),
        heightsOverFeed(values, geometry, signal),
        tolerance === undefined ? null : stepOverByDirection(values, geometry, tolerance, signal),
      ]);
      if (signal.aborted) return;
      this.#curves = { geometry, overStepOver, overFeed, byDirection };
      this.#drawCurves();
      this.#drawPolar();
    } catch (error) {
      if (error.name !== 'AbortError' && !(error instanceof Unreachable)) throw error;
    }
  });

  #drawCurves() {
    const { geometry } = this.#curves;
    for (const [chart, name, present, label] of [[this.#overStepOver, 'overStepOver', 'stepOver', 'Step-over'], [this.#overFeed, 'overFeed', 'feed', 'Feed per tooth']]) {
      if (!geometry) {
        chart.clear('The chart appears with an answer.');
        continue;
      }
      const { x, columns } = this.#curves[name];
      chart.show(() => {
        const [length, height] = [factorOf('length'), factorOf('height')];
        const scaled = columns.map((column) => column.map((value) => (value === null ? null : value * height)));
        const marks = [{ x: geometry[present] * length, colour: 'present' }];
        if (geometry.tolerance !== undefined) marks.push({ y: geometry.tolerance * height, colour: 'tolerance' });
        return {
          x: x.map((value) => value * length), xLabel: `${label} (${unitOf('length')})`, yLabel: `Height (${unitOf('height')})`, marks,
          series: [{ label: 'Exact', colour: 'envelope', values: scaled[0] }, { label: 'Published', colour: 'analytic', values: scaled[1], dash: [6, 4] }],
        };
      });
    }
  }

  #drawPolar() {
    const { geometry, byDirection } = this.#curves;
    const size = Math.min(this.#sizes.polar, 340);
    if (!size) return;
    const chart = byDirection && polarChart({
      angles: byDirection.angles, feedAngle: geometry.feedAngle, size,
      series: MODELS.map((model, i) => ({ className: model, values: byDirection.columns[i] })),
      onPick: (angle) => {
        if (this.#form.value('contact_form') === 'vectors') return;
        const field = this.#form.field('feed_angle_deg');
        field.set(angle);
        field.onChange(field);
      },
    });
    if (chart) {
      this.#polar.replaceChildren(chart);
      this.#polarCaption.textContent = 'At the tolerance and the feed in use, seen from above. Click to take a direction.';
    } else {
      this.#polar.replaceChildren();
      this.#polarCaption.textContent = geometry && byDirection ? 'The tooth marks alone exceed the tolerance in every direction.' : 'State a tolerance to see the largest step-over in each direction.';
    }
  }
}
