//! Writes the tables of `docs/analytic-shortfall.md`: the excess of a simulated cutter's scallop over the analytic
//! model's height.
//!
//! ```sh
//! cargo run --release --example analytic_shortfall > docs/analytic-shortfall.md
//! ```

#[allow(dead_code, reason = "the tests simulate more shapes")]
#[path = "../tests/simulation/solid.rs"]
mod solid;

use scallopd::milling::{Analytic, Contact, Cutter, Envelope, NoAnswer, Pass, Runout, ScallopHeight, SurfaceCurvature};
use scallopd::quantity::Length;
use solid::{Grid, Setup, Solid, highest_uncut};
use std::fmt::Write;

const OUTER_RADIUS: f64 = 5.0;
const CORNER_RADIUS: f64 = 2.0;
/// The analytic height of the step-over, in mm.
const STEP_OVER_HEIGHT: f64 = 0.01;
const FEEDS: [f64; 2] = [0.1, 0.3];
const SLOPES: [f64; 13] = [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0];
const ALPHAS: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 90.0];

const INTRODUCTION: &str = "\
# Where the analytic model falls short

The analytic model replaces the cutter by circles of its effective radii. This page compares it with a simulation that uses only the
cutter's solid: the teeth cut an inclined plane pass beside pass, with every phase between the teeth of neighbouring passes in
steps, and the highest remaining point is measured along the surface's normal. A positive figure is the excess of the simulated
scallop height over the analytic one; where the figure is negative, the cutter leaves less than the analytic height.

Toroidal cutter, R = 5 mm, r = 2 mm. Each step-over is the one at which the analytic model has h1 = 10 um. Alpha is the feed's
angle to the steepest slope, seen from above. On the grid of 96 x 320 points the simulation finds a little less than the worst
case, so the figures are lower bounds of the shortfall. A dash: passes so far apart do not overlap, and the step-over that the
model allows leaves uncut material.

The page is written by `cargo run --release --example analytic_shortfall > docs/analytic-shortfall.md`.
";

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// A contact, the analytic model's step-over for it, and the heights of both models and of the simulation in mm.
struct Comparison {
    analytic: f64,
    envelope: f64,
    simulated: f64,
}

/// An error if the passes or marks do not overlap.
fn compare(slope_deg: f64, alpha_deg: f64, feed: f64) -> Result<Comparison, NoAnswer> {
    let cutter = Cutter::toroidal(mm(2.0 * OUTER_RADIUS), mm(CORNER_RADIUS)).expect("a corner that fits");
    let contact = Contact::from_degrees(slope_deg, alpha_deg).expect("a contact");
    let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
    let analytic = Analytic::new(pass)?;
    let step_over = analytic.max_step_over(mm(STEP_OVER_HEIGHT), None)?;
    let envelope = Envelope::new(pass)?.scallop_height(step_over, Some(mm(feed))).map(ScallopHeight::total)?.mm();
    let setup = Setup {
        solid: Solid::torus(OUTER_RADIUS, CORNER_RADIUS),
        slope_deg,
        omega_deg: contact.omega().radians().to_degrees(),
        step_over: step_over.mm(),
        mark_spacing: feed,
    };
    Ok(Comparison {
        analytic: analytic.scallop_height(step_over, Some(mm(feed)))?.total().mm(),
        envelope,
        simulated: highest_uncut(setup, Grid { along: 96, across: 320 }, 4.0 * OUTER_RADIUS, 1e-8 * envelope),
    })
}

/// One table, with a row for each slope and a column for each direction, and its largest shortfall.
fn table(feed: f64) -> String {
    let mut text = format!("\n## f_z = {feed} mm: simulated height over the analytic one\n\n| slope |");
    for alpha in ALPHAS {
        write!(text, " alpha {alpha} deg |").expect("text");
    }
    text.push_str(" largest |\n|---|");
    text.push_str(&"---|".repeat(ALPHAS.len() + 1));
    let (mut furthest, mut least_share) = (f64::NEG_INFINITY, f64::INFINITY);
    for slope in SLOPES {
        write!(text, "\n| {slope} deg |").expect("text");
        let mut largest = f64::NEG_INFINITY;
        for alpha in ALPHAS {
            match compare(slope, alpha, feed) {
                Ok(Comparison { analytic, envelope, simulated }) => {
                    // Rounded to the printed digits, and 0 without a sign.
                    let shortfall = (1000.0 * (simulated / analytic - 1.0)).round() / 10.0 + 0.0;
                    largest = largest.max(shortfall);
                    least_share = least_share.min(simulated / envelope);
                    assert!(simulated <= envelope * (1.0 + 1e-6), "the envelope is exceeded at {slope} deg, alpha {alpha} deg");
                    write!(text, " {shortfall:+.1} % |").expect("text");
                }
                Err(_) => text.push_str(" - |"),
            }
        }
        furthest = furthest.max(largest);
        write!(text, " {largest:+.1} % |").expect("text");
    }
    write!(
        text,
        "\n\nLargest: {furthest:+.1} %. Model `envelope` is nowhere exceeded; the simulation reaches at least {:.1} % of it at each contact.\n",
        100.0 * least_share
    )
    .expect("text");
    text
}

fn main() {
    print!("{INTRODUCTION}");
    for feed in FEEDS {
        print!("{}", table(feed));
    }
}
