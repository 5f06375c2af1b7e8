//! Gouging: whether the cutter fits into a concave surface. It is tested near the contact by curvatures, and then over
//! the whole lower body of the cutter.

use super::curvature::eigenvalues;
use super::{NoAnswer, Pass, Profile, ProfileArc, SurfaceCurvature};
use crate::quantity::{Angle, Length};

/// The relative curvature lambda below which the second order of the surface is not accurate enough.
pub(super) const NEAR_GOUGING: f64 = 0.6;

/// The share by which the smallest radius that is reported can be too large, if the cutter gouges away from the contact.
const RADIUS_ERROR: f64 = 0.01;

/// The share of a curvature that no cutter notices.
const SMALLEST_SHARE: f64 = 1e-9;

/// The smallest relative curvature of cutter and surface at the contact, as a share of the cutter's own:
///
/// lambda = 1 + the smallest eigenvalue of C^(1/2) K C^(1/2)
///
/// in the axes of the steepest line and the level line. C = diag(r, (R - r)/sin(S) + r) has the cutter's radii of
/// curvature; R includes the radial runout. lambda is 1 for K = 0.
///
/// with r and R - r replaced by r_i and e_i of the arc at the contact.
///
/// `None` if the cutter gouges: if the slope is steeper than the profile cuts; if lambda <= 0, or if the height H of the cutter over the surface is negative anywhere
/// under the cutter.
pub(super) fn relative_curvature(pass: &Pass) -> Option<f64> {
    if steepest_beyond(pass).is_some() {
        return None;
    }
    if pass.surface.is_plane() {
        return Some(1.0);
    }
    match Concavity::of(pass) {
        Concavity::Concave(body) => {
            let lambda = 1.0 + body.change;
            (lambda > 0.0 && !body.is_cut(1.0)).then_some(lambda)
        }
        Concavity::Convex { lambda } => Some(lambda),
        Concavity::FitsNowhere => None,
    }
}

/// The reason why a pass gouges, with the radius into which the cutter would fit. It takes several times as long as
/// [`relative_curvature`].
pub(super) fn reason(pass: &Pass) -> NoAnswer {
    if let Some(steepest) = steepest_beyond(pass) {
        return NoAnswer::TooSteep { steepest };
    }
    let smallest_radius = match Concavity::of(pass) {
        Concavity::Concave(body) => body.smallest_radius(),
        Concavity::Convex { .. } | Concavity::FitsNowhere => None,
    };
    NoAnswer::Gouges { smallest_radius }
}

/// The steepest slope that the cutter's profile cuts, if the contact is steeper.
fn steepest_beyond(pass: &Pass) -> Option<Angle> {
    let steepest = pass.cutter.profile().steepest_cut();
    (pass.contact.slope().radians() > steepest).then(|| Angle::from_radians(steepest))
}

/// How a surface and a cutter that touches it are concave.
#[expect(clippy::large_enum_variant, reason = "it is taken apart where it is made")]
enum Concavity {
    /// No direction of the surface is concave, or none that the cutter's flat touches.
    Convex { lambda: f64 },
    /// The cutter fits if the surface is less concave.
    Concave(OnConcave),
    /// The flat or the straight side lies in the tangent plane, and fits at no radius.
    FitsNowhere,
}

/// The cutter on a concave surface.
struct OnConcave {
    profile: Profile,
    /// The arc at the contact.
    touching: ProfileArc,
    sin: f64,
    cos: f64,
    /// The curvature in the axes of the steepest line and the level line.
    surface: SurfaceCurvature,
    /// The smaller principal curvature.
    smallest_curvature: f64,
    /// lambda - 1.
    change: f64,
    /// The share of the curvature with which the cutter fits in any case.
    fits_certainly: f64,
}

