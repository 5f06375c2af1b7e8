//! The ridge between tooth marks that each have a normal of their own.
//!
//! The ridge is where four marks have the same height over one place of the surface, two neighbours of each pass.
//! Newton's method finds it from the ridge of the second order; without curvature both are the same. Where Newton's
//! method does not end at a ridge, nested searches in one unknown find it: the marks of a pass that are equally far
//! away, the height at which they touch the place, and the offset at which both passes leave the same height.

use super::newton::{Lengths, Ridge, Sought};
use super::smooth_bound::SmoothBound;
use super::turned_pair::{Accuracy, NEAR, NEARLY, Pair, Shift, Spacing};
use super::turning_marks::TurningMarks;
use crate::numerics::bracketed_root;

/// Without marks, the ridge is computed from marks that are this share of the step-over apart. The relative error of h
/// is the square of the share.
const NO_MARKS: f64 = 1e-6;

/// Newton's method takes three to five steps from the ridge of the second order.
const MOST_STEPS: usize = 20;

/// Heights that differ by a smaller share are those of one ridge.
const SAME: f64 = 1e-6;

/// The number of offsets of nested searches from which Newton's method is tried.
const MOST_SHORTCUTS: usize = 4;

/// If the marks are further apart than this many step-overs, the stated contact moves with the ridge.
const FEW_STEP_OVERS: f64 = 3.0;

/// The ridge: how far behind it the contact of each pass's front mark is, how far the ridge is from the middle of both
/// passes, and the lengths.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurnedRidge {
    pub(super) behind: [f64; 2],
    pub(super) aside: f64,
    pub(super) lengths: Lengths,
    /// Whether all four marks touched with the corner's round at every step of the search. Over the flat the distance can
    /// have several minima along the feed where marks turn.
    pub(super) is_round: bool,
}

impl TurnedRidge {
    /// The ridge of marks that all have the normal of the stated contact.
    pub(super) fn of_second_order(Ridge { lengths, place, .. }: &Ridge) -> Self {
        Self { behind: [place.x[0], place.neighbour_x[0]], aside: place.t - lengths.step_over / 2.0, lengths: *lengths, is_round: false }
    }

    /// The offset of the ridge from the near pass, to its side.
    fn offset(&self) -> f64 {
        self.aside + 0.5 * self.lengths.step_over
    }
}

/// Where the ridge is beside the stated contact, with its derivatives by the distance of the ridge from the middle of
/// both passes, by the step-over, and by the distance of the marks.
#[derive(Debug, Clone, Copy)]
struct Stated {
    place: f64,
    by_aside: f64,
    by_step_over: f64,
    by_spacing: f64,
}

/// The search for the ridge at one contact.
#[derive(Debug)]
pub(super) struct RidgeSearch<'a> {
    marks: &'a TurningMarks,
}

impl<'a> RidgeSearch<'a> {
    pub(super) fn new(marks: &'a TurningMarks) -> Self {
        Self { marks }
    }

    /// The distance of the marks, or that in their place without marks.
    fn length(Lengths { step_over, mark_spacing, .. }: Lengths) -> f64 {
        mark_spacing.max(NO_MARKS * step_over)
    }

    fn spacing(&self, lengths: Lengths) -> Spacing {
        Spacing::new(self.marks, Self::length(lengths))
    }

    /// Where the ridge is beside the stated contact if it is `aside` of the middle of passes s apart, with marks f apart.
    ///
    /// The stated contact is in that middle. If the step-over is short compared with the feed, oblique marks can put
    /// the ridge beyond the passes; the stated contact then moves with the ridge, and stays within
    /// B = s/2 / (1 + (f/3s)^2) of it: y / (1 + (y/B)^8)^(1/8). With B = s/2, heights could fall where short step-overs
    /// grow: they change with s^2, and by the turning with B.
    fn stated(aside: f64, step_over: f64, spacing: f64) -> Stated {
        let ratio = (spacing / (FEW_STEP_OVERS * step_over)).powi(2);
        let bound = 0.5 * step_over / (1.0 + ratio);
        // (f/B) dB/df and (s/B) dB/ds.
        let loss = 2.0 * ratio / (1.0 + ratio);
        let growth = 1.0 + loss;
        let share = (aside / bound).powi(2);
        // Under a hundredth the last factor is 1 to a rounding.
        if share < 1e-4 {
            return Stated { place: aside, by_aside: 1.0, by_step_over: 0.0, by_spacing: 0.0 };
        }
        let (place, by_aside, by_bound) = if share > 1e64 {
            (bound.copysign(aside), 0.0, bound.copysign(aside))
        } else {
            let SmoothBound { factor, slope } = SmoothBound::of(share);
            (aside * factor, slope, aside * slope * share.powi(4))
        };
        Stated { place, by_aside, by_step_over: by_bound * growth / step_over, by_spacing: -by_bound * loss / spacing }
    }

