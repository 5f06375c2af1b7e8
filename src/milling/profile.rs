//! The lower profile of a convex cutter of revolution, from which drop-cutter, milling and heights are computed.

use std::f64::consts::FRAC_PI_2;
use std::fmt;

/// The most arcs of a profile. Shapes on the market have two or three; what one states is bounded by this.
pub const MOST_ARCS: usize = 8;

/// The largest step in mm between two elements of a stated profile, and the largest difference of their normals in rad:
/// sizes are given with three to six digits.
const JOIN: f64 = 1e-4;

/// An arc of the profile. Outward normals run from `from` to `to` in rad, 0 being straight down and pi/2 horizontal; the
/// point with the normal phi is at the radius e + r sin(phi) from the axis and at the height z - r cos(phi) over the tip.
///
/// A radius of zero is a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileArc {
    /// r >= 0 in mm.
    pub radius: f64,
    /// e, the distance of the centre from the axis in mm. Negative if the arc's centre is beyond the axis.
    pub centre_offset: f64,
    /// z, the height of the centre over the tip in mm.
    pub centre_height: f64,
    /// The angle of the normal where the arc begins, nearer to the axis.
    pub from: f64,
    /// The angle of the normal where the arc ends.
    pub to: f64,
}

impl ProfileArc {
    /// The point whose normal has the angle phi: its distance from the axis and its height over the tip, in mm.
    #[must_use]
    pub fn point(&self, phi: f64) -> (f64, f64) {
        let (sin, cos) = phi.sin_cos();
        self.point_at(sin, cos)
    }

    /// [`ProfileArc::point`] by sine and cosine of the angle.
    pub(super) fn point_at(&self, sin: f64, cos: f64) -> (f64, f64) {
        (self.centre_offset + self.radius * sin, self.centre_height - self.radius * cos)
    }
}

/// The lower profile of a convex cutter of revolution: arcs whose normals follow each other from 0 (straight down) to
/// pi/2. Where one arc ends before the next begins, a straight piece with their common normal joins them: a flat, a cone
/// or a part of the side. Above the last arc the cutter is a cylinder.
///
/// The torus is that of Segonds et al. 2017, doi:10.1007/s10845-017-1360-0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    arcs: [ProfileArc; MOST_ARCS],
    count: usize,
}

/// The reason why arcs are not the profile of a cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProfileError {
    /// There is no arc, or there are more than [`MOST_ARCS`].
    NumberOfArcs,
    /// A radius is negative, an angle is outside 0 to pi/2, an arc ends before it begins, or a number is not finite.
    Arc {
        /// The index of the arc.
        index: usize,
    },
    /// The arc does not begin where the element before it ends, or its normals do not continue the element's: the profile
    /// has a step or is not convex.
    Join {
        /// The index of the arc.
        index: usize,
    },
    /// The lowest point of the profile is not at the height 0.
    TipNotAtZero,
    /// The profile ends at the axis.
    NoWidth,
}

impl fmt::Display for ProfileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NumberOfArcs => write!(f, "a profile has from 1 to {MOST_ARCS} arcs"),
            Self::Arc { .. } => {
                f.write_str("an arc has a radius of at least 0, and normals from 0 (down) to 90 deg (horizontal) that grow outwards")
            }
            Self::Join { .. } => {
                f.write_str("each arc begins where the one before it ends, or a straight piece with the normal of both joins them")
            }
            Self::TipNotAtZero => f.write_str("heights count from the tip: the lowest point of the profile is at 0"),
            Self::NoWidth => f.write_str("the profile has no width: it ends at the axis"),
        }
    }
}

impl std::error::Error for ProfileError {}

impl Profile {
    /// The profile of the outer radius R and the corner radius r in mm, 0 <= r <= R: a ball with r = R, a flat end with
    /// r = 0.
    #[must_use]
    pub fn torus(outer_radius: f64, corner_radius: f64) -> Self {
        let corner = ProfileArc {
            radius: corner_radius,
            centre_offset: outer_radius - corner_radius,
            centre_height: corner_radius,
            from: 0.0,
            to: FRAC_PI_2,
        };
        Self { arcs: [corner; MOST_ARCS], count: 1 }
    }

