//! Draws random contacts from the whole domain of model `envelope` and measures the processor time of each calculation.
//! For each group of inputs it prints the median, the 99th percentile, the longest time, the share over 1 ms, and the
//! input that takes longest.
//!
//! ```sh
//! cargo run --release --example slowest_contacts -- 1000000
//! ```
//!
//! The optional second argument is the seed. Inputs without an answer count too, because a refusal must also be fast.

#[path = "../tests/simulation/random.rs"]
mod random;
mod thread_time;

use random::Random;
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::{Angle, Length};
use std::hint::black_box;
use std::num::NonZeroU32;
use thread_time::now_us;

impl Random {
    fn logarithmic(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.unit())
    }

    /// An angle from 0 to 90 deg: one of the ends, near one of the ends, or any between.
    fn quarter_turn(&mut self) -> f64 {
        match self.unit() {
            u if u < 0.05 => 0.0,
            u if u < 0.1 => 90.0,
            u if u < 0.2 => self.logarithmic(1e-14, 5.0),
            u if u < 0.3 => 90.0 - self.logarithmic(1e-14, 5.0),
            _ => self.within(0.0, 90.0),
        }
    }
}

fn mm(value: f64) -> Length {
    Length::from_mm(value.clamp(Length::SMALLEST, Length::LARGEST)).expect("a length in its bounds")
}

