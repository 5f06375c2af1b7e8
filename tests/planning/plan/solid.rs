//! Plans against the cutter's solid on smooth surfaces: the material that neighbouring passes leave between them.

use super::surfaces::{Height, facets, unit};
use super::{mm, ranked, settings};
use scallopd::milling::{Cutter, Model};
use scallopd::planning::zigzag::{CandidateCutter, passes};
use scallopd::surface::FinishFacet;

/// z and its derivatives x, y, xx, xy, yy.
type Function = fn(f64, f64) -> [f64; 6];

/// The tolerance of all plans, in mm.
const TOLERANCE: f64 = 0.01;

/// A slope that is level in no direction.
fn plane(x: f64, y: f64) -> [f64; 6] {
    [0.3 * x + 0.1 * y, 0.3, 0.1, 0.0, 0.0, 0.0]
}

/// Waves that are convex, concave and twisted, with a level saddle and level tops.
fn waves(x: f64, y: f64) -> [f64; 6] {
    let (a, p, q) = (6.0, 18.0, 22.0);
    let ((sx, cx), (sy, cy)) = ((x / p).sin_cos(), (y / q).sin_cos());
    [
        a * sx * cy + 0.15 * x + 0.004 * y * y,
        a * cx * cy / p + 0.15,
        -a * sx * sy / q + 0.008 * y,
        -a * sx * cy / (p * p),
        -a * cx * sy / (p * q),
        -a * sx * cy / (q * q) + 0.008,
    ]
}

/// A dome, level in its middle, with slopes up to 30 deg.
fn dome(x: f64, y: f64) -> [f64; 6] {
    let (u, v) = (x - 30.0, y - 22.0);
    [-u * u / 150.0 - v * v / 110.0, -u / 75.0, -v / 55.0, -1.0 / 75.0, 0.0, -1.0 / 55.0]
}

/// A saddle, level in its middle, with slopes up to 22 deg.
fn saddle(x: f64, y: f64) -> [f64; 6] {
    let (u, v) = (x - 30.0, y - 22.0);
    [u * u / 200.0 - v * v / 160.0 + 0.004 * u * v, u / 100.0 + 0.004 * v, -v / 80.0 + 0.004 * u, 0.01, 0.004, -1.0 / 80.0]
}

const SURFACES: [(&str, Function); 4] = [("plane", plane), ("waves", waves), ("dome", dome), ("saddle", saddle)];

/// The surfaces cover the rectangle from 0 to this corner.
const SIZE: [f64; 2] = [60.0, 44.0];

/// A cutter as a solid over its tip.
#[derive(Debug, Clone, Copy)]
struct Solid {
    outer: f64,
    corner: f64,
}

impl Solid {
    fn of(cutter: Cutter) -> Self {
        Self { outer: cutter.outer_radius().mm(), corner: cutter.corner_radius().mm() }
    }

    /// The height of the bottom over the tip at a distance from the axis; infinite beside the cutter.
    fn bottom(self, distance: f64) -> f64 {
        if distance > self.outer {
            return f64::INFINITY;
        }
        let over = (distance - (self.outer - self.corner)).max(0.0).min(self.corner);
        self.corner - (self.corner * self.corner - over * over).sqrt()
    }

    /// The tip of the cutter in contact with the surface over (x, y).
    fn tip(self, surface: Function, x: f64, y: f64) -> [f64; 3] {
        let [z, zx, zy, ..] = surface(x, y);
        let n = unit([-zx, -zy, 1.0]);
        let horizontal = n[0].hypot(n[1]);
        let out = self.corner + if horizontal > 0.0 { (self.outer - self.corner) / horizontal } else { 0.0 };
        [x + out * n[0], y + out * n[1], z + self.corner * (n[2] - 1.0)]
    }

    /// Whether the cutter in contact over (x, y) cuts into the surface elsewhere by more than `depth`.
    fn gouges(self, surface: Function, x: f64, y: f64, depth: f64) -> bool {
        let tip = self.tip(surface, x, y);
        (1..=12).any(|ring| {
            let d = self.outer * (f64::from(ring) / 12.0);
            (0..24).any(|step| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(step) / 24.0).sin_cos();
                let z = surface(tip[0] + d * cos, tip[1] + d * sin)[0];
                z - tip[2] - self.bottom(d) > depth
            })
        })
    }
}

