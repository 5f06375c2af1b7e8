//! Refusals: no valid input is a panic, whatever its size, and the figures that a refusal states are accepted.

use crate::laws::passes::mm;
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, CuttingLimits, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::{Angle, Length};
use std::num::NonZeroU32;

/// A size in mm over the whole range of lengths, mostly that of real cutters.
fn sizes() -> impl Strategy<Value = f64> {
    prop_oneof![4 => 0.25..25.0_f64, 1 => (-5.0..5.0_f64).prop_map(|log| 10_f64.powf(log)), 1 => Just(5.0)]
}

/// Every shape of a cutter with the outer radius R.
fn cutters(outer: f64) -> impl Strategy<Value = Cutter> {
    let toroidal = (-4.0..0.0_f64).prop_filter_map("a corner radius", move |log| {
        Cutter::toroidal(mm(2.0 * outer), Length::from_mm(10_f64.powf(log) * outer).ok()?).ok()
    });
    prop_oneof![1 => Just(Cutter::flat_end(mm(2.0 * outer))), 1 => Just(Cutter::ball_end(mm(2.0 * outer))), 2 => toroidal]
}

/// Angles from 0 to 90 deg, with both ends and their neighbours.
fn quarter_turns() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => 0.0..90.0_f64,
        1 => Just(0.0),
        1 => Just(90.0),
        1 => (-300.0..0.0_f64).prop_map(|log| 10_f64.powf(log)),
        1 => (-14.0..0.0_f64).prop_map(|log| 90.0 - 10_f64.powf(log))
    ]
}

/// A length as a share of R, from a hundredth to three R or at a limit of an overlap.
fn shares() -> impl Strategy<Value = f64> {
    prop_oneof![3 => (-2.0..0.5_f64).prop_map(|log| 10_f64.powf(log)), 1 => Just(1.0), 1 => Just(2.0)]
}

/// Passes on any surface, a third of them planes, and R.
fn any_passes() -> impl Strategy<Value = (Pass, f64)> {
    let bend = || prop_oneof![1 => Just(0.0), 3 => (-4.0..0.0_f64, any::<bool>()).prop_map(|(log, up)| if up { 1.0 } else { -1.0 } * 10_f64.powf(log))];
    let surface = prop_oneof![1 => Just(([0.0; 2], 0.0)), 2 => ([bend(), bend()], 0.0..180.0_f64)];
    let runout = prop_oneof![2 => Just((0.0, 0.0)), 1 => (0.0..0.01_f64, -0.01..0.01_f64)];
    let of_size =
        move |outer: f64| (cutters(outer), quarter_turns(), quarter_turns(), surface.clone(), runout.clone(), 1..7_u32, Just(outer));
    sizes().prop_flat_map(of_size).prop_map(|(cutter, slope, alpha, (bends, turn), (radial, axial), teeth, outer)| {
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let turn = Angle::from_degrees(turn).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(bends.map(|bend| bend / outer), turn).unwrap();
        let largest = outer.min(10.0);
        let runout = Runout::NONE.with_radial_mm(radial * largest).unwrap().with_axial_mm(axial * largest).unwrap();
        (Pass { cutter, contact, surface, runout, teeth: NonZeroU32::new(teeth) }, outer)
    })
}

/// A length, moved to the nearest one that is accepted.
fn accepted(value: f64) -> Length {
    mm(value.clamp(Length::SMALLEST, Length::LARGEST))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn every_valid_pass_has_an_answer_or_a_reason(
        (pass, outer) in any_passes(), s in shares(), f in shares(), p in shares(), limited in any::<bool>(),
    ) {
        let (s, f, p) = (accepted(s * outer), accepted(0.3 * f * outer), accepted(0.3 * p * outer));
        for model in [Model::Analytic, Model::Envelope] {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            let refusals = [
                evaluated.scallop_height(s, None).err(),
                evaluated.scallop_height(s, Some(f)).err(),
                evaluated.max_feed_per_tooth(p, s).err(),
                evaluated.max_step_over(p, None).err(),
                evaluated.max_step_over(p, Some(f)).err(),
            ];
            let limits = if limited { CuttingLimits::new(Some(f), None, Some(s)).unwrap() } else { CuttingLimits::NONE };
            let _answer_or_reason = evaluated.fastest(p, &limits);
            for (number, refusal) in refusals.into_iter().flatten().enumerate() {
                match refusal {
                    // The largest step-over leaves a height, and so does a smaller one.
                    NoAnswer::PassesDoNotOverlap { largest_step_over } if largest_step_over.mm() >= Length::SMALLEST => {
                        for share in [1.0, 0.9] {
                            let height = evaluated.scallop_height(accepted(share * largest_step_over.mm()), None);
                            prop_assert!(height.is_ok(), "{number}: {refusal:?} {share} {height:?}");
                        }
                    }
                    NoAnswer::ToleranceLimitsNoFeed { largest_feed_per_tooth } => prop_assert!(largest_feed_per_tooth.mm() > 0.0),
                    NoAnswer::FeedUsesUpTolerance { feed_height } => prop_assert!(feed_height >= p, "{number}: {refusal:?}"),
                    _ => {}
                }
            }
            // Without a feed no marks can fail to overlap, or leave a height.
            for refusal in [evaluated.scallop_height(s, None).err(), evaluated.max_step_over(p, None).err()].into_iter().flatten() {
                let is_of_marks = matches!(refusal, NoAnswer::MarksDoNotOverlap { .. } | NoAnswer::FeedUsesUpTolerance { .. });
                prop_assert!(!is_of_marks || p.mm() <= 1e-5 * outer, "{refusal:?}");
            }
        }
    }
}

