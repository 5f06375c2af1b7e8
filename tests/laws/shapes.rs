//! Laws for cutters of every shape on planes and curved surfaces.

use crate::laws::passes::mm;
use proptest::prelude::*;
use scallopd::milling::{Contact, Cutter, Envelope, EvaluatedPass, Model, NoAnswer, Pass, ProfileArc, Runout, SurfaceCurvature};
use scallopd::quantity::Angle;
use std::f64::consts::FRAC_PI_2;

fn degrees(value: f64) -> Angle {
    Angle::from_degrees(value).unwrap()
}

/// Tapered balls, lenses, ovals, conical barrels, and cones with a flat or a point as their tip.
fn shapes() -> impl Strategy<Value = Cutter> {
    let cone = |(tip, taper, up): (f64, f64, f64)| {
        let side = FRAC_PI_2 - taper.to_radians();
        let corner = |offset: f64, height: f64, from: f64, to: f64| ProfileArc {
            radius: 0.0,
            centre_offset: offset,
            centre_height: height,
            from,
            to,
        };
        Cutter::from_arcs(&[corner(tip, 0.0, 0.0, side), corner(tip + up, up * side.tan(), side, FRAC_PI_2)]).unwrap()
    };
    prop_oneof![
        (0.5..10.0_f64, 1.0..30.0_f64, 1.0..3.0_f64).prop_map(|(ball, taper, wider)| Cutter::tapered_ball(
            mm(ball),
            degrees(taper),
            mm(wider * ball)
        )
        .unwrap()),
        (4.0..20.0_f64, 1.0..6.0_f64, 0.02..0.4_f64).prop_map(|(diameter, flatter, corner)| Cutter::lens(
            mm(diameter),
            mm(flatter * diameter / 2.0),
            mm(corner * diameter / 2.0)
        )
        .unwrap()),
        (4.0..20.0_f64, 0.1..0.9_f64, 1.0..30.0_f64).prop_map(|(diameter, tip, side)| Cutter::oval(
            mm(diameter),
            mm(tip * diameter / 2.0),
            mm(side * diameter / 2.0)
        )
        .unwrap()),
        (4.0..20.0_f64, 0.1..0.9_f64, 2.0..30.0_f64, 1.0..40.0_f64).prop_map(|(diameter, tip, side, taper)| {
            Cutter::conical_barrel(mm(diameter), mm(tip * diameter / 2.0), mm(side * diameter / 2.0), degrees(taper)).unwrap()
        }),
        (prop_oneof![Just(0.0), 0.5..3.0_f64], 5.0..60.0_f64, 0.5..3.0_f64).prop_map(cone),
    ]
}

