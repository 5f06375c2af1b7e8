//! Heights do not jump between inputs a rounding apart.
//!
//! The default run takes 4,000 pairs. All 100,000 by one command: `SCALLOPD_PAIRS=100000 cargo test --release --test integration continuity`

use crate::laws::passes::mm;
use proptest::test_runner::{Config, TestRunner};
use proptest::{prelude::*, prop_oneof};
use scallopd::milling::{Contact, Cutter, JudgedPass, Model, Pass, Runout, SurfaceCurvature};

fn pairs() -> u32 {
    std::env::var("SCALLOPD_PAIRS").map_or(4_000, |count| count.parse().expect("SCALLOPD_PAIRS must be a count"))
}

/// An angle from 0 to 90 deg, its ends preferred, and next to them by a few roundings.
fn quarter_turn() -> impl Strategy<Value = f64> {
    let near = (0..40_i32).prop_map(|power| 10.0_f64.powf(-f64::from(power) / 2.5));
    prop_oneof![1 => Just(0.0), 1 => Just(90.0), 1 => near.clone(), 1 => near.prop_map(|offset| 90.0 - offset), 4 => 0.0..90.0_f64]
}

/// On a wall all feeds but the level one are the vertical feed, so that alpha says nothing there, and next to it every rounding counts.
fn slopes() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 1 => (0..40_i32).prop_map(|power| 10.0_f64.powf(-f64::from(power) / 2.5)), 5 => 0.0..89.0_f64]
}

#[test]
fn heights_are_continuous_in_slope_direction_step_over_and_feed() {
    let ratio = prop_oneof![2 => Just(0.0), 1 => Just(1.0), 3 => 0.01..0.99_f64];
    let strategy = (0.5..10.0_f64, ratio, slopes(), quarter_turn(), 0.005..0.3_f64, 0.0..0.2_f64, 0..4_usize);
    let mut runner = TestRunner::new(Config::with_cases(pairs()));
    runner
        .run(&strategy, |(outer, ratio, slope, alpha, share, marks, moved)| {
            let cutter = if ratio <= 0.0 {
                Cutter::flat_end(mm(2.0 * outer))
            } else if ratio >= 1.0 {
                Cutter::ball_end(mm(2.0 * outer))
            } else {
                Cutter::toroidal(mm(2.0 * outer), mm(ratio * outer)).unwrap()
            };
            let find = |input: [f64; 4]| {
                let contact = Contact::from_degrees(input[0], input[1]).unwrap();
                let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
                let judged = JudgedPass::new(Model::Envelope, pass).unwrap();
                judged.scallop_height(mm(input[2]), (input[3] > 1e-6).then(|| mm(input[3]))).map(|height| height.total().mm())
            };
            let here = [slope, alpha, share * outer, marks * outer];
            let mut beside = here;
            beside[moved] = if here[moved] > 1.0 { here[moved].next_down() } else { here[moved].next_up() };
            if let (Ok(height), Ok(next)) = (find(here), find(beside)) {
                // A rounding of an angle of 90 deg, 1.4e-14 deg, moves places 20 mm away by 5e-15 mm, which at 89 deg counts 57 times; searches end
                // within some roundings of h.
                prop_assert!((height - next).abs() <= 1e-11 * height + 1e-12, "{height} and {next} at {here:?}, {beside:?}, {cutter:?}");
            }
            Ok(())
        })
        .unwrap();
}
