//! The third order of a curved surface: the ridge between tooth marks whose contacts each have a normal of their own.
//!
//! To second order all marks are the same body moved along the surface. But the surface's normal turns from contact to
//! contact by K u, and the tool axis does not turn with it: slope and steepest line of a mark are not those of the
//! stated contact, and near the floor a small turn of the normal is a large turn of the steepest line, and with it of
//! the cutter's two unequal radii. Here every mark is placed by the normal of its own contact on the quadric
//! w = -1/2 u'Ku, with the stated contact half-way between the passes and the ridge abreast of it.
//!
//! The ridge is where four marks have the same height over one place of the surface, two neighbours of each pass.
//! Newton's method finds it from the ridge of the second order. Without curvature both are the same.

use super::body::Body;
use super::newton::{Lengths, Sought};
use crate::numerics::{Dual, bracketed_root};
use std::convert::Infallible;

/// The largest turn of a normal, as a share of the sine and cosine of the slope. Turns up to half of it are exact;
/// larger ones are bounded smoothly, so that no mark reaches the floor or the wall, where the cutter's place jumps.
const LARGEST_TURN: f64 = 0.7;

/// Without marks, the ridge is computed from marks that are this share of the step-over apart. The relative error of h
/// is the square of the share.
const NO_MARKS: f64 = 1e-6;

/// Slopes along the feed up to this, a few rounding errors, count as zero.
const STRAIGHT: f64 = 1e-14;

/// The share of a length by which the last step may change it. Newton's method squares that error, to 1e-14.
const NEARLY: f64 = 1e-7;

/// Newton's method takes three to five steps from the ridge of the second order.
const MOST_STEPS: usize = 30;

/// The unknowns of a mark's distance: where the mark's contact lies behind the ridge, how far the ridge is beside the
/// stated contact, its height, and the step-over.
type Number = Dual<4>;
const BEHIND: usize = 0;
const ASIDE: usize = 1;
const HEIGHT: usize = 2;
const STEP_OVER: usize = 3;

/// A vector in the tangent plane of the stated contact, along the feed and to its side, and along the normal.
type Plane = [Number; 2];

fn dot(a: Plane, b: Plane) -> Number {
    a[0] * b[0] + a[1] * b[1]
}

/// The cutter's marks on the quadric.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurningMarks {
    core: f64,
    corner: f64,
    /// The tool axis along the feed, to the side, and along the normal of the stated contact.
    axis: [f64; 3],
    /// k_F, k_T, k_FT.
    curvature: [f64; 3],
    /// The bound of the turns.
    largest_turn: f64,
}

/// The state of the search: for each pass the place of the front mark's contact behind the ridge, the ridge's place
/// beside the stated contact, and the lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnedRidge {
    pub(super) behind: [f64; 2],
    pub(super) aside: f64,
    pub(super) lengths: Lengths,
}

/// Where the ridge's place and the contacts of the pass on `side` (-1 or 1) are beside the stated contact, for a ridge
/// that is `aside` of the middle of both passes.
///
/// The stated contact is in that middle. If the step-over is short compared with the feed, oblique marks can put the
/// ridge beyond the passes. The stated contact then moves with the ridge: their distance is y / (1 + (2y/s)^8)^(1/8),
/// never more than that of a pass from the middle.
fn placed(aside: Number, step_over: Number, side: f64) -> [Number; 2] {
    let half = step_over * 0.5;
    let share = (aside * half.recip()).square();
    let place = if share.value < 1e-4 { aside } else { aside * (share.square().square() + 1.0).sqrt().sqrt().sqrt().recip() };
    [place, half * side + place - aside]
}

/// A place over the surface, abreast of the stated contact.
#[derive(Debug, Clone, Copy)]
struct RidgePlace {
    aside: Number,
    /// The turn of the surface's normal there.
    turn: Plane,
    /// Its height by the length of the normal that has the turn as its part in the tangent plane.
    lift: Number,
}

