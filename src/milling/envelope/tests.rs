//! Tests of the model: its table, its closed forms and its laws.

use super::closed_form::circle_height;
use super::*;
use crate::milling::{Analytic, Runout, ScallopHeight, SurfaceCurvature};
use proptest::prelude::*;

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

fn cutter(outer_radius: f64, ratio: f64) -> Cutter {
    if ratio <= 0.0 {
        Cutter::flat_end(mm(2.0 * outer_radius))
    } else if ratio >= 1.0 {
        Cutter::ball_end(mm(2.0 * outer_radius))
    } else {
        Cutter::toroidal(mm(2.0 * outer_radius), mm(ratio * outer_radius)).unwrap()
    }
}

fn pass(cutter: Cutter, slope: f64, alpha: f64) -> Pass {
    let contact = Contact::from_degrees(slope, alpha).unwrap();
    Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
}

fn on_plane(cutter: Cutter, slope: f64, alpha: f64) -> Envelope {
    Envelope::new(pass(cutter, slope, alpha)).unwrap()
}

fn curved(pass: Pass, radius: f64) -> Pass {
    Pass { surface: SurfaceCurvature::from_radius_mm(radius).unwrap(), ..pass }
}

/// A pass by vectors, which distinguish all feeds on a wall; slope and theta in degrees.
fn by_theta(cutter: Cutter, slope: f64, theta: f64) -> Envelope {
    let (slope, theta) = (Angle::from_degrees(slope).unwrap(), Angle::from_degrees(theta).unwrap());
    let feed = [slope.cos() * theta.cos(), theta.sin(), -slope.sin() * theta.cos()];
    let contact = Contact::from_vectors([slope.sin(), 0.0, slope.cos()], feed, None).unwrap();
    Envelope::new(Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }).unwrap()
}

/// Any cutter: flat-end, toroidal, ball-end.
fn cutters() -> impl Strategy<Value = Cutter> {
    let ratio = prop_oneof![1 => Just(0.0), 6 => 0.01..0.99_f64, 1 => Just(1.0)];
    (0.5..10.0_f64, ratio).prop_map(|(outer_radius, ratio)| cutter(outer_radius, ratio))
}

/// An angle from 0 to 90 deg, its ends among them.
fn quarter_turn() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => 0.0..90.0_f64, 1 => Just(90.0)]
}

/// The largest step-over and feed have a height, and no less than those a thousandth smaller.
fn assert_widest_leave_most(cutter: Cutter, slope: f64, alpha: f64, share: f64) {
    let envelope = on_plane(cutter, slope, alpha);
    for marks in [0.0, share * envelope.largest_feed(0.0)] {
        let s = envelope.largest_step_over(marks);
        let (widest, before) =
            (envelope.height(s, Pattern::even(marks)).unwrap(), envelope.height(0.999 * s, Pattern::even(marks)).unwrap());
        assert!(widest >= before * (1.0 - 1e-9), "{before} at 0.999 of {s}, {widest} there");
    }
    let s = share.max(0.01) * envelope.largest_step_over(0.0);
    let marks = envelope.largest_feed(s);
    let (widest, before) = (envelope.height(s, Pattern::even(marks)).unwrap(), envelope.height(s, Pattern::even(0.999 * marks)).unwrap());
    assert!(widest >= before * (1.0 - 1e-9), "{before} at 0.999 of {marks}, {widest} there");
}

/// An input of which roundings put the largest step-over out of the domain.
#[test]
fn the_largest_step_over_and_feed_are_in_the_domain() {
    let cutter = Cutter::toroidal(mm(10.145_104_240_978_43), mm(1.446_994_298_805_383_7)).unwrap();
    assert_widest_leave_most(cutter, 67.405_866_252_726_36, 12.228_362_219_247_067, 0.952_840_327_116_88);
}

/// The general search, also where the model has a closed form.
fn searched(envelope: &Envelope, s: f64, f: f64) -> f64 {
    Section::new(&envelope.body, Pattern::even(f), 2.0 * s).level(s, envelope.guess(s, Pattern::even(f)))
}

