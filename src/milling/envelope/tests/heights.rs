//! Tests of heights: published values, closed forms, limits, and other routes to the same height.

use super::*;
use crate::milling::Analytic;
use std::num::NonZeroU32;

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

/// h1 by another route. The body's outline seen along the feed is an ellipse offset by r, with the support function r +
/// a sqrt(m_x^2 + m_y^2). It is a curve over the angle of its normal. Bisection finds the level at which both flanks
/// are s apart.
fn step_over_height_of_outline(cutter: Cutter, contact: Contact, s: f64) -> f64 {
    let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
    let (axis_up, axis_aside) = (contact.slope().cos(), contact.slope().sin() * contact.omega().sin().abs());
    let axis_along = contact.slope().sin() * contact.omega().cos();
    // The point of the outline with the normal (sin(phi), -cos(phi)) in (aside, up), relative to the disc's centre.
    let point = |phi: f64| {
        let (m, tangent) = ((phi.sin(), -phi.cos()), (phi.cos(), phi.sin()));
        let (m_z, turn) = (m.0 * axis_aside + m.1 * axis_up, tangent.0 * axis_aside + tangent.1 * axis_up);
        // The axis has the length 1, so that m_x^2 + m_y^2 = 1 - m_z^2 is the square of its other components.
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
        // Above the round, the flank continues along the axis.
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
        outer in 1.0..10.0_f64, ratio in 0.05..0.95_f64, slope in 0.1..89.0_f64, omega in 0.1..89.0_f64, share in 0.001..0.5_f64,
    ) {
        let envelope = by_omega(cutter(outer, ratio), slope, omega);
        let s = share * outer;
        let other = step_over_height_of_outline(envelope.pass.cutter, envelope.contact(), s);
        // The outline's coordinates are of the size of R, 10 mm, so that its levels have a few rounding errors of 10
        // mm: 1e-14 mm.
        approx::assert_abs_diff_eq!(envelope.at(s, 0.0).unwrap(), other, epsilon = 2e-14 + 1e-12 * other);
    }

    #[test]
    fn a_flat_end_cutter_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.1..89.9_f64, omega in quarter_turn(), share in 0.01..0.999_f64,
    ) {
        let envelope = by_omega(cutter(radius, 0.0), slope, omega);
        // Passes are up to 2R apart seen from above, and up to 6R along steep walls, so that edges and sides meet in
        // every combination.
        let s = share * envelope.largest_step_over(0.0).min(6.0 * radius);
        let general = envelope.searched(s, 0.0);
        // The search finds the edge to the rounding of s, which is at most 60 mm, and so h to a few times 1e-14 mm.
        approx::assert_relative_eq!(envelope.at(s, 0.0).unwrap(), general, max_relative = 1e-13, epsilon = 5e-14);
    }

    #[test]
    fn a_ball_end_cutter_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.01..80.0_f64, omega in quarter_turn(), share in 1e-4..0.15_f64, marks in 1e-4..0.15_f64,
    ) {
        let envelope = by_omega(cutter(radius, 1.0), slope, omega);
        let (s, f) = (share * radius, marks * radius);
        // The sides of the cutter, which are upright, leave the same up to there.
        prop_assume!(slope + (s.hypot(f) / (2.0 * radius)).asin().to_degrees() < 89.0);
        let closed = circle_height(radius, s.hypot(f));
        approx::assert_relative_eq!(envelope.searched(s, f), closed, max_relative = 1e-13);
        approx::assert_relative_eq!(envelope.searched(s, 0.0), circle_height(radius, s), max_relative = 1e-13);
    }

    /// With runout too, where a mark half-way between a deep and a shallow one must not count as a shallow one.
    #[test]
    fn a_plane_is_the_limit_of_curved_surfaces(
        cutter in cutters(), slope in 1.0..85.0_f64, omega in quarter_turn(), share in 0.01..0.3_f64, marks in 0.01..0.1_f64,
        (radial, axial) in (0.0..0.003_f64, -0.003..0.003_f64), teeth in 2_u32..5, radius in prop_oneof![-1.0..-0.5_f64, 0.5..1.0_f64],
    ) {
        let (plain, outer) = (by_omega(cutter, slope, omega).pass, cutter.outer_radius().mm());
        let runout = Runout::NONE.with_radial_mm(radial * outer).unwrap().with_axial_mm(axial * outer).unwrap();
        let plane = Pass { runout, teeth: NonZeroU32::new(teeth), ..plain };
        let [on_plane, beside] = [plane, curved(plane, 1e9 * radius)].map(|pass| Envelope::new(pass).unwrap().at(share * outer, marks * outer));
        // The surface rises by less than 1e-8 R over the marks, and a height changes by that much where grooves are nearly flat.
        approx::assert_abs_diff_eq!(beside.unwrap(), on_plane.unwrap(), epsilon = 1e-7 * outer);
    }

    #[test]
    fn floor_and_wall_are_the_limits_of_slopes_beside_them(
        cutter in cutters(), omega in quarter_turn(), share in 0.01..0.9_f64, marks in 0.01..0.4_f64, axial in 0.001..0.1_f64, teeth in 2_u32..4,
    ) {
        let s = share * 2.0 * cutter.outer_radius().mm();
        let with_runout = |slope: f64| {
            let runout = Runout::NONE.with_axial_mm(axial).unwrap();
            Envelope::new(Pass { runout, teeth: NonZeroU32::new(teeth), ..by_omega(cutter, slope, omega).pass }).unwrap()
        };
        let (floor, beside) = (with_runout(0.0), with_runout(1e-7));
        if let (Some(floor), Some(beside)) = (floor.at(s, marks), beside.at(s, marks)) {
            approx::assert_abs_diff_eq!(beside, floor, epsilon = 6e-8);
        }
        let tolerance = 0.05;
        // The height is the tolerance, or it jumps over the tolerance at the point where the deep marks cease to
        // overlap.
        let is_largest = |value: Length, height: &dyn Fn(f64) -> f64| {
            let [here, beyond] = [1.0, 1.0 + 1e-9].map(|share| height(value.mm() * share));
            here <= tolerance * (1.0 + 1e-9) && (here >= tolerance * (1.0 - 1e-9) || beyond > tolerance)
        };
        if let Ok(feed) = floor.max_feed_per_tooth(mm(tolerance), mm(s)) {
            assert!(is_largest(feed, &|feed| floor.at(s, feed).unwrap_or(f64::MAX)), "{feed:?}");
        }
        if let Ok(step_over) = floor.max_step_over(mm(tolerance), Some(mm(marks))) {
            assert!(is_largest(step_over, &|s| floor.at(s, marks).unwrap_or(f64::MAX)), "{step_over:?}");
        }
        // Within 1e-7 deg = 1.7e-9 rad of floor or wall, every point of the body moves by less than 2e-9 * 30 mm along
        // the normal.
        let moved = 6e-8;
        for f in [0.0, marks] {
            let floor = by_omega(cutter, 0.0, omega).at(s, f);
            if let (Some(floor), Some(beside)) = (floor, by_omega(cutter, 1e-7, omega).at(s, f)) {
                approx::assert_abs_diff_eq!(beside, floor, epsilon = moved);
            }
            // Along the wall the cutter's side removes what passes leave; near the wall, the rest is the side's rise
            // over s.
            let wall = by_omega(cutter, 90.0, omega).at(s, f);
            if let (Some(wall), Some(beside)) = (wall, by_omega(cutter, 90.0 - 1e-7, omega).at(s, f))
                && (omega <= 0.0 || omega > 1.0)
            {
                // With a feed 1 deg from the vertical, the side reaches s / tan(1 deg) = 57 s up, and its rise is
                // larger by this factor.
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
        // Over the distance s, radii of curvature change by a share of the order s/r. Terms odd in s cancel between the
        // two flanks, and (s/r)^2 remains. It is magnified by at most 1/sin^2(10 deg) = 33 and, along the slope, by as
        // much again.
        let part = 70.0 * shrink * shrink;
        approx::assert_relative_eq!(envelope.step_over.mm(), analytic.step_over.mm(), max_relative = part + 1e-9);
        approx::assert_relative_eq!(envelope.feed.mm(), analytic.feed.mm(), max_relative = part + 1e-9);
    }

    #[test]
    fn a_ball_end_cutter_on_a_sphere_leaves_its_closed_form(
        radius in 0.5..10.0_f64, slope in 0.0..60.0_f64, omega in quarter_turn(), share in 0.01..0.3_f64, marks in 0.01..0.3_f64,
        hollow in prop::bool::ANY, roundness in 1.5..50.0_f64,
    ) {
        let curvature = (if hollow { -roundness } else { roundness } * radius).recip();
        let surface = SurfaceCurvature::from_components_per_mm(curvature, curvature, 0.0).unwrap();
        let envelope = Envelope::new(Pass { surface, ..by_omega(cutter(radius, 1.0), slope, omega).pass }).unwrap();
        let (s, f) = (share * radius, marks * radius);
        // The ridge is half a diagonal of the rectangle between the marks away from each contact.
        let closed = circle_height(radius, s.hypot(f)) + curvature * (s * s + f * f) / 8.0;
        let found = envelope.scallop_height(mm(s), Some(mm(f))).unwrap().total().mm();
        // The plane's height is at most 3 times that on the concave sphere.
        approx::assert_relative_eq!(found, closed, max_relative = 1e-12);
    }
}

#[test]
fn on_a_floor_the_flat_leaves_nothing_and_the_corner_its_round() {
    let envelope = on_plane(cutter(5.0, 0.4), 0.0, 0.0);
    assert_eq!(envelope.scallop_height(mm(6.0), None), Ok(ScallopHeight::of_parts(Length::ZERO, Length::ZERO)));
    // 8 mm are 6 mm of flat and 2 mm between corners of 2 mm: 2 - sqrt(4 - 1).
    let height = envelope.scallop_height(mm(8.0), None).unwrap();
    // Coordinates of up to 8 mm have roundings of 9e-16 mm.
    approx::assert_abs_diff_eq!(height.step_over.mm(), 2.0 - 3.0_f64.sqrt(), epsilon = 2e-15);
    let step_over = envelope.max_step_over(height.step_over, None).unwrap();
    approx::assert_relative_eq!(step_over.mm(), 8.0, max_relative = 1e-14);
}

/// Uphill of a contact on a wall that is concave along the feed, the surface overhangs. Vertical passes meet at the
/// contact's level line there, where the cutter's side is a circle of the radius R. Marks that have normals of their own
/// know no overhang; with them the height was a thousandth of a millimetre.
#[test]
fn vertical_passes_on_an_overhanging_wall_leave_the_height_of_circles() {
    for (slope, twist) in [(89.999_999, 0.008), (89.999, 0.008), (89.9, -0.002)] {
        let surface = SurfaceCurvature::from_components_per_mm(-0.056, -0.054, twist).unwrap();
        let envelope = Envelope::new(Pass { surface, ..by_omega(cutter(3.0, 0.58), slope, 0.0).pass }).unwrap();
        let s = 3.1;
        let circles = circle_height(3.0, s) - 0.054 * s * s / 8.0;
        let found = envelope.scallop_height(mm(s), None).unwrap().step_over.mm();
        // Slope and twist tilt the section by less than 0.01.
        approx::assert_relative_eq!(found, circles, max_relative = 0.01);
    }
}