proptest! {
    /// Level and nearly level hollows are the commonest contacts of a floor whose curvature is measured.
    #[test]
    fn in_nearly_level_hollows_a_tapered_ball_leaves_what_its_ball_leaves(
        ball in 0.5..10.0_f64, taper in 1.0..30.0_f64, (exponent, alpha) in (-9.0..0.0_f64, -90.0..90.0_f64),
        [along, across] in [-0.02..0.0_f64, -0.02..0.02_f64], (share, marks) in (0.005..0.2_f64, 0.005..0.2_f64),
    ) {
        let surface = SurfaceCurvature::from_components_per_mm(along / ball, across / ball, 0.0).unwrap();
        let contact = Contact::from_degrees(10.0_f64.powf(exponent), alpha).unwrap();
        let height = |cutter: Cutter| {
            let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None };
            // To second order: marks with normals of their own are those of a tapered ball alone.
            let envelope = Envelope::new(pass).unwrap().without_turns();
            envelope.scallop_height(mm(share * ball), Some(mm(marks * ball))).unwrap().total().mm()
        };
        let [of_ball, of_tapered] = [Cutter::ball_end(mm(ball)), Cutter::tapered_ball(mm(ball), degrees(taper), mm(2.0 * ball)).unwrap()].map(height);
        approx::assert_relative_eq!(of_tapered, of_ball, epsilon = 1e-11 * ball, max_relative = 1e-9);
    }

    /// On planes the distance from the body is convex, which makes the search sure for any convex body.
    #[test]
    fn heights_of_every_shape_grow_with_step_over_and_feed_and_have_inverses(
        cutter in shapes(), slope in 0.1..89.0_f64, alpha in -90.0..90.0_f64, share in 0.005..0.5_f64, marks in 0.005..0.2_f64,
        more in 1.0001..1.3_f64,
    ) {
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let pass = Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None };
        let is_cut = slope.to_radians() <= cutter.profile().steepest_cut();
        let Ok(envelope) = EvaluatedPass::new(Model::Envelope, pass) else {
            prop_assert!(!is_cut);
            return Ok(());
        };
        let (s, f) = (share * cutter.outer_radius().mm(), marks * cutter.outer_radius().mm());
        let height = |s: f64, f: f64| envelope.scallop_height(mm(s), Some(mm(f))).map(|height| height.total().mm());
        if let (Ok(h), Ok(wider), Ok(faster)) = (height(s, f), height(s * more, f), height(s, f * more)) {
            let least = h * (1.0 - 1e-9) - 1e-13;
            prop_assert!(wider >= least && faster >= least, "{h} {wider} {faster}");
            let alone = envelope.step_over_height(mm(s)).unwrap().mm();
            prop_assert!(alone <= h * (1.0 + 1e-9) + 1e-13);
            if h > 1e-6 && alone > 0.01 * h {
                let back = envelope.max_step_over(mm(h), Some(mm(f))).unwrap().mm();
                prop_assert!(back >= s * (1.0 - 1e-9), "{back} for {s}");
                let again = height(back, f).unwrap();
                approx::assert_relative_eq!(again, h, max_relative = 1e-9);
            }
        }
    }

    /// On nearly level convex surfaces heights were 0 where the surface's normal turned by a part of the slope within a step-over.
    #[test]
    fn heights_on_nearly_level_convex_surfaces_are_at_least_those_to_second_order_and_grow(
        outer in 1.0..10.0_f64, ratio in 0.05..0.95_f64, slope in (-1.5..0.3_f64).prop_map(|log| 10_f64.powf(log)), alpha in -90.0..90.0_f64,
        (bend, flatter, angle) in ((-4.0..-0.5_f64).prop_map(|log| 10_f64.powf(log)), 0.0..1.0_f64, 0.0..180.0_f64), share in 0.01..0.5_f64,
        more in 1.0001..1.3_f64,
    ) {
        let cutter = Cutter::toroidal(mm(2.0 * outer), mm(ratio * outer)).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm([bend / outer, flatter * bend / outer], degrees(angle)).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let envelope = Envelope::new(Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }).unwrap();
        let s = share * outer;
        let height = |envelope: &Envelope, s: f64| envelope.scallop_height(mm(s), None);
        if let (Ok(h), Ok(wider), Ok(second_order)) = (height(&envelope, s), height(&envelope, s * more), height(&envelope.without_turns(), s)) {
            prop_assert!(h.total().mm() >= 0.9 * second_order.total().mm());
            // Where the normal turns through level between the marks, heights are not bounds.
            if h.largest_turn() < 0.5 && wider.largest_turn() < 0.5 {
                prop_assert!(wider.total().mm() >= h.total().mm() * (1.0 - 1e-9), "{h:?} {wider:?}");
            }
        }
    }

}

