//! Tooth marks on a curved surface that each have a normal of their own: the signed distance of a place over the surface
//! from the body of a mark, with its derivatives.
//!
//! To second order all marks are the same body moved along the surface. But the surface's normal turns from contact to
//! contact by K u, and the tool axis does not turn with it: slope and steepest line of a mark are not those of the
//! stated contact. Near the floor a small turn of the normal is a large turn of the steepest line, and with it of the
//! cutter's two unequal radii. Here every mark is placed by the normal of its own contact on the quadric
//! w = -1/2 u'Ku. `turned_ridge` searches the ridge between such marks.

use super::body::Body;
use super::smooth_bound::SmoothBound;
use crate::numerics::vector::{cross, dot};

/// The largest turn of a normal, as a share of the sine and cosine of the slope. Turns up to half of it are exact;
/// larger ones are bounded smoothly, so that no mark reaches the floor or the wall, where the cutter's place jumps.
const LARGEST_TURN: f64 = 0.7;

/// A vector in the tangent plane of the stated contact: along the feed and to its side.
type Plane = [f64; 2];

/// A vector along the feed, to its side, and along the normal of the stated contact.
type Space = [f64; 3];

/// The cutter's marks on the quadric.
#[derive(Debug, Clone, Copy)]
pub(super) struct TurningMarks {
    core: f64,
    corner: f64,
    /// The tool axis along the feed, to the side, and along the normal of the stated contact.
    axis: Space,
    /// k_F, k_T, k_FT.
    curvature: [f64; 3],
    /// The bound of the turns, and the inverse of its square.
    largest_turn: f64,
    per_bound: f64,
}

/// The turn of the normal at a place on the surface, and its derivatives along the feed and to the side.
#[derive(Debug, Clone, Copy)]
struct Turn {
    value: Plane,
    by_feed: Plane,
    by_side: Plane,
}

/// A place over the surface, abreast of the stated contact.
#[derive(Debug, Clone, Copy)]
pub(super) struct RidgePlace {
    aside: f64,
    height: f64,
    turn: Plane,
    /// The height over the length of (turn, 1).
    upright_height: f64,
    normal: Space,
    normal_by_side: Space,
}

/// The signed distance of a place over the surface from the body of a mark, negative inside, with its derivatives: by
/// the place of the mark's contact behind the ridge, by the offset of the ridge from the contact to the side, by the
/// place of both beside the stated contact, and by the height.
#[derive(Debug, Clone, Copy)]
pub(super) struct MarkDistance {
    pub(super) value: f64,
    pub(super) by_behind: f64,
    pub(super) by_offset: f64,
    pub(super) by_place: f64,
    pub(super) by_height: f64,
    /// Whether the corner's round is nearest, and not the flat or the side.
    pub(super) is_round: bool,
}

impl TurningMarks {
    pub(super) fn new(body: &Body) -> Self {
        let (slope, surface) = (body.slope(), body.surface());
        let largest_turn = LARGEST_TURN * slope.sin().min(slope.cos());
        Self {
            core: body.core(),
            corner: body.corner(),
            axis: [-slope.sin() * body.along_steepest(), slope.sin() * body.along_level(), slope.cos()],
            curvature: [surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()],
            largest_turn,
            per_bound: (largest_turn * largest_turn).recip(),
        }
    }

    /// Marks that all have the normal of the stated contact, as to second order.
    #[cfg(test)]
    pub(super) fn without_turns(body: &Body) -> Self {
        Self { largest_turn: 0.0, per_bound: f64::INFINITY, ..Self::new(body) }
    }

    /// The largest extent of the cutter.
    pub(super) fn diameter(&self) -> f64 {
        2.0 * (self.core + self.corner)
    }

    /// K u.
    fn fall(&self, u: Plane) -> Plane {
        let [f, t, ft] = self.curvature;
        [u[0] * f + u[1] * ft, u[0] * ft + u[1] * t]
    }