impl Concavity {
    fn of(pass: &Pass) -> Self {
        let profile = pass.cutter.widened(pass.runout.radial()).profile();
        let touching = *profile.arc_at(pass.contact.slope().radians());
        let (core, corner) = (touching.centre_offset, touching.radius);
        let (sin, cos, omega) = (pass.contact.slope().sin(), pass.contact.slope().cos(), pass.contact.omega());
        let [_, smallest_curvature] = pass.surface.principal_per_mm();
        let flat = core != 0.0 && core / sin + corner > 1e300;
        if flat {
            // The flat lies in the tangent plane: it gouges in any concave direction, at any radius, and in no convex
            // direction.
            return if smallest_curvature < 0.0 { Self::FitsNowhere } else { Self::Convex { lambda: 1.0 } };
        }
        let level_radius = if core == 0.0 { corner } else { core / sin + corner };
        let steepest = pass.surface.turned(-omega.sin(), omega.cos());
        if cos == 0.0 && side_gouges(steepest, profile.outer_radius()) {
            return Self::FitsNowhere;
        }
        let root = (corner * level_radius).sqrt();
        let [_, change] =
            eigenvalues(corner * steepest.along_per_mm(), level_radius * steepest.across_per_mm(), root * steepest.twist_per_mm());
        if smallest_curvature >= 0.0 {
            return Self::Convex { lambda: 1.0 + change };
        }
        // The lower body of a torus lies inside the sphere of radius (R - r)/sin(S) + r that touches it at the contact. This
        // sphere fits into any surface that is less concave.
        let fits_certainly = if profile.arcs().len() == 1 { -1.0 / (smallest_curvature * level_radius) } else { 0.0 };
        Self::Concave(OnConcave { profile, touching, sin, cos, surface: steepest, smallest_curvature, change, fits_certainly })
    }
}

/// Whether the cutter's straight side, a cylinder of radius R about the axis, cuts into a wall that it touches. The
/// side is straight along the steepest line, so it fits if [[k_ss, k_sl], [k_sl, 1/R + k_ll]] has no negative
/// eigenvalue.
fn side_gouges(steepest: SurfaceCurvature, outer: f64) -> bool {
    let (bend, twist, level) = (steepest.along_per_mm(), steepest.twist_per_mm(), outer.recip() + steepest.across_per_mm());
    // Components that are exactly 0 become rounding errors of the largest one when the curvature is turned from the
    // feed's axes.
    let rounding = 1e-12 * (bend.abs() + twist.abs() + steepest.across_per_mm().abs());
    bend < -rounding || twist.abs() > rounding && bend * level < twist * twist
}

impl OnConcave {
    /// Whether the cutter cuts into the surface anywhere with a share of its curvature with which lambda >= 0. The sphere of a ball tip
    /// that touches the surface then fits as a whole.
    fn is_cut(&self, share: f64) -> bool {
        if share <= self.fits_certainly {
            return false;
        }
        let surface = self.surface.scaled(share);
        let (outwards, upwards) = self.touching.point_at(self.sin, self.cos);
        let is_touching_ball = |arc: &ProfileArc| *arc == self.touching && arc.centre_offset == 0.0;
        self.profile.cutting_arcs().iter().filter(|arc| !is_touching_ball(arc)).any(|arc| {
            let (same_out, same_up) = arc.point_at(self.sin, self.cos);
            let offset = if *arc == self.touching { [0.0; 2] } else { [outwards - same_out, same_up - upwards] };
            let (core, corner) = (arc.centre_offset, arc.radius);
            Footprint { core, corner, offset, range: [arc.from, arc.to], sin: self.sin, cos: self.cos, surface }
                .is_cut(self.profile.outer_radius())
        })
    }

    /// The concave principal radius at which the cutter fits if both curvatures are scaled alike: exact where lambda is 0
    /// there, otherwise larger than the smallest by at most [`RADIUS_ERROR`].
    fn smallest_radius(&self) -> Option<Length> {
        let of_share =
            |share: f64| Some(-1.0 / (share * self.smallest_curvature)).filter(|radius| radius.is_finite()).map(Length::computed);
        // With this share of the curvature lambda is 0. Near the floor the rounding of lambda can exceed its change.
        let closest = if self.change < 0.0 { -1.0 / self.change } else { f64::INFINITY };
        let mut cuts = closest.min(1.0);
        if closest <= 1.0 && !self.is_cut(closest) {
            return of_share(closest);
        }
        let mut fits = if self.fits_certainly > 0.0 { self.fits_certainly.min(cuts) } else { cuts };
        while self.is_cut(fits) {
            fits /= 4.0;
            if fits < SMALLEST_SHARE {
                return None;
            }
        }
        while cuts > fits * (1.0 + RADIUS_ERROR) {
            let middle = (cuts * fits).sqrt();
            if self.is_cut(middle) { cuts = middle } else { fits = middle }
        }
        of_share(fits)
    }
}