/// What a pass leaves at the ridge's place: the distance of the place from its two marks' bodies, which vanishes on the
/// ridge, with the derivatives by the ridge's place and by the length that is sought, and how the marks have to move
/// for both to be equally far away.
#[derive(Debug, Clone, Copy)]
struct Row {
    value: f64,
    aside: f64,
    sought: f64,
    moves: [f64; 3],
    /// By how much the front mark is further away than the back one.
    difference: f64,
    is_ridge: bool,
}

impl TurnedRidge {
    /// Moves the ridge aside while the sought length grows, and the marks with it.
    fn follow(&mut self, rows: [Row; 2], aside: f64, growth: f64, reach: f64) {
        self.aside += aside;
        for (behind, row) in self.behind.iter_mut().zip(rows) {
            *behind += (row.moves[0] + row.moves[1] * aside + row.moves[2] * growth).clamp(-reach, reach);
        }
    }
}

impl TurningMarks {
    pub(super) fn new(body: &Body) -> Self {
        let (slope, surface) = (body.slope(), body.surface());
        Self {
            core: body.core(),
            corner: body.corner(),
            axis: [-slope.sin() * body.along_steepest(), slope.sin() * body.along_level(), slope.cos()],
            curvature: [surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()],
            largest_turn: LARGEST_TURN * slope.sin().min(slope.cos()),
        }
    }

    /// K u.
    fn fall(&self, u: Plane) -> Plane {
        let [f, t, ft] = self.curvature;
        [u[0] * f + u[1] * ft, u[0] * ft + u[1] * t]
    }

    /// K u, the tangent of the angle by which the normal turns from the stated contact to the place u, bounded:
    /// w / (1 + (|w|/b)^8)^(1/8).
    fn turn(&self, u: Plane) -> Plane {
        let turn = self.fall(u);
        let share = dot(turn, turn) * (self.largest_turn * self.largest_turn).recip();
        // Under a hundredth of the bound the factor is 1 to a rounding.
        if share.value < 1e-4 {
            return turn;
        }
        // On floor and wall no turn is allowed.
        if share.value.is_nan() || share.value > 1e64 {
            return [Number::constant(0.0); 2];
        }
        let factor = (share.square().square() + 1.0).sqrt().sqrt().sqrt().recip();
        turn.map(|component| component * factor)
    }

    /// The place at (0, `aside`), `height` along the normal there over the surface.
    fn ridge_place(&self, aside: Number, height: Number) -> RidgePlace {
        let turn = self.turn([Number::constant(0.0), aside]);
        RidgePlace { aside, turn, lift: height * (dot(turn, turn) + 1.0).sqrt().recip() }
    }

    /// The signed distance of a place over the surface from the body of a mark, negative inside. The place is at
    /// (0, `aside`) and `height` along the normal there; the mark's contact is at (-`behind`, `pass`).
    ///
    /// With w and w' the turns at the contact and at the place, L = sqrt(1 + w^2) and L' likewise, d from contact to
    /// place, the frame of the contact is that of the stated contact turned about the line across w. A vector with the
    /// components (v, v_n) has in it the components v - w (v_n + v.w/(1 + L))/L and (v_n + v.w)/L. The place on the
    /// surface is d'w + 1/2 d'Kd under the contact, so that nothing cancels: along the contact's normal -1/2 d'Kd/L
    /// remains.
    #[inline]
    fn distance(&self, behind: Number, ridge: &RidgePlace, pass: Number) -> Number {
        let (a, r) = (self.core, self.corner);
        let RidgePlace { aside, turn: turn_at_place, lift } = *ridge;
        let along = [behind, aside - pass];
        let turn = self.turn([-behind, pass]);
        let length = (dot(turn, turn) + 1.0).sqrt();
        let (per_length, per_half) = (length.recip(), (length + 1.0).recip());
        let sag = dot(along, self.fall(along)) * 0.5;

        // The normal at the place, in the contact's frame.
        let cross = dot(turn, turn_at_place);
        let lean = (cross * per_half + 1.0) * per_length;
        let raised = (cross + 1.0) * per_length * lift;
        // The place, in the contact's frame: along the normal, and in the tangent plane.
        let up = raised - sag * per_length;
        let stretch = (dot(along, turn) * length * per_half + sag) * per_length;
        let place: Plane = std::array::from_fn(|i| along[i] + turn[i] * stretch + (turn_at_place[i] - turn[i] * lean) * lift);
        // The tool axis, in the contact's frame.
        let [axis_x, axis_y, axis_n] = self.axis;
        let rise = turn[0] * axis_x + turn[1] * axis_y;
        let tilt = (rise * per_half + axis_n) * per_length;
        let level_axis = [-(turn[0] * tilt) + axis_x, -(turn[1] * tilt) + axis_y];
        let (cos, sin) = ((rise + axis_n) * per_length, dot(level_axis, level_axis).sqrt());
        let per_sin = sin.recip();

        // From here on as in the second order: offsets from the contact along D, along the level line, and along Z.
        let steep = -(dot(place, level_axis) * per_sin);
        let level = (place[0] * level_axis[1] - place[1] * level_axis[0]) * per_sin;
        let (d, e) = (up * sin + steep * cos, up * cos - steep * sin);
        let b = sin * r - d + a;
        let radius = (b.square() + level.square()).sqrt();
        let excess = if b.value > 0.0 { level.square() * (radius + b).recip() } else { radius - b };
        let grown = excess - d;
        let (outside, below) = (sin * r + grown, cos * r - e);
        if outside.value > 0.0 && below.value > 0.0 {
            let to_core = (outside.square() + below.square()).sqrt();
            ((sin * excess - up) * (2.0 * r) + grown.square() + e.square()) * (to_core + r).recip()
        } else if outside.value > below.value {
            grown - (-sin + 1.0) * r
        } else {
            -e - (-cos + 1.0) * r
        }
    }