#[test]
fn the_check_values_agree_to_their_printed_digits() {
    // Slope and alpha in deg, step-over in mm, h1 in um, for R = 5 mm, r = 2 mm.
    for (slope, alpha, step_over, micrometres) in [
        (40.0, 0.0, 0.73, 10.006),
        (40.0, 90.0, 0.4, 10.025),
        (5.0, 0.0, 2.0, 14.065),
        (1.0, 0.0, 3.7, 10.958),
        (0.5, 0.0, 5.27, 13.420),
        (0.2, 0.0, 5.9, 8.295),
        (0.01, 0.0, 6.4, 10.548),
        (85.0, 90.0, 0.4, 9.936),
        (89.0, 90.0, 0.4, 4.371),
    ] {
        let height = on_plane(cutter(5.0, 0.4), slope, alpha).scallop_height(mm(step_over), None).unwrap();
        // Half of the last digit printed.
        approx::assert_abs_diff_eq!(height.step_over.mm() * 1e3, micrometres, epsilon = 5e-4);
    }
}

/// h1 by another route: the body's outline seen along the feed, an ellipse offset by r, from its support function r + a
/// sqrt(m_x^2 + m_y^2), as a curve over the angle of its normal. Both flanks are followed by halving to the level at
/// which they are s apart.
fn step_over_height_of_outline(cutter: Cutter, contact: Contact, s: f64) -> f64 {
    let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
    let (axis_up, axis_aside) = (contact.slope().cos(), contact.slope().sin() * contact.theta().sin().abs());
    let axis_along = contact.slope().sin() * contact.theta().cos();
    // The point of the outline with the normal (sin(phi), -cos(phi)) in (aside, up), relative to the disc's centre.
    let point = |phi: f64| {
        let (m, tangent) = ((phi.sin(), -phi.cos()), (phi.cos(), phi.sin()));
        let (m_z, turn) = (m.0 * axis_aside + m.1 * axis_up, tangent.0 * axis_aside + tangent.1 * axis_up);
        // The axis has the length 1, so that m_x^2 + m_y^2 = 1 - m_z^2 is what its two other parts are.
        let level = turn.hypot(axis_along);
        let (support, derivative) = (corner + core * level, -core * m_z * turn / level);
        (support * m.0 + derivative * tangent.0, support * m.1 + derivative * tangent.1)
    };
    let bottom = point(0.0).1;
    let flank = axis_up.atan2(axis_aside);
    let aside_at = |level: f64, furthest: f64| {
        let (mut near, mut far) = (0.0, furthest);
        for _ in 0..100 {
            let middle = f64::midpoint(near, far);
            if point(middle).1 - bottom < level { near = middle } else { far = middle }
        }
        let (aside, up) = point(near);
        // Where the level is above the round, the flank goes on along the axis.
        aside + (level - (up - bottom)).max(0.0) * axis_aside / axis_up
    };
    let (mut low, mut high) = (0.0, 10.0 * s);
    for _ in 0..100 {
        let level = f64::midpoint(low, high);
        if aside_at(level, flank) - aside_at(level, flank - std::f64::consts::PI) < s { low = level } else { high = level }
    }
    low
}

