//! Model `envelope` on curved surfaces: limits, symmetries, monotony, agreement with other formulas, and gouging.

use crate::laws::passes::{at, cutters, feed_angles, has_lobes, height, is_settled, mm, toroidal};
use approx::assert_relative_eq;
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, NoAnswer, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Angle;
use std::num::NonZeroU32;

/// Toroidal, ball-end and flat-end cutters of 1 to 20 mm.
fn all_cutters() -> impl Strategy<Value = Cutter> {
    (0.5..10.0_f64, prop_oneof![1 => Just(0.0), 4 => 0.05..0.95_f64, 1 => Just(1.0)]).prop_map(|(outer, ratio)| {
        if ratio <= 0.0 {
            Cutter::flat_end(mm(2.0 * outer))
        } else if ratio >= 1.0 {
            Cutter::ball_end(mm(2.0 * outer))
        } else {
            toroidal(outer, ratio)
        }
    })
}

fn on(cutter: Cutter, contact: Contact, surface: SurfaceCurvature) -> Pass {
    Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }
}

fn angle(degrees: f64) -> Angle {
    Angle::from_degrees(degrees).unwrap()
}

fn envelope(pass: Pass) -> Result<EvaluatedPass, NoAnswer> {
    EvaluatedPass::new(Model::Envelope, pass)
}

/// Principal curvatures as shares of 1/R, of both signs, and their direction.
fn bends() -> impl Strategy<Value = ([f64; 2], f64)> {
    ((-0.3..0.5_f64, -0.3..0.5_f64).prop_map(|(one, other)| [one, other]), 0.0..180.0_f64)
}

fn bent(cutter: Cutter, (shares, turn): ([f64; 2], f64)) -> SurfaceCurvature {
    SurfaceCurvature::from_principal_per_mm(shares.map(|share| share / cutter.outer_radius().mm()), angle(turn)).unwrap()
}

/// The curvature of a surface in the axes of a feed that is turned by `degrees` in the tangent plane. Relative to the
/// feed, both principal directions turn the other way.
fn turned(principal: [f64; 2], direction: f64, degrees: f64) -> SurfaceCurvature {
    SurfaceCurvature::from_principal_per_mm(principal, angle(direction - degrees)).unwrap()
}

