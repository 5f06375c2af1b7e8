//! The height between two passes by the cutter's imprints alone, on the paraboloid that has a facet's slope and
//! curvature.
//!
//! The marks of a flat-end cutter are of the second order in model `envelope`: all have the normal of the stated
//! contact. Near the floor a small turn of the normal is a large turn of the steepest line, which moves the tip; here
//! each tip follows from the normal at its own contact.

use crate::milling::Cutter;
use crate::numerics::bracketed_root;
use crate::numerics::vector::length;
use crate::surface::FinishFacet;
use std::convert::Infallible;
use std::f64::consts::FRAC_PI_2;

/// The number of tips of a pass on each side of the place.
const TIPS: i32 = 24;

/// The number of tips on each side of the place at which a pass runs level.
const TURNED: i32 = 12;

/// The number of parts into which the strip is divided before its highest place is refined.
const PARTS: u32 = 6;

/// Steps of the golden section across the strip and along a pass: 0.618^9 = 0.013, 0.618^16 = 5e-4.
const STEPS_ACROSS: u32 = 9;
const STEPS_ALONG: u32 = 16;

/// A cutter on the paraboloid z = g u + u'Hu/2 over u = (along, across), seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Imprints {
    outer: f64,
    corner: f64,
    gradient: [f64; 2],
    /// H: along twice, along and across, across twice.
    hessian: [f64; 3],
    cos: f64,
}

impl Imprints {
    /// On a facet passed in the direction `e`. With tangents t over the two axes, H_ij = -t_i'K t_j / cos(S).
    pub(super) fn new(cutter: Cutter, facet: &FinishFacet, e: [f64; 2]) -> Self {
        let [x, y, z] = facet.normal;
        let gradient = [-(x * e[0] + y * e[1]) / z, (x * e[1] - y * e[0]) / z];
        let (along, across) = ([e[0], e[1], gradient[0]], [-e[1], e[0], gradient[1]]);
        let second = |t: [f64; 3], u: [f64; 3]| -facet.curvature_between(t, u) / z;
        let hessian = [second(along, along), second(along, across), second(across, across)];
        Self { outer: cutter.outer_radius().mm(), corner: cutter.corner_radius().mm(), gradient, hessian, cos: z }
    }

    /// The place along the pass, within a range around the facet's middle, at which passes `spacing` apart leave most,
    /// and the height there.
    ///
    /// Heights have a narrow peak where the pass runs level: the cutter then leaves the shape of its corner alone.
    pub(super) fn highest(&self, spacing: f64, [low, high]: [f64; 2]) -> (f64, f64) {
        let at = |along: f64| (along, self.height(spacing, along));
        let middle = at(0.0);
        if !self.run_level([low, high]) {
            return middle;
        }
        let level = -self.gradient[0] / self.hessian[0];
        let others = [low, high, level.clamp(low, high)].map(at);
        others.into_iter().fold(middle, |highest, place| if place.1 > highest.1 { place } else { highest })
    }

    /// Whether passes run level within twice this range around the facet's middle.
    pub(super) fn run_level(&self, [low, high]: [f64; 2]) -> bool {
        let level = -self.gradient[0] / self.hessian[0];
        level.abs() <= 2.0 * high.max(-low)
    }

    /// The height that passes in planes `spacing` apart leave half-way between their contacts at a place along them,
    /// along the normal, in mm; infinite where they do not meet.
    pub(super) fn height(&self, spacing: f64, place: f64) -> f64 {
        let planes = [-0.5 * spacing, 0.5 * spacing];
        self.height_between(planes, planes, place)
    }

