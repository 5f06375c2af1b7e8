//! The level of the ridge between two passes on a plane, for the worst phase between their teeth.
//!
//! A place at the height p over the surface stays uncut if no tooth's body covers it. The cutter's section K(p) at that height is
//! convex; let its chord along the feed have the length l(t) at the lateral offset t. One pass, its teeth f apart, leaves the
//! places at t uncut for some phase exactly when l(t) < f. So something is left at the height p, for some phase of each pass,
//! exactly when the interval {t: l(t) >= f} is shorter than the step-over s. Raising p moves the section along the cutter's side and
//! never shortens the interval, so the height h that is left in the worst case is the smallest p at which it is s long:
//!
//! h = min p such that (x, t, p), (x - f, t, p), (x', t - s, p) and (x' - f, t - s, p) all lie in the body.
//!
//! That is a convex problem in x, x', t and p. Nothing is assumed on where the lowest place is or on symmetry. A feed f = 0 leaves two
//! points and gives h1.
//!
//! In terms of the signed distance to the body, which is convex: c(t, p) = min over x of max(distance(x, t, p), distance(x - f, t, p))
//! and V(p) = min over t of max(c(t, p), c(t - s, p)) are convex as well, V falls with p, and V(h) = 0.

use super::body::{Body, Distance};
use super::newton::{self, Lengths, Sought};
use super::root::{Slope, rising_root};

/// A chord along the feed at its best place: c and its derivatives to the side and along the normal.
#[derive(Debug, Clone, Copy)]
struct Chord {
    value: f64,
    by_side: f64,
    by_height: f64,
}

/// The search for the ridge of one pass and its neighbour.
pub(super) struct Ridge<'a> {
    body: &'a Body,
    step_over: f64,
    mark_spacing: f64,
    /// Places are found to this length. It moves h by about its product with the flank's slope, and slopes are about h over the
    /// lengths in play: a few roundings of h.
    resolution: f64,
}

/// Newton on a convex function gains at least a factor 2 a step even at a double root, so that 64 steps are more than a number has digits.
const MOST_STEPS: usize = 64;

impl<'a> Ridge<'a> {
    pub(super) fn new(body: &'a Body, step_over: f64, mark_spacing: f64) -> Self {
        Self { body, step_over, mark_spacing, resolution: 2.0 * f64::EPSILON * (step_over + mark_spacing) }
    }

    /// h, given a first guess of it and a height that it cannot exceed.
    pub(super) fn level(&self, guess: f64, highest: f64) -> f64 {
        let guess = guess.min(highest);
        let lengths = Lengths { level: guess, step_over: self.step_over, mark_spacing: self.mark_spacing };
        match newton::solve(self.body, Sought::Level, lengths) {
            Some(found) => found.level.min(highest),
            None => self.nested(guess, highest),
        }
    }

    /// h by nested searches, each with a bracket: slower, and without conditions.
    ///
    /// Newton from any p gives the root of a tangent to the convex V, which is never above h; from there on it rises to h.
    fn nested(&self, guess: f64, highest: f64) -> f64 {
        let mut place = Place::start(self.body, self.step_over, self.mark_spacing);
        let mut p = guess;
        for step in 0..MOST_STEPS {
            let mut mean = None;
            // c(t) - c(t - s) never falls with t, because c is convex, and has no bound, because the chord leaves the body on either side.
            place.t = rising_root(place.t, self.step_over, self.resolution, |t| {
                place.t = t;
                let (near, far) = self.chords(p, &mut place);
                mean = Some(near.balanced(&far));
                Slope { value: near.value - far.value, derivative: near.by_side - far.by_side }
            });
            let Some(mean) = mean else { break };
            // Above h the tangent may be level or meet 0 below the surface; 0 is under h as well. Passes or marks as far apart as they
            // may be fit in nowhere but at the top, and there by a rounding only: a level tangent over the body leads there.
            let next = if mean.by_height < 0.0 {
                (p - mean.value / mean.by_height).clamp(0.0, highest)
            } else if mean.value > 0.0 {
                highest
            } else {
                0.0
            };
            // From under h there is no way down but by rounding.
            if step > 1 && next <= p {
                break;
            }
            let settled = (next - p).abs() <= 4.0 * f64::EPSILON * p;
            p = next;
            if settled {
                break;
            }
        }
        p
    }

