//! Laws of heights: symmetry, limits, monotony, and the height on a curved surface by an independent method.

use crate::laws::passes::{BOTH, at, curved, evaluated, feed_angles, has_lobes, height, is_settled, mm, passes, plane_passes, slopes};
use approx::assert_relative_eq;
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, NoAnswer, Pass, Runout, StepOver, SurfaceCurvature};

/// Normal and feed of a contact in a frame turned about the tool axis, by the definition of the angles. The slope tilts
/// the normal downhill. The feed follows the surface and is, seen from above, at `alpha` from downhill.
fn vectors(slope: f64, alpha: f64, turn: f64) -> ([f64; 3], [f64; 3]) {
    let [s, a, t] = [slope, alpha, turn].map(f64::to_radians);
    let normal = [s.sin() * t.cos(), s.sin() * t.sin(), s.cos()];
    let seen_from_above = [(t + a).cos(), (t + a).sin()];
    let rise = -(normal[0] * seen_from_above[0] + normal[1] * seen_from_above[1]) / normal[2];
    (normal, [seen_from_above[0], seen_from_above[1], rise])
}

/// Asserts that both passes have heights within `epsilon` of each other, or that neither has one.
fn assert_same_heights(a: Pass, b: Pass, step_over: f64, feed: f64, epsilon: f64) {
    for model in BOTH {
        if EvaluatedPass::new(model, a).is_ok_and(|evaluated| !is_settled(&evaluated, step_over, feed)) {
            continue;
        }
        let find = |pass: Pass| EvaluatedPass::new(model, pass).and_then(|evaluated| height(&evaluated, step_over, feed));
        match (find(a), find(b)) {
            (Ok(one), Ok(other)) => {
                let epsilon = if model == Model::Envelope && has_lobes(&a) { epsilon.max(0.02) } else { epsilon };
                assert_relative_eq!(one, other, max_relative = epsilon);
            }
            (one, other) => assert_eq!(one.is_err(), other.is_err(), "{model:?}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// The tolerance of 1e-12: adding 180 to an angle in degrees rounds it by 3e-14 deg, and effective radii change by
    /// some multiples of that. Slopes are at most 89 deg, because slopes of 89.9 deg magnify the error by a few
    /// hundred.
    #[test]
    fn the_feeds_sign_and_sense_do_not_matter(pass in passes(), slope in 1.0..89.0_f64, alpha in feed_angles(), step_over in 0.02..0.6_f64, feed in 0.0..0.2_f64) {
        for same in [alpha + 180.0, alpha - 180.0, -alpha] {
            assert_same_heights(at(pass, slope, alpha), at(pass, slope, same), step_over, feed.max(1e-3), 1e-12);
        }
    }

    /// The feed's rise is a quotient by cos S, so its roundings of 1e-16 grow to 1e-16 / cos^2 S = 3e-13 at 89 deg.
    #[test]
    fn angles_and_vectors_agree(pass in passes(), slope in 1.0..89.0_f64, alpha in feed_angles(), turn in 0.0..360.0_f64, step_over in 0.02..0.6_f64, feed in 1e-3..0.2_f64) {
        let (normal, along) = vectors(slope, alpha, turn);
        let by_vectors = Contact::from_vectors(normal.map(|c| 3.0 * c), along.map(|c| 0.01 * c), None).unwrap();
        assert_same_heights(at(pass, slope, alpha), Pass { contact: by_vectors, ..pass }, step_over, feed, 1e-10);
    }

    /// On a wall, heights depend on the feed's inclination in the surface, which vectors state and alpha does not.
    #[test]
    fn on_walls_vectors_agree_with_the_angles_of_level_and_vertical_feeds(pass in passes(), turn in 0.0..360.0_f64, step_over in 0.02..0.6_f64, feed in 1e-3..0.2_f64) {
        let t = turn.to_radians();
        let normal = [t.cos(), t.sin(), 0.0];
        for (along, alpha) in [([0.0, 0.0, 1.0], 0.0), ([-t.sin(), t.cos(), 0.0], 90.0)] {
            let contact = Contact::from_vectors(normal, along, None).unwrap();
            assert_same_heights(at(pass, 90.0, alpha), Pass { contact, ..pass }, step_over, feed, 1e-10);
        }
    }

    /// The steps are up to a fifth of the diameter each, and their diagonal up to 0.283 of it. Half of the diagonal is
    /// at an angle of asin(0.283) = 16.4 deg from the ball's centre, so that at slopes up to 70 deg the cutter's side,
    /// which the envelope includes, does not matter.
    #[test]
    fn a_ball_ends_height_does_not_depend_on_slope_and_direction(diameter in 1.0..20.0_f64, slope in 0.0..70.0_f64, wall in slopes(), alpha in feed_angles(), s in 0.01..0.2_f64, f in 0.01..0.2_f64) {
        let contact = Contact::from_degrees(0.0, 0.0).unwrap();
        let floor = Pass { cutter: Cutter::ball_end(mm(diameter)), contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
        let (s, f) = (s * diameter, f * diameter);
        assert_same_heights(floor, at(floor, slope, alpha), s, f, 1e-12);
        let analytic = |pass| height(&evaluated(Model::Analytic, pass), s, f).unwrap();
        assert_relative_eq!(analytic(floor), analytic(at(floor, wall, alpha)), max_relative = 1e-14);
    }

    /// The surface falls by at most s^2 / (2 rho) over a step-over, and the envelope's height changes by at most as
    /// much; with a circle in place of the cutter by less. The normal turns by s / rho between the passes, which moves
    /// the cutter's axis along the level line by s (R - r)/(rho sin(S)).
    #[test]
    fn a_curved_surface_tends_to_a_plane_as_its_radius_grows(pass in plane_passes(), share in 0.01..1.0_f64, sign in prop_oneof![Just(1.0), Just(-1.0)]) {
        let radius = evaluated(Model::Analytic, pass).effective_radius().unwrap().mm();
        let s = share * radius.min(pass.cutter.outer_radius().mm());
        for model in BOTH {
            let flat = height(&evaluated(model, pass), s, 0.0).unwrap();
            for rho in [1e5, 1e7, 1e9] {
                if sign < 0.0 && s / rho > pass.contact.slope().cos() && pass.contact.slope().cos() > 0.0 {
                    // Within a step-over such a surface turns beyond vertical, where the cutter does not reach.
                    continue;
                }
                let bent = EvaluatedPass::new(model, curved(pass, sign * rho)).and_then(|evaluated| height(&evaluated, s, 0.0));
                match bent {
                    Ok(bent) => {
                        // The last term is the rounding of the envelope's search.
                        // The normal turns by s/rho between the passes, which moves the cutters' axes apart and counts
                        // by the smaller of sine and cosine of the slope. On floor and wall no turn is allowed.
                        let (sin, cos) = (pass.contact.slope().sin(), pass.contact.slope().cos());
                        let apart = s * pass.cutter.core_radius().mm() / (rho * (sin * cos).max(f64::MIN_POSITIVE));
                        let apart = if model == Model::Envelope { apart } else { 0.0 };
                        let most = 1.01 * s * s / (2.0 * rho) + apart + 1e-12 * flat;
                        prop_assert!((bent - flat).abs() <= most, "{model:?} {rho}: {bent} {flat}");
                    }
                    // On a wall that is concave along its steepest line, the cutter's straight side gouges at any
                    // radius.
                    Err(NoAnswer::Gouges { smallest_radius: None }) if pass.contact.slope().cos() == 0.0 => prop_assert!(sign < 0.0),
                    // The cutter's side leaves less than the depth of the hollow.
                    Err(_) => prop_assert!(sign < 0.0 && flat <= 1.01 * s * s / (2.0 * rho), "{model:?} {rho}"),
                }
            }
        }
    }

    #[test]
    fn heights_rise_with_step_over_and_feed(pass in passes(), s in 0.02..1.0_f64, f in 0.01..0.4_f64, more in 1.001..1.5_f64) {
        for model in BOTH {
            let Ok(evaluated) = EvaluatedPass::new(model, pass) else { continue };
            let Ok(low) = height(&evaluated, s, f) else { continue };
            if [(s, f), (s * more, f), (s, f * more)].into_iter().any(|(s, f)| !is_settled(&evaluated, s, f)) {
                continue;
            }
            // On a wall the cylinder leaves no height along its axis, and little near that direction. Heights there
            // must only not fall by more than the rounding of the search.
            let near_wall = pass.contact.slope().degrees() > 85.0;
            // With runout, the height is constant up to the step-over at which the offsets of deep marks and those of all
            // marks meet.
            let may_be_level = model == Model::Envelope && (near_wall || pass.runout != Runout::NONE);
            // Heights come from distances to the cutter's axis, which are rounded to 1e-16 of its radius.
            let rounding = f64::EPSILON * pass.cutter.outer_radius().mm();
            let rises = |low: f64, high: f64| high > low || may_be_level && high >= low * (1.0 - 1e-12) - rounding;
            if let Ok(wider) = height(&evaluated, s * more, f) {
                prop_assert!(rises(low, wider), "{model:?}: step-over {low} {wider}");
            }
            // If the feed climbs, axial runout larger than the feed can shorten the distance between marks.
            if pass.runout == Runout::NONE && let Ok(longer) = height(&evaluated, s, f * more) {
                prop_assert!(rises(low, longer), "{model:?}: feed {low} {longer}");
            }
        }
    }

    /// The height and the chord of a circle, by Pythagoras' theorem instead of the formulas.
    #[test]
    fn on_a_plane_the_height_is_that_of_circles(pass in plane_passes(), share in 0.01..0.99_f64) {
        let analytic = evaluated(Model::Analytic, pass);
        let radius = analytic.effective_radius().unwrap().mm();
        let s = (2.0 * radius).min(2.0 * pass.cutter.outer_radius().mm() / pass.contact.spacing_ratio()) * share;
        let h = height(&analytic, s, 0.0).unwrap();
        // The circle about (0, R) passes through (s/2, h). Each square is rounded to 1e-16 of R^2.
        prop_assert!(((radius - h).powi(2) + (s / 2.0).powi(2) - radius * radius).abs() <= 1e-14 * radius * radius);
        prop_assert!(h <= radius);
        let back = analytic.max_step_over(mm(h), None).unwrap().mm();
        // h rises with s^2, and faster near a half circle, so the relative error of s is at most that of h.
        assert_relative_eq!(back, s, max_relative = 1e-13);
    }

    #[test]
    fn the_step_over_seen_from_above_is_the_projection_of_the_one_along_the_surface(turn in 0.0..360.0_f64, slope in 1.0..89.0_f64, alpha in feed_angles(), d in 0.01..1.0_f64) {
        // The step from pass to pass is perpendicular to the normal and the feed; seen from above, its component across
        // the feed counts.
        let (n, f) = vectors(slope, alpha, turn);
        let step = [n[1] * f[2] - n[2] * f[1], n[2] * f[0] - n[0] * f[2], n[0] * f[1] - n[1] * f[0]];
        let length = step.iter().map(|c| c * c).sum::<f64>().sqrt();
        let across = (step[0] * -f[1] + step[1] * f[0]).abs() / f[0].hypot(f[1]);
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        assert_relative_eq!(contact.spacing_ratio(), across / length, max_relative = 1e-12);
        let s = StepOver::SeenFromAbove(mm(d)).along_surface(contact).unwrap().mm();
        assert_relative_eq!(s * across / length, d, max_relative = 1e-12);
    }

    /// Circles of radius `R_eff` that touch the curved surface s apart meet at h1 above it. Here they are placed in the
    /// plane, and their intersection on the line of symmetry is found by bisection, without the law of cosines.
    #[test]
    fn on_a_curved_surface_the_height_is_where_two_placed_circles_meet(pass in plane_passes(), rho in prop_oneof![1.0..1e3_f64, -1e3..-1.0_f64], s in 0.05..1.0_f64) {
        let bent = curved(pass, rho);
        let Ok(model) = EvaluatedPass::new(Model::Analytic, bent) else { return Ok(()) };
        let Ok(found) = height(&model, s, 0.0) else { return Ok(()) };
        let effective = model.effective_radius().unwrap().mm();
        // The surface's centre at the origin; the contact at the half angle beta from the line of symmetry, the y axis.
        let beta = (s / (2.0 * rho.abs())).asin();
        // The outside of the part is away from the centre on a hill and towards it in a hollow: the cutter's centre is
        // rho + R_eff from the surface's centre.
        let centre = rho + effective;
        let (x, y) = (centre * beta.sin(), centre * beta.cos());
        let inside = |h: f64| x.hypot(y - (rho + h)) <= effective;
        // At the surface the point is outside the circle, at its centre's height inside; otherwise the circles do not
        // meet.
        let (mut low, mut high) = (0.0, y - rho);
        prop_assume!(high > 0.0 && !inside(low) && inside(high));
        for _ in 0..200 {
            let middle = f64::midpoint(low, high);
            if inside(middle) { high = middle } else { low = middle }
        }
        // The distance is rounded to 1e-16 of |rho| + R_eff, and its derivative by h is at least 0.01 unless the
        // circles meet at a grazing angle.
        let rate = (y - (rho + found)) / effective;
        let epsilon = 8.0 * f64::EPSILON * (rho.abs() + effective) / rate.max(0.01);
        prop_assert!((found - low).abs() <= epsilon, "{found} {low} within {epsilon}");
    }
}
