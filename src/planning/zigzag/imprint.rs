//! The height between two passes by the cutter's imprints alone, on the paraboloid that has a facet's slope and
//! curvature.
//!
//! The marks of a flat-end cutter are of the second order in model `envelope`: all have the normal of the stated
//! contact. Near the floor a small turn of the normal is a large turn of the steepest line, which moves the tip; here
//! each tip follows from the normal at its own contact.

use crate::milling::Cutter;
use crate::surface::FinishFacet;

/// The number of tips of a pass on each side of the place.
const TIPS: i32 = 24;

/// The number of parts into which the strip is divided before its highest place is refined.
const PARTS: u32 = 6;

/// Steps of the golden section across the strip, along a pass, and along a pass of a flat-end cutter, whose cut ends at
/// its edge: 0.618^9 = 0.013, 0.618^16 = 5e-4, 0.618^28 = 1.4e-6.
const STEPS_ACROSS: u32 = 9;
const STEPS_ALONG: u32 = 16;
const STEPS_OF_EDGE: u32 = 28;

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
        let step = 2.0 * self.outer / f64::from(TIPS);
        let steps = if self.corner > 0.0 { STEPS_ALONG } else { STEPS_OF_EDGE };
        let tips = planes.map(|across| {
            let along = (-TIPS..=TIPS).map(|number| place + f64::from(number) * step);
            (across, along.map(|along| (along, self.tip(along, across))).collect::<Vec<_>>())
        });
        let nearest = |at: f64| {
            tips.each_ref().map(|(across, tips)| {
                let cuts = tips.iter().map(|&(along, tip)| (self.cut(tip, [place, at]), along, *across));
                cuts.fold((f64::INFINITY, place, *across), |least, cut| if cut.0 < least.0 { cut } else { least })
            })
        };
        let left = |at: f64| {
            let lowest = nearest(at).map(|(cut, along, across)| {
                let exact = |along: f64| self.cut(self.tip(along, across), [place, at]);
                if cut.is_finite() { cut.min(least(exact, along - step, along + step, steps)) } else { cut }
            });
            lowest[0].min(lowest[1]) - self.surface(place, at)
        };
        let interval = (high - low) / f64::from(PARTS);
        let coarse = (0..=PARTS).map(|number| low + interval * f64::from(number)).map(|at| (left(at), at));
        let (_, at) = coarse.fold((f64::NEG_INFINITY, low), |highest, place| if place.0 > highest.0 { place } else { highest });
        let ends = ((at - interval).max(low), (at + interval).min(high));
        -least(|at| -left(at), ends.0, ends.1, STEPS_ACROSS) * self.cos
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

    /// The tip of the cutter that touches the paraboloid at a place.
    fn tip(&self, along: f64, across: f64) -> [f64; 3] {
        let [gg, gh, hh] = self.hessian;
        let rise = [self.gradient[0] + gg * along + gh * across, self.gradient[1] + gh * along + hh * across];
        let steepest = rise[0].hypot(rise[1]);
        let length = steepest.hypot(1.0);
        // r n, and R - r further along the horizontal part of n.
        let out = self.corner / length + if steepest > 0.0 { (self.outer - self.corner) / steepest } else { 0.0 };
        [along - out * rise[0], across - out * rise[1], self.surface(along, across) + self.corner * (length.recip() - 1.0)]
    }

    /// The height down to which a tip cuts at a place; infinite beside the cutter.
    fn cut(&self, [along, across, height]: [f64; 3], place: [f64; 2]) -> f64 {
        let distance = (place[0] - along).hypot(place[1] - across);
        if distance > self.outer {
            return f64::INFINITY;
        }
        let over = (distance - (self.outer - self.corner)).clamp(0.0, self.corner);
        height + self.corner - (self.corner * self.corner - over * over).sqrt()
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
                    // height; along the pass within 5e-4 of 0.8 mm, whose square over the corner's diameter is 1e-7 mm,
                    // at an edge within 1.4e-6 of 0.5 mm.
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