/// An arc of the cutter's lower body over a surface with the curvature `surface` in the axes of the steepest line and the
/// level line.
///
/// If the surface has a concave direction, the lowest point is on the round, including the rim of the flat: over the
/// flat's disc H is a quadratic function that is not positive definite, which has no minimum inside the disc.
#[derive(Debug, Clone, Copy)]
struct Footprint {
    core: f64,
    corner: f64,
    /// From the arc's point with the contact's normal to the contact, outwards; and from the contact to that point, upwards.
    offset: [f64; 2],
    /// The angles of the arc's normals.
    range: [f64; 2],
    sin: f64,
    cos: f64,
    surface: SurfaceCurvature,
}

/// The numbers of grid points of the search around the axis and down the round. H is a trigonometric polynomial of the
/// second degree in both angles, with few extrema. With half as many points in each angle, one of 75 000 random contacts counts as one
/// that fits although it does not.
const AROUND: u8 = 64;
const DOWN: u8 = 16;

/// The largest number of steps of Newton's method from a grid point, which takes three to five.
const MOST_NEWTON_STEPS: usize = 8;

/// The last step of Newton's method, in rad: H differs from its minimum by the square, 1e-16 of the cutter's radius.
const LAST_ANGLE: f64 = 1e-8;

impl Footprint {
    /// H, the height above the surface along the normal, of the point of the round at the azimuth psi from the contact,
    /// with its normal at the angle beta to the axis. beta is 0 at the flat's rim, S at the contact, and pi/2 where the
    /// side begins:
    ///
    /// p = a sin(S) (1 - cos(psi)) + r (1 - sin(S) sin(beta) cos(psi) - cos(S) cos(beta)),   H = p + 1/2 u'Ku
    fn height(&self, (sin_psi, cos_psi): (f64, f64), (sin_beta, cos_beta): (f64, f64)) -> f64 {
        let (a, r, sin, cos) = (self.core, self.corner, self.sin, self.cos);
        let outwards = self.offset[0] + a * (1.0 - cos_psi) + r * (sin - sin_beta * cos_psi);
        let upwards = self.offset[1] + r * (cos - cos_beta);
        let level = (a + r * sin_beta) * sin_psi;
        let steep = outwards * cos - upwards * sin;
        let normal = outwards * sin + upwards * cos;
        let surface = &self.surface;
        let bend =
            surface.along_per_mm() * steep * steep + 2.0 * surface.twist_per_mm() * steep * level + surface.across_per_mm() * level * level;
        normal + bend / 2.0
    }

    /// Whether H is negative anywhere, by more than the rounding of its terms.
    #[expect(clippy::cast_precision_loss, reason = "at most 64")]
    fn is_cut(&self, outer_radius: f64) -> bool {
        let rounding = -1e-12 * outer_radius;
        let step = (std::f64::consts::TAU / f64::from(AROUND), (self.range[1] - self.range[0]) / f64::from(DOWN));
        let around: [(f64, f64); AROUND as usize] = std::array::from_fn(|i| (step.0 * i as f64).sin_cos());
        let down: [(f64, f64); DOWN as usize + 1] = std::array::from_fn(|j| (self.range[0] + step.1 * j as f64).sin_cos());
        let heights: [[f64; DOWN as usize + 1]; AROUND as usize] = around.map(|psi| down.map(|beta| self.height(psi, beta)));
        if heights.iter().flatten().any(|height| *height < rounding) {
            return true;
        }
        let last = usize::from(AROUND) - 1;
        // All rows of a sharp edge are the same, and all points of the first row of a ball tip.
        let lowest_row = if self.corner > 0.0 { usize::from(DOWN) } else { 0 };
        let is_tip = self.core == 0.0 && self.range[0] == 0.0;
        (0..=last).any(|i| {
            (0..=lowest_row).any(|j| {
                let (before, after) = (if i == 0 { last } else { i - 1 }, if i == last { 0 } else { i + 1 });
                let least = heights[before][j].min(heights[after][j]).min(heights[i][j.saturating_sub(1)]);
                let least = least.min(heights[i][(j + 1).min(usize::from(DOWN))]);
                let start = (step.0 * i as f64, self.range[0] + step.1 * j as f64);
                let lowest = || if is_tip { self.lowest_on_tip(start, step.1) } else { self.lowest_near(start, step) };
                heights[i][j] <= least && !(is_tip && i > 0 && j == 0) && lowest() < rounding
            })
        })
    }

