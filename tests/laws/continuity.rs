//! Heights and both inverses are continuous: they do not jump between inputs that differ by rounding errors.
//!
//! The default run has 4,000 pairs. This command runs 100,000:
//! `SCALLOPD_PAIRS=100000 cargo test --release --test integration continuity`

use crate::laws::passes::{is_settled, mm};
use proptest::test_runner::{Config, TestRunner};
use proptest::{prelude::*, prop_oneof};
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::{Angle, Length};

fn pairs() -> u32 {
    std::env::var("SCALLOPD_PAIRS").map_or(4_000, |count| count.parse().expect("SCALLOPD_PAIRS must be a count"))
}

/// An angle from 0 to 90 deg, often an end or within a few roundings of one.
fn quarter_turn() -> impl Strategy<Value = f64> {
    let near = (0..40_i32).prop_map(|power| 10.0_f64.powf(-f64::from(power) / 2.5));
    prop_oneof![1 => Just(0.0), 1 => Just(90.0), 1 => near.clone(), 1 => near.prop_map(|offset| 90.0 - offset), 4 => 0.0..90.0_f64]
}

/// Slopes next to a wall are left out: on a wall every alpha except that of the level feed means the vertical feed, so
/// that rounding errors matter there.
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
                let evaluated = EvaluatedPass::new(Model::Envelope, pass).unwrap();
                evaluated.scallop_height(mm(input[2]), (input[3] > 1e-6).then(|| mm(input[3]))).map(|height| height.total().mm())
            };
            let here = [slope, alpha, share * outer, marks * outer];
            let mut beside = here;
            beside[moved] = if here[moved] > 1.0 { here[moved].next_down() } else { here[moved].next_up() };
            if let (Ok(height), Ok(next)) = (find(here), find(beside)) {
                // A rounding error of an angle of 90 deg, 1.4e-14 deg, moves points 20 mm away by 5e-15 mm, which at 89
                // deg is magnified 57 times. Searches end within a few rounding errors of h.
                prop_assert!((height - next).abs() <= 1e-11 * height + 1e-12, "{height} and {next} at {here:?}, {beside:?}, {cutter:?}");
            }
            Ok(())
        })
        .unwrap();
}

/// Heights and inverses on convex surfaces and with runout, including a wall's level and vertical feeds.
#[test]
fn answers_on_convex_surfaces_and_with_runout_are_continuous() {
    let ratio = prop_oneof![1 => Just(1.0), 4 => 0.05..0.99_f64];
    let slope = prop_oneof![1 => Just(90.0), 6 => slopes()];
    let lengths = (0.02..0.3_f64, 0.01..0.2_f64);
    let bend = (0.0..0.3_f64, 0.0..0.3_f64, 0.0..180.0_f64);
    let runout = prop_oneof![1 => Just((0.0, 0.0)), 1 => (0.0..2e-3_f64, -2e-3..2e-3_f64)];
    let strategy = (0.5..10.0_f64, ratio, slope, quarter_turn(), lengths, bend, runout, 0..4_usize);
    let mut runner = TestRunner::new(Config::with_cases(pairs() / 4));
    runner
        .run(&strategy, |(outer, ratio, slope, alpha, (share, marks), (one, other, turn), (radial, axial), moved)| {
            let cutter = if ratio >= 1.0 {
                Cutter::ball_end(mm(2.0 * outer))
            } else {
                Cutter::toroidal(mm(2.0 * outer), mm(ratio * outer)).unwrap()
            };
            let turn = Angle::from_degrees(turn).unwrap();
            let surface = SurfaceCurvature::from_principal_per_mm([one / outer, other / outer], turn).unwrap();
            let runout = Runout::NONE.with_radial_mm(radial * outer).unwrap().with_axial_mm(axial * outer).unwrap();
            // On a wall, alpha = 90 deg means the level feed and every other value the vertical feed.
            let alpha = if slope >= 90.0 && alpha < 90.0 { 0.0 } else { alpha };
            let find = |input: [f64; 4]| {
                let contact = Contact::from_degrees(input[0], input[1]).unwrap();
                let evaluated = EvaluatedPass::new(Model::Envelope, Pass { cutter, contact, surface, runout, teeth: None }).ok()?;
                let (s, f, tolerance) = (mm(input[2]), mm(input[3]), mm(2e-3 * outer));
                let height = evaluated.scallop_height(s, Some(f)).ok()?.total().mm();
                if !is_settled(&evaluated, input[2], input[3]) {
                    return None;
                }
                // With runout, an inverse jumps at the point where the deep marks alone begin to suffice. Without
                // runout there are no jumps.
                let inverses = (runout == Runout::NONE).then(|| {
                    (
                        evaluated.max_step_over(tolerance, Some(f)).map(Length::mm),
                        evaluated.max_feed_per_tooth(tolerance, s).map(Length::mm),
                    )
                });
                Some((height, inverses))
            };
            let here = [slope, alpha, share * outer, marks * outer];
            let mut beside = here;
            // On a wall, only the lengths are varied, because a slightly different alpha means another feed.
            let moved = if slope >= 90.0 { 2 + moved % 2 } else { moved };
            beside[moved] = if here[moved] > 1.0 { here[moved].next_down() } else { here[moved].next_up() };
            if let (Some((height, inverses)), Some((next, next_inverses))) = (find(here), find(beside)) {
                prop_assert!((height - next).abs() <= 1e-11 * height + 1e-12, "{height} and {next} at {here:?}, {beside:?}, {cutter:?}");
                for (one, other) in inverses.into_iter().zip(next_inverses).flat_map(|(a, b)| [(a.0, b.0), (a.1, b.1)]) {
                    if let (Ok(one), Ok(other)) = (one, other) {
                        // Short feeds and step-overs, on which the height hardly depends, are left out. At a largest
                        // feed f the derivative of the height is of the order f/R, so that rounding errors of 1e-12 of
                        // h become 1e-12 h R/f^2 of f.
                        let room = 1e-9 * one + 1e-11 * outer;
                        prop_assert!(
                            (one - other).abs() <= room || one.min(other) < 0.03 * outer,
                            "{one} and {other} at {here:?}, {beside:?}, {cutter:?}"
                        );
                    }
                }
            }
            Ok(())
        })
        .unwrap();
}