    /// The largest height that passes in two planes leave over a part of the strip between them, at a place along them.
    /// `planes` and the ends of the part are coordinates across the passes, both in rising order.
    pub(super) fn height_between(&self, planes: [f64; 2], [low, high]: [f64; 2], place: f64) -> f64 {
        let passes = planes.map(|across| Pass::new(self, across, place));
        let left = |at: f64| {
            let lowest = passes.each_ref().map(|pass| self.lowest(pass, [place, at]));
            lowest[0].min(lowest[1]) - self.surface(place, at)
        };
        let interval = (high - low) / f64::from(PARTS);
        let coarse = (0..=PARTS).map(|number| low + interval * f64::from(number)).map(|at| (left(at), at));
        let (_, at) = coarse.fold((f64::NEG_INFINITY, low), |highest, place| if place.0 > highest.0 { place } else { highest });
        let ends = ((at - interval).max(low), (at + interval).min(high));
        -least(|at| -left(at), ends.0, ends.1, STEPS_ACROSS) * self.cos
    }

    /// The height down to which a pass cuts at a place; infinite beside the pass.
    fn lowest(&self, pass: &Pass, place: [f64; 2]) -> f64 {
        self.lowest_of(&pass.even, pass.across, place).min(self.lowest_of(&pass.turned, pass.across, place))
    }

    /// The same for the part of the pass between the neighbours of the lowest of these tips.
    fn lowest_of(&self, tips: &[Tip], across: f64, place: [f64; 2]) -> f64 {
        let cuts = tips.iter().map(|tip| self.cut(tip.at, place)).enumerate();
        let (index, cut) = cuts.fold((0, f64::INFINITY), |least, cut| if cut.1 < least.1 { cut } else { least });
        if !cut.is_finite() {
            return cut;
        }
        let along = tips[index].along;
        let ends = [index.saturating_sub(1), (index + 1).min(tips.len() - 1)].map(|index| tips[index].along);
        let tip = |along: f64| self.tip(along, across);
        if self.corner > 0.0 {
            return cut.min(least(|along| self.cut(tip(along), place), ends[0], ends[1], STEPS_ALONG));
        }
        // A sharp edge cuts at the height of its tip: the lowest one is where the edge meets the place, or where the pass
        // runs level.
        let beyond_edge = |along: f64| Self::squared_distance(tip(along), place) - self.squared_reach();
        let at_edges = ends.into_iter().filter(|&end| beyond_edge(end) > 0.0).map(|end| {
            let Ok(at) = bracketed_root(along, end, |along| Ok::<_, Infallible>(beyond_edge(along)));
            self.surface(at, across)
        });
        let level = self.level_at(across).clamp(ends[0], ends[1]);
        at_edges.fold(cut.min(self.cut(tip(level), place)), f64::min)
    }

    /// The place along a plane at which the pass in it runs level; infinite if it has the same climb everywhere.
    pub(super) fn level_at(&self, across: f64) -> f64 {
        let climb = self.gradient[0] + self.hessian[1] * across;
        if self.hessian[0] == 0.0 { f64::INFINITY } else { -climb / self.hessian[0] }
    }

    fn surface(&self, along: f64, across: f64) -> f64 {
        let ([g, h], [gg, gh, hh]) = (self.gradient, self.hessian);
        g * along + h * across + 0.5 * (gg * along * along + hh * across * across) + gh * along * across
    }

    /// The gradient at a place.
    fn rise(&self, along: f64, across: f64) -> [f64; 2] {
        let [gg, gh, hh] = self.hessian;
        [self.gradient[0] + gg * along + gh * across, self.gradient[1] + gh * along + hh * across]
    }

    /// The tip of the cutter that touches the paraboloid at a place.
    fn tip(&self, along: f64, across: f64) -> [f64; 3] {
        let rise = self.rise(along, across);
        let steepest = length(rise);
        let secant = length([steepest, 1.0]);
        // r n, and R - r further along the horizontal part of n.
        let out = self.corner / secant + if steepest > 0.0 { (self.outer - self.corner) / steepest } else { 0.0 };
        [along - out * rise[0], across - out * rise[1], self.surface(along, across) + self.corner * (secant.recip() - 1.0)]
    }

    /// The height down to which a tip cuts at a place; infinite beside the cutter.
    fn cut(&self, tip: [f64; 3], place: [f64; 2]) -> f64 {
        let squared = Self::squared_distance(tip, place);
        if squared > self.squared_reach() {
            return f64::INFINITY;
        }
        let over = (squared.sqrt() - (self.outer - self.corner)).clamp(0.0, self.corner);
        tip[2] + self.corner - (self.corner * self.corner - over * over).sqrt()
    }