proptest! {
    #[test]
    fn the_step_over_height_agrees_with_the_outline_seen_along_the_feed(
        outer in 1.0..10.0_f64, ratio in 0.05..0.95_f64, slope in 0.1..89.0_f64, theta in 0.1..89.0_f64, share in 0.001..0.5_f64,
    ) {
        let envelope = by_theta(cutter(outer, ratio), slope, theta);
        let s = share * outer;
        let other = step_over_height_of_outline(envelope.cutter, envelope.contact(), s);
        // The outline's coordinates are of the size of R, 10 mm, so that its levels carry a few roundings of 10 mm:
        // 1e-14 mm.
        approx::assert_abs_diff_eq!(envelope.height(s, Pattern::even(0.0)).unwrap(), other, epsilon = 2e-14 + 1e-12 * other);
    }

    #[test]
    fn the_quick_and_the_general_search_agree(
        cutter in cutters(), slope in 0.01..89.99_f64, theta in quarter_turn(), share in 0.001..0.9_f64, marks in 0.0..0.4_f64,
    ) {
        let envelope = by_theta(cutter, slope, theta);
        let s = share * cutter.outer_radius().mm();
        let lengths = Lengths { level: envelope.guess(s, Pattern::even(marks)), step_over: s, mark_spacing: marks };
        let Some(quick) = envelope.quickly(lengths, Sought::Level) else { return Ok(()) };
        // Both add roundings of places of the size of R, up to a hundred times h.
        approx::assert_relative_eq!(quick.level, searched(&envelope, s, marks), max_relative = 1e-12);
    }

    /// The general search does not treat ridges between marks of two kinds: it intersects and joins intervals.
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
        let search = |s: f64, pattern| Section::new(&envelope.body, pattern, 2.0 * s).level(s, envelope.guess(s, pattern));
        let width = |pattern| Section::new(&envelope.body, pattern, 4.0 * outer / envelope.spacing_ratio().max(1e-9)).width(p);
        if let Ok(level) = envelope.height(s, pattern) {
            // Both add roundings of places of the size of R.
            approx::assert_relative_eq!(level, search(s, pattern), max_relative = 1e-10, epsilon = 1e-13 * outer);
        }
        if let Ok(feed) = envelope.max_feed_per_tooth(mm(p), mm(s)) {
            let level = |share: f64| search(s, envelope.pattern(feed.mm() * share));
            prop_assert!(level(1.0 - 1e-9) <= p * (1.0 + 1e-9) && level(1.0 + 1e-6) >= p * (1.0 - 1e-9), "{} {} {p}", level(1.0 - 1e-9), level(1.0 + 1e-6));
        }
        if let Ok(step_over) = envelope.max_step_over(mm(p), Some(mm(pattern.spacing))) {
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
        // Distances are up to some 60 mm, whose rounding is 1e-14 mm; a few of them add up, magnified by at most 60 mm
        // / r' where the sum of distance and corner radius is small, which a random place is not.
        prop_assert!(middle <= ends + 1e-12, "{middle} over {ends}");
    }

    #[test]
    fn a_flat_end_cutter_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.1..89.9_f64, theta in quarter_turn(), share in 0.01..0.999_f64,
    ) {
        let envelope = by_theta(cutter(radius, 0.0), slope, theta);
        // Up to where the passes are 2R apart seen from above, and up to 6R on steep walls: edges and sides meet in all
        // their ways.
        let s = share * envelope.largest_step_over(0.0).min(6.0 * radius);
        let general = searched(&envelope, s, 0.0);
        // The search finds the edge to the rounding of s, 60 mm at the most, hence h to a few times 1e-14 mm.
        approx::assert_relative_eq!(envelope.height(s, Pattern::even(0.0)).unwrap(), general, max_relative = 1e-13, epsilon = 5e-14);
    }

    #[test]
    fn a_ball_end_cutter_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.01..80.0_f64, theta in quarter_turn(), share in 1e-4..0.15_f64, marks in 1e-4..0.15_f64,
    ) {
        let envelope = by_theta(cutter(radius, 1.0), slope, theta);
        let (s, f) = (share * radius, marks * radius);
        prop_assume!(envelope.ball_alone(s, f));
        let closed = circle_height(radius, s.hypot(f));
        approx::assert_relative_eq!(searched(&envelope, s, f), closed, max_relative = 1e-13);
        approx::assert_relative_eq!(searched(&envelope, s, 0.0), circle_height(radius, s), max_relative = 1e-13);
    }

    #[test]
    fn floor_and_wall_are_the_limits_of_slopes_beside_them(
        cutter in cutters(), theta in quarter_turn(), share in 0.01..0.9_f64, marks in 0.01..0.4_f64, axial in 0.001..0.1_f64, teeth in 2_u32..4,
    ) {
        let s = share * 2.0 * cutter.outer_radius().mm();
        let with_runout = |slope: f64| {
            let runout = Runout::NONE.with_axial_mm(axial).unwrap();
            Envelope::new(Pass { runout, teeth: NonZeroU32::new(teeth), ..by_theta(cutter, slope, theta).pass }).unwrap()
        };
        let (floor, beside) = (with_runout(0.0), with_runout(1e-7));
        if let (Ok(floor), Ok(beside)) = (floor.height(s, floor.pattern(marks)), beside.height(s, beside.pattern(marks))) {
            approx::assert_abs_diff_eq!(beside, floor, epsilon = 6e-8);
        }
        let tolerance = 0.05;
        // The height is the tolerance, or it jumps over it where the deep marks cease to overlap.
        let is_largest = |value: Length, height: &dyn Fn(f64) -> f64| {
            let [here, beyond] = [1.0, 1.0 + 1e-9].map(|share| height(value.mm() * share));
            here <= tolerance * (1.0 + 1e-9) && (here >= tolerance * (1.0 - 1e-9) || beyond > tolerance)
        };
        if let Ok(feed) = floor.max_feed_per_tooth(mm(tolerance), mm(s)) {
            assert!(is_largest(feed, &|feed| floor.height(s, floor.pattern(feed)).unwrap_or(f64::MAX)), "{feed:?}");
        }
        if let Ok(step_over) = floor.max_step_over(mm(tolerance), Some(mm(marks))) {
            assert!(is_largest(step_over, &|s| floor.height(s, floor.pattern(marks)).unwrap_or(f64::MAX)), "{step_over:?}");
        }
        // Within 1e-7 deg = 1.7e-9 rad of floor or wall every place of the body moves by less than 2e-9 * 30 mm along
        // the normal.
        let moved = 6e-8;
        for f in [0.0, marks] {
            let floor = by_theta(cutter, 0.0, theta).height(s, Pattern::even(f));
            if let (Ok(floor), Ok(beside)) = (floor, by_theta(cutter, 1e-7, theta).height(s, Pattern::even(f))) {
                approx::assert_abs_diff_eq!(beside, floor, epsilon = moved);
            }
            // Along the wall the cutter's side takes off what passes leave; beside it the rest is the side's rise over
            // s.
            let wall = by_theta(cutter, 90.0, theta).height(s, Pattern::even(f));
            if let (Ok(wall), Ok(beside)) = (wall, by_theta(cutter, 90.0 - 1e-7, theta).height(s, Pattern::even(f)))
                && (theta <= 0.0 || theta > 1.0)
            {
                // A feed 1 deg beside the vertical makes the side reach s / tan(1 deg) = 57 s up, and rise as much
                // more.
                approx::assert_abs_diff_eq!(beside, wall, epsilon = 60.0 * moved);
            }
        }
    }

    #[test]
    fn small_steps_along_or_across_the_slope_leave_what_the_analytic_model_says(
        outer in 1.0..10.0_f64, ratio in 0.1..1.0_f64, slope in 10.0..80.0_f64, across in prop::bool::ANY, shrink in 1e-4..1e-2_f64,
    ) {
        let pass = pass(cutter(outer, ratio), slope, if across { 90.0 } else { 0.0 });
        let step = mm(shrink * ratio * outer);
        let analytic = Analytic::new(pass).unwrap().scallop_height(step, Some(step)).unwrap();
        let envelope = Envelope::new(pass).unwrap().scallop_height(step, Some(step)).unwrap();
        // Curvature radii change over the distance s by a part of the order s/r; what is odd in s cancels between the
        // two flanks, and (s/r)^2 stays, magnified by at most 1/sin^2(10 deg) = 33 and, along the slope, by tan^2 of
        // the side's angle, as much again.
        let part = 70.0 * shrink * shrink;
        approx::assert_relative_eq!(envelope.step_over.mm(), analytic.step_over.mm(), max_relative = part + 1e-9);
        approx::assert_relative_eq!(envelope.feed.mm(), analytic.feed.mm(), max_relative = part + 1e-9);
    }

    #[test]
    fn the_height_grows_with_step_over_and_feed(
        cutter in cutters(), slope in quarter_turn(), theta in quarter_turn(), share in 0.01..0.8_f64, marks in 0.01..0.4_f64,
        more in 1.001..1.2_f64,
    ) {
        let envelope = by_theta(cutter, slope, theta);
        let s = share * 2.0 * cutter.outer_radius().mm();
        if let (Ok(height), Ok(wider), Ok(faster)) =
            (envelope.height(s, Pattern::even(marks)), envelope.height(more * s, Pattern::even(marks)), envelope.height(s, Pattern::even(more * marks)))
        {
            // Equal on a flat and along a wall; elsewhere 0.1 % more is far above the rounding of 1e-13.
            prop_assert!(wider >= height * (1.0 - 1e-13) && faster >= height * (1.0 - 1e-13), "{height} {wider} {faster}");
            prop_assert!(height >= envelope.height(s, Pattern::even(0.0)).unwrap() * (1.0 - 1e-13));
        }
    }

    /// Where passes overlap only by a rounding error, the search must converge: the height must exceed that at a
    /// smaller distance.
    #[test]
    fn the_widest_passes_and_marks_leave_the_most(
        cutter in cutters(), slope in 0.0..90.0_f64, alpha in 0.0..90.0_f64, share in prop_oneof![1 => Just(0.0), 3 => 0.01..1.0_f64],
    ) {
        assert_widest_leave_most(cutter, slope, alpha, share);
    }

    #[test]
    fn the_inverses_give_back_step_over_and_feed(
        cutter in cutters(), slope in 0.1..89.0_f64, theta in quarter_turn(), share in 0.01..0.8_f64, marks in 0.05..0.4_f64,
        radius in prop_oneof![Just(None), (30.0..1e4_f64).prop_map(Some)], radial in 0.0..0.005_f64, axial in -0.005..0.005_f64,
    ) {
        let mut pass = by_theta(cutter, slope, theta).pass;
        pass.runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        if let Some(radius) = radius {
            pass = curved(pass, radius);
        }
        // A sharp edge along the cut has no answer on a curve.
        let Ok(envelope) = Envelope::new(pass) else { return Ok(()) };
        let (s, f) = (mm(share * cutter.outer_radius().mm()), mm(marks));
        let Ok(height) = envelope.scallop_height(s, Some(f)) else { return Ok(()) };
        // A height to 1e-13 gives a step-over or feed to 1e-13 h / (its part of h). Below 1e-3 of h that part is not
        // asked for 1e-9.
        prop_assume!(height.feed.mm() > 1e-3 * height.total().mm() && height.step_over.mm() > 1e-3 * height.total().mm());
        // Where what deep marks alone clear begins to touch what deep and shallow ones clear, the width jumps at one
        // height: several step-overs and feeds leave that height, and the largest ones are found.
        let back = envelope.max_step_over(height.total(), Some(f)).unwrap();
        prop_assert!(back.mm() >= s.mm() * (1.0 - 1e-9));
        if back.mm() > s.mm() * (1.0 + 1e-9) {
            approx::assert_relative_eq!(envelope.scallop_height(back, Some(f)).unwrap().total().mm(), height.total().mm(), max_relative = 1e-9);
            prop_assert!(pass.runout != Runout::NONE);
        }
        let back = envelope.max_feed_per_tooth(height.total(), s).unwrap();
        prop_assert!(back.mm() >= f.mm() * (1.0 - 1e-9));
        if back.mm() > f.mm() * (1.0 + 1e-9) {
            approx::assert_relative_eq!(envelope.scallop_height(s, Some(back)).unwrap().total().mm(), height.total().mm(), max_relative = 1e-9);
            prop_assert!(pass.runout != Runout::NONE);
        }
        let back = envelope.max_step_over(height.step_over, None).unwrap();
        approx::assert_relative_eq!(back.mm(), s.mm(), max_relative = 1e-9);
    }

    #[test]
    fn a_ball_end_cutter_on_a_sphere_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.0..60.0_f64, theta in quarter_turn(), share in 0.01..0.3_f64, marks in 0.01..0.3_f64,
        hollow in prop::bool::ANY, roundness in 1.5..50.0_f64,
    ) {
        let curvature = (if hollow { -roundness } else { roundness } * radius).recip();
        let surface = SurfaceCurvature::from_components_per_mm(curvature, curvature, 0.0).unwrap();
        let envelope = Envelope::new(Pass { surface, ..by_theta(cutter(radius, 1.0), slope, theta).pass }).unwrap();
        let (s, f) = (share * radius, marks * radius);
        // The ridge is half a diagonal of the rectangle between the marks away from each of its contacts.
        let closed = circle_height(radius, s.hypot(f)) + curvature * (s * s + f * f) / 8.0;
        let found = envelope.scallop_height(mm(s), Some(mm(f))).unwrap().total().mm();
        // The plane's height is at most 3 times that on the concave sphere.
        approx::assert_relative_eq!(found, closed, max_relative = 1e-12);
    }
}