    /// The two marks of the pass on `side` (-1 or 1) at the ridge.
    fn row(&self, ridge: &TurnedRidge, pass: usize, side: f64, sought: Sought) -> Option<Row> {
        let Lengths { level, step_over, mark_spacing } = ridge.lengths;
        let spacing = mark_spacing.max(NO_MARKS * step_over);
        let aside = Number::unknown(ridge.aside, ASIDE);
        let height = Number::unknown(level, HEIGHT);
        let [place, offset] = placed(aside, Number::unknown(step_over, STEP_OVER), side);
        let place = self.ridge_place(place, height);
        let at = |behind: f64| self.distance(Number::unknown(behind, BEHIND), &place, offset);
        let (front, back) = (at(ridge.behind[pass]), at(ridge.behind[pass] - spacing));
        let mean = (front + back) * 0.5;
        let slope = (front - back) * spacing.recip();
        // The second derivative along the feed. It vanishes if both marks are on the cutter's flat or side and the
        // surface is straight along the feed; the marks may then lie anywhere.
        let bend = slope.by[BEHIND];
        let is_straight = bend.abs() * spacing <= STRAIGHT && slope.value.abs() <= STRAIGHT;
        if bend.is_nan() || bend <= 0.0 && !is_straight {
            return None;
        }
        let (mean_by_sought, slope_by_sought) = match sought {
            Sought::Level => (mean.by[HEIGHT], slope.by[HEIGHT]),
            Sought::StepOver => (mean.by[STEP_OVER], slope.by[STEP_OVER]),
            // The back mark moves against the front one.
            Sought::MarkSpacing => (-0.5 * back.by[BEHIND], (back.by[BEHIND] - slope.value) / spacing),
        };
        let moves = [slope.value, slope.by[ASIDE], slope_by_sought].map(|by| if is_straight { 0.0 } else { -by / bend });
        let along = mean.by[BEHIND];
        Some(Row {
            value: mean.value + along * moves[0],
            aside: mean.by[ASIDE] + along * moves[1],
            sought: mean_by_sought + along * moves[2],
            moves,
            difference: front.value - back.value,
            // The distance falls from the back mark to the front one and rises beyond.
            is_ridge: mean.by[HEIGHT] < 0.0 && (is_straight || mark_spacing < spacing || front.by[BEHIND] >= 0.0 && back.by[BEHIND] <= 0.0),
        })
    }

