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
        let (widest, before) =
            (envelope.height(s, Pattern::even(marks)).unwrap(), envelope.height(0.999 * s, Pattern::even(marks)).unwrap());
        assert!(widest >= before * (1.0 - 1e-9), "{before} at 0.999 of {s}, {widest} there");
    }
    let s = share.max(0.01) * envelope.largest_step_over(0.0);
    let marks = envelope.largest_spacing(s);
    let (widest, before) = (envelope.height(s, Pattern::even(marks)).unwrap(), envelope.height(s, Pattern::even(0.999 * marks)).unwrap());
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

/// Marks of the deepest tooth that meet clear offsets beyond those that all marks clear, even if they do not clear the
/// whole step-over by themselves.
#[test]
fn with_runout_deep_marks_extend_the_offsets_that_all_marks_clear() {
    let (outer, teeth) = (0.5, NonZeroU32::new(5));
    let drop = 0.004_315_946_068_936_546 * 0.01_f64.to_radians().sin() + 0.000_892_927_179_126_459_3;
    let runout = Runout::NONE.with_axial_mm(drop * outer).unwrap();
    let envelope =
        Envelope::new(Pass { runout, teeth, ..by_theta(cutter(1.004_315_946_068_936_5 * outer, 0.0), 0.01, 65.000_991_707_652_8).pass })
            .unwrap();
    let (s, pattern) = (0.860_414_538_672_917_1 * outer, envelope.pattern(0.397_136_333_858_897_13 * outer));
    let general = Section::new(&envelope.body, pattern, 2.0 * s).level(s, envelope.guess(s, pattern), envelope.ceiling(s, &pattern));
    approx::assert_relative_eq!(envelope.height(s, pattern).unwrap(), general, max_relative = 1e-10);
    // Both intervals meet at this height, so that the step-over jumps there. The deep marks' interval then stays as wide
    // as it is, so that the height jumps at the largest step-over.
    let step_over = envelope.second_order_max_step_over(mm(general), Some(mm(envelope.feed_per_tooth(pattern.spacing)))).unwrap().mm();
    assert!(step_over > 1.1 * s, "{step_over} {s}");
    let [height, more] = [1.0, 1.0 + 1e-9].map(|share| envelope.height(share * step_over, pattern).unwrap());
    approx::assert_relative_eq!(height, general, max_relative = 1e-10);
    assert!(more > 1.04 * general, "{more} {general}");
}

