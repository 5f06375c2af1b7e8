//! Model `envelope`: the height that the cutter's exact lower body leaves.
//!
//! The analytic radii are radii of curvature at one point. They fail in three cases: on gentle slopes the groove is far
//! narrower than the circle of its curvature; with an oblique feed, neighbouring tooth marks meet along the feed and
//! not in its normal plane; and on steep walls the cutter's side cuts beside its corner. Here the height is that of the
//! highest point that any phase between the teeth of neighbouring passes can leave uncut: a bound that is reached.
//!
//! Assumptions: a tooth cuts the shape of the whole body, so the feed per revolution is small compared with the
//! cutter's circumference; the cutter's side is as long as the wall that it passes; passes are parallel; the surface is
//! of the second order, so that changes of its curvature are left out.
//!
//! - `body`: the cutter, placed at a mark by the surface's own normal there, and its distance from a point;
//! - `marks`: which pairs of marks decide, with and without runout;
//! - `ridge`: the fast search, Newton's method on all unknowns at once;
//! - `search`: the sure search, nested and bracketed, wherever the fast one does not prove its result;
//! - `mod` (this file): heights and both inverses.

mod body;
mod marks;
mod ridge;
mod search;

use super::gouging;
use super::{Contact, Cutter, NoAnswer, Pass, ScallopHeight};
use crate::quantity::{Direction, Length};
use body::Body;
use marks::Pattern;
use search::{Lengths, Outcome, Places, Search, Sought};

/// The share by which the largest length that is reported may be smaller than the largest that has a height on a curved
/// surface.
const MET: f64 = 0.01;

/// The share of lengths that is left of those at which passes or marks only just overlap.
const JUST_UNDER: f64 = 1.0 - 1e-9;

/// A height under this, in mm, is 0: the place lies on the cutter's flat or side.
const NOTHING: f64 = 1e-30;

/// The envelope model at one contact. It covers every slope from 0 to 90 deg and every cutter.
///
/// **Heights.** The stated contact is the place where the ridge is left. A mark leaves the height at which its body is
/// entered along the stated normal there; a pass leaves at most the higher of what two neighbouring marks leave, in the worst
/// phase of its teeth, and the lowest over where the pair lies; two passes s apart leave at most the lower of what each
/// leaves, wherever they lie. h is the greatest of these, h1 is the same without marks, and the feed's part is h - h1. Both
/// grow with s and with the feed by definition.
///
/// **Overlap.** Seen from above, a pass clears a strip 2R wide, and the marks of the teeth are circles of radius R.
/// With d the passes' distance and f the marks' distance seen from above, material stays uncut from top to bottom
/// unless d^2 + f^2 <= 4 R^2; that is an error. For a feed along a wall, d is 0 for every s.
///
/// **Curved surfaces.** Heights are measured from the surface 1/2 u'Ku below the tangent plane, and each mark is placed by
/// the surface's normal at its own contact.
///
/// **Runout.** Heights are measured from the surface that the deepest tooth touches, whose radius is R + |rr|. The
/// shallowest tooth reaches delta = |rr| sin(S) + |ar| cos(S) less deep, and its mark is displaced along the slope, by up to
/// |rr| cos(S) downwards and |ar| sin(S) upwards. A pass leaves the lower of what a deep and a shallow mark leave in the worse
/// order, one feed per tooth and the displacement along the feed apart, and what deep marks alone, z f_z apart, leave.
#[derive(Debug, Clone, Copy)]
pub struct Envelope {
    pass: Pass,
    outer_radius: f64,
    body: Body,
    pattern: Pattern,
    climb: Direction,
    /// lambda.
    relative_curvature: f64,
    /// The cutter's curvature relative to the surface along the feed, across it and the twist, for first guesses.
    curvature: [f64; 3],
}

/// A height and the ridge that has it.
#[derive(Debug, Clone, Copy)]
struct Height {
    level: f64,
    places: Places,
}

