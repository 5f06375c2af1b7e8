//! Heights on curved surfaces and with runout against an independent implementation.

use crate::laws::passes::mm;
use scallopd::milling::{Contact, Cutter, Envelope, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Angle;
use serde_json::Value;

fn contacts(file: &str) -> Vec<Value> {
    let document: Value = serde_json::from_str(file).unwrap();
    document["contacts"].as_array().unwrap().clone()
}

fn number(contact: &Value, name: &str) -> f64 {
    contact[name].as_f64().unwrap_or_else(|| panic!("{name} in {contact}"))
}

fn pass(contact: &Value, surface: SurfaceCurvature, runout: Runout) -> Pass {
    let get = |name| number(contact, name);
    Pass {
        cutter: Cutter::toroidal(mm(get("diameter_mm")), mm(get("corner_radius_mm"))).unwrap(),
        contact: Contact::from_degrees(get("slope_deg"), get("feed_angle_deg")).unwrap(),
        surface,
        runout,
        teeth: None,
    }
}

/// The height with the third order, and without.
fn heights(contact: &Value, pass: Pass) -> [f64; 2] {
    let envelope = Envelope::new(pass).unwrap();
    let (step_over, feed) = (mm(number(contact, "step_over_mm")), Some(mm(number(contact, "feed_per_tooth_mm"))));
    let (found, second_order) = (envelope.scallop_height(step_over, feed), envelope.without_turns().scallop_height(step_over, feed));
    [found, second_order].map(|height| height.unwrap().total().mm())
}

#[test]
fn heights_on_curved_surfaces_agree_with_an_independent_implementation() {
    let contacts = contacts(include_str!("../data/envelope_curved.json"));
    for contact in &contacts {
        let get = |name| number(contact, name);
        let surface = SurfaceCurvature::from_components_per_mm(get("along_per_mm"), get("across_per_mm"), get("twist_per_mm")).unwrap();
        let [found, second_order] = heights(contact, pass(contact, surface, Runout::NONE));
        // The file has the second order. It states 1e-6; its curvatures are rounded to 1e-9 of some 1e-2, which is less.
        approx::assert_relative_eq!(second_order, get("scallop_height_mm"), max_relative = 2e-6);
        assert!(get("simulated_peak_mm") <= found * 1.001, "{contact}");
    }
    assert!(contacts.len() >= 20);
}

/// The file's heights are those of marks that are one feed per tooth apart: with the displacement of shallow marks, heights are
/// higher unless the deepest tooth's marks alone count, and at a feed that is smaller by the displacement they are lower unless
/// all marks count.
#[test]
fn heights_with_runout_agree_with_an_independent_implementation() {
    let mut equal = 0;
    let contacts = contacts(include_str!("../data/envelope_runout.json"));
    for contact in &contacts {
        let get = |name| number(contact, name);
        let runout = Runout::NONE.with_radial_mm(get("radial_mm")).unwrap().with_axial_mm(get("axial_mm")).unwrap();
        let pass = pass(contact, SurfaceCurvature::PLANE, runout);
        let [found, second_order] = heights(contact, pass);
        assert!(found.to_bits() == second_order.to_bits());
        let (slope, omega) = (pass.contact.slope(), pass.contact.omega());
        let displacement = omega.cos().abs() * (get("radial_mm") * slope.cos()).max(get("axial_mm").abs() * slope.sin());
        let mut nearer = contact.clone();
        nearer["feed_per_tooth_mm"] = (get("feed_per_tooth_mm") - displacement).into();
        let [of_nearer, _] = heights(&nearer, pass);
        let stated = get("scallop_height_mm");
        assert!(of_nearer <= stated * (1.0 + 2e-6) && stated <= found * (1.0 + 2e-6), "{of_nearer} {stated} {found}");
        equal += usize::from([of_nearer, found].into_iter().any(|height| (height / stated - 1.0).abs() < 2e-6));
    }
    assert!(contacts.len() >= 10 && equal >= 8, "{equal} of {}", contacts.len());
}

/// Tapered balls, lenses, ovals and conical barrels: heights from the solid alone, to second order, of which the file states 0.1 %.
#[test]
fn heights_of_other_profiles_agree_with_those_of_their_solids() {
    let document: Value = serde_json::from_str(include_str!("../data/profile_cutters.json")).unwrap();
    let cases = document["cases"].as_array().unwrap();
    for case in cases {
        let get = |name| number(case, name);
        let length = |name| mm(number(&case["cutter"], name));
        let taper = || Angle::from_degrees(number(&case["cutter"], "taper_deg")).unwrap();
        let cutter = match case["cutter"]["type"].as_str().unwrap() {
            "tapered_ball" => Cutter::tapered_ball(length("diameter_mm"), taper(), length("shank_diameter_mm")),
            "lens" => Cutter::lens(length("diameter_mm"), length("lens_radius_mm"), length("corner_radius_mm")),
            "oval" => Cutter::oval(length("diameter_mm"), length("tip_radius_mm"), length("side_radius_mm")),
            _ => Cutter::conical_barrel(length("diameter_mm"), length("tip_radius_mm"), length("side_radius_mm"), taper()),
        };
        let contact = Contact::from_degrees(get("slope_deg"), get("feed_angle_deg")).unwrap();
        let surface = SurfaceCurvature::from_components_per_mm(get("along_per_mm"), get("across_per_mm"), 0.0).unwrap();
        let pass = Pass { cutter: cutter.unwrap(), contact, surface, runout: Runout::NONE, teeth: None };
        let feed = Some(get("feed_per_tooth_mm")).filter(|feed| *feed > 0.0).map(mm);
        let found = Envelope::new(pass).unwrap().without_turns().scallop_height(mm(get("step_over_mm")), feed).unwrap();
        approx::assert_relative_eq!(found.step_over.mm(), get("step_over_height_mm"), max_relative = 1e-3);
        approx::assert_relative_eq!(found.total().mm(), get("scallop_height_mm"), max_relative = 1e-3);
    }
    assert!(cases.len() >= 16);
}

/// A profile that spells a torus answers as the torus, and an oval whose side has the radius of its tip as a ball.
#[test]
fn other_spellings_of_a_torus_and_a_ball_leave_the_same() {
    let torus = Cutter::toroidal(mm(10.0), mm(2.0)).unwrap();
    let ball = Cutter::ball_end(mm(10.0));
    for (cutter, same) in
        [(Cutter::from_arcs(torus.profile().arcs()).unwrap(), torus), (Cutter::oval(mm(10.0), mm(5.0), mm(5.0)).unwrap(), ball)]
    {
        for (slope, alpha, radius) in [(3.0, 20.0, f64::INFINITY), (40.0, 60.0, 70.0), (80.0, 10.0, -90.0)] {
            let surface = SurfaceCurvature::from_components_per_mm(0.0, radius.recip(), 0.001 * radius.recip()).unwrap();
            let contact = Contact::from_degrees(slope, alpha).unwrap();
            let heights = [cutter, same].map(|cutter| {
                let pass = Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None };
                Envelope::new(pass).unwrap().scallop_height(mm(0.5), Some(mm(0.2))).unwrap().total().mm()
            });
            approx::assert_relative_eq!(heights[0], heights[1], max_relative = 1e-12);
        }
    }
}