    /// The profile of arcs that a shape's dimensions give: from 1 to [`MOST_ARCS`], which join and cover 0 to pi/2.
    pub(super) fn of_valid_arcs(arcs: &[ProfileArc]) -> Self {
        let mut profile = Self { arcs: [arcs[0]; MOST_ARCS], count: arcs.len() };
        profile.arcs[..arcs.len()].copy_from_slice(arcs);
        profile
    }

    /// The profile with its outer radius larger by `extra` in mm: a flat is wider and all else stays; if the tip is round,
    /// the profile is the parallel one at the distance `extra`, whose tip is at 0 again.
    pub(crate) fn widened(&self, extra: f64) -> Self {
        let has_flat = self.arcs[0].centre_offset > 0.0;
        let widen = |arc: ProfileArc| {
            if has_flat {
                ProfileArc { centre_offset: arc.centre_offset + extra, ..arc }
            } else {
                ProfileArc { radius: arc.radius + extra, centre_height: arc.centre_height + extra, ..arc }
            }
        };
        Self { arcs: self.arcs.map(widen), count: self.count }
    }

    /// The profile of these arcs, from the axis outwards. A corner is added at the axis if the first normal is not
    /// straight down, and at the end if the last one is not horizontal.
    ///
    /// # Errors
    /// The [`ProfileError`] of the first arc that does not fit.
    pub fn of_arcs(stated: &[ProfileArc]) -> Result<Self, ProfileError> {
        let (Some(first), Some(last)) = (stated.first(), stated.last()) else { return Err(ProfileError::NumberOfArcs) };
        let valid = |arc: &ProfileArc| {
            let finite = arc.centre_offset.is_finite() && arc.centre_height.is_finite() && arc.radius.is_finite();
            finite && arc.radius >= 0.0 && arc.from >= 0.0 && arc.to >= arc.from && arc.to <= FRAC_PI_2 + JOIN
        };
        if let Some(index) = stated.iter().position(|arc| !valid(arc)) {
            return Err(ProfileError::Arc { index });
        }
        let corner = |(offset, height), from, to| ProfileArc { radius: 0.0, centre_offset: offset, centre_height: height, from, to };
        let mut arcs = Vec::with_capacity(stated.len() + 2);
        let start = first.point(first.from);
        if first.from > JOIN {
            if start.0.abs() > JOIN {
                return Err(ProfileError::Join { index: 0 });
            }
            arcs.push(corner((0.0, start.1), 0.0, first.from));
        } else if start.0 < -JOIN {
            return Err(ProfileError::Join { index: 0 });
        }
        if start.1.abs() > JOIN {
            return Err(ProfileError::TipNotAtZero);
        }
        arcs.extend_from_slice(stated);
        if last.to < FRAC_PI_2 - JOIN {
            arcs.push(corner(last.point(last.to), last.to, FRAC_PI_2));
        }
        if arcs.len() > MOST_ARCS {
            return Err(ProfileError::NumberOfArcs);
        }
        for index in 1..stated.len() {
            if !joins(&stated[index - 1], &stated[index]) {
                return Err(ProfileError::Join { index });
            }
        }
        let profile = Self::of_valid_arcs(&arcs);
        if profile.outer_radius() < JOIN { Err(ProfileError::NoWidth) } else { Ok(profile) }
    }

    /// The arcs from the axis outwards; their normals cover 0 to pi/2 without a gap.
    #[must_use]
    pub fn arcs(&self) -> &[ProfileArc] {
        &self.arcs[..self.count]
    }

    /// The arcs without the corner that closes a cone at the shank: what cuts.
    pub(super) fn cutting_arcs(&self) -> &[ProfileArc] {
        let count = self.count - usize::from(self.count > 1 && self.arcs[self.count - 1].radius == 0.0);
        &self.arcs[..count]
    }

    /// The steepest slope in rad that the profile cuts: pi/2, or the slope of the cone at its end.
    #[must_use]
    pub fn steepest_cut(&self) -> f64 {
        if self.cutting_arcs().len() < self.count { self.arcs[self.count - 1].from } else { FRAC_PI_2 }
    }