/// The passes of a plan on a smooth surface: planes at rising coordinates, and tips along them.
struct Milled {
    solid: Solid,
    surface: Function,
    e: [f64; 2],
    planes: Vec<f64>,
    /// For each plane the coordinate of the first contact along it, and the tips.
    traces: Vec<(f64, Vec<[f64; 3]>)>,
}

/// The distance of contacts along a pass between which tips are interpolated by their own contacts.
const STEP: f64 = 0.1;

impl Milled {
    fn new(cutter: Cutter, surface: Function, e: [f64; 2], planes: Vec<f64>) -> Self {
        let solid = Solid::of(cutter);
        let mut milled = Self { solid, surface, e, planes, traces: Vec::new() };
        milled.traces = milled.planes.iter().map(|&at| milled.trace(at)).collect();
        milled
    }

    fn place(&self, along: f64, across: f64) -> [f64; 2] {
        [along * self.e[0] - across * self.e[1], along * self.e[1] + across * self.e[0]]
    }

    fn trace(&self, across: f64) -> (f64, Vec<[f64; 3]>) {
        // Passes go on beyond the border, so that heights at it are those of the spacing.
        let beyond = -2.0 * self.solid.outer;
        let all = (-900..=900).map(|step| STEP * f64::from(step)).filter(|&along| is_inside(self.place(along, across), beyond));
        let contacts: Vec<f64> = all.collect();
        (contacts.first().copied().unwrap_or(0.0), contacts.iter().map(|&along| self.tip(along, across)).collect())
    }

    fn tip(&self, along: f64, across: f64) -> [f64; 3] {
        let [x, y] = self.place(along, across);
        self.solid.tip(self.surface, x, y)
    }

    /// The height over (x, y) up to which the cutter with its tip here removes the material.
    fn cut(&self, tip: [f64; 3], [x, y]: [f64; 2]) -> f64 {
        tip[2] + self.solid.bottom((tip[0] - x).hypot(tip[1] - y))
    }

    /// The height left over the surface at a place, along the normal, by the passes around the strip: two on each side.
    fn left(&self, strip: usize, along: f64, across: f64) -> f64 {
        let place = self.place(along, across);
        let around = strip.saturating_sub(1)..(strip + 3).min(self.planes.len());
        let lowest = around.map(|plane| self.lowest_cut(plane, along, place)).fold(f64::INFINITY, f64::min);
        let [z, zx, zy, ..] = (self.surface)(place[0], place[1]);
        // Of a point over the surface the distance is its height times cos S, up to the square of that height.
        (lowest - z) / zx.hypot(zy).hypot(1.0)
    }