    /// The squared distance from its tip up to which a cutter cuts, a rounding error more than R^2: the contact of a sharp
    /// edge is itself at this distance.
    fn squared_reach(&self) -> f64 {
        self.outer * self.outer * (1.0 + 1e-12)
    }

    /// The squared distance of a tip from a place, seen from above.
    fn squared_distance(tip: [f64; 3], place: [f64; 2]) -> f64 {
        let [along, across] = [place[0] - tip[0], place[1] - tip[1]];
        along * along + across * across
    }
}

/// A pass with some of its tips around a place, in their order.
struct Pass {
    across: f64,
    /// Tips whose contacts are at even distances.
    even: Vec<Tip>,
    /// Tips around the contact at which the pass runs level: there the steepest line turns by half a turn over a length
    /// that can be short, and the tip moves around the contact. Their steepest lines are at even angles.
    turned: Vec<Tip>,
}

/// A tip, and the coordinate of its contact along the pass.
struct Tip {
    along: f64,
    at: [f64; 3],
}

impl Pass {
    fn new(imprints: &Imprints, across: f64, place: f64) -> Self {
        let tip = |along: f64| Tip { along, at: imprints.tip(along, across) };
        let reach = 2.0 * imprints.outer;
        let even = (-TIPS..=TIPS).map(|number| place + f64::from(number) * reach / f64::from(TIPS)).map(tip).collect();
        let level = imprints.level_at(across);
        // Over this length from the level contact, the steepest line turns by 45 deg.
        let turn = imprints.rise(level, across)[1] / imprints.hessian[0];
        let angle = |number: i32| f64::from(number) * FRAC_PI_2 / f64::from(TURNED + 1);
        let turned = (-TURNED..=TURNED).map(|number| level + turn.abs() * angle(number).tan());
        let turned = turned.filter(|along| (along - place).abs() <= reach).map(tip).collect();
        Self { across, even, turned }
    }
}

