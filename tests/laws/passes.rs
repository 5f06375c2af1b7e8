//! Random passes for the laws, and functions to build and evaluate them.

use proptest::prelude::*;
use scallopd::milling::{
    Contact, Cutter, CutterKind, EvaluatedPass, Model, ModelWarning, NoAnswer, Pass, Runout, ScallopHeight, SurfaceCurvature,
};
use scallopd::quantity::Length;

pub(crate) const BOTH: [Model; 2] = [Model::Analytic, Model::Envelope];

pub(crate) fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

/// The whole height at a step-over and a feed, in mm; a feed of 0 means no tooth marks.
pub(crate) fn height(evaluated: &EvaluatedPass, step_over: f64, feed: f64) -> Result<f64, NoAnswer> {
    evaluated.scallop_height(mm(step_over), (feed > 0.0).then(|| mm(feed))).map(|height| height.total().mm())
}

pub(crate) fn evaluated(model: Model, pass: Pass) -> EvaluatedPass {
    EvaluatedPass::new(model, pass).unwrap()
}

pub(crate) fn at(pass: Pass, slope: f64, alpha: f64) -> Pass {
    Pass { contact: Contact::from_degrees(slope, alpha).unwrap(), ..pass }
}

pub(crate) fn curved(pass: Pass, radius: f64) -> Pass {
    Pass { surface: SurfaceCurvature::from_radius_mm(radius).unwrap(), ..pass }
}

pub(crate) fn toroidal(outer_radius: f64, share: f64) -> Cutter {
    Cutter::toroidal(mm(2.0 * outer_radius), mm(share * outer_radius)).unwrap()
}

/// Toroidal and ball-end cutters of 1 to 20 mm. Flat-end cutters are left out: their marks have no curvature, which the
/// analytic model cannot always invert.
pub(crate) fn cutters() -> impl Strategy<Value = Cutter> {
    let toroidal = (0.5..10.0_f64, 0.05..0.95_f64).prop_map(|(outer_radius, share)| toroidal(outer_radius, share));
    prop_oneof![3 => toroidal, 1 => (1.0..20.0_f64).prop_map(|diameter| Cutter::ball_end(mm(diameter)))]
}

/// Slopes above the floor, including walls.
pub(crate) fn slopes() -> impl Strategy<Value = f64> {
    prop_oneof![9 => 1.0..90.0_f64, 1 => Just(90.0)]
}

/// Feed directions, including quarter turns.
pub(crate) fn feed_angles() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -180.0..180.0_f64, 1 => Just(0.0), 1 => Just(90.0)]
}

/// Passes on a plane with a cutter without runout.
pub(crate) fn plane_passes() -> impl Strategy<Value = Pass> {
    (cutters(), slopes(), feed_angles()).prop_map(|(cutter, slope, alpha)| {
        let contact = Contact::from_degrees(slope, alpha).unwrap();
        Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
    })
}

/// Passes with or without runout, on planes, hills and hollows.
pub(crate) fn passes() -> impl Strategy<Value = Pass> {
    let radius = prop_oneof![1 => Just(None), 1 => (5.0..500.0_f64).prop_map(Some), 1 => (-500.0..-50.0_f64).prop_map(Some)];
    let runout = prop_oneof![1 => Just((0.0, 0.0)), 1 => (0.0..0.01_f64, -0.01..0.01_f64)];
    (plane_passes(), radius, runout).prop_map(|(pass, radius, (radial, axial))| {
        let runout = Runout::NONE.with_radial_mm(radial).unwrap().with_axial_mm(axial).unwrap();
        let pass = radius.map_or(pass, |radius| curved(pass, radius));
        Pass { runout, ..pass }
    })
}

/// Whether the section can have ridges that differ by less than the outline's error of 3 %, so that a rounding decides
/// which one is found. That is the case if lobes of the section join: near the floor, near walls and in close fits of
/// concave surfaces.
pub(crate) fn has_lobes(pass: &Pass) -> bool {
    let in_middle = (10.0..85.0).contains(&pass.contact.slope().degrees());
    let lambda = EvaluatedPass::new(Model::Envelope, *pass).map_or(1.0, |evaluated| evaluated.relative_curvature());
    pass.surface.principal_per_mm()[1] < 0.0 && !(in_middle && lambda > 0.6)
}

/// Whether the height has no warning about the turning of the surface's normal, for which the laws hold. Near the floor,
/// and with larger turns, a toroidal cutter's marks can have several lowest places along the feed, and the height can be
/// that of any one. On surfaces with concave curvature, heights fall by up to 2e-4 where step-overs that are short compared
/// with the feed grow, and these are left out.
pub(crate) fn is_settled(evaluated: &EvaluatedPass, s: f64, f: f64) -> bool {
    let is_smooth_on_curve = !evaluated.pass().surface.is_plane() && evaluated.pass().cutter.kind() == CutterKind::Toroidal;
    let is_short = || evaluated.pass().surface.principal_per_mm()[1] < 0.0 && s < 0.5 * f;
    let warns = || {
        let (s, f) = (mm(s.max(1e-6)), Some(mm(f.max(1e-6))));
        let turn = evaluated.scallop_height(s, f).map_or(f64::INFINITY, ScallopHeight::largest_turn);
        evaluated
            .warnings(s, f, turn)
            .any(|warning| matches!(warning, ModelWarning::CurvatureApproximate | ModelWarning::HeightNotABound { .. }))
    };
    !is_smooth_on_curve || !(is_short() || warns())
}
