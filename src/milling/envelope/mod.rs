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
//! - `cutter_body`: the cutter, placed at a mark by the surface's own normal there, and its distance from a point;
//! - `marks`: which pairs of marks decide, with and without runout;
//! - `ridge`: the fast search, Newton's method on all unknowns at once;
//! - `search`: the sure search, nested and bracketed, wherever the fast one does not prove its result;
//! - `overlap`: up to where passes and marks meet, and the refusals that say so;
//! - `inverses`: the largest feed and the largest step-over;
//! - `mod` (this file): heights.

mod cutter_body;
mod inverses;
mod marks;
mod ridge;
mod search;
#[cfg(test)]
mod tests;

use super::{Contact, Cutter, NoAnswer, Pass, Runout, ScallopHeight, gouging};
use crate::numerics::bracketed_root;
use crate::quantity::{Direction, Length};
use cutter_body::CutterBody;
use marks::{MarkPattern, Which};
use search::{Lengths, MarkPlaces, Outcome, Search, Sought};
use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;

/// The share of lengths that is left of those at which passes or marks only just overlap.
const JUST_UNDER: f64 = 1.0 - 1e-9;

/// By what share a pass between those of a ridge may leave more, and where such passes are tried, as shares of the step-over.
const MORE: f64 = 1e-9;
const BETWEEN: [f64; 4] = [0.12, 0.35, 0.65, 0.88];

/// The number of steps in which the passes beside a place are tried.
const MARCH: u8 = 24;

/// The highest ridge, as a share of the lengths that bound it; on planes it is at most 0.45 of them.
const HIGHEST: f64 = 2.0;

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
/// **Curved surfaces.** Heights are measured from the surface 1/2 u'Ku below the tangent plane. h is the greater of two: that
/// to second order, where all marks have the stated normal, and that where each mark has the surface's normal at its own
/// contact. The second one can be the greater by a few percent under 10 deg. It can also be far less, on nearly level
/// surfaces with a concave direction: where the normal turns by a part of the slope, the cutter would cut into the surface,
/// and no mark lies there.
///
/// **Runout.** Heights are measured from the surface that the deepest tooth touches, whose radius is R + |rr|. The
/// shallowest tooth reaches delta = |rr| sin(S) + |ar| cos(S) less deep, and its mark is displaced along the slope, by up to
/// |rr| cos(S) downwards and |ar| sin(S) upwards. A pass leaves the lower of what a deep and a shallow mark leave in the worse
/// order, one feed per tooth and the displacement along the feed apart, and what deep marks alone, z f_z apart, leave.
#[derive(Debug, Clone, Copy)]
pub struct Envelope {
    pass: Pass,
    outer_radius: f64,
    /// With the stated normal at all marks.
    body: CutterBody,
    /// With the normals of a curved surface.
    turned: Option<CutterBody>,
    pattern: MarkPattern,
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
    /// The turn of the normal at the ridge's marks.
    turn: f64,
}

impl Envelope {
    /// Prepares the cutter in contact with the surface.
    ///
    /// # Errors
    /// [`NoAnswer::Gouges`] on a concave surface into which the cutter does not fit.
    pub fn new(pass: Pass) -> Result<Self, NoAnswer> {
        Self::fitting(pass).ok_or_else(|| gouging::reason(&pass))
    }