proptest! {
    #[test]
    fn the_quick_and_the_general_search_agree(
        cutter in cutters(), slope in 0.01..89.99_f64, theta in quarter_turn(), share in 0.001..0.9_f64, marks in 0.0..0.4_f64,
    ) {
        let envelope = by_theta(cutter, slope, theta);
        let s = share * cutter.outer_radius().mm();
        let lengths = Lengths { level: envelope.guess(s, Pattern::even(marks)), step_over: s, mark_spacing: marks };
        let Some(quick) = envelope.quickly(lengths, Sought::Level).map(|ridge| ridge.lengths) else { return Ok(()) };
        // Both have rounding errors of coordinates of the size of R, which is up to a hundred times h. The general search
        // ends where the distances of both marks differ by 1e-9 h. With the radius P along the feed, at most a/sin(S) + r,
        // its place is then 1e-9 h P/f off, which counts by that length's square over 2P.
        let radius = envelope.body.core() / envelope.contact().slope().sin() + envelope.body.corner();
        let short = if marks > 0.0 { 0.5e-18 * quick.level * radius / (marks * marks) } else { 0.0 };
        approx::assert_relative_eq!(quick.level, searched(&envelope, s, marks), max_relative = 1e-12 + short.min(1e-6));
    }

    #[test]
    fn a_flat_end_cutters_closed_form_and_the_general_search_agree(
        outer in 0.5..10.0_f64, slope in 0.01..89.99_f64, theta in quarter_turn(), diagonal in 0.001..1.99_f64, turn in 0.0..90.0_f64,
    ) {
        let envelope = by_theta(cutter(outer, 0.0), slope, theta);
        let (across, along) = (diagonal * outer * turn.to_radians().sin(), diagonal * outer * turn.to_radians().cos());
        let [s, f] = [across / envelope.spacing_ratio(), along / envelope.climb.cos()].map(|length| length.min(100.0 * outer));
        let closed = envelope.closed_form(s, f).unwrap();
        // The search has rounding errors of coordinates of the size of s and f.
        approx::assert_relative_eq!(closed, searched(&envelope, s, f), max_relative = 1e-11, epsilon = 1e-14 * (outer + s + f));
    }

    /// Nested searches find the same heights as the search of the section's edges.
    #[test]
    fn the_nested_and_the_section_search_agree(
        cutter in cutters(), slope in slopes(), alpha in quarter_turn(), bends in [0.0..0.3_f64, 0.0..0.3_f64], turn in 0.0..180.0_f64,
        s in -3.0..-0.1_f64, feed in -2.5..-0.4_f64, runs_out in -5.0..-2.0_f64, teeth in 1..6_u32,
    ) {
        let outer = cutter.outer_radius().mm();
        let surface = SurfaceCurvature::from_principal_per_mm(bends.map(|bend| bend / outer), Angle::from_degrees(turn).unwrap()).unwrap();
        let runout = Runout::NONE.with_radial_mm(if teeth == 1 { 0.0 } else { 10_f64.powf(runs_out) * outer }).unwrap();
        let envelope = Envelope::new(Pass { surface, runout, teeth: NonZeroU32::new(teeth), ..pass(cutter, slope, alpha) }).unwrap();
        let [s, feed] = [s, feed].map(|log| 10_f64.powf(log) * outer);
        let pattern = envelope.pattern(feed);
        prop_assume!(envelope.overlap(1.01 * s, 1.01 * feed));
        let guess = envelope.guess(s, pattern);
        let Some(nested) = envelope.nested_level(s, &pattern, guess) else { return Ok(()) };
        let section = Section::new(&envelope.body, pattern, 2.0 * s).level(s, guess, f64::INFINITY);
        approx::assert_relative_eq!(nested, section, max_relative = 1e-8);
    }

    /// Beside a wall, the section over the axis shrinks again with the height, where passes and marks hardly overlap.
    #[test]
    fn the_nested_search_answers_only_heights_that_clear_both_edges(
        cutter in cutters(), from_wall in -3.0..1.5_f64, alpha in quarter_turn(), s in -3.0..-0.01_f64, gap in -4.0..-1.0_f64,
    ) {
        let envelope = on_plane(cutter, 90.0 - 10_f64.powf(from_wall), alpha);
        let s = 10_f64.powf(s) * envelope.largest_step_over(0.0);
        let pattern = Pattern::even((1.0 - 10_f64.powf(gap)) * envelope.largest_spacing(s));
        let Some(nested) = envelope.nested_level(s, &pattern, envelope.guess(s, pattern)) else { return Ok(()) };
        approx::assert_relative_eq!(nested, searched(&envelope, s, pattern.spacing), max_relative = 1e-7);
    }

    /// The same for largest feeds.
    #[test]
    fn the_nested_and_the_section_search_of_feeds_agree(
        cutter in cutters(), slope in slopes(), alpha in quarter_turn(), bends in [0.0..0.3_f64, 0.0..0.3_f64], turn in 0.0..180.0_f64,
        s in -3.0..-0.1_f64, share in 0.01..0.99_f64, runs_out in -5.0..-2.0_f64, teeth in 1..6_u32,
    ) {
        let outer = cutter.outer_radius().mm();
        let surface = SurfaceCurvature::from_principal_per_mm(bends.map(|bend| bend / outer), Angle::from_degrees(turn).unwrap()).unwrap();
        let runout = Runout::NONE.with_radial_mm(if teeth == 1 { 0.0 } else { 10_f64.powf(runs_out) * outer }).unwrap();
        let envelope = Envelope::new(Pass { surface, runout, teeth: NonZeroU32::new(teeth), ..pass(cutter, slope, alpha) }).unwrap();
        let s = 10_f64.powf(s) * outer;
        let Some(step_over_height) = envelope.height(s, Pattern::even(0.0)) else { return Ok(()) };
        let p = step_over_height / share;
        if p > 0.1 * outer {
            return Ok(());
        }
        let guess = (8.0 * (p - step_over_height) * outer).sqrt();
        let largest = envelope.largest_spacing(s);
        let Some(nested) = envelope.nested_feed(p, s, guess) else { return Ok(()) };
        // The section's search has no answer below the smallest length.
        let section = envelope.feed_held(p, s, guess, largest).unwrap_or(Length::SMALLEST);
        approx::assert_relative_eq!(nested.clamp(Length::SMALLEST, largest.max(Length::SMALLEST)), section, max_relative = 1e-8);
    }

    /// The search of the section's edges has no special case for ridges between marks of two kinds: it intersects and joins
    /// intervals.
    #[test]
    fn with_runout_the_quick_and_the_general_search_agree(
        cutter in cutters(), slope in 0.01..89.99_f64, theta in quarter_turn(), share in 0.001..0.9_f64, marks in 0.001..0.4_f64, radial in 0.0..0.005_f64, axial in -0.005..0.005_f64, teeth in 2_u32..6, bend in prop_oneof![2 => Just([0.0; 2]), 1 => [0.0..0.3_f64, 0.0..0.3_f64]],
        tolerance in 1e-4..0.03_f64,
    ) {
        let (on_plane, outer) = (by_theta(cutter, slope, theta), cutter.outer_radius().mm());
        let runout = Runout::NONE.with_radial_mm(radial * outer).unwrap().with_axial_mm(axial * outer).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(bend.map(|bend| bend / outer), Angle::from_degrees(20.0).unwrap()).unwrap();
        let Ok(envelope) = Envelope::new(Pass { runout, surface, teeth: NonZeroU32::new(teeth), ..on_plane.pass }) else { return Ok(()) };
        let (s, p) = (share * outer, tolerance * outer);
        let pattern = envelope.pattern(marks * outer);
        prop_assume!(!pattern.is_even());
        let search = |s: f64, pattern| Section::new(&envelope.body, pattern, 2.0 * s).level(s, envelope.guess(s, pattern), envelope.ceiling(s, &pattern));
        let width = |pattern| Section::new(&envelope.body, pattern, 4.0 * outer / envelope.spacing_ratio().max(1e-9)).width(p);
        if let Some(level) = envelope.height(s, pattern) {
            // Both have rounding errors of coordinates of the size of R.
            approx::assert_relative_eq!(level, search(s, pattern), max_relative = 1e-10, epsilon = 1e-13 * outer);
        }
        let feed = envelope.height(s, Pattern::even(0.0)).and_then(|alone| {
            envelope.second_order_max_feed_per_tooth_above(Length::computed(alone), mm(p), mm(s)).ok()
        });
        if let Some(feed) = feed {
            let level = |share: f64| search(s, envelope.pattern_of(Some(mm(feed.mm() * share))));
            prop_assert!(level(1.0 - 1e-9) <= p * (1.0 + 1e-9) && level(1.0 + 1e-6) >= p * (1.0 - 1e-9), "{} {} {p}", level(1.0 - 1e-9), level(1.0 + 1e-6));
        }
        if let Ok(step_over) = envelope.second_order_max_step_over(mm(p), Some(mm(envelope.feed_per_tooth(pattern.spacing)))) {
            approx::assert_relative_eq!(step_over.mm(), width(pattern), max_relative = 1e-8);
        }
    }

    #[test]
    fn the_distance_to_the_body_is_convex(
        cutter in cutters(), slope in quarter_turn(), theta in quarter_turn(),
        (x, y, p) in (-20.0..20.0_f64, -20.0..20.0_f64, -20.0..20.0_f64), (u, v, q) in (-20.0..20.0_f64, -20.0..20.0_f64, -20.0..20.0_f64),
    ) {
        let body = by_theta(cutter, slope, theta).body;
        let ends = f64::midpoint(body.distance(x, y, p).value, body.distance(u, v, q).value);
        let middle = body.distance(f64::midpoint(x, u), f64::midpoint(y, v), f64::midpoint(p, q)).value;
        // Distances are up to some 60 mm, with rounding errors of 1e-14 mm. A few of these add up; they would be
        // magnified only if the sum of distance and corner radius were small, which it is not at a random point.
        prop_assert!(middle <= ends + 1e-12, "{middle} over {ends}");
    }

    #[test]
    fn the_height_grows_with_step_over_and_feed(
        cutter in cutters(), slope in quarter_turn(), theta in quarter_turn(), share in 0.01..0.8_f64, marks in 0.01..0.4_f64,
        more in 1.001..1.2_f64,
    ) {
        let envelope = by_theta(cutter, slope, theta);
        let s = share * 2.0 * cutter.outer_radius().mm();
        if let (Some(height), Some(wider), Some(faster)) =
            (envelope.height(s, Pattern::even(marks)), envelope.height(more * s, Pattern::even(marks)), envelope.height(s, Pattern::even(more * marks)))
        {
            // The heights are equal on a flat and along a wall. Otherwise the change for 0.1 % more is far above the
            // rounding error of 1e-13.
            prop_assert!(wider >= height * (1.0 - 1e-13) && faster >= height * (1.0 - 1e-13), "{height} {wider} {faster}");
            prop_assert!(height >= envelope.height(s, Pattern::even(0.0)).unwrap() * (1.0 - 1e-13));
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
