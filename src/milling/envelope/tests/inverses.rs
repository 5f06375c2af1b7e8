//! Tests of the inverses: the largest step-over and feed that keep a height.

use super::*;

proptest! {
    #[test]
    fn the_inverses_give_back_step_over_and_feed(
        cutter in cutters(), slope in 0.1..89.0_f64, omega in quarter_turn(), share in 0.01..0.8_f64, marks in 0.05..0.4_f64,
        radius in prop_oneof![Just(None), (30.0..1e4_f64).prop_map(Some)], radial in 0.0..0.005_f64, axial in -0.005..0.005_f64,
    ) {
        let mut pass = by_omega(cutter, slope, omega).pass;
        pass.runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        if let Some(radius) = radius {
            pass = curved(pass, radius);
        }
        // Some of these cutters do not fit the surface.
        let Ok(envelope) = Envelope::new(pass) else { return Ok(()) };
        let (s, f) = (mm(share * cutter.outer_radius().mm()), mm(marks));
        let Ok(height) = envelope.scallop_height(s, Some(f)) else { return Ok(()) };
        // A relative error of the height of 1e-13 becomes 1e-13 h / (its part of h) of the step-over or feed. Parts
        // below 1e-3 of h are left out, because 1e-9 cannot be expected of them.
        prop_assume!(height.feed.mm() > 1e-3 * height.total().mm() && height.step_over.mm() > 1e-3 * height.total().mm());
        // At the height from which the interval of deep marks alone touches that of deep and shallow marks, the width
        // jumps: several step-overs and feeds leave that height, and the largest ones are found, or where rounding puts the
        // jump above the height, the smallest. Near the floor of a curved surface heights can fall where the turn of the
        // normal is bounded, so that the largest are found.
        let can_be_larger = pass.runout != Runout::NONE || radius.is_some() && slope < 10.0;
        let leaves_as_much = |s: Length, f: Length| {
            let left = envelope.scallop_height(s, Some(f)).unwrap().total().mm();
            pass.runout != Runout::NONE && left >= height.total().mm() * (1.0 - 1e-12)
        };
        let back = envelope.max_step_over(height.total(), Some(f)).unwrap();
        prop_assert!(back.mm() >= s.mm() * (1.0 - 1e-9) || leaves_as_much(mm(back.mm() * (1.0 + 1e-9)), f));
        if back.mm() > s.mm() * (1.0 + 1e-9) {
            approx::assert_relative_eq!(envelope.scallop_height(back, Some(f)).unwrap().total().mm(), height.total().mm(), max_relative = 1e-9);
            prop_assert!(can_be_larger);
        }
        let back = envelope.max_feed_per_tooth(height.total(), s).unwrap();
        prop_assert!(back.mm() >= f.mm() * (1.0 - 1e-9) || leaves_as_much(s, mm(back.mm() * (1.0 + 1e-9))));
        if back.mm() > f.mm() * (1.0 + 1e-9) {
            approx::assert_relative_eq!(envelope.scallop_height(s, Some(back)).unwrap().total().mm(), height.total().mm(), max_relative = 1e-9);
            prop_assert!(can_be_larger);
        }
        let back = envelope.max_step_over(height.step_over, None).unwrap();
        prop_assert!(back.mm() >= s.mm() * (1.0 - 1e-9));
        if back.mm() > s.mm() * (1.0 + 1e-9) {
            approx::assert_relative_eq!(envelope.scallop_height(back, None).unwrap().total().mm(), height.step_over.mm(), max_relative = 1e-9);
            prop_assert!(radius.is_some() && slope < 10.0);
        }
    }

    /// Near a floor the height jumps where the marks of the deepest tooth no longer overlap: any tolerance under the depth of the
    /// others is within the jump.
    #[test]
    fn on_floors_largest_lengths_keep_a_tolerance_within_a_jump(
        ratio in prop_oneof![Just(0.0), 0.001..0.1_f64],
        slope in -3.0..0.0_f64,
        alpha in 0.0..360.0_f64,
        radial in prop_oneof![Just(0.0), 0.001..0.02_f64],
        axial in 0.001..0.01_f64,
        teeth in 2..7_u32,
        share in 0.05..1.0_f64,
        length in 0.02..0.5_f64,
    ) {
        let mut pass = pass(cutter(1.0, ratio), 10.0_f64.powf(slope), alpha);
        pass.runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        pass.teeth = std::num::NonZeroU32::new(teeth);
        let (envelope, tolerance, length) = (Envelope::new(pass).unwrap(), mm(share * axial), mm(length));
        let is_kept = |s: Length, f: Length| {
            let total = envelope.scallop_height(s, Some(f)).unwrap().total();
            total.mm() <= tolerance.mm() * (1.0 + 1e-9)
        };
        if let Ok(feed) = envelope.max_feed_per_tooth(tolerance, length) {
            prop_assert!(is_kept(length, feed), "feed {feed:?}");
        }
        if let Ok(step_over) = envelope.max_step_over(tolerance, Some(length)) {
            prop_assert!(is_kept(step_over, length), "step-over {step_over:?}");
        }
    }
}