/// Whether the inverse `back` of the height at `value` is `value`, or lies beyond a fall of the height by less than 3 %.
fn comes_back(back: f64, value: f64, height: impl Fn(f64) -> f64) -> bool {
    if (back / value - 1.0).abs() <= 1e-9 {
        return true;
    }
    let tolerance = height(value);
    let between = (0..100).map(|number| value + (back - value) * f64::from(number) / 100.0);
    let is_same = (height(back) / tolerance - 1.0).abs() <= 1e-9;
    back > value && is_same && between.map(height).all(|height| height < 1.03 * tolerance)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Over 20 mm, surfaces with radii of at least 1e9 mm differ from a plane by at most 2e-7 mm, and at the ridge by
    /// s^2/(8 radius).
    #[test]
    fn heights_tend_to_those_of_the_plane(
        cutter in all_cutters(), slope in 1.0..89.0_f64, alpha in feed_angles(), s in 0.02..0.5_f64, f in 0.01..0.3_f64, turn in 0.0..180.0_f64,
    ) {
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let (s, f) = (s * cutter.outer_radius().mm(), f * cutter.outer_radius().mm());
        let flat = height(&envelope(on(cutter, contact, SurfaceCurvature::PLANE)).unwrap(), s, f);
        let Ok(flat) = flat else { return Ok(()) };
        // A curvature of 0 in components is the plane itself.
        let zero = SurfaceCurvature::from_components_per_mm(0.0, 0.0, -0.0).unwrap();
        assert_relative_eq!(height(&envelope(on(cutter, contact, zero)).unwrap(), s, f).unwrap(), flat, max_relative = 1e-12);
        for curvature in [1e-9, 1e-10, -1e-10, 1e-12, -1e-12, 1e-13, -1e-13, 1e-15, -1e-15, 1e-300] {
            let surface = SurfaceCurvature::from_principal_per_mm([curvature, -curvature / 2.0], angle(turn)).unwrap();
            let bent = height(&envelope(on(cutter, contact, surface)).unwrap(), s, f).unwrap();
            // At most 20 mm from the contact: 200 mm^2 times the curvature.
            prop_assert!((bent - flat).abs() <= 1e-12 * flat + 200.0 * curvature.abs(), "{bent} {flat} at {curvature}");
        }
    }

    /// The height depends neither on the form in which the curvature is stated, nor on the direction of the feed along
    /// its line, nor on a reflection in the plane of normal and steepest line. Sharp edges are left out: see
    /// `the_inverses_leave_the_tolerance`.
    #[test]
    fn curvature_may_be_stated_by_components_or_by_principal_directions(
        cutter in cutters(), slope in 1.0..89.0_f64, alpha in feed_angles(), bend in bends(), s in 0.02..0.3_f64, f in 0.01..0.2_f64,
    ) {
        let surface = bent(cutter, bend);
        let components =
            SurfaceCurvature::from_components_per_mm(surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        // The same line fed the other way, and feed and surface mirrored at the steepest line.
        let back = Contact::from_degrees(slope, alpha + 180.0).unwrap();
        let mirrored = Contact::from_degrees(slope, -alpha).unwrap();
        let untwisted =
            SurfaceCurvature::from_components_per_mm(surface.along_per_mm(), surface.across_per_mm(), -surface.twist_per_mm()).unwrap();
        let (s, f) = (s * cutter.outer_radius().mm(), f * cutter.outer_radius().mm());
        let find = |contact, surface| envelope(on(cutter, contact, surface)).and_then(|evaluated| height(&evaluated, s, f));
        let Ok(found) = find(contact, surface) else { return Ok(()) };
        if !is_settled(&envelope(on(cutter, contact, surface)).unwrap(), s, f) {
            return Ok(());
        }
        for same in [find(contact, components), find(back, surface), find(mirrored, untwisted)] {
            let epsilon = if has_lobes(&on(cutter, contact, surface)) { 0.02 } else { 1e-10 };
            assert_relative_eq!(same.unwrap(), found, max_relative = epsilon);
        }
    }

    /// A ball is the same in every direction: with K turned along with the feed, the height does not change.
    #[test]
    fn a_ball_end_cutters_height_depends_only_on_the_curvature_in_the_feeds_axes(
        radius in 0.5..10.0_f64, slope in 0.0..50.0_f64, alpha in feed_angles(), bend in bends(), turn in 0.0..180.0_f64,
        s in 0.02..0.3_f64, f in 0.01..0.2_f64,
    ) {
        let cutter = Cutter::ball_end(mm(2.0 * radius));
        let (s, f) = (s * radius, f * radius);
        let surface = bent(cutter, bend);
        let find = |slope, alpha| envelope(on(cutter, Contact::from_degrees(slope, alpha).unwrap(), surface)).and_then(|evaluated| height(&evaluated, s, f));
        let (Ok(one), Ok(other)) = (find(slope, alpha), find(0.0, alpha + turn)) else { return Ok(()) };
        assert_relative_eq!(one, other, max_relative = 1e-10);
    }

    /// The relative curvature lambda belongs to the contact, not to the feed: a feed turned in the tangent plane, with
    /// the curvature stated in its axes, has the same lambda.
    #[test]
    fn the_relative_curvature_does_not_depend_on_the_feed(
        cutter in all_cutters(), slope in 5.0..85.0_f64, bend in bends(), omega in 0.0..180.0_f64, turn in 0.0..180.0_f64,
    ) {
        let by_omega = |omega: f64| {
            let (slope, omega) = (angle(slope), angle(omega));
            let feed = [slope.cos() * omega.cos(), omega.sin(), -slope.sin() * omega.cos()];
            Contact::from_vectors([slope.sin(), 0.0, slope.cos()], feed, None).unwrap()
        };
        let principal = bend.0.map(|share| share / cutter.outer_radius().mm());
        let find = |turn: f64| envelope(on(cutter, by_omega(omega + turn), turned(principal, bend.1, turn))).map(|evaluated| evaluated.relative_curvature());
        match (find(0.0), find(turn)) {
            (Ok(one), Ok(other)) => approx::assert_abs_diff_eq!(one, other, epsilon = 1e-12 * (1.0 + one.abs())),
            (one, other) => prop_assert!(one.is_err() && other.is_err(), "{one:?} {other:?}"),
        }
    }

    /// Sharp edges are left out: see `the_inverses_leave_the_tolerance`.
    #[test]
    fn heights_rise_with_step_over_and_feed(
        cutter in cutters(), slope in 1.0..85.0_f64, alpha in feed_angles(), bend in bends(), s in 0.01..0.4_f64, f in 0.01..0.2_f64,
        more in 1.001..1.5_f64,
    ) {
        let Ok(evaluated) = envelope(on(cutter, Contact::from_degrees(slope, alpha).unwrap(), bent(cutter, bend))) else { return Ok(()) };
        let (s, f) = (s * cutter.outer_radius().mm(), f * cutter.outer_radius().mm());
        let Ok(low) = height(&evaluated, s, f) else { return Ok(()) };
        if [(s, f), (s * more, f), (s, f * more)].into_iter().any(|(s, f)| !is_settled(&evaluated, s, f)) {
            return Ok(());
        }
        for higher in [height(&evaluated, s * more, f), height(&evaluated, s, f * more)].into_iter().flatten() {
            prop_assert!(higher >= low * (1.0 - 1e-12), "{low} {higher}");
        }
    }

    /// The height at both inverses is the tolerance. An inverse whose part of the height is under a thousandth is not
    /// compared. Cutters with a sharp edge are left out: on a surface that is concave along the feed their section has
    /// two lobes, and a search may find either, so that heights differ by up to 3 % (one in some 5,000 inputs).
    ///
    /// With the feed along a level line, a height can fall by up to 3 % where another ridge becomes the one that is found
    /// (one in some 35,000 inputs), and more where no ridge of turned marks is found, of which a warning tells. The inverse
    /// is then a larger length with the same height.
    #[test]
    fn the_inverses_leave_the_tolerance(
        cutter in cutters(), slope in 10.0..85.0_f64, alpha in feed_angles(), bend in bends(), s in 0.02..0.3_f64, f in 0.02..0.2_f64,
    ) {
        let Ok(evaluated) = envelope(on(cutter, Contact::from_degrees(slope, alpha).unwrap(), bent(cutter, bend))) else { return Ok(()) };
        let (s, f) = (s * cutter.outer_radius().mm(), f * cutter.outer_radius().mm());
        let Ok(found) = evaluated.scallop_height(mm(s), Some(mm(f))) else { return Ok(()) };
        if !is_settled(&evaluated, s, f) {
            return Ok(());
        }
        // In a close fit the section has lobes beside the contact. Slopes near the floor, where the same occurs, are left
        // out.
        prop_assume!(evaluated.relative_curvature() > 0.6);
        prop_assume!(found.feed.mm() > 1e-3 * found.total().mm() && found.step_over.mm() > 1e-3 * found.total().mm());
        let (step_over, feed) = (evaluated.max_step_over(found.total(), Some(mm(f))), evaluated.max_feed_per_tooth(found.total(), mm(s)));
        let height_of = |s: f64, f: f64| height(&evaluated, s, f).unwrap();
        let (step_over, feed) = (step_over.unwrap().mm(), feed.unwrap().mm());
        let keeps = |height: f64| height <= found.total().mm() * (1.0 + 1e-9);
        let is_warned = |s: f64, f: f64| !is_settled(&evaluated, s, f) && keeps(height_of(s, f));
        let is_larger = step_over > s && is_warned(step_over, f);
        prop_assert!(is_larger || comes_back(step_over, s, |s| height_of(s, f)), "{step_over} {s}");
        let is_larger = feed > f && is_warned(s, feed);
        prop_assert!(is_larger || comes_back(feed, f, |f| height_of(s, f)), "{feed} {f}");
    }

    /// Circles of the radius R placed on a sphere, s apart and f apart, meet over the middle of the rectangle between
    /// them. Model `envelope` has the same height to second order, so that the difference is of the fourth order.
    #[test]
    fn a_ball_end_cutter_on_a_sphere_agrees_with_placed_spheres(
        radius in 0.5..10.0_f64, slope in 0.0..60.0_f64, alpha in feed_angles(), share in 0.01..0.1_f64, marks in 0.01..0.1_f64,
        roundness in prop_oneof![1.5..50.0_f64, -50.0..-1.5_f64],
    ) {
        let (cutter, rho) = (Cutter::ball_end(mm(2.0 * radius)), roundness * radius);
        let surface = SurfaceCurvature::from_components_per_mm(rho.recip(), rho.recip(), 0.0).unwrap();
        let found = height(&envelope(on(cutter, Contact::from_degrees(slope, alpha).unwrap(), surface)).unwrap(), share * radius, marks * radius).unwrap();
        // The middle is half a diagonal from each contact; the cutter's centre is rho + R from the sphere's.
        let half = share.hypot(marks) * radius / 2.0;
        let (sin, cos) = (half / rho, (1.0 - (half / rho).powi(2)).sqrt());
        let (aside, up) = ((rho + radius) * sin, (rho + radius) * cos);
        let exact = up - (radius * radius - aside * aside).sqrt() - rho;
        // Parabola and circle differ by half^4 / (8 radius^3). The rounding errors of rho + R matter for small heights.
        let smallest = radius.min(rho.abs());
        prop_assert!((found - exact).abs() <= 2.0 * half.powi(4) / smallest.powi(3) + 1e-14 * rho.abs(), "{found} {exact}");
    }

    /// [Segonds 2017, eq. 9-12] is the law of cosines in the plane across the feed. Down the slope or along it, with
    /// the surface curved across the feed alone, the groove is symmetric, and both agree as long as a circle
    /// approximates the cutter: the differences are of the order s^2/R^2.
    #[test]
    fn a_cylinder_across_the_feed_agrees_with_the_published_formula(
        outer in 1.0..10.0_f64, ratio in 0.1..1.0_f64, slope in 15.0..70.0_f64, across in prop::bool::ANY, share in 1e-3..0.03_f64,
        roundness in prop_oneof![3.0..50.0_f64, -50.0..-3.0_f64],
    ) {
        let cutter = if ratio > 0.99 { Cutter::ball_end(mm(2.0 * outer)) } else { toroidal(outer, ratio) };
        let contact = Contact::from_degrees(slope, if across { 90.0 } else { 0.0 }).unwrap();
        let largest = (cutter.core_radius().mm() / slope.to_radians().sin()) + cutter.corner_radius().mm();
        let pass = on(cutter, contact, SurfaceCurvature::from_radius_mm(roundness * largest).unwrap());
        let s = share * cutter.corner_radius().mm();
        let [published, found] = [Model::Analytic, Model::Envelope].map(|model| height(&EvaluatedPass::new(model, pass).unwrap(), s, 0.0).unwrap());
        // The profile's curvature changes by tan(70 deg) = 2.7 times s/r, whose odd part cancels between the flanks;
        // its square stays, on a relative curvature of 2/3 of the cutter's or more.
        assert_relative_eq!(found, published, max_relative = 40.0 * share * share + 1e-9);
    }

    /// A contact of a tilted tool is the contact of the upright one in the tool's frame. Sharp edges are left out, as
    /// above.
    #[test]
    fn a_tilted_tool_leaves_the_height_of_the_upright_one(
        cutter in cutters(), slope in 1.0..89.0_f64, alpha in feed_angles(), bend in bends(), s in 0.02..0.3_f64, f in 0.01..0.2_f64,
        (roll, pitch, yaw) in (-3.0..3.0_f64, -1.5..1.5_f64, -3.0..3.0_f64),
    ) {
        let (tilt, turn) = (slope.to_radians(), alpha.to_radians());
        let normal = Vector3::new(tilt.sin(), 0.0, tilt.cos());
        let feed = Vector3::new(turn.cos() * tilt.cos(), turn.sin(), -turn.cos() * tilt.sin());
        let rotation = Rotation3::from_euler_angles(roll, pitch, yaw);
        let rotated = [normal, feed, Vector3::z()].map(|vector| <[f64; 3]>::from(rotation * vector));
        let upright = Contact::from_vectors(normal.into(), feed.into(), None).unwrap();
        let tilted = Contact::from_vectors(rotated[0], rotated[1], Some(rotated[2])).unwrap();
        let (s, f) = (s * cutter.outer_radius().mm(), f * cutter.outer_radius().mm());
        let find = |contact| envelope(on(cutter, contact, bent(cutter, bend))).and_then(|evaluated| height(&evaluated, s, f));
        if envelope(on(cutter, upright, bent(cutter, bend))).is_ok_and(|evaluated| !is_settled(&evaluated, s, f)) {
            return Ok(());
        }
        match (find(upright), find(tilted)) {
            // A rotation carries roundings of 1e-15, which slopes within 1 deg of wall or floor magnify by 57.
            (Ok(one), Ok(other)) => {
                let epsilon = if has_lobes(&on(cutter, upright, bent(cutter, bend))) { 0.02 } else { 1e-9 };
                assert_relative_eq!(one, other, max_relative = epsilon);
            }
            (one, other) => prop_assert!(one.is_err() && other.is_err(), "{one:?} {other:?}"),
        }
    }
}

/// Troughs, bowls and saddles, some of which the cutter fits and some not, in every direction of the feed.
/// Deep and alternating marks of a flat-end cutter fed along the level line clear parts of the step-over that do not meet.
#[test]
fn runout_of_a_flat_end_cutter_counts_on_a_hardly_concave_surface_as_on_a_plane() {
    let cutter = Cutter::flat_end(mm(6.272));
    let contact = Contact::from_degrees(32.964, 90.0).unwrap();
    let runout = Runout::NONE.with_radial_mm(0.004_132).unwrap().with_axial_mm(0.002_573).unwrap();
    let heights = |surface| {
        let evaluated = envelope(Pass { runout, teeth: NonZeroU32::new(2), ..on(cutter, contact, surface) }).unwrap();
        [0.0055, 0.006, 0.00654].map(|step_over| height(&evaluated, step_over, 0.18043).unwrap())
    };
    let concave = heights(SurfaceCurvature::from_components_per_mm(-3e-6, -3e-6, 0.0).unwrap());
    for (concave, plane) in concave.into_iter().zip(heights(SurfaceCurvature::PLANE)) {
        assert_relative_eq!(concave, plane, max_relative = 1e-4);
    }
}

#[test]
fn troughs_bowls_and_saddles_gouge_whatever_the_feeds_direction() {
    let cutter = toroidal(6.0, 1.0 / 6.0);
    // The cutter's radii at 30 deg are 1 and 5/sin(30 deg) + 1 = 11 mm.
    for (name, principal, gouges) in [
        ("trough of 10 mm, level", [-0.1, 0.0], true),
        ("trough of 40 mm, level", [-0.025, 0.0], false),
        ("bowl of 10 mm", [-0.1, -0.1], true),
        ("bowl of 40 mm", [-0.025, -0.025], false),
        ("saddle of 10 mm", [-0.1, 0.1], true),
        ("saddle of 40 mm", [-0.025, 0.025], false),
    ] {
        for alpha in [0.0, 30.0, 45.0, 90.0, 120.0] {
            let contact = Contact::from_degrees(30.0, alpha).unwrap();
            // The direction of the first principal curvature is the level line, a quarter turn from the steepest one.
            let surface = SurfaceCurvature::from_principal_per_mm(principal, angle(90.0 - contact.omega().degrees())).unwrap();
            for model in [Model::Analytic, Model::Envelope] {
                let found = EvaluatedPass::new(model, on(cutter, contact, surface)).map(|evaluated| evaluated.relative_curvature());
                match found {
                    Err(NoAnswer::Gouges { smallest_radius: Some(smallest) }) if gouges => {
                        assert_relative_eq!(smallest.mm(), 11.0, max_relative = 1e-12);
                    }
                    Ok(lambda) if !gouges => assert_relative_eq!(lambda, 1.0 - 11.0 / 40.0, max_relative = 1e-12),
                    other => panic!("{name}, alpha {alpha}, {model:?}: {other:?}"),
                }
            }
        }
    }
}

/// The cutter fits at the stated smallest radius, and gouges at one smaller by 2 %.
#[test]
fn the_cutter_fits_at_the_stated_smallest_radius() {
    for slope in [0.5, 3.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0, 89.0] {
        for alpha in [0.0, 15.0, 30.0, 60.0, 90.0, 140.0] {
            for shape in [[-1.0, 0.0], [-1.0, -0.6], [-1.0, 0.3]] {
                let at_radius = |radius: f64| {
                    let surface = SurfaceCurvature::from_principal_per_mm(shape.map(|bend| bend / radius), angle(25.0)).unwrap();
                    envelope(on(toroidal(5.0, 0.4), Contact::from_degrees(slope, alpha).unwrap(), surface)).map(|_| ())
                };
                let place = format!("slope {slope}, alpha {alpha}, {shape:?}");
                let Err(NoAnswer::Gouges { smallest_radius: Some(smallest) }) = at_radius(1.0) else { panic!("{place}") };
                assert_eq!(at_radius(smallest.mm() * (1.0 + 1e-9)), Ok(()), "{place}");
                let Err(NoAnswer::Gouges { smallest_radius: Some(again) }) = at_radius(smallest.mm() * 0.98) else { panic!("{place}") };
                assert_relative_eq!(again.mm(), smallest.mm(), max_relative = 0.011);
            }
        }
    }
}

/// Near the contact the cutter fits (lambda is 0.95), but its flat cuts into the far side of the trough.
#[test]
fn level_troughs_gouge_away_from_the_contact() {
    let cutter = toroidal(6.0, 1.0 / 6.0);
    for (radius, alpha) in [(20.0, 0.0), (20.0, 35.0), (20.0, 90.0), (40.0, 0.0), (40.0, 35.0), (40.0, 90.0)] {
        let contact = Contact::from_degrees(5.0, alpha).unwrap();
        // The trough runs along the level line, so that it is curved along the steepest one.
        let surface = SurfaceCurvature::from_principal_per_mm([-1.0 / radius, 0.0], angle(-contact.omega().degrees())).unwrap();
        for model in [Model::Analytic, Model::Envelope] {
            let found = EvaluatedPass::new(model, on(cutter, contact, surface)).map(|evaluated| evaluated.relative_curvature());
            let Err(NoAnswer::Gouges { smallest_radius: Some(smallest) }) = found else {
                panic!("radius {radius}, alpha {alpha}, {model:?}")
            };
            // The flat's far edge is 10 cos(5 deg) up the slope and 10 sin(5 deg) over the tangent plane, where the trough is
            // 50 cos^2(5 deg) / radius over it. The corner's round reaches a little further.
            let slope = 5.0_f64.to_radians();
            assert_relative_eq!(smallest.mm(), 5.0 * slope.cos().powi(2) / slope.sin(), max_relative = 0.03);
        }
    }
}

/// A step-over that is too wide on a concave surface is not gouging: the stated reason is the distance of the passes,
/// and a smaller step-over has an answer.
#[test]
fn passes_too_far_apart_on_a_concave_surface_do_not_gouge() {
    let pass = on(toroidal(6.0, 1.0 / 6.0), Contact::from_degrees(80.0, 20.0).unwrap(), SurfaceCurvature::from_radius_mm(-60.0).unwrap());
    let evaluated = envelope(pass).unwrap();
    assert!(height(&evaluated, 0.5, 0.1).is_ok());
    assert!(matches!(height(&evaluated, 200.0, 0.1), Err(NoAnswer::PassesDoNotOverlap { .. })));
    let seen_from_above =
        evaluated.max_step_over(mm(0.5), None).map_or(0.0, |widest| widest.mm() * evaluated.pass().contact.spacing_ratio());
    assert!(seen_from_above <= 12.0);
    assert!(envelope(at(pass, 40.0, 0.0)).is_ok());
}