impl Envelope {
    /// Prepares the cutter in contact with the surface.
    ///
    /// # Errors
    /// [`NoAnswer::Gouges`] on a concave surface into which the cutter does not fit.
    pub fn new(pass: Pass) -> Result<Self, NoAnswer> {
        Self::fitting(pass).ok_or_else(|| gouging::reason(&pass))
    }

    /// The same; `None` if the cutter does not fit.
    pub(in crate::milling) fn fitting(pass: Pass) -> Option<Self> {
        let relative_curvature = gouging::relative_curvature(&pass)?;
        let cutter: Cutter = pass.cutter.widened(pass.runout.radial());
        let body = Body::new(&cutter.profile(), pass.contact, pass.surface);
        let [along, across, twist] = body.relative_curvature(pass.contact);
        let definite = across * along - twist * twist;
        if !pass.surface.is_plane() && (definite.is_nan() || definite <= 0.0) {
            // The relative curvature is a rounding error, and the cutter's radius that of the surface.
            return None;
        }
        Some(Self {
            pass,
            outer_radius: cutter.outer_radius().mm(),
            body,
            pattern: Pattern::new(&pass),
            climb: pass.contact.climb(),
            relative_curvature,
            curvature: [along, across, twist],
        })
    }

    /// The same to second order: all marks have the stated normal. An independent calculation needs no more of the surface.
    #[must_use]
    pub fn without_turns(self) -> Self {
        Self { body: self.body.without_turns(), ..self }
    }

    pub(super) fn pass(&self) -> &Pass {
        &self.pass
    }

    /// lambda, the smallest relative curvature of cutter and surface as a share of the cutter's own.
    pub(super) fn relative_curvature(&self) -> f64 {
        self.relative_curvature
    }

    fn contact(&self) -> Contact {
        self.pass.contact
    }