    /// The ridge from one near it, of whose lengths the sought one is a guess; `None` where the search does not end at
    /// a ridge.
    ///
    /// Newton's method moves the marks along with the ridge. That fails if a mark's flat or side has almost no
    /// curvature along the feed; a careful search brings each pass's marks to the same height before each step.
    pub(super) fn solve(&self, sought: Sought, start: TurnedRidge, is_careful: bool) -> Option<TurnedRidge> {
        let mut ridge = start;
        let reach = start.lengths.step_over + start.lengths.mark_spacing + start.behind[0].abs();
        for _ in 0..MOST_STEPS {
            if is_careful {
                ridge.behind = [self.level_marks(&ridge, 0, -1.0)?, self.level_marks(&ridge, 1, 1.0)?];
            }
            let [near, far] = [self.row(&ridge, 0, -1.0, sought)?, self.row(&ridge, 1, 1.0, sought)?];
            if !(near.aside > 0.0 && far.aside < 0.0) {
                // The ridge lies beside the deepest place of each pass; the change of slope between the passes shows
                // roughly where that is.
                let change = -ridge.lengths.step_over * f64::midpoint(near.aside, far.aside) / (near.aside - far.aside);
                if !(near.aside > far.aside && change.is_finite()) {
                    return None;
                }
                ridge.follow([near, far], change.clamp(-reach, reach), 0.0, reach);
                continue;
            }
            let det = near.aside * far.sought - far.aside * near.sought;
            let change = (near.sought * far.value - far.sought * near.value) / det;
            let growth = (far.aside * near.value - near.aside * far.value) / det;
            if !(growth.is_finite() && change.is_finite()) {
                return None;
            }
            let length = match sought {
                Sought::Level => &mut ridge.lengths.level,
                Sought::StepOver => &mut ridge.lengths.step_over,
                Sought::MarkSpacing => &mut ridge.lengths.mark_spacing,
            };
            let level = start.lengths.level;
            let is_level = [near, far].iter().all(|row| row.value.abs() <= NEARLY * level && row.difference.abs() <= NEARLY * level);
            let is_exact = is_level && growth.abs() <= NEARLY * *length;
            let growth = growth.clamp(-0.5 * *length, *length);
            *length += growth;
            ridge.follow([near, far], change.clamp(-reach, reach), growth, reach);
            if is_exact {
                return (near.is_ridge && far.is_ridge).then_some(ridge);
            }
        }
        None
    }

    /// Where the front mark of a pass is if both of its marks have the same distance at the ridge's place.
    fn level_marks(&self, ridge: &TurnedRidge, pass: usize, side: f64) -> Option<f64> {
        let Lengths { level, step_over, mark_spacing } = ridge.lengths;
        let spacing = mark_spacing.max(NO_MARKS * step_over);
        let height = Number::constant(level);
        let [place, offset] = placed(Number::constant(ridge.aside), Number::constant(step_over), side);
        let place = self.ridge_place(place, height);
        let at = |behind: f64| self.distance(Number::constant(behind), &place, offset).value;
        let difference = |behind: f64| at(behind) - at(behind - spacing);
        let start = ridge.behind[pass];
        if difference(start).abs() <= STRAIGHT * spacing {
            return Some(start);
        }
        let side = if difference(start) < 0.0 { 1.0 } else { -1.0 };
        let mut step = 0.1 * (step_over + spacing);
        let mut other = start + side * step;
        while side * difference(other) < 0.0 {
            step *= 2.0;
            if step > 4.0 * (self.core + self.corner) {
                return None;
            }
            other += side * step;
        }
        let Ok(behind) = bracketed_root(start.min(other), start.max(other), |behind| Ok::<_, Infallible>(difference(behind)));
        Some(behind)
    }