    /// The ridge from one near it, of whose lengths the sought one is a guess; `None` where Newton's method does not end
    /// at a ridge.
    pub(super) fn solve(&self, sought: Sought, start: TurnedRidge) -> Option<TurnedRidge> {
        let mut ridge = TurnedRidge { is_round: true, ..start };
        let mut offset = ridge.offset();
        for _ in 0..MOST_STEPS {
            let Lengths { level, step_over, mark_spacing } = ridge.lengths;
            let spacing = self.spacing(ridge.lengths);
            let reach = step_over + spacing.length;
            let stated = Self::stated(offset - 0.5 * step_over, step_over, spacing.length);
            let place = self.marks.ridge_place(stated.place, level);
            let [near_behind, far_behind] = &mut ridge.behind;
            let near = Pair::search(self.marks, &place, offset, spacing, near_behind, Accuracy::rough(level))?;
            let far = Pair::search(self.marks, &place, offset - step_over, spacing, far_behind, Accuracy::rough(level))?;
            if !(near.by_height < 0.0 && far.by_height < 0.0) {
                return None;
            }
            let mut change = Change::default();
            let mut is_exact = false;
            if near.by_offset > 0.0 && far.by_offset < 0.0 {
                // With the place beside the stated contact, which follows the offset.
                let near_by_offset = near.by_offset + near.by_place * stated.by_aside;
                let far_by_offset = far.by_offset + far.by_place * stated.by_aside;
                let place_by_step_over = stated.by_step_over - 0.5 * stated.by_aside;
                let (near_by, far_by) = match sought {
                    Sought::Level => (near.by_height, far.by_height),
                    Sought::StepOver => (near.by_place * place_by_step_over, far.by_place * place_by_step_over - far.by_offset),
                    Sought::MarkSpacing => {
                        (near.by_spacing + near.by_place * stated.by_spacing, far.by_spacing + far.by_place * stated.by_spacing)
                    }
                };
                let det = near_by_offset * far_by - far_by_offset * near_by;
                change.offset = (near_by * far.value - far_by * near.value) / det;
                let growth = (far_by_offset * near.value - near_by_offset * far.value) / det;
                if !(growth.is_finite() && change.offset.is_finite()) {
                    return None;
                }
                let small = NEARLY * level;
                let (length, change_of) = match sought {
                    Sought::Level => (level, &mut change.rise),
                    Sought::StepOver => (step_over, &mut change.wider),
                    Sought::MarkSpacing => (mark_spacing, &mut change.longer),
                };
                *change_of = growth.clamp(-0.5 * length, length);
                is_exact = [near, far]
                    .iter()
                    .all(|pair| pair.value.abs() <= small && pair.error <= NEARLY * small && pair.shift.off.abs() <= NEAR * reach)
                    && growth.abs() <= NEARLY * length
                    && change.offset.abs() <= NEARLY * reach;
            } else {
                // The passes must be on both sides of the lowest place; the change of slope between them shows where
                // that approximately is.
                change.offset = -step_over * f64::midpoint(near.by_offset, far.by_offset) / (near.by_offset - far.by_offset);
                if !(near.by_offset > far.by_offset && change.offset.is_finite()) {
                    return None;
                }
            }
            change.offset = change.offset.clamp(-reach, reach);
            let shifted_place = stated.by_aside * (change.offset - 0.5 * change.wider)
                + stated.by_step_over * change.wider
                + stated.by_spacing * change.longer;
            let pairs = [(near, change.offset), (far, change.offset - change.wider)];
            for (behind, (pair, aside)) in ridge.behind.iter_mut().zip(pairs) {
                let Shift { off, by_offset, by_place, by_height, by_spacing } = pair.shift;
                let shift = off + by_offset * aside + by_place * shifted_place + by_height * change.rise + by_spacing * change.longer;
                *behind += shift.clamp(-reach, reach);
            }
            offset += change.offset;
            ridge.lengths =
                Lengths { level: level + change.rise, step_over: step_over + change.wider, mark_spacing: mark_spacing + change.longer };
            ridge.aside = offset - 0.5 * ridge.lengths.step_over;
            ridge.is_round &= near.is_round && far.is_round;
            if is_exact {
                return Some(ridge);
            }
        }
        None
    }