    /// Prepares the cutter in contact with the surface, or `None` if it does not fit.
    pub(in crate::milling) fn fitting(pass: Pass) -> Option<Self> {
        let relative_curvature = gouging::relative_curvature(&pass)?;
        let cutter: Cutter = pass.cutter.widened(pass.runout.radial());
        let turned = CutterBody::new(&cutter.profile(), pass.contact, pass.surface);
        let body = turned.without_turns();
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
            turned: turned.turns().then_some(turned),
            pattern: MarkPattern::new(&pass),
            climb: pass.contact.climb(),
            relative_curvature,
            curvature: [along, across, twist],
        })
    }

    /// The model to second order: all marks have the stated normal. An independent calculation needs no more of the surface.
    #[must_use]
    pub fn without_turns(self) -> Self {
        Self { turned: None, ..self }
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
        let feed = feed_per_tooth.map_or(0.0, Length::mm);
        let alone = self.height(step_over.mm(), 0.0).ok_or_else(|| self.no_height(step_over.mm(), feed))?;
        if feed_per_tooth.is_none() {
            let level = Length::computed(alone.level);
            return Ok(ScallopHeight::of_total(level, level).with_turn(alone.turn));
        }
        self.height_above(Length::computed(alone.level), step_over, feed_per_tooth)
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
        let total = self.ridge(step_over, feed_per_tooth)?;
        Ok(ScallopHeight::of_total(step_over_height, Length::computed(total.level)).with_turn(total.turn))
    }

    fn ridge(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Height, NoAnswer> {
        let (s, feed) = (step_over.mm(), feed_per_tooth.map_or(0.0, Length::mm));
        self.height(s, feed).ok_or_else(|| self.no_height(s, feed))
    }

    /// h for passes s apart with a feed per tooth; `None` if there is none, for the reason in [`Envelope::no_height`].
    fn height(&self, s: f64, feed: f64) -> Option<Height> {
        if !(s <= self.largest_step_over(0.0) && self.overlap(s, self.pattern.spacing(feed))) {
            return None;
        }
        if let Some(level) = self.height_of_ball(s, feed) {
            return Some(Height { level, turn: 0.0 });
        }
        let height = self.height_of(&self.body, s, feed)?;
        let turned = self.turned.as_ref().map_or(Some(height), |turned| self.height_of(turned, s, feed))?;
        Some(if turned.level > height.level { turned } else { height })
    }

    /// R - sqrt(R^2 - (s^2 + f_z^2)/4), the height that a ball leaves on a plane where its side does not cut: the marks touch the
    /// ridge with normals that are asin(sqrt(s^2 + f_z^2)/(2R)) from that of the plane.
    fn height_of_ball(&self, s: f64, feed: f64) -> Option<f64> {
        let is_plain = self.pass.surface.is_plane() && self.pass.runout == Runout::NONE;
        let share = s.hypot(feed) / (2.0 * self.outer_radius);
        let is_round = is_plain && self.body.is_ball() && self.contact().slope().radians() + share.min(1.0).asin() < FRAC_PI_2;
        // Without cancellation: 1 - sqrt(1 - q^2) = q^2 / (1 + sqrt(1 - q^2)).
        is_round.then(|| self.outer_radius * share * share / (1.0 + ((1.0 - share) * (1.0 + share)).sqrt()))
    }

    fn height_of(&self, body: &CutterBody, s: f64, feed: f64) -> Option<Height> {
        let guess = Lengths { level: self.guess(s, feed), step_over: s, feed };
        // No ridge is higher than the cutter is wide and its marks are apart, and the surface falls by no more over these lengths.
        let highest = HIGHEST * (self.outer_radius + s + self.pattern.spacing(feed));
        let found = |level: f64, places: &MarkPlaces| {
            let lengths = Lengths { level, ..guess };
            if level > 0.0 && !self.clears_across(body, &lengths, places) {
                return self.first_ridge(body, lengths, highest);
            }
            Some(Height { level, turn: self.turn(places, s, feed) })
        };
        if let Some(ridge) = self.quickly(body, Sought::Level, guess)
            && ridge.lengths.level <= highest
            && self.clears_between(body, &ridge)
        {
            return found(ridge.lengths.level, &ridge.places);
        }
        let search = |guess: Lengths| {
            let mut places = self.places(&guess);
            match self.search(body).solve(Sought::Level, guess, body.rounding(), highest, &mut places) {
                Outcome::At(level) => found(level, &places),
                Outcome::Below => found(0.0, &places),
                Outcome::Above => None,
            }
        };
        let only_just_touch = || !self.overlap(s / JUST_UNDER, self.pattern.spacing(feed) / JUST_UNDER);
        // Where the circles seen from above only just touch, rounding decides whether they do.
        search(guess)
            .or_else(|| only_just_touch().then(|| search(Lengths { step_over: s * JUST_UNDER, feed: feed * JUST_UNDER, ..guess }))?)
    }

    /// Whether passes that lie between those of a ridge clear the place too. On a convex surface they do. Where the surface is
    /// concave, passes can clear a place from afar that others between them do not. Marks with normals of their own are not held
    /// to this: near level ones none may lie between.
    fn clears_across(&self, body: &CutterBody, lengths: &Lengths, places: &MarkPlaces) -> bool {
        if body.turns() || self.pass.surface.principal_per_mm()[1] >= 0.0 {
            return true;
        }
        let Lengths { level, step_over, feed } = *lengths;
        let marks = self.pattern.marks(feed);
        let level = level * (1.0 + MORE) + body.rounding();
        let distance = marks.pairs()[0].distance;
        BETWEEN.iter().all(|share| {
            let c = places.c - share * step_over;
            let mut x = [0, 1, 2].map(|pair| places.x[0][pair] + share * (places.x[1][pair] - places.x[0][pair]));
            // The marks half-way between those of the ridge clear it, or others do.
            let is_cleared = |x: f64| body.gap(x, c, level).value <= 0.0;
            is_cleared(x[0]) && is_cleared(x[0] + distance)
                || self.search(body).pass_gap(&marks, step_over + distance, &mut x, c, level) <= 0.0
        })
    }

    /// The height up to which all passes from one offset to that of the next pass clear the place.
    fn first_ridge(&self, body: &CutterBody, lengths: Lengths, highest: f64) -> Option<Height> {
        let Lengths { level: least, step_over, feed } = lengths;
        let (marks, search) = (self.pattern.marks(feed), self.search(body));
        let stride = (step_over + marks.pairs()[0].distance) / 4.0;
        let centred = || {
            let mut places = self.places(&Lengths { step_over: 0.0, ..lengths });
            places.c = 0.0;
            places
        };
        // The first offset on one side of the pass that clears the most at which a pass does not clear the place down to p.
        let end = |middle: &MarkPlaces, sign: f64, p: f64| {
            let (mut x, mut cleared) = (middle.x[0], 0.0);
            let gap_at = |aside: f64, x: &mut [f64; 3]| search.pass_gap(&marks, stride, x, middle.c + sign * aside, p);
            for step in 0..=MARCH {
                let aside = step_over * f64::from(step) / f64::from(MARCH);
                let mut next = x;
                if gap_at(aside, &mut next) > 0.0 {
                    if step > 0 {
                        let Ok(root) = bracketed_root(cleared, aside, |aside| Ok::<_, Infallible>(gap_at(aside, &mut x)));
                        cleared = root;
                    }
                    break;
                }
                (x, cleared) = (next, aside);
            }
            (cleared, x)
        };
        let ends = |p: f64| {
            let mut middle = centred();
            search.centre(&Lengths { level: p, ..lengths }, &mut middle);
            (middle.c, end(&middle, 1.0, p), end(&middle, -1.0, p))
        };
        let spare = |p: f64| {
            let (_, near, far) = ends(p);
            near.0 + far.0 - step_over
        };
        let (mut low, mut high) = (least, least);
        while spare(high) < 0.0 {
            if high > highest {
                return None;
            }
            (low, high) = (high, 2.0 * high);
        }
        let level = if high > least {
            let Ok(level) = bracketed_root(low, high, |p| Ok::<_, Infallible>(spare(p)));
            level
        } else {
            least
        };
        let (middle, near, far) = ends(level);
        let places = MarkPlaces { x: [near.1, far.1], c: middle + near.0 };
        Some(Height { level, turn: self.turn(&places, step_over, feed) })
    }

    /// How much the surface's normal turns from the stated contact to a ridge's marks; see [`ScallopHeight::largest_turn`].
    fn turn(&self, places: &MarkPlaces, s: f64, feed: f64) -> f64 {
        let Some(turned) = &self.turned else { return 0.0 };
        let marks = self.pattern.marks(feed);
        let turn = |pass: usize, c: f64| {
            let ends = marks.pairs().iter().zip(places.x[pass]).flat_map(|(pair, x)| [x, x + pair.distance]);
            ends.map(move |x| turned.turn(x, c)).fold(0.0, f64::max)
        };
        turn(0, places.c).max(turn(1, places.c - s))
    }

    /// Whether marks half-way between those of the ridge clear the place too. Where the surface is concave, both can lie on either
    /// side of a part of the surface that keeps those between away.
    fn clears_between(&self, body: &CutterBody, ridge: &ridge::Ridge) -> bool {
        let Lengths { level, step_over, feed } = ridge.lengths;
        let marks = self.pattern.marks(feed);
        let clears = |pass: usize, c: f64| {
            marks.of(ridge.choice[pass]).all(|index| {
                let (pair, x) = (&marks.pairs()[index], ridge.places.x[pass][index]);
                body.gap(x + pair.distance / 2.0, c, level - pair.half_way_drop()).value <= 0.0
            })
        };
        let c = ridge.places.c;
        self.pass.surface.is_plane() || feed == 0.0 || clears(0, c) && clears(1, c - step_over)
    }

    /// The bodies of which the one that leaves more decides.
    fn bodies(&self) -> impl Iterator<Item = &CutterBody> {
        self.turned.iter().chain([&self.body])
    }

    fn search<'a>(&'a self, body: &'a CutterBody) -> Search<'a> {
        Search { body, pattern: &self.pattern, is_convex: self.pass.surface.is_plane(), is_thorough: false }
    }

    /// The ridge by the fast search. With runout each pass clears its place by the deepest marks or by the others: the search begins
    /// with those that decide by an approximation, and goes on to a choice that leaves less until there is none.
    fn quickly(&self, body: &CutterBody, sought: Sought, guess: Lengths) -> Option<ridge::Ridge> {
        let stride = guess.step_over + self.pattern.spacing(guess.feed);
        let start = self.places(&guess);
        let first = [self.pattern.likely(guess.feed, self.groove()[0]); 2];
        let mut choice = first;
        for _ in self.pattern.choices(true) {
            let Some(mut ridge) = ridge::solve(body, &self.pattern, choice, stride, sought, guess, start) else {
                if choice != first {
                    return None;
                }
                choice = first.map(Which::others);
                continue;
            };
            if self.pattern.marks(ridge.lengths.feed).pairs().len() == 1 {
                return Some(ridge);
            }
            let search = self.search(body);
            let next = search.better_choice(choice, &ridge.lengths, &mut ridge.places);
            if next == choice {
                return search.meet(choice, &ridge.lengths, &ridge.places).then_some(ridge);
            }
            choice = next;
        }
        None
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
    fn places(&self, lengths: &Lengths) -> MarkPlaces {
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
        MarkPlaces { x, c: half }
    }
}