    /// The largest turn at the ridge's contacts as a share of the smaller of the slope's sine and cosine.
    pub(super) fn share(&self, ridge: &TurnedRidge) -> f64 {
        let Lengths { step_over, mark_spacing, .. } = ridge.lengths;
        let mut largest = 0.0_f64;
        for (behind, side) in ridge.behind.into_iter().zip([-1.0, 1.0]) {
            for behind in [behind, behind - mark_spacing] {
                let turn = self.fall([Number::constant(-behind), Number::constant(side * step_over / 2.0)]);
                largest = largest.max(dot(turn, turn).value.sqrt());
            }
        }
        largest * LARGEST_TURN / self.largest_turn
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::envelope::Envelope;
    use crate::milling::{Contact, Cutter, Pass, Runout, SurfaceCurvature};
    use crate::quantity::{Angle, Length};
    use nalgebra::Vector3;
    use proptest::prelude::*;

    fn envelope(ratio: f64, slope: f64, alpha: f64, principal: [f64; 2], turn: f64) -> Option<Envelope> {
        let mm = |value: f64| Length::from_mm(value).unwrap();
        let cutter = Cutter::toroidal(mm(10.0), mm(5.0 * ratio)).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(principal, Angle::from_degrees(turn).unwrap()).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        Envelope::new(Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }).ok()
    }

    /// The distance of the same place from a torus that is placed by vectors.
    fn placed_distance(marks: &TurningMarks, behind: f64, aside: f64, height: f64, pass: f64) -> f64 {
        let [f, t, ft] = marks.curvature;
        let surface = |x: f64, y: f64| Vector3::new(x, y, -(f * x * x + 2.0 * ft * x * y + t * y * y) / 2.0);
        let normal = |x: f64, y: f64| Vector3::new(f * x + ft * y, ft * x + t * y, 1.0).normalize();
        let axis = Vector3::from(marks.axis);
        let at_contact = normal(-behind, pass);
        let outwards = at_contact - axis * axis.dot(&at_contact);
        let centre = surface(-behind, pass) + at_contact * marks.corner + outwards.normalize() * marks.core;
        let from = surface(0.0, aside) + normal(0.0, aside) * height - centre;
        let up = from.dot(&axis);
        let beyond = (from - axis * up).norm() - marks.core;
        let core = if up < 0.0 && beyond > 0.0 { up.hypot(beyond) } else { beyond.max(-up) };
        core - marks.corner
    }

    proptest! {
        #[test]
        fn distances_are_those_from_a_placed_torus(
            ratio in 0.1..0.9_f64, slope in 10.0..80.0_f64, alpha in 0.0..360.0_f64, (one, other) in (-0.01..0.01_f64, -0.01..0.01_f64),
            turn in 0.0..180.0_f64, (behind, aside, height, pass) in (-1.0..1.0_f64, -0.5..0.5_f64, 0.0..0.05_f64, -0.5..0.5_f64),
        ) {
            let Some(envelope) = envelope(ratio, slope, alpha, [one, other], turn) else { return Ok(()) };
            // Turns are at most 0.015; with a bound of 2 they are exact.
            let marks = TurningMarks { largest_turn: 2.0, ..TurningMarks::new(&envelope.body) };
            let [behind, aside, height, pass] = [behind, aside, height, pass].map(Number::constant);
            let found = marks.distance(behind, &marks.ridge_place(aside, height), pass).value;
            let expected = placed_distance(&marks, behind.value, aside.value, height.value, pass.value);
            // Roundings of places some 10 mm from the axis.
            prop_assert!((found - expected).abs() <= 1e-13, "{found} {expected}");
        }

        /// Without turns the ridge is that of the second order.
        #[test]
        fn without_turns_the_ridge_is_that_of_the_second_order(
            ratio in 0.1..0.9_f64, slope in 10.0..80.0_f64, alpha in 0.0..360.0_f64, (one, other) in (0.0..0.01_f64, 0.0..0.01_f64),
            turn in 0.0..180.0_f64, s in 0.1..0.5_f64, f in 0.05..0.3_f64,
        ) {
            let envelope = envelope(ratio, slope, alpha, [one, other], turn).unwrap();
            let level = envelope.height(s, super::super::section::Pattern::even(f)).unwrap();
            let marks = TurningMarks { largest_turn: 0.0, ..TurningMarks::new(&envelope.body) };
            let start = envelope.ridge_of_paraboloid(Lengths { level, step_over: s, mark_spacing: f });
            let ridge = marks.solve(Sought::Level, start, false).unwrap();
            approx::assert_relative_eq!(ridge.lengths.level, level, max_relative = 1e-10);
        }
    }
}