    /// Whether a straight piece, a flat or a cone, has the normal phi in rad.
    #[must_use]
    pub fn is_straight_at(&self, phi: f64) -> bool {
        let has_flat = phi == 0.0 && self.arcs[0].point(0.0).0 > 0.0;
        let joins = |pair: &[ProfileArc]| {
            let is_common = (pair[0].to..=pair[1].from).contains(&phi);
            is_common && pair[1].point(phi).0 - pair[0].point(phi).0 > JOIN
        };
        has_flat || self.arcs().windows(2).any(joins)
    }

    /// R, the largest radius in mm.
    #[must_use]
    pub fn outer_radius(&self) -> f64 {
        let last = &self.arcs[self.count - 1];
        last.centre_offset + last.radius
    }

    /// The arc whose normals contain the angle phi in rad from 0 to pi/2; of two that share it the outer one.
    #[must_use]
    pub fn arc_at(&self, phi: f64) -> &ProfileArc {
        self.arcs().iter().rev().find(|arc| phi >= arc.from).unwrap_or(&self.arcs[0])
    }

    /// The height in mm of the bottom over the tip at the distance rho from the axis; infinite beyond the outer radius.
    #[must_use]
    pub fn low(&self, rho: f64) -> f64 {
        self.element(rho).map_or(f64::INFINITY, |element| element.height(rho))
    }

    /// The height of the bottom over the tip at the distance rho, its first derivative (infinite where the profile is
    /// vertical) and its second in 1/mm; `None` beyond the outer radius.
    #[must_use]
    pub fn derivatives(&self, rho: f64) -> Option<[f64; 3]> {
        self.element(rho).map(|element| element.derivatives(rho))
    }

    fn element(&self, rho: f64) -> Option<Element<'_>> {
        let mut before: Option<&ProfileArc> = None;
        for arc in self.arcs() {
            let (start, _) = arc.point(arc.from);
            if rho < start {
                return Some(Element::Straight { to: arc, angle: arc.from });
            }
            before = Some(arc);
            let end = if arc.to >= FRAC_PI_2 { arc.centre_offset + arc.radius } else { arc.point(arc.to).0 };
            if rho <= end {
                break;
            }
            before = None;
        }
        before.map(Element::Arc)
    }
}

/// Whether `next` begins where `arc` ends, or where a straight piece with the normal of both leads.
fn joins(arc: &ProfileArc, next: &ProfileArc) -> bool {
    let ((rho0, z0), (rho1, z1)) = (arc.point(arc.to), next.point(next.from));
    let (sin, cos) = arc.to.sin_cos();
    let along = (rho1 - rho0) * cos + (z1 - z0) * sin;
    let off = (rho1 - rho0) * sin - (z1 - z0) * cos;
    (arc.to - next.from).abs() <= JOIN && off.abs() <= JOIN && along >= -JOIN
}