    /// K u, the tangent of the angle by which the normal turns from the stated contact to the place u, bounded:
    /// w / (1 + (|w|/b)^8)^(1/8).
    fn turn(&self, u: Plane) -> Turn {
        let [f, t, ft] = self.curvature;
        let turn = self.fall(u);
        let per_bound = self.per_bound;
        let share = dot(turn, turn) * per_bound;
        // Under a hundredth of the bound the factor is 1 to a rounding.
        if share < 1e-4 {
            return Turn { value: turn, by_feed: [f, ft], by_side: [ft, t] };
        }
        // On floor and wall no turn is allowed.
        if share.is_nan() || share > 1e64 {
            return Turn { value: [0.0; 2], by_feed: [0.0; 2], by_side: [0.0; 2] };
        }
        let SmoothBound { factor, slope } = SmoothBound::of(share);
        let by_share = -0.5 * share.powi(3) * slope;
        let derivative = |by: Plane| {
            let more = by_share * 2.0 * dot(turn, by) * per_bound;
            [factor * by[0] + more * turn[0], factor * by[1] + more * turn[1]]
        };
        Turn { value: turn.map(|component| component * factor), by_feed: derivative([f, ft]), by_side: derivative([ft, t]) }
    }

    /// The place at (0, `aside`), `height` along the normal there over the surface.
    pub(super) fn ridge_place(&self, aside: f64, height: f64) -> RidgePlace {
        let Turn { value: turn, by_side, .. } = self.turn([0.0, aside]);
        let per_length = (1.0 + dot(turn, turn)).sqrt().recip();
        let normal = [turn[0] * per_length, turn[1] * per_length, per_length];
        let lengthening = dot(turn, by_side) * per_length * per_length;
        let normal_by_side = [
            by_side[0] * per_length - normal[0] * lengthening,
            by_side[1] * per_length - normal[1] * lengthening,
            -normal[2] * lengthening,
        ];
        RidgePlace { aside, height, turn, upright_height: height * per_length, normal, normal_by_side }
    }

    /// The distance of the ridge's place from a mark whose contact is `behind` it along the feed and `offset` to its
    /// side.
    ///
    /// W = (w, 1) with the turn w at the contact is the normal times L = sqrt(1 + w^2), and W' = (w', 1) likewise at
    /// the place; d leads from the contact to the place. The place on the surface is d.w + 1/2 d'Kd under the tangent
    /// plane of the stated contact, seen from the contact. Along the contact's normal -1/2 d'Kd/L remains, so that
    /// nothing cancels. With the axis A, the level line is A x W and the offset towards the axis (A x W) x A.
    ///
    /// The derivatives are those of the offset of the place from the centre of the torus, contact + r normal + a
    /// outwards, times the normal of the body.
    #[inline]
    pub(super) fn distance(&self, ridge: &RidgePlace, behind: f64, offset: f64) -> MarkDistance {
        let (a, r, axis) = (self.core, self.corner, self.axis);
        let along = [behind, offset];
        let Turn { value: turn, by_feed, by_side } = self.turn([-behind, ridge.aside - offset]);
        let square = 1.0 + dot(turn, turn);
        let length = square.sqrt();
        let fall = self.fall(along);
        let sag = 0.5 * dot(along, fall);
        let upright = [turn[0], turn[1], 1.0];

        // The level line and the descent, which is horizontal and leads from the contact towards the axis.
        let level_raw = cross(axis, upright);
        let (upright_axis, sin_length) = (dot(axis, upright), dot(level_raw, level_raw).sqrt());
        let per_both = (length * sin_length).recip();
        let (per_length, per_sin_length) = (per_both * sin_length, per_both * length);
        let level_line = level_raw.map(|component| component * per_sin_length);
        let descent: Space = std::array::from_fn(|i| (upright[i] - upright_axis * axis[i]) * per_sin_length);
        let (sin, cos) = (sin_length * per_length, upright_axis * per_length);

        // From here on as in the second order: offsets from the contact along the descent, the level line and the axis.
        let place: Space = [
            along[0] + ridge.height * ridge.normal[0],
            along[1] + ridge.height * ridge.normal[1],
            ridge.height * ridge.normal[2] - dot(along, turn) - sag,
        ];
        let up = (ridge.upright_height * (1.0 + dot(turn, ridge.turn)) - sag) * per_length;
        let (d, level, e) = (dot(descent, place), dot(level_line, place), dot(axis, place));
        let b = a + r * sin - d;
        let radius = (b * b + level * level).sqrt();
        let (excess, per_radius) = if b > 0.0 {
            let per_both = (radius * (radius + b)).recip();
            (level * level * per_both * radius, per_both * (radius + b))
        } else {
            (radius - b, if radius > 0.0 { radius.recip() } else { 0.0 })
        };
        let grown = excess - d;
        let (outside, below) = (r * sin + grown, r * cos - e);
        let is_round = outside > 0.0 && below > 0.0;
        let (value, out, down) = if is_round {
            let to_core = (outside * outside + below * below).sqrt();
            let per_both = (to_core * (to_core + r)).recip();
            let per_core = per_both * (to_core + r);
            ((2.0 * r * (sin * excess - up) + grown * grown + e * e) * (per_both * to_core), outside * per_core, below * per_core)
        } else if outside > below {
            (grown - r * (1.0 - sin), 1.0, 0.0)
        } else {
            (-e - r * (1.0 - cos), 0.0, 1.0)
        };

        // The normal of the body.
        let (to_axis, to_level) = (-out * b * per_radius, out * level * per_radius);
        let normal: Space = std::array::from_fn(|i| to_axis * descent[i] + to_level * level_line[i] - down * axis[i]);
        let facing = dot(normal, upright) * per_length * per_length;
        // How the centre of the torus moves with the turn of the contact's normal, times the normal.
        let moves = |by: Plane| {
            let by_normal = (dot([normal[0], normal[1]], by) - facing * dot(turn, by)) * per_length;
            let by_outwards = to_level * dot([level_line[0], level_line[1]], by) * per_sin_length;
            normal[2] * dot(along, by) + r * by_normal + a * by_outwards
        };
        let (by_feed, by_side) = (moves(by_feed), moves(by_side));
        MarkDistance {
            value,
            by_behind: normal[0] - normal[2] * (turn[0] + fall[0]) + by_feed,
            by_offset: normal[1] - normal[2] * (turn[1] + fall[1]) + by_side,
            by_place: ridge.height * dot(normal, ridge.normal_by_side) - by_side,
            by_height: dot(normal, ridge.normal),
            is_round,
        }
    }