    /// The height that a pass leaves at an offset from it, for any phase of its teeth; `None` if no height is found.
    fn level(&self, start: f64, aside: f64, offset: f64, spacing: Spacing, behind: &mut f64) -> Option<f64> {
        let mut level = start;
        for _ in 0..MOST_STEPS {
            let place = self.marks.ridge_place(aside, level);
            let pair = Pair::search(self.marks, &place, offset, spacing, behind, Accuracy::full(level))?;
            let rise = -pair.value / pair.by_height;
            if !(pair.by_height < 0.0 && rise.is_finite()) {
                return None;
            }
            level = (level + rise).max(0.1 * level);
            if rise.abs() <= NEARLY * level {
                return Some(level);
            }
        }
        None
    }

    /// The ridge for given step-over and marks by nested searches, with what is left of their errors removed by Newton's
    /// method; `None` if there is none.
    pub(super) fn search(&self, start: &TurnedRidge) -> Option<TurnedRidge> {
        let ridge = self.nested(start, MOST_SHORTCUTS)?;
        let is_same = |other: &TurnedRidge| (other.lengths.level / ridge.lengths.level - 1.0).abs() <= SAME;
        self.solve(Sought::Level, ridge).filter(is_same).or(Some(ridge))
    }

    /// The ridge for given step-over and marks by nested searches, from a ridge near it; `None` if there is none.
    ///
    /// A pass leaves the lowest height abreast of its deepest place and more to both sides of it, so that the height
    /// left by the near pass exceeds that left by the far one exactly on the far side of the ridge. From the first offsets,
    /// as many as `shortcuts`, Newton's method is tried: its ridge is the one sought if both passes leave its height there.
    fn nested(&self, start: &TurnedRidge, mut shortcuts: usize) -> Option<TurnedRidge> {
        let Lengths { level, step_over, .. } = start.lengths;
        let spacing = self.spacing(start.lengths);
        // The height and the place of the marks that both passes leave at an offset. Every search starts at the same place,
        // so that what it finds depends on the offset alone.
        let left = |offset: f64| {
            let aside = Self::stated(offset - 0.5 * step_over, step_over, spacing.length).place;
            let left_by = |pass: usize, offset: f64| {
                let mut behind = start.behind[pass];
                self.level(level, aside, offset, spacing, &mut behind).map(|level| (level, behind))
            };
            // Without a height of either pass nothing is known of the ridge.
            Some([left_by(0, offset)?, left_by(1, offset - step_over)?])
        };
        let ridge_at = |offset: f64, [near, far]: [(f64, f64); 2]| TurnedRidge {
            behind: [near.1, far.1],
            aside: offset - 0.5 * step_over,
            lengths: Lengths { level: near.0.min(far.0), ..start.lengths },
            is_round: false,
        };
        let [low, high] = Self::bracket(start.offset(), step_over + spacing.length, 8.0 * self.marks.diameter(), |offset| {
            left(offset).map(|[near, far]| near.0 - far.0)
        })?;
        let is_ridge = |ridge: &TurnedRidge| {
            let is_level = |(level, _): (f64, f64)| (level / ridge.lengths.level - 1.0).abs() <= SAME;
            (low..=high).contains(&ridge.offset()) && left(ridge.offset()).is_some_and(|passes| passes.into_iter().all(is_level))
        };
        let excess = |offset: f64| {
            let passes = left(offset).ok_or(None)?;
            if shortcuts > 0 {
                shortcuts -= 1;
                let ridge = self.solve(Sought::Level, ridge_at(offset, passes)).filter(is_ridge);
                if ridge.is_some() {
                    return Err(ridge);
                }
            }
            Ok(passes[0].0 - passes[1].0)
        };
        let offset = match bracketed_root(low, high, excess) {
            Ok(offset) => offset,
            Err(found) => return found,
        };
        // Where the marks that clear a pass change, its height can jump, and the ridge is under the higher of both ends of
        // the jump.
        let resolution = 4.0 * f64::EPSILON * low.abs().max(high.abs());
        let ends = [offset - resolution, offset + resolution].into_iter().filter_map(|offset| Some(ridge_at(offset, left(offset)?)));
        ends.reduce(|one, other| if one.lengths.level >= other.lengths.level { one } else { other })
    }

    /// A bracket of the offset at which `excess` changes its sign, from a start, with steps that grow from a tenth of
    /// `reach` up to `furthest`; `None` if there is none.
    fn bracket(start: f64, reach: f64, furthest: f64, excess: impl Fn(f64) -> Option<f64>) -> Option<[f64; 2]> {
        let first = excess(start)?;
        let mut step = 0.1 * reach;
        let mut other = start;
        while step <= furthest {
            let last = other;
            other -= step.copysign(first);
            if (excess(other)? > 0.0) != (first > 0.0) {
                return Some([last.min(other), last.max(other)]);
            }
            step *= 2.0;
        }
        None
    }

