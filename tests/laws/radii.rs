//! The effective radii by an independent method, and their formulas near walls.

use crate::laws::passes::{cutters, feed_angles, mm, slopes, toroidal};
use approx::{assert_abs_diff_eq, assert_relative_eq};
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, EffectiveRadius};

fn across(cutter: Cutter, slope: f64, alpha: f64) -> f64 {
    EffectiveRadius::across_feed(cutter, Contact::from_degrees(slope, alpha).unwrap()).finite().unwrap().mm()
}

fn along(cutter: Cutter, slope: f64, alpha: f64) -> f64 {
    EffectiveRadius::along_feed(cutter, Contact::from_degrees(slope, alpha).unwrap()).finite().unwrap().mm()
}

/// The radius of curvature, at the contact, of the cutter's outline seen along the feed. The circle of the corner's
/// centre appears as an ellipse, and the corner is an offset of it by r. The outline's support function in the
/// direction phi is the largest extent of that circle in this direction, plus r. The radius of curvature is this
/// function plus its second derivative, computed by differences.
fn curvature_radius(cutter: Cutter, slope: f64, alpha: f64) -> f64 {
    let (s, a) = (slope.to_radians(), alpha.to_radians());
    // The surface's normal, the feed in the surface, and the third direction, in which the outline is seen.
    let normal = [s.sin(), 0.0, s.cos()];
    let feed = [a.cos(), a.sin(), -a.cos() * s.tan()];
    let length = feed.iter().map(|c| c * c).sum::<f64>().sqrt();
    let feed = feed.map(|c| c / length);
    let side = [normal[1] * feed[2] - normal[2] * feed[1], normal[2] * feed[0] - normal[0] * feed[2]];
    // The circle is horizontal, so only the horizontal part of a direction matters.
    let core = cutter.core_radius().mm();
    let support = |phi: f64| {
        let x = -phi.cos() * normal[0] + phi.sin() * side[0];
        let y = -phi.cos() * normal[1] + phi.sin() * side[1];
        core * x.hypot(y) + cutter.corner_radius().mm()
    };
    let second = |step: f64| (support(step) - 2.0 * support(0.0) + support(-step)) / (step * step);
    // One step of extrapolation removes the second-order error of the differences.
    let step = 2e-3 * s.sin();
    support(0.0) + (4.0 * second(step / 2.0) - second(step)) / 3.0
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Differences with a step e have a truncation error of e^4 and a rounding error of 1e-16/e^2. With e = 2e-3 sin S
    /// and S of at least 10 deg, e is at least 3.5e-4: 1e-16 / 1.2e-7 = 1e-9 of the support function.
    #[test]
    fn the_effective_radius_is_the_curvature_of_the_outline_seen_along_the_feed(cutter in cutters(), slope in 10.0..80.0_f64, alpha in feed_angles()) {
        assert_relative_eq!(across(cutter, slope, alpha), curvature_radius(cutter, slope, alpha), max_relative = 1e-7);
    }

    #[test]
    fn the_transverse_radius_is_the_effective_radius_a_quarter_turn_further(cutter in cutters(), slope in 1.0..89.0_f64, alpha in feed_angles()) {
        assert_relative_eq!(along(cutter, slope, alpha), across(cutter, slope, alpha + 90.0), max_relative = 1e-11);
    }

    #[test]
    fn radii_lie_between_the_corners_and_the_largest_which_is_along_the_steepest_slope(cutter in cutters(), slope in slopes(), alpha in feed_angles()) {
        let largest = cutter.core_radius().mm() / slope.to_radians().sin() + cutter.corner_radius().mm();
        for radius in [across(cutter, slope, alpha), along(cutter, slope, alpha)] {
            prop_assert!(radius >= cutter.corner_radius().mm() && radius <= largest * (1.0 + 1e-14), "{radius} {largest}");
        }
    }

    /// On a wall, by omega: a level feed has the corner's radius, a vertical feed the circle of radius R.
    #[test]
    fn on_a_wall_the_radii_follow_from_the_feeds_inclination(outer in 0.5..10.0_f64, share in 0.05..0.95_f64, omega in 0.0..180.0_f64) {
        let (cutter, omega) = (toroidal(outer, share), omega.to_radians());
        let contact = Contact::from_vectors([1.0, 0.0, 0.0], [0.0, omega.sin(), -omega.cos()], None).unwrap();
        let (core, corner) = (cutter.core_radius().mm(), cutter.corner_radius().mm());
        let found = EffectiveRadius::across_feed(cutter, contact).finite().unwrap().mm();
        assert_abs_diff_eq!(found, core * omega.cos().powi(2) + corner, epsilon = 1e-14 * outer);
    }

    /// Towards a wall, the radii of a feed that is fixed in the surface tend to those on the wall, without a jump: they
    /// change with cos^2 S.
    #[test]
    fn radii_are_continuous_towards_walls(outer in 0.5..10.0_f64, share in 0.05..0.95_f64, omega in 0.0..180.0_f64, from_wall in 1e-7..1e-3_f64) {
        let (cutter, omega) = (toroidal(outer, share), omega.to_radians());
        let near = |tilt: f64| {
            let (sin, cos) = (tilt.cos(), tilt.sin());
            let feed = [cos * omega.cos(), omega.sin(), -sin * omega.cos()];
            let contact = Contact::from_vectors([sin, 0.0, cos], feed, None).unwrap();
            EffectiveRadius::across_feed(cutter, contact).finite().unwrap().mm()
        };
        // (R - r) cos^2(omega) (1/sin S - 1), and 1/sin S - 1 is cos^2(S) / 2 to the next order.
        prop_assert!((near(from_wall) - near(0.0)).abs() <= outer * (from_wall * from_wall + 1e-13));
    }
}

#[test]
fn at_walls_the_two_radii_are_the_corners_and_the_cutters() {
    let cutter = toroidal(5.0, 0.4);
    for (alpha, expected) in [(90.0, (2.0, 5.0)), (270.0, (2.0, 5.0)), (0.0, (5.0, 2.0)), (180.0, (5.0, 2.0))] {
        let contact = Contact::from_degrees(90.0, alpha).unwrap();
        let radii = [EffectiveRadius::across_feed(cutter, contact), EffectiveRadius::along_feed(cutter, contact)];
        let [a, t] = radii.map(|radius| radius.finite().unwrap().mm());
        assert_eq!((a, t), expected, "{alpha}");
    }
    let ball = Cutter::ball_end(mm(10.0));
    for slope in [0.0, 45.0, 90.0] {
        assert_eq!((across(ball, slope, 17.0), along(ball, slope, 17.0)), (5.0, 5.0));
    }
}