/// The least value that the golden section finds of a function between two places.
fn least(f: impl Fn(f64) -> f64, low: f64, high: f64, steps: u32) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    let (mut low, mut high) = (low, high);
    let (mut one, mut other) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_one, mut at_other) = (f(one), f(other));
    let mut least = at_one.min(at_other);
    for _ in 0..steps {
        if at_one < at_other {
            (high, other, at_other) = (other, one, at_one);
            one = high - GOLDEN * (high - low);
            at_one = f(one);
            least = least.min(at_one);
        } else {
            (low, one, at_one) = (one, other, at_other);
            other = low + GOLDEN * (high - low);
            at_other = f(other);
            least = least.min(at_other);
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::Model;
    use crate::planning::zigzag::contacts::FacetContact;
    use crate::quantity::Length;

    fn facet(slope: f64, curvature: [f64; 6]) -> FinishFacet {
        let (sin, cos) = slope.to_radians().sin_cos();
        FinishFacet { corners: [[0.0; 3]; 3], normal: [sin, 0.0, cos], area: 1.0, curvature }
    }

    /// The height by the envelope.
    fn by_envelope(cutter: Cutter, facet: &FinishFacet, e: [f64; 2], spacing: f64) -> f64 {
        let contact = FacetContact::new(facet, e).unwrap();
        let step_over = Length::computed(contact.step_over(spacing));
        contact.evaluated(cutter, Model::Envelope).unwrap().scallop_height(step_over, None).unwrap().total().mm()
    }

    fn cutters() -> [Cutter; 4] {
        let mm = Length::computed;
        [
            Cutter::ball_end(mm(6.0)),
            Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(),
            Cutter::toroidal(mm(10.0), mm(0.5)).unwrap(),
            Cutter::flat_end(mm(6.0)),
        ]
    }

    #[test]
    fn on_a_plane_imprints_leave_the_height_of_the_envelope() {
        for cutter in cutters() {
            for (slope, direction) in [(5.0, 10.0_f64), (20.0, 60.0), (40.0, 0.0), (40.0, 35.0), (60.0, 80.0)] {
                let (sin, cos) = direction.to_radians().sin_cos();
                let plane = facet(slope, [0.0; 6]);
                for spacing in [0.1, 0.4] {
                    let model = by_envelope(cutter, &plane, [cos, sin], spacing);
                    let found = Imprints::new(cutter, &plane, [cos, sin]).height(spacing, 0.0);
                    // Across the strip the search ends within 0.013 of a third of it, which is 0.9 % of the peak's
                    // height; along the pass within 5e-4 of 0.8 mm, whose square over the corner's diameter is 1e-7 mm.
                    approx::assert_relative_eq!(found, model, max_relative = 0.01, epsilon = 1e-6);
                }
            }
        }
    }

    #[test]
    fn on_a_cylinder_across_the_slope_a_ball_leaves_the_height_of_the_envelope() {
        // Axis along y, radius 40 mm: K = (1/40) t t' with t the steepest line, on a slope of 30 deg.
        let (sin, cos) = 30.0_f64.to_radians().sin_cos();
        let t = [cos, 0.0, -sin];
        for sign in [1.0, -1.0] {
            let k = |i: usize, j: usize| sign * t[i] * t[j] / 40.0;
            let curved = facet(30.0, [k(0, 0), k(0, 1), k(0, 2), k(1, 1), k(1, 2), k(2, 2)]);
            for direction in [0.0_f64, 30.0, 90.0] {
                let (sin, cos) = direction.to_radians().sin_cos();
                let ball = Cutter::ball_end(Length::computed(6.0));
                let model = by_envelope(ball, &curved, [cos, sin], 0.4);
                let found = Imprints::new(ball, &curved, [cos, sin]).height(0.4, 0.0);
                // The third order of the paraboloid.
                approx::assert_relative_eq!(found, model, max_relative = 0.02);
            }
        }
    }

    /// Curved facets on a slope of 20 deg: convex, concave and twisted, with radii of 50 mm and more.
    fn curved() -> [FinishFacet; 3] {
        let (sin, cos) = 20.0_f64.to_radians().sin_cos();
        let (t, u) = ([cos, 0.0, -sin], [0.0, 1.0, 0.0]);
        [[0.01, 0.0, 0.02], [-0.008, 0.0, -0.005], [0.005, 0.01, -0.005]].map(|[steepest, twist, level]| {
            let k = |i: usize, j: usize| steepest * t[i] * t[j] + twist * (t[i] * u[j] + u[i] * t[j]) + level * u[i] * u[j];
            facet(20.0, [k(0, 0), k(0, 1), k(0, 2), k(1, 1), k(1, 2), k(2, 2)])
        })
    }

    #[test]
    fn heights_grow_with_the_spacing() {
        for cutter in cutters() {
            for facet in curved() {
                for direction in [0.0_f64, 50.0] {
                    let (sin, cos) = direction.to_radians().sin_cos();
                    let imprints = Imprints::new(cutter, &facet, [cos, sin]);
                    let heights: Vec<f64> = [0.1, 0.2, 0.3, 0.4].map(|spacing| imprints.height(spacing, 0.0)).to_vec();
                    assert!(heights[0] > 0.0 && heights.windows(2).all(|pair| pair[1] > pair[0]), "{heights:?}");
                }
            }
        }
    }

    #[test]
    fn the_parts_of_a_strip_have_the_height_of_the_whole() {
        for cutter in cutters() {
            for facet in curved() {
                let imprints = Imprints::new(cutter, &facet, [0.6, 0.8]);
                let planes = [-0.1, 0.2];
                let of = |part: [f64; 2]| imprints.height_between(planes, part, 0.05);
                let parts = [[-0.1, 0.0], [0.0, 0.1], [0.1, 0.2]].map(of);
                let most = parts.into_iter().fold(0.0, f64::max);
                // The search across a strip ends within 0.9 % of its highest point.
                approx::assert_relative_eq!(most, of(planes), max_relative = 0.01);
                assert!(parts.iter().any(|&part| part < 0.99 * most));
            }
        }
    }
}
