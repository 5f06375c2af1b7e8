//! Comparison of plans with the cutter's solid on smooth surfaces: the height that two neighbouring passes leave
//! between them.

use super::surfaces::{Height, dot, facets, unit};
use super::{mm, ranked, settings};
use scallopd::milling::{Cutter, Model};
use scallopd::planning::zigzag::{CandidateCutter, passes};

/// z and its derivatives x, y, xx, xy, yy of a surface that is convex, concave and twisted, with slopes up to 35 deg.
fn waves(x: f64, y: f64) -> [f64; 6] {
    let (a, p, q) = (9.0, 32.0, 41.0);
    let ((sx, cx), (sy, cy)) = ((x / p).sin_cos(), (y / q).sin_cos());
    [
        a * sx * cy + 0.25 * x,
        a * cx * cy / p + 0.25,
        -a * sx * sy / q,
        -a * sx * cy / (p * p),
        -a * cx * sy / (p * q),
        -a * sx * cy / (q * q),
    ]
}

/// A cutter as a solid over its tip.
#[derive(Clone, Copy)]
struct Solid {
    outer: f64,
    corner: f64,
}

impl Solid {
    /// The tip of the cutter in contact with the surface over (x, y).
    fn tip(self, x: f64, y: f64) -> [f64; 3] {
        let [z, zx, zy, ..] = waves(x, y);
        let n = unit([-zx, -zy, 1.0]);
        let horizontal = n[0].hypot(n[1]);
        let out = self.corner + if horizontal > 0.0 { (self.outer - self.corner) / horizontal } else { 0.0 };
        [x + out * n[0], y + out * n[1], z + self.corner * (n[2] - 1.0)]
    }

    /// The distance from `from` along `n` to the solid with its tip at `tip`, up to `most`. Bisection suffices, because
    /// a ray up enters the solid once.
    fn height(self, tip: [f64; 3], from: [f64; 3], n: [f64; 3], most: f64) -> f64 {
        let inside = |t: f64| {
            let p = [0, 1, 2].map(|axis| from[axis] + t * n[axis] - tip[axis]);
            let beyond = (p[0].hypot(p[1]) - (self.outer - self.corner)).max(0.0);
            beyond <= self.corner && p[2] >= self.corner - (self.corner * self.corner - beyond * beyond).sqrt()
        };
        if !inside(most) {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..18 {
            let middle = 0.5 * (low + high);
            if inside(middle) { high = middle } else { low = middle }
        }
        high
    }
}

#[test]
fn scallops_between_imprints_keep_the_tolerance_and_use_it() {
    let tolerance = 0.01;
    let patch = Height { low: [0.0, 0.0], high: [60.0, 50.0], surface: waves };
    let facets = facets(&patch, 80, 70);
    let settings = settings(Model::Envelope);
    for (cutter, outer, corner) in [(Cutter::toroidal(mm(10.0), mm(1.5)).unwrap(), 5.0, 1.5), (Cutter::ball_end(mm(8.0)), 4.0, 4.0)] {
        let (solid, candidate) = (Solid { outer, corner }, CandidateCutter::new(cutter));
        let plan = ranked(&facets, &[candidate], &settings).plans.remove(0);
        let points = passes(&plan, &facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
        let (e, q) = ([plan.direction.cos(), plan.direction.sin()], [-plan.direction.sin(), plan.direction.cos()]);
        let mut planes: Vec<f64> = points.points.iter().filter_map(|point| point.contact).map(|c| q[0] * c[0] + q[1] * c[1]).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
        let place = |along: f64, across: f64| [along * e[0] + across * q[0], along * e[1] + across * q[1]];
        let is_inside = |[x, y]: [f64; 2]| (1.0..59.0).contains(&x) && (1.0..49.0).contains(&y);
        let (mut heights, mut tight, mut strips) = (Vec::new(), 0, 0);
        let mut state: u64 = 5;
        // Knuth's multiplier.
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            f64::from(u32::try_from(state >> 32).unwrap()) / f64::from(u32::MAX)
        };
        for pair in planes.windows(2).step_by(3) {
            let mut highest: f64 = 0.0;
            let mut places = 0;
            for _ in 0..40 {
                // A random coordinate along the pass, within the largest extent of the patch.
                let along = -80.0 + 160.0 * random();
                if !(is_inside(place(along, pair[0])) && is_inside(place(along, pair[1]))) {
                    continue;
                }
                places += 1;
                // The tips near the point, every 0.02 mm; between them 0.02^2/8/1.5 mm = 0.03 um are left.
                let tips: Vec<[f64; 3]> = (-75..=75)
                    .flat_map(|mark| pair.iter().map(move |&across| (along + 0.02 * f64::from(mark), across)))
                    .map(|(along, across)| place(along, across))
                    .map(|[x, y]| solid.tip(x, y))
                    .collect();
                let left = |share: f64| {
                    let [x, y] = place(along, pair[0] + share * (pair[1] - pair[0]));
                    let [z, zx, zy, ..] = waves(x, y);
                    let n = unit([-zx, -zy, 1.0]);
                    assert!(dot(n, [0.0, 0.0, 1.0]) > 0.7);
                    tips.iter().fold(3.0 * tolerance, |most, &tip| solid.height(tip, [x, y, z], n, most))
                };
                let ridge = (0..=20).map(|step| left(0.3 + 0.02 * f64::from(step))).fold(0.0, f64::max);
                heights.push(ridge);
                highest = highest.max(ridge);
            }
            if places >= 5 {
                strips += 1;
                tight += usize::from(highest >= 0.9 * tolerance);
            }
        }
        heights.sort_by(f64::total_cmp);
        let at = |share: f64| {
            #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "hundreds")]
            let index = ((heights.len() as f64 * share) as usize).min(heights.len() - 1);
            heights[index]
        };
        println!("{} places: median {:.5}, 99.9 % {:.5} mm; {tight} of {strips} strips tight", heights.len(), at(0.5), at(0.999));
        assert!(heights.len() > 200 && strips > 10);
        assert!(at(0.999) <= 1.03 * tolerance, "{}", at(0.999));
        assert!(10 * tight >= 9 * strips, "{tight} of {strips}");
    }
}