    /// The largest turn of the normal over 1 mm, as a share of the smaller of the slope's sine and cosine; not bounded.
    pub(super) fn turn_per_mm(&self) -> f64 {
        let [f, t, ft] = self.curvature;
        let half = 0.5 * (f - t);
        let largest = f64::midpoint(f, t).abs() + (half * half + ft * ft).sqrt();
        largest * LARGEST_TURN / self.largest_turn
    }

    /// How much the normal turns from the stated contact to those of marks, at most, as a share of the smaller of the
    /// slope's sine and cosine; not bounded.
    pub(super) fn share(&self, contacts: impl IntoIterator<Item = Plane>) -> f64 {
        let square = |contact: Plane| {
            let turn = self.fall(contact);
            dot(turn, turn)
        };
        contacts.into_iter().map(square).fold(0.0, f64::max).sqrt() * LARGEST_TURN / self.largest_turn
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
            let marks = TurningMarks { largest_turn: 2.0, per_bound: 0.25, ..TurningMarks::new(&envelope.body) };
            let found = marks.distance(&marks.ridge_place(aside, height), behind, aside - pass).value;
            let expected = placed_distance(&marks, behind, aside, height, pass);
            // Roundings of places some 10 mm from the axis.
            prop_assert!((found - expected).abs() <= 1e-13, "{found} {expected}");
        }

        /// Turns up to several times their bound.
        #[test]
        fn derivatives_are_those_of_central_differences(
            ratio in 0.1..0.9_f64, slope in 10.0..80.0_f64, alpha in 0.0..360.0_f64, (one, other) in (0.0..0.3_f64, 0.0..0.3_f64),
            turn in 0.0..180.0_f64, (behind, offset, place, height) in (-1.0..1.0_f64, -1.0..1.0_f64, -0.5..0.5_f64, 0.0..0.05_f64),
        ) {
            let marks = TurningMarks::new(&envelope(ratio, slope, alpha, [one, other], turn).unwrap().body);
            let at = |behind: f64, offset: f64, place: f64, height: f64| marks.distance(&marks.ridge_place(place, height), behind, offset);
            let found = at(behind, offset, place, height);
            // The second derivatives jump at the border of flat and corner. Elsewhere the error of central differences
            // is of the order of the step's square, and 1e-15 over the step.
            let step = 1e-5;
            let difference = |more: MarkDistance, less: MarkDistance| (more.value - less.value) / (2.0 * step);
            for (found, expected) in [
                (found.by_behind, difference(at(behind + step, offset, place, height), at(behind - step, offset, place, height))),
                (found.by_offset, difference(at(behind, offset + step, place, height), at(behind, offset - step, place, height))),
                (found.by_place, difference(at(behind, offset, place + step, height), at(behind, offset, place - step, height))),
                (found.by_height, difference(at(behind, offset, place, height + step), at(behind, offset, place, height - step))),
            ] {
                approx::assert_abs_diff_eq!(found, expected, epsilon = 1e-4);
            }
        }
    }
}
