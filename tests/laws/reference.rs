//! Heights on curved surfaces and with runout against an independent implementation.

use crate::laws::passes::mm;
use scallopd::milling::{Contact, Cutter, Envelope, Pass, Runout, SurfaceCurvature};
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
        let (slope, theta) = (pass.contact.slope(), pass.contact.theta());
        let displacement = theta.cos().abs() * (get("radial_mm") * slope.cos()).max(get("axial_mm").abs() * slope.sin());
        let mut nearer = contact.clone();
        nearer["feed_per_tooth_mm"] = (get("feed_per_tooth_mm") - displacement).into();
        let [of_nearer, _] = heights(&nearer, pass);
        let stated = get("scallop_height_mm");
        assert!(of_nearer <= stated * (1.0 + 2e-6) && stated <= found * (1.0 + 2e-6), "{of_nearer} {stated} {found}");
        equal += usize::from([of_nearer, found].into_iter().any(|height| (height / stated - 1.0).abs() < 2e-6));
    }
    assert!(contacts.len() >= 10 && equal >= 8, "{equal} of {}", contacts.len());
}