/// One element of the profile: an arc, or the straight piece that ends where an arc begins.
enum Element<'a> {
    Arc(&'a ProfileArc),
    Straight { to: &'a ProfileArc, angle: f64 },
}

impl Element<'_> {
    fn height(&self, rho: f64) -> f64 {
        match self {
            Self::Arc(arc) => {
                // Without cancellation: r - sqrt(r^2 - d^2) = d^2 / (r + sqrt(r^2 - d^2)).
                let from_centre = rho - arc.centre_offset;
                let down = ((arc.radius - from_centre) * (arc.radius + from_centre)).max(0.0).sqrt();
                let bottom = arc.centre_height - arc.radius;
                let sum = arc.radius + down;
                if sum > 0.0 { bottom + from_centre * from_centre / sum } else { bottom }
            }
            Self::Straight { to, angle } => {
                let (end, height) = to.point(to.from);
                height - (end - rho) * angle.tan()
            }
        }
    }

    fn derivatives(&self, rho: f64) -> [f64; 3] {
        match self {
            Self::Arc(arc) => {
                let from_centre = rho - arc.centre_offset;
                let down = ((arc.radius - from_centre) * (arc.radius + from_centre)).max(0.0).sqrt();
                if arc.radius == 0.0 {
                    return [self.height(rho), 0.0, 0.0];
                }
                [self.height(rho), from_centre / down, arc.radius * arc.radius / (down * down * down)]
            }
            Self::Straight { angle, .. } => [self.height(rho), angle.tan(), 0.0],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    fn tapered_ball(radius: f64, taper: f64, shank_radius: f64) -> Profile {
        let end = FRAC_PI_2 - taper;
        let ball = ProfileArc { radius, centre_offset: 0.0, centre_height: radius, from: 0.0, to: end };
        let (rho, z) = ball.point(end);
        let shank = ProfileArc {
            radius: 0.0,
            centre_offset: shank_radius,
            centre_height: z + (shank_radius - rho) * end.tan(),
            from: end,
            to: FRAC_PI_2,
        };
        Profile::of_arcs(&[ball, shank]).unwrap()
    }

    #[test]
    fn a_torus_is_flat_inside_and_round_at_its_corner() {
        let torus = Profile::torus(5.0, 2.0);
        for (value, expected) in
            [(torus.low(0.0), 0.0), (torus.low(3.0), 0.0), (torus.outer_radius(), 5.0), (Profile::torus(5.0, 0.0).low(5.0), 0.0)]
        {
            assert_relative_eq!(value, expected, epsilon = 1e-15);
        }
        assert_relative_eq!(torus.low(4.0), 2.0 - 3.0_f64.sqrt(), epsilon = 1e-15);
        assert_relative_eq!(torus.low(5.0), 2.0, epsilon = 1e-15);
        assert!(torus.low(5.001).is_infinite());
        assert_relative_eq!(Profile::torus(5.0, 5.0).low(3.0), 1.0, epsilon = 1e-15);
    }

    #[test]
    fn a_tapered_ball_is_a_ball_then_a_cone_then_a_cylinder() {
        let taper = 0.1;
        let cutter = tapered_ball(1.0, taper, 3.0);
        assert_relative_eq!(cutter.low(0.5), 1.0 - 0.75_f64.sqrt(), epsilon = 1e-15);
        let (joint, height) = (taper.cos(), 1.0 - taper.sin());
        assert_relative_eq!(cutter.low(2.0), height + (2.0 - joint) / taper.tan(), epsilon = 1e-12);
        assert_relative_eq!(cutter.outer_radius(), 3.0);
        assert!(cutter.low(3.1).is_infinite());
    }

    #[test]
    fn derivatives_agree_with_differences() {
        for profile in [Profile::torus(5.0, 2.0), Profile::torus(3.0, 3.0), tapered_ball(1.0, 0.1, 3.0)] {
            for step in 1..40 {
                let rho = profile.outer_radius() * f64::from(step) / 40.7;
                let [low, first, second] = profile.derivatives(rho).unwrap();
                let h = 1e-5;
                // Differences over 1e-5 of values near 1 have an error of about 1e-11 for the first derivative and 1e-5 for
                // the second, whose own third-order term is smaller except next to the vertical end.
                let (below, above) = (profile.low(rho - h), profile.low(rho + h));
                assert_relative_eq!((above - below) / (2.0 * h), first, epsilon = 1e-6, max_relative = 1e-5);
                assert_relative_eq!((above - 2.0 * low + below) / (h * h), second, epsilon = 1e-4, max_relative = 1e-3);
            }
        }
    }

    #[test]
    fn what_is_no_profile_is_refused_with_its_arc() {
        let ball = ProfileArc { radius: 2.0, centre_offset: 0.0, centre_height: 2.0, from: 0.0, to: 1.0 };
        let side = ProfileArc { radius: 80.0, centre_offset: -75.0, centre_height: 60.0, from: 1.0, to: FRAC_PI_2 };
        assert_eq!(Profile::of_arcs(&[]), Err(ProfileError::NumberOfArcs));
        assert_eq!(Profile::of_arcs(&[ball, side]), Err(ProfileError::Join { index: 1 }));
        assert_eq!(Profile::of_arcs(&[ProfileArc { to: -1.0, ..ball }]), Err(ProfileError::Arc { index: 0 }));
        assert_eq!(Profile::of_arcs(&[ProfileArc { centre_height: 2.5, ..ball }]), Err(ProfileError::TipNotAtZero));
        let point = ProfileArc { radius: 0.0, centre_offset: 0.0, centre_height: 0.0, from: 0.0, to: FRAC_PI_2 };
        assert_eq!(Profile::of_arcs(&[point]), Err(ProfileError::NoWidth));
        assert_eq!(Profile::of_arcs(&[ProfileArc { radius: f64::NAN, ..ball }]), Err(ProfileError::Arc { index: 0 }));
    }
}