#[test]
fn on_a_floor_the_flat_leaves_nothing_and_the_corner_its_round() {
    let envelope = on_plane(cutter(5.0, 0.4), 0.0, 0.0);
    assert_eq!(envelope.scallop_height(mm(6.0), None), Ok(ScallopHeight { step_over: Length::ZERO, feed: Length::ZERO }));
    // 8 mm are 6 mm of flat and 2 mm between corners of 2 mm: 2 - sqrt(4 - 1).
    let height = envelope.scallop_height(mm(8.0), None).unwrap();
    approx::assert_relative_eq!(height.step_over.mm(), 2.0 - 3.0_f64.sqrt(), max_relative = 1e-15);
    let step_over = envelope.max_step_over(height.step_over, None).unwrap();
    approx::assert_relative_eq!(step_over.mm(), 8.0, max_relative = 1e-14);
}

#[test]
fn passes_and_marks_that_do_not_overlap_seen_from_above_are_errors_with_the_way_out() {
    let envelope = on_plane(cutter(5.0, 0.4), 60.0, 90.0);
    // Seen from above s = 20 mm is 10 mm = 2R at 60 deg.
    let Err(NoAnswer::PassesDoNotOverlap { largest_step_over }) = envelope.scallop_height(mm(20.01), None) else { panic!("an answer") };
    approx::assert_relative_eq!(largest_step_over.mm(), 20.0, max_relative = 1e-14);
    assert!(envelope.scallop_height(largest_step_over, None).unwrap().total().mm().is_finite());
    // Marks 8 mm apart leave 6 mm for the passes, 12 mm along the slope, and the other way round.
    let Err(NoAnswer::MarksDoNotOverlap { largest_mark_spacing }) = envelope.scallop_height(mm(12.0), Some(mm(8.01))) else {
        panic!("an answer")
    };
    approx::assert_relative_eq!(largest_mark_spacing.mm(), 8.0, max_relative = 1e-14);
    assert!(envelope.scallop_height(mm(12.0), Some(largest_mark_spacing)).unwrap().total().mm().is_finite());
}

