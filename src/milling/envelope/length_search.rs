//! The search for the length, a step-over or a feed per tooth, at which the height is the tolerance.

use crate::quantity::Length;

/// The share of a tolerance that counts as a rounding.
const ROUNDING: f64 = 1e-10;

/// The share of a tolerance by which the height of a length at a ridge may differ from it. A feed whose part of the height
/// is a thousandth is then right to 5e-10.
const CONFIRMED: f64 = 1e-12;

/// The logarithm of the share of a tolerance under which a height counts as none.
const LEAST_EXCESS: f64 = -30.0;

/// The slope of a height's logarithm by that of a length under which a secant shows nothing.
const LEAST_SLOPE: f64 = 1e-9;

/// The first step by which a length is bracketed, as a logarithm.
const FIRST_REACH: f64 = 0.4;

/// The width, as a share of the length, down to which the place of a jump is searched.
const NARROW: f64 = 5e-10;

/// The slopes of a height's logarithm by that of a length between which a secant counts.
const LEAST_SECANT: f64 = 0.01;
const MOST_SECANT: f64 = 20.0;

/// The largest number of secants from a guess within a few percent.
const MOST_SECANTS: usize = 8;

/// The largest length up to `largest` whose height is at most p: `found`, or the result of a search over the
/// heights that starts there or at `guess`; `None` if the height of the smallest length exceeds p.
///
/// Lengths and heights are searched by their logarithms, between which a paraboloid has the slope 2. The steps are
/// those of the secant, inside a bracket. A length without a height does not keep the tolerance.
pub(super) fn largest_within(p: f64, guess: f64, found: Option<f64>, largest: f64, height: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let excess = |length: f64| height(length).map_or(f64::INFINITY, |height| (height / p).ln().max(LEAST_EXCESS));
    let found = found.filter(|found| (Length::SMALLEST..largest).contains(found)).map(|found| (found, excess(found)));
    if let Some((found, excess)) = found
        && excess.abs() <= CONFIRMED
    {
        return Some(found);
    }
    let (shortest, longest) = (Length::SMALLEST.ln(), largest.ln());
    // The longest logarithm known to keep the tolerance, and the shortest known not to.
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut last = None::<(f64, f64)>;
    let (mut slope, mut reach) = (2.0, FIRST_REACH);
    let mut widths = [f64::INFINITY; 3];
    let mut is_near = false;
    let mut at = found.map_or(guess, |(found, _)| found).clamp(Length::SMALLEST, largest).ln();
    let mut known = found.map(|(_, excess)| excess);
    loop {
        let length = if at >= longest { largest } else { at.exp().clamp(Length::SMALLEST, largest) };
        let excess = known.take().unwrap_or_else(|| excess(length));
        if excess <= ROUNDING && (at >= longest || at <= shortest && excess > 0.0) {
            return Some(length);
        }
        if excess <= 0.0 {
            low = at;
        } else if at <= shortest {
            return None;
        } else {
            high = at;
        }
        if let Some((last_at, last_excess)) = last.replace((at, excess))
            && (excess - last_excess).is_finite()
        {
            let secant = (excess - last_excess) / (at - last_at);
            slope = if secant > LEAST_SLOPE { secant } else { f64::NAN };
        }
        let step = -excess / slope;
        if excess.abs() <= ROUNDING && step.abs() <= ROUNDING {
            // The next step ends the search, unless this one already ends within the rounding of heights.
            if is_near || step.abs() <= 0.01 * ROUNDING {
                return Some(length);
            }
            is_near = true;
        }
        let width = high - low;
        if width <= NARROW {
            return Some(low.exp());
        }
        let is_slow = width.is_finite() && width > 0.5 * widths[0];
        widths = [widths[1], widths[2], width];
        let next = at + step;
        at = if next > low && next < high && !is_slow && step.abs() <= reach {
            next
        } else if width.is_finite() {
            f64::midpoint(low, high)
        } else {
            let next = at + reach.copysign(-excess);
            reach *= 2.0;
            next
        }
        .clamp(shortest, longest);
    }
}

/// Whether a height confirms the length at which a search found the height p.
pub(super) fn confirms(height: f64, p: f64) -> bool {
    (height / p).ln().abs() <= CONFIRMED
}

/// A length near `guess` at which the logarithm of a height over the tolerance is 0, by secants without a bracket; `None`
/// where they do not converge. `at_guess` is about that logarithm at the guess. The last evaluation is at the result.
pub(super) fn by_secants(guess: f64, at_guess: f64, mut excess: impl FnMut(f64) -> Option<f64>) -> Option<f64> {
    let mut last = (guess.ln(), at_guess);
    let mut step = if at_guess == 0.0 { f64::MIN_POSITIVE } else { -at_guess / 2.0 };
    for _ in 0..MOST_SECANTS {
        if step.is_nan() || step.abs() > FIRST_REACH {
            return None;
        }
        let at = last.0 + step;
        let here = (at, excess(at.exp())?);
        if here.1.abs() <= CONFIRMED / 2.0 {
            return Some(at.exp());
        }
        // If the logarithm at the guess was not exact, the first secant can be wrong by far; the slope of a paraboloid replaces it.
        let slope = (here.1 - last.1) / (at - last.0);
        step = -here.1 / if (LEAST_SECANT..MOST_SECANT).contains(&slope) { slope } else { 2.0 };
        last = here;
    }
    None
}
