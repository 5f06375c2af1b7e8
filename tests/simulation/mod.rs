//! Comparison of model `envelope` with a simulation of the cutter's solid: the simulated height never exceeds the
//! model's, and reaches it.
//!
//! The default run simulates a few hundred configurations of each kind. This command simulates more:
//!
//! ```sh
//! SCALLOPD_SIMULATIONS=5000 cargo test --release --test integration simulation -- --nocapture
//! ```

mod curved;
pub(crate) mod random;
mod solid;
pub(crate) mod swept;

use random::Random;
use scallopd::milling::{Contact, Cutter, Envelope, NoAnswer, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::{Angle, Length};
use solid::{Grid, Setup, Solid, highest_uncut};

impl Random {
    /// Either end of the range with a probability of a tenth each, otherwise a number between them.
    fn with_ends(&mut self, low: f64, high: f64) -> f64 {
        match self.unit() {
            u if u < 0.1 => low,
            u if u < 0.2 => high,
            _ => self.within(low, high),
        }
    }
}

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// A configuration, and the height that the model has for it.
#[derive(Debug)]
struct Case {
    setup: Setup,
    height: f64,
}

impl Case {
    /// Draws a configuration: slopes from 0 to 90 deg, all directions, r/R from 0 to 1, marks up to 0.4 mm apart,
    /// step-overs that leave 1 to 100 um.
    fn draw(random: &mut Random) -> Result<Self, NoAnswer> {
        let outer_radius = random.within(1.0, 10.0);
        let ratio = random.with_ends(0.0, 1.0);
        let (cutter, corner_radius) = if ratio <= 0.0 {
            (Cutter::flat_end(mm(2.0 * outer_radius)), 0.0)
        } else if ratio >= 1.0 {
            (Cutter::ball_end(mm(2.0 * outer_radius)), outer_radius)
        } else {
            (Cutter::toroidal(mm(2.0 * outer_radius), mm(ratio * outer_radius)).unwrap(), ratio * outer_radius)
        };
        Self::of(cutter, Solid::torus(outer_radius, corner_radius), 90.0, random)
    }

    /// Draws a tapered ball, a lens, an oval or a conical barrel, on a slope at which it has an arc.
    fn draw_of_other_shapes(random: &mut Random) -> Result<Self, NoAnswer> {
        let radius = random.within(1.0, 10.0);
        let (diameter, taper_deg) = (mm(2.0 * radius), random.within(2.0, 30.0));
        let taper = Angle::from_degrees(taper_deg).unwrap();
        let tip = random.within(0.1, 0.7) * radius;
        let side = random.within(1.2, 10.0) * radius / taper.cos();
        match random.unit() {
            u if u < 0.25 => {
                let shank = random.within(1.0, 3.0) * radius;
                let cutter = Cutter::tapered_ball(diameter, taper, mm(2.0 * shank)).unwrap();
                Self::of(cutter, Solid::tapered_ball(radius, taper.radians(), shank), 90.0 - taper_deg, random)
            }
            u if u < 0.5 => {
                Self::of(Cutter::lens(diameter, mm(side), mm(tip)).unwrap(), Solid::two_rounds(radius, side, tip, 0.0), 90.0, random)
            }
            u if u < 0.75 => {
                Self::of(Cutter::oval(diameter, mm(tip), mm(side)).unwrap(), Solid::two_rounds(radius, tip, side, 0.0), 90.0, random)
            }
            _ => {
                let cutter = Cutter::conical_barrel(diameter, mm(tip), mm(side), taper).unwrap();
                Self::of(cutter, Solid::two_rounds(radius, tip, side, taper.radians()), 90.0 - taper_deg, random)
            }
        }
    }

    fn of(cutter: Cutter, solid: Solid, steepest_deg: f64, random: &mut Random) -> Result<Self, NoAnswer> {
        let (slope_deg, alpha_deg) = (random.with_ends(0.0, steepest_deg), random.with_ends(0.0, 90.0));
        let contact = Contact::from_degrees(slope_deg, alpha_deg).unwrap();
        let envelope = Envelope::new(Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None })?;
        let left = 1e-3 * 100.0_f64.powf(random.unit());
        let step_over = match envelope.max_step_over(mm(left), None) {
            // Along a wall, no step-over leaves a height.
            Err(NoAnswer::ToleranceLimitsNoStepOver { .. }) => mm(random.within(0.1, 1.0)),
            step_over => step_over?,
        };
        let mark_spacing = random.within(1e-3, 0.4);
        let height = envelope.scallop_height(step_over, Some(mm(mark_spacing)))?.total().mm();
        let omega_deg = contact.omega().radians().to_degrees();
        Ok(Self { setup: Setup { solid, slope_deg, omega_deg, step_over: step_over.mm(), mark_spacing }, height })
    }

    /// The simulated height as a share of the model's height. If the model's height is 0, the share is 1 if the
    /// simulation leaves at most 1e-11 mm. The simulation resolves 1e-8 of the height, far below the 1e-6 of the
    /// assertion.
    fn reached(&self, grid: Grid) -> f64 {
        let resolution = (1e-8 * self.height).max(1e-11);
        let simulated = highest_uncut(self.setup, grid, 4.0 * self.setup.solid.outer_radius, resolution);
        if self.height > 0.0 { simulated / self.height } else { 1.0 + (simulated - resolution).max(0.0) }
    }
}

/// The number of configurations to simulate.
fn wanted(default: usize) -> usize {
    std::env::var("SCALLOPD_SIMULATIONS").map_or(default, |count| count.parse().expect("SCALLOPD_SIMULATIONS must be a count"))
}

#[test]
fn the_height_is_never_exceeded_and_is_reached() {
    let (median, without_answer) = simulated(Case::draw, 20_261_121);
    assert!(median >= 0.98, "the model's height is not reached: median {median}");
    assert!(without_answer <= 0.1, "{without_answer} of the configurations have no answer");
}

#[test]
fn heights_of_other_shapes_are_never_exceeded_and_are_reached() {
    let (median, without_answer) = simulated(Case::draw_of_other_shapes, 20_261_126);
    assert!(median >= 0.97, "the model's height is not reached: median {median}");
    // Slopes of 0, at which a lens has no flat, have answers; those at the very end of an arc may have none.
    assert!(without_answer <= 0.15, "{without_answer} of the configurations have no answer");
}

/// The median share of the model's height that simulations reach, and the share of configurations without an answer.
///
/// # Panics
///
/// Where a simulation leaves more than the model's height.
fn simulated(draw: fn(&mut Random) -> Result<Case, NoAnswer>, seed: u64) -> (f64, f64) {
    let wanted = wanted(240);
    let mut random = Random(seed);
    let (mut reached, mut without_answer) = (Vec::new(), 0);
    while reached.len() < wanted {
        let Ok(case) = draw(&mut random) else {
            without_answer += 1;
            continue;
        };
        let share = case.reached(Grid { along: 48, across: 160 });
        assert!(share <= 1.0 + 1e-6, "the simulation leaves {share} of the model's height in {case:?}");
        reached.push(share);
    }
    reached.sort_by(f64::total_cmp);
    let (least, median, most) = (reached[0], reached[wanted / 2], reached[wanted - 1]);
    println!(
        "{wanted} configurations: simulated height {least:.4} to {most:.8} of the model's, median {median:.4}; {without_answer} without answer"
    );
    #[expect(clippy::cast_precision_loss, reason = "hundreds")]
    let share = f64::from(without_answer) / wanted as f64;
    (median, share)
}