/// A step-over that leaves no room for marks of an accepted feed.
#[test]
fn passes_that_hardly_overlap_leave_no_feed() {
    let plane = SurfaceCurvature::PLANE;
    let cases = [
        (Cutter::flat_end(mm(10.0)), 0.0, 45.0, plane, 9.999_999_999_999_991, 0.5),
        (Cutter::flat_end(mm(10.0)), 1.0, 45.0, plane, 10.000_761_553_211_783, 0.5),
        (Cutter::flat_end(mm(6.0)), 70.0, 90.0, plane, 17.542_826_400_978_51, 10.0),
        (
            Cutter::toroidal(mm(5.280_986_442_349_606), mm(0.710_804_116_910_768_7)).unwrap(),
            53.4,
            147.0,
            SurfaceCurvature::from_radius_mm(-54.714_804_724_954_384).unwrap(),
            5.872_055_351_562_2,
            7.982,
        ),
    ];
    for (cutter, slope, alpha, surface, step_over, tolerance) in cases {
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: NonZeroU32::new(8) };
        let found = EvaluatedPass::new(Model::Envelope, pass).unwrap().max_feed_per_tooth(mm(tolerance), mm(step_over));
        assert!(matches!(found, Err(NoAnswer::MarksDoNotOverlap { .. })), "slope {slope}, alpha {alpha}: {found:?}");
    }
}

/// The step-over of a refusal has a height with the feed that was refused.
#[test]
fn the_largest_step_over_counts_the_feed() {
    let cutters = [Cutter::ball_end(mm(10.0)), Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), Cutter::flat_end(mm(10.0))];
    for (cutter, (slope, alpha)) in
        cutters.into_iter().flat_map(|cutter| [(40.0, 30.0), (70.0, 80.0), (10.0, 150.0)].map(|at| (cutter, at)))
    {
        for surface in [SurfaceCurvature::PLANE, SurfaceCurvature::from_radius_mm(120.0).unwrap()] {
            let contact = Contact::from_degrees(slope, alpha).unwrap();
            let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None };
            let evaluated = EvaluatedPass::new(Model::Envelope, pass).unwrap();
            for feed in [0.2, 3.0] {
                let refusal = evaluated.scallop_height(mm(1000.0), Some(mm(feed)));
                let Err(NoAnswer::PassesDoNotOverlap { largest_step_over }) = refusal else { panic!("{refusal:?}") };
                let height = evaluated.scallop_height(largest_step_over, Some(mm(feed)));
                assert!(height.is_ok(), "{cutter:?}, slope {slope}, feed {feed}: {largest_step_over:?} {height:?}");
            }
        }
    }
}

/// A ball in a trough of its own radius: lambda is a rounding error.
#[test]
fn a_cutter_of_the_surfaces_own_radius_gouges() {
    let cutter = Cutter::ball_end(mm(0.017_536_083_101_991_125));
    let surface = SurfaceCurvature::from_components_per_mm(-0.000_546_260_344_784_456_6, -114.050_554_412_171_51, 0.0).unwrap();
    let contact = Contact::from_degrees(85.0, 100.594_349_822_937_94).unwrap();
    let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: NonZeroU32::new(1) };
    assert!(matches!(EvaluatedPass::new(Model::Envelope, pass), Err(NoAnswer::Gouges { .. })));
}
