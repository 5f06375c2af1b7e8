// Pass or fail of a contact's answer at the tolerance, and one click for what to do about it.

import { el } from '../dom.js';
import { post } from '../service.js';
import { factorOf, formatRound, formatWithUnit } from '../units.js';
import { ENDPOINTS, requestOf } from './request.js';

// The service's heights at a limit that it found itself are that limit to rounding.
const ROUNDING = 1e-6;

// Rounded down to three digits in the units in use, so that it stays under the limit.
function under(limit) {
  const shown = limit * factorOf('length');
  const step = 10 ** (Math.floor(Math.log10(shown)) - 2);
  return Number((Math.floor(shown / step + 1e-9) * step).toPrecision(3)) / factorOf('length');
}

const button = (text, onclick) => el('button', { type: 'button', onclick }, text);

/** The verdict of an answer's height; null without a tolerance. `take(values)` sets fields. */
export function verdictOf({ values, answer }, take) {
  const { scallop_tolerance_mm: tolerance } = values;
  const { scallop_height_mm: height } = answer ?? {};
  if (typeof tolerance !== 'number' || height === undefined) return null;
  const passes = height <= tolerance * (1 + ROUNDING);
  const limit = formatRound(tolerance, 'height');
  const remedy = passes ? null : button('Use the largest step-over under the tolerance', async () => {
    const found = await post(ENDPOINTS.step, requestOf({ ...values, question: 'step' }, 'envelope'));
    if (found.answer) take({ step_form: 'surface', step_over_mm: under(found.answer.step_over_mm) });
    else take({ question: 'fastest' });
  });
  return el('p', { class: `verdict ${passes ? 'pass' : 'fail'}` }, el('b', { 'data-verdict': passes ? 'pass' : 'fail' }, passes ? 'Within tolerance' : 'Over tolerance'),
    passes ? ` – ${formatWithUnit(height, 'height')} of ${limit}.` : ` – ${formatWithUnit(height, 'height')}, ${formatWithUnit(height - tolerance, 'height')} over ${limit}. `, remedy);
}

/** The buttons for a problem's remedies; an empty list where the service names none. */
export function remediesOf({ type, max_step_over_mm: largest }, take) {
  const fastest = () => button('Find the fastest step-over and feed', () => take({ question: 'fastest' }));
  if (type === 'tolerance-exceeded' && largest > 0) return [button(`Use a step-over of ${formatRound(under(largest), 'length')}`, () => take({ step_form: 'surface', step_over_mm: under(largest) })), fastest()];
  if (type === 'tolerance-exceeded-by-feed') return [button('Ask without tooth marks', () => take({ feed_per_tooth_mm: 0 })), fastest()];
  return [];
}