    /// The least height to which one pass cuts at a place: among the tips, and between the best one and its neighbours.
    fn lowest_cut(&self, plane: usize, along: f64, place: [f64; 2]) -> f64 {
        let (first, tips) = &self.traces[plane];
        let at = self.planes[plane];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "thousands of tips")]
        let index = |along: f64| (((along - first) / STEP).max(0.0) as usize).min(tips.len());
        let reach = 2.0 * self.solid.outer + STEP;
        let range = index(along - reach)..index(along + reach);
        let exact = |contact: f64| self.cut(self.tip(contact, at), place);
        #[expect(clippy::cast_precision_loss, reason = "thousands of tips")]
        let contact = |index: usize| first + STEP * index as f64;
        let (mut best, mut lowest) = (None, f64::INFINITY);
        for index in range.clone() {
            let cut = self.cut(tips[index], place);
            if cut < lowest {
                (best, lowest) = (Some(index), cut);
            }
        }
        if self.solid.corner > 0.0 {
            return best.map_or(lowest, |best| lowest.min(least(exact, contact(best) - STEP, contact(best) + STEP)));
        }
        // The flat ends at a circle: the tips at which the circle passes over the place count as well.
        for index in range.skip(1) {
            let pair = [tips[index - 1], tips[index]];
            let is_in = pair.map(|tip| self.cut(tip, place).is_finite());
            if is_in[0] != is_in[1] && pair[0][2].min(pair[1][2]) < lowest {
                let [mut inside, mut outside] = if is_in[0] { [index - 1, index] } else { [index, index - 1] }.map(contact);
                for _ in 0..20 {
                    let middle = f64::midpoint(inside, outside);
                    if exact(middle).is_finite() { inside = middle } else { outside = middle }
                }
                lowest = lowest.min(exact(inside));
            }
        }
        lowest
    }

    /// The largest height of a strip: among the places, and every 0.05 mm around the highest of them, because heights
    /// have narrow peaks where passes run level.
    fn highest(&self, strip: usize, places: &[f64], is_open: impl Fn(f64) -> bool) -> f64 {
        let heights = places.iter().map(|&along| (self.ridge(strip, along), along));
        let (highest, at) = heights.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        let around = (-10..=10).map(|step| at + 0.05 * f64::from(step)).filter(|&along| is_open(along));
        around.map(|along| self.ridge(strip, along)).fold(highest, f64::max)
    }

    /// The height of the highest point left in a strip at a place along it.
    fn ridge(&self, strip: usize, along: f64) -> f64 {
        let (low, high) = (self.planes[strip], self.planes[strip + 1]);
        let at = |share: f64| low + share * (high - low);
        let coarse = (0..=20).map(|step| 0.05 * f64::from(step)).map(|share| (self.left(strip, along, at(share)), share));
        let (_, share) = coarse.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
        -least(|share| -self.left(strip, along, at(share)), (share - 0.05).max(0.0), (share + 0.05).min(1.0))
    }
}

/// The least value of a function with one minimum between `low` and `high`, by the golden section.
fn least(f: impl Fn(f64) -> f64, low: f64, high: f64) -> f64 {
    let golden = 0.618_033_988_749_895;
    let (mut low, mut high) = (low, high);
    let (mut a, mut b) = (high - golden * (high - low), low + golden * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..14 {
        if at_a < at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - golden * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + golden * (high - low);
            at_b = f(b);
        }
    }
    at_a.min(at_b)
}

fn is_inside([x, y]: [f64; 2], margin: f64) -> bool {
    (margin..=SIZE[0] - margin).contains(&x) && (margin..=SIZE[1] - margin).contains(&y)
}

/// Pseudo-random numbers from 0 to 1, by Knuth's multiplier.
fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    f64::from(u32::try_from(*state >> 32).unwrap()) / f64::from(u32::MAX)
}

/// What a plan leaves on a surface, by its solid.
struct Figures {
    /// The heights at random places, in rising order.
    heights: Vec<f64>,
    /// The random places at which the cutter gouges the surface beside its contact, so that it leaves no scallop.
    gouging: usize,
    /// The strips, and those of them in which some place reaches 0.9 of the tolerance.
    strips: usize,
    tight: usize,
}

impl Figures {
    fn percentile(&self, share: f64) -> f64 {
        #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "thousands")]
        let index = ((self.heights.len() as f64 * share) as usize).min(self.heights.len() - 1);
        self.heights[index]
    }
}