    /// The largest turn at the ridge's contacts as a share of the smaller of the slope's sine and cosine.
    pub(super) fn share(&self, ridge: &TurnedRidge) -> f64 {
        let Lengths { step_over, mark_spacing, .. } = ridge.lengths;
        let place = Self::stated(ridge.aside, step_over, Self::length(ridge.lengths)).place;
        let offset = ridge.offset();
        let passes = ridge.behind.into_iter().zip([offset, offset - step_over]);
        let contacts = passes.flat_map(|(behind, offset)| [behind, behind - mark_spacing].map(|behind| [-behind, place - offset]));
        self.marks.share(contacts)
    }
}

/// The changes of the unknowns in a step.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    offset: f64,
    rise: f64,
    wider: f64,
    longer: f64,
}

#[cfg(test)]
mod tests {
    use super::super::section::Pattern;
    use super::*;
    use crate::milling::envelope::Envelope;
    use crate::milling::{Contact, Cutter, Pass, Runout, SurfaceCurvature};
    use crate::quantity::{Angle, Length};
    use proptest::prelude::*;

    fn envelope(ratio: f64, slope: f64, alpha: f64, principal: [f64; 2], turn: f64) -> Envelope {
        let mm = |value: f64| Length::from_mm(value).unwrap();
        let cutter = Cutter::toroidal(mm(10.0), mm(5.0 * ratio)).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(principal, Angle::from_degrees(turn).unwrap()).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        Envelope::new(Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }).unwrap()
    }

    proptest! {
        #[test]
        fn without_turns_the_ridge_is_that_of_the_second_order(
            ratio in 0.1..0.9_f64, slope in 10.0..80.0_f64, alpha in 0.0..360.0_f64, (one, other) in (0.0..0.01_f64, 0.0..0.01_f64),
            turn in 0.0..180.0_f64, s in 0.1..0.5_f64, f in 0.05..0.3_f64,
        ) {
            let envelope = envelope(ratio, slope, alpha, [one, other], turn);
            let level = envelope.height(s, Pattern::even(f)).unwrap();
            let marks = TurningMarks::without_turns(&envelope.body);
            let start = envelope.ridge_of_paraboloid(Lengths { level, step_over: s, mark_spacing: f });
            let ridge = RidgeSearch::new(&marks).solve(Sought::Level, start).unwrap();
            approx::assert_relative_eq!(ridge.lengths.level, level, max_relative = 1e-10);
        }

        /// From a guess of the height that is wrong by a factor of up to 3.
        #[test]
        fn nested_searches_find_the_ridge_of_newtons_method(
            ratio in 0.1..0.9_f64, slope in 10.0..80.0_f64, alpha in 0.0..360.0_f64, (one, other) in (0.0..0.05_f64, 0.0..0.05_f64),
            turn in 0.0..180.0_f64, s in 0.001..0.5_f64, f in prop_oneof![Just(0.0), 0.01..0.3_f64], wrong in 0.3..3.0_f64,
        ) {
            let envelope = envelope(ratio, slope, alpha, [one, other], turn);
            let level = envelope.height(s, Pattern::even(f)).unwrap();
            let marks = TurningMarks::new(&envelope.body);
            let search = RidgeSearch::new(&marks);
            let start = |level| envelope.ridge_of_paraboloid(Lengths { level, step_over: s, mark_spacing: f });
            if let Some(quick) = search.solve(Sought::Level, start(level)) {
                // The nested searches end within 1e-14 of the offset and of the height.
                for shortcuts in [0, MOST_SHORTCUTS] {
                    let nested = search.nested(&start(wrong * level), shortcuts).unwrap();
                    approx::assert_relative_eq!(nested.lengths.level, quick.lengths.level, max_relative = 1e-12);
                }
            }
        }

        /// The derivatives are those of central differences, whose error is of the order of the step's square.
        #[test]
        fn the_stated_contact_moves_smoothly(aside in -3.0..3.0_f64, s in 0.01..1.0_f64, f in 0.001..1.0_f64) {
            let found = RidgeSearch::stated(aside, s, f);
            prop_assert!(found.place.abs() <= s / 2.0);
            let step = 1e-6 * s;
            let difference = |more: Stated, less: Stated| (more.place - less.place) / (2.0 * step);
            for (found, expected) in [
                (found.by_aside, difference(RidgeSearch::stated(aside + step, s, f), RidgeSearch::stated(aside - step, s, f))),
                (found.by_step_over, difference(RidgeSearch::stated(aside, s + step, f), RidgeSearch::stated(aside, s - step, f))),
            ] {
                approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-5);
            }
        }
    }
}