/// The least height of the lower body over the surface at points all over it, in radii of the cutter: the arcs, and the flat and the
/// cones between them, up to the end of the last arc that is no corner. The feed runs along the steepest line.
fn least_height_over(cutter: Cutter, slope: f64, surface: SurfaceCurvature) -> f64 {
    let profile = cutter.profile();
    let arcs: Vec<ProfileArc> = profile.arcs().to_vec();
    let touching = arcs.iter().rev().find(|arc| slope >= arc.from).unwrap().point(slope);
    let is_closing = |index: usize| index > 0 && index + 1 == arcs.len() && arcs[index].radius == 0.0;
    let of_arc = |arc: &ProfileArc| (0..=60).map(|step| arc.point(arc.from + (arc.to - arc.from) * f64::from(step) / 60.0)).collect();
    let mut outline: Vec<(f64, f64)> = vec![(0.0, 0.0)];
    for (_, arc) in arcs.iter().enumerate().filter(|(index, _)| !is_closing(*index)) {
        let of_arc: Vec<(f64, f64)> = of_arc(arc);
        let (from, to) = (outline[outline.len() - 1], of_arc[0]);
        outline.extend(
            (1..30).map(|step| f64::from(step) / 30.0).map(|share| (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1))),
        );
        outline.extend(of_arc);
    }
    let height = |(offset, height): (f64, f64), azimuth: f64| {
        let (out, level, up) = (touching.0 - offset * azimuth.cos(), offset * azimuth.sin(), height - touching.1);
        let (normal, steep) = (out * slope.sin() + up * slope.cos(), up * slope.sin() - out * slope.cos());
        let bend =
            surface.along_per_mm() * steep * steep + 2.0 * surface.twist_per_mm() * steep * level + surface.across_per_mm() * level * level;
        normal + bend / 2.0
    };
    let around = (0..240).map(|step| f64::from(step) * std::f64::consts::TAU / 240.0);
    let least = around
        .map(|azimuth| outline.iter().map(|point| height(*point, azimuth)).fold(f64::INFINITY, f64::min))
        .fold(f64::INFINITY, f64::min);
    least / cutter.outer_radius().mm()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// A cutter that fits is nowhere under the surface. One that does not is under the surface that is twice as curved, and deeper
    /// there than rounding.
    #[test]
    fn a_shape_fits_where_no_point_of_it_is_under_the_surface(
        cutter in shapes(), share in prop_oneof![0.0..0.01_f64, 0.0..1.0_f64], (along, across, twist) in (-1.0..0.3_f64, -1.0..1.0_f64, -0.5..0.5_f64), size in -3.0..0.5_f64,
    ) {
        let slope = degrees(0.01 + 84.0 * share);
        let per_radius = 10.0_f64.powf(size) / cutter.outer_radius().mm();
        let curved = |factor: f64| SurfaceCurvature::from_components_per_mm(along * factor * per_radius, across * factor * per_radius, twist * factor * per_radius).unwrap();
        let contact = Contact::from_degrees(slope.degrees(), 0.0).unwrap();
        let pass = Pass { cutter, contact, surface: curved(1.0), runout: Runout::NONE, teeth: None };
        match Envelope::new(pass) {
            Ok(_) => prop_assert!(least_height_over(cutter, slope.radians(), curved(1.0)) > -1e-9),
            Err(NoAnswer::Gouges { .. }) => prop_assert!(least_height_over(cutter, slope.radians(), curved(2.0)) < -1e-9),
            Err(other) => prop_assert!(matches!(other, NoAnswer::TooSteep { .. }), "{other}"),
        }
    }
}

proptest! {
    // A refusal's smallest radius takes a hundred times as long as a height.
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn no_shape_leads_to_a_number_that_is_not_finite(
        cutter in shapes(), slope in prop_oneof![Just(0.0), Just(90.0), 0.0..90.0_f64], alpha in -90.0..90.0_f64,
        (along, across, twist) in (-0.1..0.1_f64, -0.1..0.1_f64, -0.1..0.1_f64), share in 0.001..1.0_f64, marks in 0.001..0.5_f64,
        is_analytic in prop::bool::ANY,
    ) {
        let surface = SurfaceCurvature::from_components_per_mm(along, across, twist).unwrap();
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None };
        let model = if is_analytic { Model::Analytic } else { Model::Envelope };
        let Ok(evaluated) = EvaluatedPass::new(model, pass) else { return Ok(()) };
        let (s, f) = (mm(share * cutter.outer_radius().mm()), mm(marks * cutter.outer_radius().mm()));
        if let Ok(height) = evaluated.scallop_height(s, Some(f)) {
            prop_assert!(height.total().mm().is_finite() && height.total().mm() >= 0.0 && height.largest_turn() >= 0.0);
        }
        if let Ok(largest) = evaluated.max_step_over(mm(0.01), Some(mm(0.05))) {
            prop_assert!(largest.mm().is_finite() && largest.mm() > 0.0);
        }
        prop_assert!(evaluated.relative_curvature() > 0.0);
    }
}