    /// The least H that a descent from a grid point of a ball tip finds: in the plane of beta (cos psi, sin psi), in which the lowest
    /// point is a point like all others. Away from that point Newton's method may end it.
    fn lowest_on_tip(&self, (psi, beta): (f64, f64), step: f64) -> f64 {
        let end = self.range[1];
        let at = |[x, y]: [f64; 2]| self.height(y.atan2(x).sin_cos(), x.hypot(y).sin_cos());
        let inside = |[x, y]: [f64; 2]| {
            let beyond = (x.hypot(y) / end).max(1.0);
            [x / beyond, y / beyond]
        };
        Descent::new([beta * psi.cos(), beta * psi.sin()], [step, step], at).lowest(inside, |descent| {
            let ([x, y], [step, _]) = (descent.place, descent.steps);
            let beta = x.hypot(y);
            let is_fine = descent.halvings > 1 && beta > 4.0 * step;
            if is_fine { self.lowest_by_newton((y.atan2(x), beta), (step / beta, step)) } else { None }
        })
    }

    /// The least H by Newton's method in both angles, or in psi alone at a border of the round beyond which H falls; `None` where
    /// H is not convex, and farther than a step of the descent from the start.
    fn lowest_by_newton(&self, start: (f64, f64), step: (f64, f64)) -> Option<f64> {
        let (mut psi, mut beta) = start;
        for _ in 0..MOST_NEWTON_STEPS {
            let ([by_psi, by_beta], [psi_psi, psi_beta, beta_beta]) = self.derivatives(psi.sin_cos(), beta.sin_cos());
            let is_at_border = beta <= self.range[0] && by_beta > 0.0 || beta >= self.range[1] && by_beta < 0.0;
            let (to_psi, to_beta) = if is_at_border || self.corner == 0.0 {
                (-by_psi / psi_psi, 0.0)
            } else {
                let determinant = psi_psi * beta_beta - psi_beta * psi_beta;
                if determinant.is_nan() || determinant <= 0.0 {
                    return None;
                }
                ((psi_beta * by_beta - beta_beta * by_psi) / determinant, (psi_beta * by_psi - psi_psi * by_beta) / determinant)
            };
            let next = (psi + to_psi, (beta + to_beta).clamp(self.range[0], self.range[1]));
            if psi_psi <= 0.0 || !((next.0 - start.0).abs() <= step.0 && (next.1 - start.1).abs() <= step.1) {
                return None;
            }
            let size = (next.0 - psi).abs() + (next.1 - beta).abs();
            (psi, beta) = next;
            if size <= LAST_ANGLE {
                return Some(self.height(psi.sin_cos(), beta.sin_cos()));
            }
        }
        None
    }

    /// The first derivatives of H by psi and beta, and the second ones: twice by psi, by both, twice by beta.
    fn derivatives(&self, (sin_psi, cos_psi): (f64, f64), (sin_beta, cos_beta): (f64, f64)) -> ([f64; 2], [f64; 3]) {
        let (a, r, sin, cos, surface) = (self.core, self.corner, self.sin, self.cos, &self.surface);
        let (around, down) = (a + r * sin_beta, r * cos_beta);
        let outwards = self.offset[0] + a * (1.0 - cos_psi) + r * (sin - sin_beta * cos_psi);
        let upwards = self.offset[1] + r * (cos - cos_beta);
        // Components along the steepest line, the level line and the normal.
        let parts = |outwards: f64, level: f64, upwards: f64| [outwards * cos - upwards * sin, level, outwards * sin + upwards * cos];
        let bend = |[steep, level, _]: [f64; 3], [other_steep, other_level, _]: [f64; 3]| {
            surface.along_per_mm() * steep * other_steep
                + surface.twist_per_mm() * (steep * other_level + level * other_steep)
                + surface.across_per_mm() * level * other_level
        };
        let place = parts(outwards, around * sin_psi, upwards);
        let by_psi = parts(around * sin_psi, around * cos_psi, 0.0);
        let by_beta = parts(-down * cos_psi, down * sin_psi, r * sin_beta);
        let first = |by: [f64; 3]| by[2] + bend(place, by);
        let second = |by: [f64; 3], one: [f64; 3], other: [f64; 3]| first(by) + bend(one, other);
        (
            [first(by_psi), first(by_beta)],
            [
                second(parts(around * cos_psi, -around * sin_psi, 0.0), by_psi, by_psi),
                second(parts(down * sin_psi, down * cos_psi, 0.0), by_psi, by_beta),
                second(parts(r * sin_beta * cos_psi, -r * sin_beta * sin_psi, down), by_beta, by_beta),
            ],
        )
    }