/// Plans a cutter on a surface and mills it, with heights at `count` places.
fn milled(cutter: Cutter, surface: Function, facets: &[FinishFacet], count: usize) -> Figures {
    let (settings, candidate) = (settings(Model::Envelope), CandidateCutter::new(cutter));
    let plan = ranked(facets, &[candidate], &settings).plans.remove(0);
    let points = passes(&plan, facets, &candidate, &settings, &|tip| tip[2], 200_000).unwrap();
    let e = [plan.direction.cos(), plan.direction.sin()];
    let mut planes: Vec<f64> = points.points.iter().filter_map(|point| point.contact).map(|c| e[0] * c[1] - e[1] * c[0]).collect();
    planes.sort_by(f64::total_cmp);
    planes.dedup_by(|a, b| (*a - *b).abs() < 1e-6);
    let milled = Milled::new(cutter, surface, e, planes);
    let mut figures = Figures { heights: Vec::new(), gouging: 0, strips: 0, tight: 0 };
    let is_open = |strip: usize, along: f64| {
        strip + 1 < milled.planes.len() && [0, 1].iter().all(|side| is_inside(milled.place(along, milled.planes[strip + side]), 0.0))
    };
    let gouges = |along: f64, across: f64| {
        let [x, y] = milled.place(along, across);
        milled.solid.gouges(surface, x, y, 0.1 * TOLERANCE)
    };
    let mut state = 5;
    while figures.heights.len() + figures.gouging < count {
        let [x, y] = [SIZE[0] * random(&mut state), SIZE[1] * random(&mut state)];
        let (along, across) = (e[0] * x + e[1] * y, e[0] * y - e[1] * x);
        let strip = milled.planes.partition_point(|&at| at <= across).saturating_sub(1);
        if !is_open(strip, along) {
            continue;
        }
        if gouges(along, milled.planes[strip]) || gouges(along, milled.planes[strip + 1]) {
            figures.gouging += 1;
            continue;
        }
        let height = milled.ridge(strip, along);
        figures.heights.push(height);
    }
    let every = milled.planes.len().div_ceil(STRIPS).max(1);
    for strip in (0..milled.planes.len()).step_by(every) {
        let places: Vec<f64> = (-180..=180).map(|step| 0.5 * f64::from(step)).filter(|&along| is_open(strip, along)).collect();
        if places.len() < 20 {
            continue;
        }
        figures.strips += 1;
        figures.tight += usize::from(milled.highest(strip, &places, |along| is_open(strip, along)) >= 0.9 * TOLERANCE);
    }
    figures.heights.sort_by(f64::total_cmp);
    figures
}

/// The most strips of a plan that are examined for places near the tolerance.
const STRIPS: usize = 20;

/// Plans for one cutter on all surfaces keep the tolerance; the share of strips in which some place reaches 0.9 of it
/// is at least `tight`.
///
/// The count of random places is 400 on each surface; `SCALLOPD_PLACES` changes it.
fn keeps_and_uses_the_tolerance(cutter: Cutter, tight: f64) {
    let count = std::env::var("SCALLOPD_PLACES").ok().and_then(|count| count.parse().ok()).unwrap_or(400);
    let (mut strips, mut tight_strips) = (0, 0);
    for (name, surface) in SURFACES {
        let facets = facets(&Height { low: [0.0, 0.0], high: SIZE, surface }, 100, 74);
        let figures = milled(cutter, surface, &facets, count);
        let [median, most] = [0.5, 0.999].map(|share| figures.percentile(share) / TOLERANCE);
        println!(
            "{name}: median {median:.3}, 99.9 % {most:.3}; {} of {} strips; {} of {count} places gouge",
            figures.tight, figures.strips, figures.gouging
        );
        assert!(most <= 1.03, "{name}: {most}");
        assert!(30 * figures.gouging <= count, "{name}: {}", figures.gouging);
        strips += figures.strips;
        tight_strips += figures.tight;
    }
    #[expect(clippy::cast_precision_loss, reason = "dozens")]
    let share = tight_strips as f64 / strips as f64;
    assert!(share >= tight, "{tight_strips} of {strips}");
}

#[test]
fn scallops_of_a_ball_keep_the_tolerance_and_use_it() {
    keeps_and_uses_the_tolerance(Cutter::ball_end(mm(8.0)), 0.9);
}

#[test]
fn scallops_of_a_bull_nose_keep_the_tolerance_and_use_it() {
    keeps_and_uses_the_tolerance(Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), 0.9);
}

#[test]
fn scallops_of_a_sharp_bull_nose_keep_the_tolerance_and_use_it() {
    keeps_and_uses_the_tolerance(Cutter::toroidal(mm(10.0), mm(0.5)).unwrap(), 0.9);
}

#[test]
fn scallops_of_a_flat_end_keep_the_tolerance_and_use_it() {
    keeps_and_uses_the_tolerance(Cutter::flat_end(mm(6.0)), 0.9);
}