#[test]
fn a_tolerance_that_is_used_up_or_limits_nothing_is_an_error_with_the_way_out() {
    let envelope = on_plane(cutter(5.0, 0.4), 40.0, 30.0);
    let Err(NoAnswer::StepOverUsesUpTolerance { step_over_height, max_step_over }) = envelope.max_feed_per_tooth(mm(0.01), mm(0.9)) else {
        panic!("an answer")
    };
    assert_eq!(Ok(step_over_height), envelope.scallop_height(mm(0.9), None).map(|height| height.step_over));
    approx::assert_relative_eq!(envelope.scallop_height(max_step_over, None).unwrap().step_over.mm(), 0.01, max_relative = 1e-12);
    assert!(matches!(envelope.max_step_over(mm(0.001), Some(mm(0.4))), Err(NoAnswer::FeedUsesUpTolerance { .. })));
    assert!(matches!(envelope.max_step_over(mm(100.0), None), Err(NoAnswer::ToleranceLimitsNoStepOver { .. })));
    assert!(matches!(envelope.max_feed_per_tooth(mm(100.0), mm(0.5)), Err(NoAnswer::ToleranceLimitsNoFeed { .. })));
    let wall = on_plane(cutter(5.0, 0.4), 90.0, 90.0);
    assert_eq!(wall.max_step_over(mm(0.01), None), Err(NoAnswer::ToleranceLimitsNoStepOver { largest_step_over: mm(Length::LARGEST) }));
}

#[test]
fn a_concave_surface_that_the_cutter_gouges_is_an_error() {
    let gouges = |radius| Envelope::new(curved(pass(cutter(5.0, 0.4), 40.0, 0.0), radius)).map(|_| ());
    // The feed runs down the slope, and across it the cutter's radius is 3/sin(40 deg) + 2 = 6.667 mm.
    let Err(NoAnswer::Gouges { smallest_radius: Some(smallest) }) = gouges(-6.6) else { panic!("no gouging") };
    approx::assert_relative_eq!(smallest.mm(), 3.0 / 40.0_f64.to_radians().sin() + 2.0, max_relative = 1e-12);
    assert_eq!(gouges(-6.7), Ok(()));
    let floor = Envelope::new(curved(pass(cutter(5.0, 0.4), 0.0, 0.0), -1e6)).map(|_| ());
    assert_eq!(floor, Err(NoAnswer::Gouges { smallest_radius: None }));
}