    /// The least H that a descent from a grid point finds in both angles. From the second halving on Newton's method may end it.
    fn lowest_near(&self, start: (f64, f64), step: (f64, f64)) -> f64 {
        let at = |[psi, beta]: [f64; 2]| self.height(psi.sin_cos(), beta.sin_cos());
        let inside = |[psi, beta]: [f64; 2]| [psi, beta.clamp(self.range[0], self.range[1])];
        Descent::new([start.0, start.1], [step.0, step.1], at).lowest(inside, |descent| {
            let ([psi, beta], [psi_step, beta_step]) = (descent.place, descent.steps);
            // Beside the floor's rim H can have two minima within the slope.
            let is_fine = descent.halvings > 1 && (beta_step < 0.25 * self.sin || self.corner == 0.0);
            if is_fine { self.lowest_by_newton((psi, beta), (psi_step, beta_step)) } else { None }
        })
    }
}

/// The halvings after which a descent ends: 2^-24 of the first steps is 1e-8 rad, at which H differs from its minimum by 1e-16 of the
/// cutter's radius.
const MOST_HALVINGS: u32 = 24;

/// A descent on a function of two coordinates. It moves to a lower neighbour, and halves its steps if none is lower.
struct Descent<F> {
    at: F,
    place: [f64; 2],
    steps: [f64; 2],
    lowest: f64,
    halvings: u32,
}

impl<F: Fn([f64; 2]) -> f64> Descent<F> {
    fn new(place: [f64; 2], steps: [f64; 2], at: F) -> Self {
        let lowest = at(place);
        Self { at, place, steps, lowest, halvings: 0 }
    }

    /// The least value found. `inside` brings a place back into the domain; after each halving `sooner` may end the descent with the
    /// minimum.
    fn lowest(mut self, inside: impl Fn([f64; 2]) -> [f64; 2], sooner: impl Fn(&Self) -> Option<f64>) -> f64 {
        const NEIGHBOURS: [[f64; 2]; 8] =
            [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        while self.halvings < MOST_HALVINGS {
            let neighbours = NEIGHBOURS.iter().map(|towards| {
                let place = inside([0, 1].map(|axis| self.place[axis] + towards[axis] * self.steps[axis]));
                (place, (self.at)(place))
            });
            if let Some((place, height)) = neighbours.into_iter().find(|(_, height)| *height < self.lowest) {
                (self.place, self.lowest) = (place, height);
                continue;
            }
            self.steps = self.steps.map(|step| step / 2.0);
            self.halvings += 1;
            if let Some(least) = sooner(&self) {
                return least.min(self.lowest);
            }
        }
        self.lowest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    proptest! {
        /// The error of central differences is of the order of the step's square, 1e-8, and of the roundings over the step.
        #[test]
        fn derivatives_are_those_of_central_differences(
            core in 0.0..5.0_f64, corner in 0.0..5.0_f64, slope in 0.0..1.57_f64, psi in -3.1..3.1_f64, beta in 0.0..1.57_f64,
            (along, across, twist) in (-0.3..0.3_f64, -0.3..0.3_f64, -0.3..0.3_f64), offset in [-1.0..1.0_f64, 0.0..1.0_f64],
        ) {
            let (sin, cos) = slope.sin_cos();
            let surface = SurfaceCurvature::from_components_per_mm(along, across, twist).unwrap();
            let footprint = Footprint { core, corner, offset, range: [0.0, FRAC_PI_2], sin, cos, surface };
            let (step, epsilon) = (1e-4, 1e-5);
            let height = |psi: f64, beta: f64| footprint.height(psi.sin_cos(), beta.sin_cos());
            let slopes = |psi: f64, beta: f64| footprint.derivatives(psi.sin_cos(), beta.sin_cos()).0;
            let ([by_psi, by_beta], [psi_psi, psi_beta, beta_beta]) = footprint.derivatives(psi.sin_cos(), beta.sin_cos());
            let central = |more: f64, less: f64| (more - less) / (2.0 * step);
            let (before, after) = (slopes(psi - step, beta), slopes(psi + step, beta));
            for (found, expected) in [
                (by_psi, central(height(psi + step, beta), height(psi - step, beta))),
                (by_beta, central(height(psi, beta + step), height(psi, beta - step))),
                (psi_psi, central(after[0], before[0])),
                (psi_beta, central(after[1], before[1])),
                (beta_beta, central(slopes(psi, beta + step)[1], slopes(psi, beta - step)[1])),
            ] {
                approx::assert_abs_diff_eq!(found, expected, epsilon = epsilon);
            }
        }
    }
}