    /// h1 and h for a step-over along the surface and a feed per tooth; `None` leaves no marks.
    ///
    /// # Errors
    /// [`NoAnswer::PassesDoNotOverlap`], [`NoAnswer::MarksDoNotOverlap`].
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        self.height_above(self.step_over_height(step_over)?, step_over, feed_per_tooth)
    }

    /// h1.
    pub(super) fn step_over_height(&self, step_over: Length) -> Result<Length, NoAnswer> {
        self.total_height(step_over, None)
    }

    /// h alone.
    pub(super) fn total_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        Ok(Length::computed(self.ridge(step_over, feed_per_tooth)?.level))
    }

    /// [`Envelope::scallop_height`] for a step-over that alone leaves `step_over_height`.
    pub(super) fn height_above(
        &self,
        step_over_height: Length,
        step_over: Length,
        feed_per_tooth: Option<Length>,
    ) -> Result<ScallopHeight, NoAnswer> {
        let total = if feed_per_tooth.is_some() { self.total_height(step_over, feed_per_tooth)? } else { step_over_height };
        Ok(ScallopHeight::of_total(step_over_height, total))
    }

    /// The largest feed per tooth that keeps `tolerance` on h at a step-over along the surface.
    ///
    /// # Errors
    /// - [`NoAnswer::StepOverUsesUpTolerance`], [`NoAnswer::ToleranceLimitsNoFeed`];
    /// - those of the step-over in [`Envelope::scallop_height`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        self.max_feed_per_tooth_above(self.step_over_height(step_over)?, tolerance, step_over)
    }

    /// The same for a step-over that alone leaves `step_over_height`.
    pub(super) fn max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        let (p, s) = (tolerance.mm(), step_over.mm());
        let used_up = || {
            let max_step_over = self.max_step_over(tolerance, None)?;
            Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over })
        };
        if step_over_height >= tolerance {
            return used_up();
        }
        let largest = self.pattern.feed_per_tooth(self.largest_spacing(s));
        if largest < Length::SMALLEST {
            return Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(largest) });
        }
        let [along, across, _] = self.groove();
        // The heights of parabolas add up.
        let spacing = (8.0 * (p - step_over_height.mm()).max(p * 1e-6).min(p - across * s * s / 8.0).max(p * 1e-6) / along).sqrt();
        let guess = Lengths { level: p, step_over: s, feed: self.pattern.feed_per_tooth(spacing) };
        match self.solve(Sought::Feed, guess, largest) {
            Outcome::At(feed) if feed >= Length::SMALLEST => Ok(Length::computed(feed)),
            Outcome::Above => Err(NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth: Length::computed(largest) }),
            Outcome::At(_) | Outcome::Below => used_up(),
        }
    }

    /// The largest step-over along the surface that keeps `tolerance` on h at a feed per tooth.
    ///
    /// # Errors
    /// - [`NoAnswer::FeedUsesUpTolerance`] if even passes [`Length::SMALLEST`] apart exceed the tolerance;
    /// - [`NoAnswer::MarksDoNotOverlap`];
    /// - [`NoAnswer::ToleranceLimitsNoStepOver`] if no step-over up to the largest one exceeds the tolerance.
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        let (p, feed) = (tolerance.mm(), feed_per_tooth.map_or(0.0, Length::mm));
        let spacing = self.pattern.spacing(feed);
        let largest = self.largest_step_over(spacing);
        if largest < Length::SMALLEST {
            return Err(self.no_height(Length::SMALLEST, feed));
        }
        let [along, across, _] = self.groove();
        let left = (p - along * spacing * spacing / 8.0).max(p * 1e-6);
        let guess = Lengths { level: p, step_over: (8.0 * left / across).sqrt().min(largest), feed };
        match self.solve(Sought::StepOver, guess, largest) {
            Outcome::At(step_over) if step_over >= Length::SMALLEST => Ok(Length::computed(step_over)),
            Outcome::Above => Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: Length::computed(largest) }),
            Outcome::At(_) | Outcome::Below => {
                let feed_height = self.height(Length::SMALLEST, feed).ok_or_else(|| self.no_height(Length::SMALLEST, feed))?;
                Err(NoAnswer::FeedUsesUpTolerance { feed_height: Length::computed(feed_height.level.max(p)) })
            }
        }
    }

    /// How much the surface's normal turns from the stated contact to the marks at the ridge; see
    /// [`EvaluatedPass::largest_turn`](crate::milling::EvaluatedPass::largest_turn).
    pub(super) fn largest_turn(&self, step_over: Length, feed_per_tooth: Option<Length>) -> f64 {
        if self.pass.surface.is_plane() {
            return 0.0;
        }
        self.ridge(step_over, feed_per_tooth).map_or(f64::INFINITY, |height| {
            let (s, feed) = (step_over.mm(), feed_per_tooth.map_or(0.0, Length::mm));
            let marks = self.pattern.marks(feed);
            let Places { x, c } = height.places;
            let turn = |pass: usize, c: f64| {
                let ends = marks.pairs().iter().zip(x[pass]).flat_map(|(pair, x)| [x, x + pair.distance]);
                ends.map(move |x| self.body.turn(x, c)).fold(0.0, f64::max)
            };
            turn(0, c).max(turn(1, c - s))
        })
    }

    fn ridge(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Height, NoAnswer> {
        let (s, feed) = (step_over.mm(), feed_per_tooth.map_or(0.0, Length::mm));
        self.height(s, feed).ok_or_else(|| self.no_height(s, feed))
    }

    /// h for passes s apart with a feed per tooth; `None` if there is none, for the reason in [`Envelope::no_height`].
    fn height(&self, s: f64, feed: f64) -> Option<Height> {
        let spacing = self.pattern.spacing(feed);
        if !(s <= self.largest_step_over(0.0) && self.overlap(s, spacing)) {
            return None;
        }
        let guess = Lengths { level: self.guess(s, feed), step_over: s, feed };
        if let Some(ridge) = self.quickly(Sought::Level, guess) {
            return Some(Height { level: ridge.lengths.level, places: ridge.places });
        }
        let search = |guess: Lengths| {
            let mut places = self.places(&guess);
            match self.search().solve(Sought::Level, guess, NOTHING, Length::LARGEST, &mut places) {
                Outcome::At(level) => Some(Height { level, places }),
                Outcome::Below => Some(Height { level: 0.0, places }),
                Outcome::Above => None,
            }
        };
        // Where the circles seen from above only just touch, rounding decides whether they do.
        search(guess).or_else(|| search(Lengths { step_over: s * JUST_UNDER, feed: feed * JUST_UNDER, ..guess }))
    }

    /// A length at which h is a tolerance.
    fn solve(&self, sought: Sought, guess: Lengths, largest: f64) -> Outcome {
        match self.quickly(sought, guess).map(|ridge| ridge.lengths.get(sought)) {
            Some(length) if length <= largest => Outcome::At(length),
            _ => self.confirmed(sought, guess, self.search().solve(sought, guess, Length::SMALLEST, largest, &mut self.places(&guess))),
        }
    }

    /// The length of the sure search, or where a curved surface has other ridges, of which the search found one that is not the
    /// height's, a smaller length whose height keeps the tolerance.
    fn confirmed(&self, sought: Sought, lengths: Lengths, found: Outcome) -> Outcome {
        let Outcome::At(length) = found else { return found };
        let keeps = |length: f64| {
            let Lengths { step_over, feed, level } = lengths.with(sought, length);
            self.height(step_over, feed).is_some_and(|height| height.level <= level * (1.0 + 1e-10))
        };
        if self.pass.surface.is_plane() || keeps(length) {
            return found;
        }
        let kept = largest_met(length, keeps);
        if kept > 0.0 { Outcome::At(kept) } else { Outcome::Below }
    }

    fn search(&self) -> Search<'_> {
        Search { body: &self.body, pattern: &self.pattern }
    }

    fn quickly(&self, sought: Sought, guess: Lengths) -> Option<ridge::Ridge> {
        let stride = guess.step_over + self.pattern.spacing(guess.feed);
        ridge::solve(&self.body, &self.pattern, stride, sought, guess, self.places(&guess))
    }

    /// The curvatures of the groove's bottom along the feed, and across it where the marks have moved along; and by how much
    /// they move.
    fn groove(&self) -> [f64; 3] {
        let [along, across, twist] = self.curvature;
        let along = along.max(1e-9);
        let lean = twist / along;
        [along, (across - twist * lean).max(1e-9), lean]
    }

    /// An approximation of h: the sum of the parabolas' heights, of which each is at most that of a half circle.
    fn guess(&self, s: f64, feed: f64) -> f64 {
        let [along, across, _] = self.groove();
        let spacing = self.pattern.even_spacing(feed, along);
        let parabola = |curvature: f64, length: f64| length / 4.0 * (curvature * length / 2.0).min(1.0);
        (parabola(across, s) + parabola(along, spacing)).min(self.outer_radius / 4.0)
    }

    /// Where marks and passes lie on paraboloids.
    fn places(&self, lengths: &Lengths) -> Places {
        let [_, _, lean] = self.groove();
        let marks = self.pattern.marks(lengths.feed);
        let half = lengths.step_over / 2.0;
        let x = [half, -half].map(|c| {
            let mut x = [0.0; 3];
            for (x, pair) in x.iter_mut().zip(marks.pairs()) {
                *x = -lean * c - pair.distance / 2.0;
            }
            x
        });
        Places { x, c: half }
    }

    /// d/s, the ratio of the passes' distance seen from above to that along the surface: cos(S) / cos(climb). Seen from
    /// above, a unit square with a side along the feed has the area cos(S), and that side the length cos(climb). On a
    /// wall the ratio is 1 for the vertical feed and 0 for any other; only theta distinguishes feeds there.
    fn spacing_ratio(&self) -> f64 {
        if self.climb.cos() == 0.0 { 1.0 } else { self.contact().slope().cos().abs() / self.climb.cos() }
    }

    /// Whether passes s apart with marks f apart overlap, seen from above. The largest step-over and feed lie on the
    /// limit, up to a few rounding errors.
    fn overlap(&self, s: f64, f: f64) -> bool {
        let (across, along) = (s * self.spacing_ratio(), f * self.climb.cos());
        let diameter = 2.0 * self.outer_radius * (1.0 + 16.0 * f64::EPSILON);
        across * across + along * along <= diameter * diameter
    }

    /// The reason why passes s apart with a feed per tooth have no height: they do not overlap seen from above, or on a curved
    /// surface the grooves or the marks do not meet.
    fn no_height(&self, s: f64, feed: f64) -> NoAnswer {
        if feed == 0.0 || self.height(s, 0.0).is_none() {
            // With a feed at which no passes overlap, the feed is the next thing to change.
            let with_marks = Some(self.largest_met_step_over(feed)).filter(|step_over| feed > 0.0 && *step_over >= Length::SMALLEST);
            let largest_step_over = with_marks.unwrap_or_else(|| self.largest_met_step_over(0.0));
            return NoAnswer::PassesDoNotOverlap { largest_step_over: Length::computed(largest_step_over) };
        }
        let largest = self.pattern.feed_per_tooth(self.largest_spacing(s));
        let met = if self.pass.surface.is_plane() { largest } else { largest_met(largest, |feed| self.height(s, feed).is_some()) };
        NoAnswer::MarksDoNotOverlap { largest_mark_spacing: Length::computed(met) }
    }

    /// The largest step-over at which passes with a feed per tooth meet; on a curved surface one that is smaller by at most
    /// [`MET`].
    fn largest_met_step_over(&self, feed: f64) -> f64 {
        let overlapping = self.largest_step_over(self.pattern.spacing(feed));
        if self.pass.surface.is_plane() {
            overlapping
        } else {
            // An answer has both heights.
            largest_met(overlapping, |s| [feed, 0.0].into_iter().all(|feed| self.height(s, feed).is_some()))
        }
    }

    /// The step-over up to which passes with marks f apart overlap, seen from above, and grooves meet on a curved
    /// surface. It is reduced by a rounding error, so that it is itself in the domain, and is at most the largest
    /// accepted length.
    fn largest_step_over(&self, f: f64) -> f64 {
        let on_plane = largest_leg(2.0 * self.outer_radius, f * self.climb.cos(), self.spacing_ratio());
        on_plane.min(2.0 / self.pass.surface.across_per_mm().abs())
    }

    /// The distance up to which marks overlap, seen from above, in passes s apart.
    fn largest_spacing(&self, s: f64) -> f64 {
        largest_leg(2.0 * self.outer_radius, s * self.spacing_ratio(), self.climb.cos())
    }
}

/// The largest length, at most `length`, that has a height, to [`MET`]: 0 if none has down to the smallest.
fn largest_met(length: f64, has_height: impl Fn(f64) -> bool) -> f64 {
    if has_height(length) {
        return length;
    }
    let mut high = length;
    let mut low = loop {
        let low = high / 2.0;
        if low < Length::SMALLEST {
            return 0.0;
        }
        if has_height(low) {
            break low;
        }
        high = low;
    };
    while high - low > MET * high {
        let middle = f64::midpoint(low, high);
        if has_height(middle) { low = middle } else { high = middle }
    }
    low
}

/// The length x for which `ratio` x and `leg` are the legs of a right triangle with the hypotenuse `hypotenuse`. It is
/// reduced by a rounding error, and at most the largest accepted length.
fn largest_leg(hypotenuse: f64, leg: f64, ratio: f64) -> f64 {
    let room = ((hypotenuse - leg) * (hypotenuse + leg)).max(0.0).sqrt();
    (room / ratio * (1.0 - 4.0 * f64::EPSILON)).min(Length::LARGEST)
}
