//! Tests of the searches: the fast and the general one agree, and they converge up to the ends of the domain.

use super::*;
use std::num::NonZeroU32;

/// A slope in degrees, as often close to a floor or a wall, down to a millionth of a degree, as between.
fn slopes() -> impl Strategy<Value = f64> {
    let from_end = || (-6.0..1.65_f64).prop_map(|log| 10_f64.powf(log));
    prop_oneof![2 => 0.1..89.9_f64, 1 => from_end(), 1 => from_end().prop_map(|from_end| 90.0 - from_end)]
}

/// Asserts that the largest step-over and feed have heights, and that these are not less than those at a thousandth
/// less.
fn assert_widest_leave_most(cutter: Cutter, slope: f64, alpha: f64, share: f64) {
    let envelope = on_plane(cutter, slope, alpha);
    for marks in [0.0, share * envelope.largest_spacing(0.0)] {
        let s = envelope.largest_step_over(marks);
        let (widest, before) = (envelope.at(s, marks).unwrap(), envelope.at(0.999 * s, marks).unwrap());
        assert!(widest >= before * (1.0 - 1e-9), "{before} at 0.999 of {s}, {widest} there");
    }
    let s = share.max(0.01) * envelope.largest_step_over(0.0);
    let marks = envelope.largest_spacing(s);
    let (widest, before) = (envelope.at(s, marks).unwrap(), envelope.at(s, 0.999 * marks).unwrap());
    assert!(widest >= before * (1.0 - 1e-9), "{before} at 0.999 of {marks}, {widest} there");
}

/// An input with which rounding errors could put the largest step-over outside the domain.
#[test]
fn the_largest_step_over_and_feed_are_in_the_domain() {
    let cutter = Cutter::toroidal(mm(10.145_104_240_978_43), mm(1.446_994_298_805_383_7)).unwrap();
    assert_widest_leave_most(cutter, 67.405_866_252_726_36, 12.228_362_219_247_067, 0.952_840_327_116_88);
}

/// Inputs at which rounding errors of the section, or of the largest step-over, exceed those at other slopes.
#[test]
fn the_largest_step_over_has_a_height_beside_a_wall() {
    let cutter = Cutter::toroidal(mm(18.831_778_998_470_928), mm(7.543_019_925_938_837)).unwrap();
    assert_widest_leave_most(cutter, 86.318_437_761_672_12, 83.432_599_109_847_3, 0.979_435_833_896_094_5);
}

proptest! {
    /// On planes, and with runout.
    #[test]
    fn the_fast_and_the_sure_search_agree(
        cutter in cutters(), slope in slopes(), omega in quarter_turn(), share in 0.001..0.9_f64, marks in 0.001..0.4_f64,
        (radial, axial) in prop_oneof![Just((0.0, 0.0)), (0.0..0.005_f64, -0.005..0.005_f64)], teeth in 2_u32..6,
    ) {
        let (plain, outer) = (by_omega(cutter, slope, omega), cutter.outer_radius().mm());
        let runout = Runout::NONE.with_radial_mm(radial * outer).unwrap().with_axial_mm(axial * outer).unwrap();
        let envelope = Envelope::new(Pass { runout, teeth: NonZeroU32::new(teeth), ..plain.pass }).unwrap();
        let (s, f) = (share * outer, marks * outer);
        for f in [0.0, f] {
            let guess = Lengths { level: envelope.guess(s, f), step_over: s, feed: f };
            if let Some(quick) = envelope.quickly(&envelope.body, Sought::Level, guess) {
                // Both have rounding errors of coordinates of the size of R.
                approx::assert_relative_eq!(quick.lengths.level, envelope.searched(s, f), max_relative = 1e-11, epsilon = 1e-14 * outer);
            }
        }
    }

    #[test]
    fn the_distance_to_the_body_is_convex(
        cutter in cutters(), slope in quarter_turn(), omega in quarter_turn(),
        (x, y, p) in (-20.0..20.0_f64, -20.0..20.0_f64, -20.0..20.0_f64), (u, v, q) in (-20.0..20.0_f64, -20.0..20.0_f64, -20.0..20.0_f64),
    ) {
        let body = by_omega(cutter, slope, omega).body;
        let ends = f64::midpoint(body.gap(x, y, p).value, body.gap(u, v, q).value);
        let middle = body.gap(f64::midpoint(x, u), f64::midpoint(y, v), f64::midpoint(p, q)).value;
        // Distances are up to some 60 mm, with rounding errors of 1e-14 mm. A few of these add up; they would be
        // magnified only if the sum of distance and corner radius were small, which it is not at a random point.
        prop_assert!(middle <= ends + 1e-12, "{middle} over {ends}");
    }

    #[test]
    fn the_height_grows_with_step_over_and_feed(
        cutter in cutters(), slope in quarter_turn(), omega in quarter_turn(), share in 0.01..0.8_f64, marks in 0.01..0.4_f64,
        more in 1.001..1.2_f64,
    ) {
        let envelope = by_omega(cutter, slope, omega);
        let s = share * 2.0 * cutter.outer_radius().mm();
        if let (Some(height), Some(wider), Some(faster)) =
            (envelope.at(s, marks), envelope.at(more * s, marks), envelope.at(s, more * marks))
        {
            let least = |height: f64| height * (1.0 - 1e-13) - 2e-16 * cutter.outer_radius().mm();
            // The heights are equal on a flat and along a wall. Otherwise the change for 0.1 % more is far above the
            // rounding error of 1e-13, and of coordinates of the size of R.
            prop_assert!(wider >= least(height) && faster >= least(height), "{height} {wider} {faster}");
            prop_assert!(height >= least(envelope.at(s, 0.0).unwrap()));
        }
    }

    /// The search must converge even if passes overlap only by a rounding error: the height must exceed that at a
    /// smaller distance.
    #[test]
    fn the_widest_passes_and_marks_leave_the_most(
        cutter in cutters(), slope in 0.0..90.0_f64, alpha in 0.0..90.0_f64, share in prop_oneof![1 => Just(0.0), 3 => 0.01..1.0_f64],
    ) {
        assert_widest_leave_most(cutter, slope, alpha, share);
    }
}