/// A pass, a step-over, a feed per tooth if there is one, and a tolerance.
#[derive(Debug, Clone, Copy)]
struct Input {
    pass: Pass,
    step_over: Length,
    feed: Option<Length>,
    tolerance: Length,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Surface {
    Plane,
    Convex,
    Concave,
}

const SURFACES: [(Surface, &str); 3] =
    [(Surface::Plane, "plane"), (Surface::Convex, "convex"), (Surface::Concave, "concave or saddle, lambda from 0.25")];

impl Input {
    /// Nine of ten sizes are those of real cutters, the others any valid length.
    fn draw(random: &mut Random, surface: Surface, runs_out: bool) -> Self {
        loop {
            let outer = if random.unit() < 0.9 { random.within(0.25, 25.0) } else { random.logarithmic(1e-5, 1e5) };
            let cutter = match random.unit() {
                u if u < 0.15 => Cutter::flat_end(mm(2.0 * outer)),
                u if u < 0.3 => Cutter::ball_end(mm(2.0 * outer)),
                u => {
                    let ratio = if u < 0.9 { random.within(0.02, 0.98) } else { random.logarithmic(1e-4, 1.0) };
                    match Cutter::toroidal(mm(2.0 * outer), mm(ratio * outer)) {
                        Ok(cutter) => cutter,
                        Err(_) => continue,
                    }
                }
            };
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            let contact = Contact::from_degrees(random.quarter_turn(), sign * random.quarter_turn()).expect("a contact");
            let curvature = match surface {
                Surface::Plane => SurfaceCurvature::PLANE,
                Surface::Convex | Surface::Concave => {
                    let mut bend = || {
                        let size = random.logarithmic(1e-4, 1.0) / outer;
                        if surface == Surface::Concave && random.unit() < 0.7 { -size } else { size }
                    };
                    let principal = [bend(), bend()];
                    let turn = Angle::from_degrees(random.within(0.0, 180.0)).expect("an angle");
                    SurfaceCurvature::from_principal_per_mm(principal, turn).expect("curvatures in their bounds")
                }
            };
            if surface == Surface::Concave && curvature.principal_per_mm()[1] >= 0.0 {
                continue;
            }
            let runout = if runs_out {
                let largest = outer.min(Runout::LARGEST);
                let size = random.logarithmic(1e-6, 1e-2) * largest;
                let (radial, axial) = (random.unit() * size, random.within(-1.0, 1.0) * size);
                Runout::NONE.with_radial_mm(radial).and_then(|runout| runout.with_axial_mm(axial)).expect("a runout in its bounds")
            } else {
                Runout::NONE
            };
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 2 to 6")]
            let teeth = NonZeroU32::new(2 + (random.unit() * 5.0) as u32);
            let pass = Pass { cutter, contact, surface: curvature, runout, teeth };
            // The search is over contacts that the cutter fits; those that it gouges are refused by a closed form and a grid.
            match EvaluatedPass::new(Model::Envelope, pass) {
                Ok(evaluated) if evaluated.relative_curvature() >= 0.25 => {}
                _ => continue,
            }
            let step_over = mm(random.logarithmic(1e-3, 1.5) * outer);
            let feed = (random.unit() < 0.8).then(|| mm(random.logarithmic(1e-3, 0.5) * outer));
            let tolerance = mm(random.logarithmic(1e-5, 0.1) * outer);
            return Self { pass, step_over, feed, tolerance };
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Calculation {
    Height,
    LargestFeed,
    LargestStepOver,
}

const CALCULATIONS: [(Calculation, &str); 3] =
    [(Calculation::Height, "height"), (Calculation::LargestFeed, "largest feed"), (Calculation::LargestStepOver, "largest step-over")];

/// Processor time in us.
fn time(calculation: Calculation, input: &Input) -> f64 {
    let began = now_us();
    let Input { pass, step_over, feed, tolerance } = *black_box(input);
    if let Ok(evaluated) = EvaluatedPass::new(Model::Envelope, pass) {
        match calculation {
            Calculation::Height => drop(black_box(evaluated.scallop_height(step_over, feed))),
            Calculation::LargestFeed => drop(black_box(evaluated.max_feed_per_tooth(tolerance, step_over))),
            Calculation::LargestStepOver => drop(black_box(evaluated.max_step_over(tolerance, feed))),
        }
    }
    now_us() - began
}

/// A time above this is measured again, because interrupts count as processor time of the interrupted thread.
const DOUBTFUL_US: f64 = 50.0;

fn main() {
    let argument = |n: usize, default: u64| std::env::args().nth(n).map_or(default, |text| text.parse().expect("a whole number"));
    let (wanted, seed) = (argument(1, 20_000), argument(2, 1));
    println!("{wanted} random inputs in each row, seed {seed}; processor time in us, that of reading the clock (about 0.3) included\n");
    println!("| surface | runout | calculation | median | p99 | worst | over 1 ms |");
    println!("|---|---|---|---|---|---|---|");
    let mut worst_inputs = Vec::new();
    for (surface, surface_name) in SURFACES {
        for (runs_out, runout_name) in [(false, "none"), (true, "2 to 6 teeth")] {
            for (calculation, name) in CALCULATIONS {
                let mut random = Random(seed);
                let mut times = Vec::new();
                let mut worst = None;
                for _ in 0..wanted {
                    let input = Input::draw(&mut random, surface, runs_out);
                    let mut least = time(calculation, &input);
                    if least > DOUBTFUL_US {
                        least = (0..3).map(|_| time(calculation, &input)).fold(least, f64::min);
                    }
                    if worst.as_ref().is_none_or(|(longest, _)| least > *longest) {
                        worst = Some((least, input));
                    }
                    times.push(least);
                }
                times.sort_by(f64::total_cmp);
                let Some((longest, input)) = worst else { continue };
                #[expect(clippy::cast_precision_loss, reason = "counts are far under 2^53")]
                let slow = 100.0 * times.iter().rev().take_while(|time| **time > 1000.0).count() as f64 / times.len() as f64;
                let (median, p99) = (times[times.len() / 2], times[times.len() - 1 - times.len() / 100]);
                println!("| {surface_name} | {runout_name} | {name} | {median:.1} | {p99:.1} | {longest:.0} | {slow:.2} % |");
                worst_inputs.push(format!("{surface_name}, runout {runout_name}, {name}: {longest:.0} us\n    {input:?}"));
            }
        }
    }
    println!("\nThe slowest inputs:\n\n{}", worst_inputs.join("\n"));
}
