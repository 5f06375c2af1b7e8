//! How much longer heights and inverses of model `envelope` take on curved surfaces than on planes, over ordinary contacts
//! of toroidal cutters: R 2 to 10 mm, r/R 0.1 to 0.7, slopes 5 to 85 deg, all directions, radii of curvature from 20 to
//! 220 mm, tolerances of 2 to 25 um, feeds per tooth of 0.05 to 0.3 mm.
//!
//! ```sh
//! cargo run --release --example curved_contacts
//! ```

#[path = "../tests/simulation/random.rs"]
mod random;
mod thread_time;

use random::Random;
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::{Angle, Length};
use std::hint::black_box;
use thread_time::now_us;

const CONTACTS: usize = 3000;

/// Each calculation is repeated within a measurement, because reading the clock takes 0.3 us.
const REPEATS: u32 = 4;

fn mm(value: f64) -> Length {
    Length::from_mm(value).expect("a length in its bounds")
}

/// A pass on a plane, with the curvature of the other surface, and the lengths of the calculations.
struct Input {
    plane: Pass,
    curvature: SurfaceCurvature,
    step_over: Length,
    feed: Length,
    tolerance: Length,
}

impl Input {
    /// A contact whose step-over alone leaves half of the tolerance on the curved surface; `None` if the cutter gouges it.
    fn draw(random: &mut Random, signs: [f64; 2]) -> Option<Self> {
        let outer = random.within(2.0, 10.0);
        let cutter = Cutter::toroidal(mm(2.0 * outer), mm(random.within(0.1, 0.7) * outer)).expect("a corner under the radius");
        let contact = Contact::from_degrees(random.within(5.0, 85.0), random.within(0.0, 360.0)).expect("a contact");
        let principal = signs.map(|sign| sign / random.within(20.0, 220.0));
        let turn = Angle::from_degrees(random.within(0.0, 180.0)).expect("an angle");
        let curvature = SurfaceCurvature::from_principal_per_mm(principal, turn).expect("curvatures in their bounds");
        let (feed, half) = (mm(random.within(0.05, 0.3)), random.within(0.002, 0.025) / 2.0);
        let plane = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
        let evaluated = EvaluatedPass::new(Model::Envelope, Pass { surface: curvature, ..plane }).ok()?;
        let step_over = evaluated.max_step_over(mm(half), None).ok()?;
        Some(Self { plane, curvature, step_over, feed, tolerance: mm(2.0 * half) })
    }
}

/// The result of a calculation, so that the compiler cannot leave the calculation out.
type Calculation = fn(&EvaluatedPass, &Input) -> Option<Length>;

const CALCULATIONS: [(&str, Calculation); 4] = [
    ("height of a step-over", |pass, input| Some(pass.scallop_height(input.step_over, None).ok()?.total())),
    ("height of both", |pass, input| Some(pass.scallop_height(input.step_over, Some(input.feed)).ok()?.total())),
    ("largest feed", |pass, input| pass.max_feed_per_tooth(input.tolerance, input.step_over).ok()),
    ("largest step-over", |pass, input| pass.max_step_over(input.tolerance, Some(input.feed)).ok()),
];

fn time_us(calculate: Calculation, pass: Pass, input: &Input) -> f64 {
    let began = now_us();
    for _ in 0..REPEATS {
        let evaluated = EvaluatedPass::new(Model::Envelope, black_box(pass)).expect("the cutter fits");
        black_box(calculate(&evaluated, input));
    }
    (now_us() - began) / f64::from(REPEATS)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() {
    let mut random = Random(7);
    println!("medians over {CONTACTS} contacts, processor time in us\n");
    println!("| surface | calculation | on a plane | curved | of the plane's |");
    println!("|---|---|---|---|---|");
    for (surface, signs) in [("convex", [1.0, 1.0]), ("saddle", [1.0, -1.0]), ("concave", [-1.0, -1.0])] {
        let inputs: Vec<_> = std::iter::from_fn(|| Some(Input::draw(&mut random, signs))).flatten().take(CONTACTS).collect();
        for (name, calculate) in CALCULATIONS {
            // Both in turn for each contact, because the processor's clock changes within a second.
            let times = || {
                inputs.iter().map(|input| {
                    [input.plane, Pass { surface: input.curvature, ..input.plane }].map(|pass| time_us(calculate, pass, input))
                })
            };
            // The first round warms caches and the processor.
            drop(times().collect::<Vec<_>>());
            let (on_plane, on_curved): (Vec<_>, Vec<_>) = times().map(|[plane, curved]| (plane, curved)).unzip();
            let (plane, curved) = (median(on_plane), median(on_curved));
            println!("| {surface} | {name} | {plane:.2} | {curved:.2} | {:.2} |", curved / plane);
        }
    }
}