    /// h by the nested searches alone, to hold Newton's outcome against.
    #[cfg(test)]
    pub(super) fn level_by_nested_searches(&self, guess: f64, highest: f64) -> f64 {
        self.nested(guess.min(highest), highest)
    }

    /// The chords of a pass and its neighbour at the height p.
    fn chords(&self, p: f64, place: &mut Place) -> (Chord, Chord) {
        let t = place.t;
        (self.chord(t, p, &mut place.x), self.chord(t - self.step_over, p, &mut place.neighbour_x))
    }

    /// c at the lateral offset t and the height p; `x` is where the search starts and where it ended.
    ///
    /// The slope along the feed (f = 0), or the difference of both ends' distances, never falls with x, because the distance is convex.
    fn chord(&self, t: f64, p: f64, x: &mut f64) -> Chord {
        let f = self.mark_spacing;
        let (mut falling, mut rising) = (None, None);
        *x = rising_root(*x, self.step_over + f, self.resolution, |x| {
            let front = self.body.distance(x, t, p);
            if f == 0.0 {
                *(if front.by_feed < 0.0 { &mut falling } else { &mut rising }) = Some((x, front));
                return Slope { value: front.by_feed, derivative: front.bend };
            }
            let back = self.body.distance(x - f, t, p);
            (rising, falling) = (Some((x, front)), Some((x, back)));
            Slope { value: front.value - back.value, derivative: front.by_feed - back.by_feed }
        });
        match (rising, falling) {
            (Some(rising), Some(falling)) => Chord::between(rising, falling),
            (Some((_, alone)), None) | (None, Some((_, alone))) => Chord::at(alone),
            (None, None) => Chord::at(self.body.distance(*x, t, p)),
        }
    }
}

/// Where the search for the ridge stands: the offset t, and where both chords end along the feed.
pub(super) struct Place {
    pub(super) t: f64,
    pub(super) x: f64,
    pub(super) neighbour_x: f64,
}

impl Place {
    /// Half-way between the passes, the chords where the body is an ellipsoid.
    pub(super) fn start(body: &Body, step_over: f64, mark_spacing: f64) -> Self {
        let (half_step, half_mark, radii) = (step_over / 2.0, mark_spacing / 2.0, body.relative_radii());
        // A sharp edge fed along the level line has no radius across the feed; its lowest places are somewhere on the cutter.
        let ahead = (radii.skew * half_step / radii.across.max(f64::MIN_POSITIVE)).clamp(-body.reach(), body.reach());
        Self { t: half_step, x: half_mark + ahead, neighbour_x: half_mark - ahead }
    }
}

impl Chord {
    fn at(place: Distance) -> Self {
        Self { value: place.value, by_side: place.by_side, by_height: place.by_height }
    }

    /// c from the tangents at two ends, one where the distance rises along the feed and one where it falls. Balanced, they do not
    /// depend on x: a lower bound of c, and c itself where the ends are the chord's. The corner of a sharp edge keeps two tangents at
    /// one place.
    fn between((rising_x, rising): (f64, Distance), (falling_x, falling): (f64, Distance)) -> Self {
        let share = balance(rising.by_feed, falling.by_feed);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Self {
            value: mix(rising.value, falling.value) - share * rising.by_feed * (rising_x - falling_x),
            by_side: mix(rising.by_side, falling.by_side),
            by_height: mix(rising.by_height, falling.by_height),
        }
    }

    /// The mean of a chord that rises to the side and one that falls, with the weights that make their slopes cancel: where the
    /// greater of two convex functions is least, this is it and its derivative along the normal.
    fn balanced(&self, falling: &Self) -> Self {
        let share = balance(self.by_side, falling.by_side);
        let mix = |one: f64, other: f64| share * one + (1.0 - share) * other;
        Self { value: mix(self.value, falling.value), by_side: 0.0, by_height: mix(self.by_height, falling.by_height) }
    }
}

/// The weight of a rising slope against a falling one that makes their mean vanish; any weight does where neither slopes.
pub(super) fn balance(rising: f64, falling: f64) -> f64 {
    let whole = rising - falling;
    if whole > 0.0 { (-falling / whole).clamp(0.0, 1.0) } else { 0.5 }
}
