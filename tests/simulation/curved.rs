//! Curved surfaces and runout: the model's height against a simulation that knows only the cutter's solid and the quadric surface. The tool axis is fixed, and every
//! tooth mark is placed by the surface's own normal there, so that the terms of the third order, which the model leaves out, are in the simulation.

use super::{Random, mm, wanted};
use scallopd::milling::{Contact, Cutter, JudgedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use std::num::NonZeroU32;

type Vector = [f64; 3];

fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sum(terms: &[(f64, Vector)]) -> Vector {
    std::array::from_fn(|i| terms.iter().map(|(factor, vector)| factor * vector[i]).sum())
}

/// A tooth's solid: the torus' major radius, its minor radius, and its height over the deepest tooth's.
#[derive(Debug, Clone, Copy)]
struct Tooth {
    core: f64,
    corner: f64,
    lift: f64,
}

/// Surface, feed and cutter; lengths in mm.
#[derive(Debug)]
struct Setup {
    teeth: Vec<Tooth>,
    frame: [Vector; 3],
    /// Along the feed, across it, twist.
    curvature: [f64; 3],
    feed: f64,
    step_over: f64,
}

impl Setup {
    fn surface(&self, x: f64, y: f64) -> Vector {
        let [f, t, ft] = self.curvature;
        let fall = (f * x * x + 2.0 * ft * x * y + t * y * y) / 2.0;
        sum(&[(x, self.frame[0]), (y, self.frame[1]), (-fall, self.frame[2])])
    }

    fn normal(&self, x: f64, y: f64) -> Vector {
        let [f, t, ft] = self.curvature;
        let normal = sum(&[(f * x + ft * y, self.frame[0]), (ft * x + t * y, self.frame[1]), (1.0, self.frame[2])]);
        let length = dot(normal, normal).sqrt();
        normal.map(|c| c / length)
    }

    /// The centre of the deepest tooth's torus when it touches the surface at (x, y).
    fn centre(&self, x: f64, y: f64) -> Vector {
        let (place, normal) = (self.surface(x, y), self.normal(x, y));
        let level = normal[0].hypot(normal[1]);
        let deepest = self.teeth[0];
        sum(&[(1.0, place), (deepest.corner, normal), (deepest.core / level, [normal[0], normal[1], 0.0])])
    }

    /// How far along `normal` from `place` the line enters the torus of a tooth whose deepest neighbour's centre is `centre`, from below; infinite where it does not.
    fn entry(tooth: Tooth, centre: Vector, place: Vector, normal: Vector) -> f64 {
        let from = sum(&[(1.0, place), (-1.0, centre), (-tooth.lift, [0.0, 0.0, 1.0])]);
        let mut along = -0.5 * tooth.corner;
        // Sphere tracing: the distance to the torus is how far the line can go without entering it.
        for _ in 0..400 {
            let [x, y, z] = sum(&[(1.0, from), (along, normal)]);
            let beyond = x.hypot(y) - tooth.core;
            let distance = if z > 0.0 {
                beyond - tooth.corner
            } else if beyond < 0.0 {
                -z - tooth.corner
            } else {
                beyond.hypot(z) - tooth.corner
            };
            if distance < 1e-9 {
                return along;
            }
            along += distance;
            if along > tooth.corner {
                return f64::INFINITY;
            }
        }
        along
    }

    /// The highest place that two neighbouring passes leave between them over a grid of places and phases; the second pass' teeth lag by every share of the pattern.
    fn highest(&self, along: u16, across: u16) -> f64 {
        let count = u16::try_from(self.teeth.len()).expect("a few teeth");
        let length = self.feed * f64::from(count);
        let places = along * count;
        let mut highest = 0.0_f64;
        for row in 0..=across {
            // The stated contact is half-way between the passes, where the slope is the mean of theirs.
            let y = self.step_over * (f64::from(row) / f64::from(across) - 0.5);
            let mut left = [Vec::new(), Vec::new()];
            for (pass, at) in [(0, -0.5 * self.step_over), (1, 0.5 * self.step_over)] {
                let mut deepest = 0_i32;
                left[pass] = (0..places)
                    .map(|cell| {
                        let x = length * (f64::from(cell) / f64::from(places) - 0.5);
                        let (place, normal) = (self.surface(x, y), self.normal(x, y));
                        let height = |tooth: i32| {
                            let solid = self.teeth[usize::try_from(tooth.rem_euclid(i32::from(count))).expect("a tooth")];
                            Self::entry(solid, self.centre(f64::from(tooth) * self.feed, at), place, normal)
                        };
                        let window = i32::from(count) + 1;
                        loop {
                            let best =
                                (deepest - window..=deepest + window).min_by(|a, b| height(*a).total_cmp(&height(*b))).expect("teeth");
                            if best == deepest || !height(best).is_finite() {
                                return height(deepest);
                            }
                            deepest = best;
                        }
                    })
                    .collect();
            }
            for lag in 0..places {
                for cell in 0..places {
                    let (first, second) = (left[0][usize::from(cell)], left[1][usize::from((cell + lag) % places)]);
                    highest = highest.max(first.min(second));
                }
            }
        }
        highest
    }
}

/// The model's height, lambda and the simulated height as a share of the model's.
struct Outcome {
    slope_deg: f64,
    lambda: f64,
    share: f64,
}

fn simulate(random: &mut Random, curved: bool, harsh: bool) -> Result<Outcome, NoAnswer> {
    let outer = random.within(2.0, 10.0);
    let corner = outer * random.within(0.1, 0.7);
    let (slope_deg, alpha_deg) = (random.within(5.0, 85.0), random.within(-180.0, 180.0));
    let contact = Contact::from_degrees(slope_deg, alpha_deg).unwrap();
    let (slope, theta) = (slope_deg.to_radians(), contact.theta().radians());
    let largest = (outer - corner) / slope.sin() + corner;
    let smallest_radius = if harsh { 12.0 } else { (3.0 * largest).max(20.0) };
    let mut principal = || if random.unit() < 0.5 { 1.0 } else { -1.0 } * random.unit() / smallest_radius;
    let principal = [principal(), principal()];
    let turn = random.within(0.0, 180.0);
    let surface = if curved {
        SurfaceCurvature::from_principal_per_mm(principal, scallopd::quantity::Angle::from_degrees(turn).unwrap()).unwrap()
    } else {
        SurfaceCurvature::PLANE
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 2 to 6")]
    let count = if curved { 1 } else { 2 + (random.unit() * 5.0) as u32 };
    let (radial, axial) = if curved { (0.0, 0.0) } else { (random.within(0.0, 0.008), random.within(-0.008, 0.008)) };
    let runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
    let cutter = Cutter::toroidal(mm(2.0 * outer), mm(corner)).unwrap();
    let judged = JudgedPass::new(Model::Envelope, Pass { cutter, contact, surface, runout, teeth: NonZeroU32::new(count) })?;
    let feed = random.within(0.05, 0.3);
    let target = 0.002 * 12.5_f64.powf(random.unit());
    let step_over = judged.max_step_over(mm(target), None)?;
    let height = judged.scallop_height(step_over, Some(mm(feed)))?.total().mm();
    let mut share = || random.unit();
    let teeth = (0..count)
        .map(|tooth| {
            let (less_radius, lift) = if tooth == 0 { (0.0, 0.0) } else { (share(), share()) };
            Tooth { core: outer + radial * (1.0 - less_radius) - corner, corner, lift: axial.abs() * lift }
        })
        .collect();
    let (u, v) = ([slope.cos(), 0.0, -slope.sin()], [0.0, 1.0, 0.0]);
    let frame = [sum(&[(theta.cos(), u), (theta.sin(), v)]), sum(&[(-theta.sin(), u), (theta.cos(), v)]), [slope.sin(), 0.0, slope.cos()]];
    let curvature = [surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()];
    let setup = Setup { teeth, frame, curvature, feed, step_over: step_over.mm() };
    let (along, across) = if curved { (16, 64) } else { (8, 32) };
    let share = setup.highest(along, across) / height;
    Ok(Outcome { slope_deg, lambda: judged.relative_curvature(), share })
}

fn outcomes(seed: u64, count: usize, curved: bool, harsh: bool) -> Vec<Outcome> {
    let mut random = Random(seed);
    let mut outcomes = Vec::new();
    while outcomes.len() < count {
        outcomes.extend(simulate(&mut random, curved, harsh));
    }
    outcomes
}

fn print(name: &str, outcomes: &mut [Outcome]) -> f64 {
    outcomes.sort_by(|a, b| a.share.total_cmp(&b.share));
    let (median, most) = (outcomes[outcomes.len() / 2].share, outcomes[outcomes.len() - 1].share);
    let over = outcomes.iter().filter(|outcome| outcome.share > 1.001).count();
    println!("{name}: {} configurations, median {median:.4}, largest {most:.4}, {over} over 1.001", outcomes.len());
    median
}

#[test]
fn heights_on_curved_surfaces_are_not_exceeded_and_are_reached() {
    let mut outcomes = outcomes(11, wanted(200), true, false);
    // Terms of the third order exceed 1 % in about one configuration of 400; docs/envelope-on-curved-surfaces.md has the figures.
    let over = outcomes.iter().filter(|outcome| outcome.slope_deg >= 10.0 && outcome.share > 1.01).count();
    assert!(100 * over <= outcomes.len(), "{over} of {} exceed the height by more than 1 %", outcomes.len());
    for outcome in &outcomes {
        assert!(outcome.share <= 1.045, "{} of the height at {} deg, lambda {}", outcome.share, outcome.slope_deg, outcome.lambda);
    }
    // The grid of 16 places along a mark and 64 across misses a percent or two of the peak.
    let median = print("curved", &mut outcomes);
    assert!(median >= 0.97, "median {median}");
}

#[test]
fn close_fits_are_simulated_for_the_record() {
    let mut near = Vec::new();
    let mut fair = Vec::new();
    for outcome in outcomes(12, wanted(40), true, true) {
        assert!(outcome.lambda > 0.0 && outcome.share.is_finite());
        if outcome.lambda < 0.6 { near.push(outcome) } else { fair.push(outcome) }
    }
    for (name, outcomes) in [("harsh, lambda over 0.6", &mut fair), ("harsh, lambda up to 0.6", &mut near)] {
        if !outcomes.is_empty() {
            print(name, outcomes);
        }
    }
}

#[test]
fn heights_with_runout_are_not_exceeded() {
    let mut outcomes = outcomes(13, wanted(40), false, false);
    for outcome in &outcomes {
        assert!(outcome.share <= 1.01, "{} of the height at {} deg", outcome.share, outcome.slope_deg);
    }
    print("runout, 2 to 6 teeth", &mut outcomes);
}
