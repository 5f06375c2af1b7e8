//! Plans of tips, milled: published and independent times, laws, degenerate meshes, the points of the path, and what an
//! independent simulator finds that the path leaves.

mod hostile;
mod laws;
mod operations;
pub(super) mod parts;
mod passes;
mod published;
mod random_patches;
mod ranking;
mod referee;
pub(super) mod surfaces;

use scallopd::milling::{Cutter, Model};
use scallopd::motion::{Machine, Preset};
use scallopd::planning::SurfaceEvidence;
use scallopd::planning::plan::{CandidateCutter, Directions, Drive, PlanSettings, Ranking, Workpiece, rank};
use scallopd::quantity::{Angle, Length, SpindleSpeed};
use scallopd::surface::mesh::Selection;
use scallopd::surface::{Facing, Mesh, MeshBuilder, Sink, Unit};
use surfaces::Facet;

pub(crate) fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

pub(crate) fn degrees(value: f64) -> Angle {
    Angle::from_degrees(value).unwrap()
}

/// The published cutters: toroidal, R = 5 mm, r = 2 mm, and ball-end, R = 5 mm.
pub(crate) fn published_cutters() -> [CandidateCutter; 2] {
    [CandidateCutter::new(Cutter::toroidal(mm(10.0), mm(2.0)).unwrap()), CandidateCutter::new(Cutter::ball_end(mm(10.0)))]
}

/// 10 um on the published machine.
pub(crate) fn settings(model: Model) -> PlanSettings {
    let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
    PlanSettings { model, ..PlanSettings::new(mm(0.01), machine) }
}

/// The same settings in one direction.
pub(crate) fn in_direction(model: Model, direction: f64) -> PlanSettings {
    PlanSettings { directions: Directions::Only(vec![degrees(direction)]), ..settings(model) }
}

pub(crate) fn drive(teeth: u32, rpm: f64) -> Drive {
    Drive { teeth, spindle_speed: SpindleSpeed::from_rpm(rpm).unwrap(), max_feed_per_tooth: None }
}

pub(crate) fn mesh_of(facets: impl IntoIterator<Item = Facet>) -> Mesh {
    let mut builder = MeshBuilder::new();
    facets.into_iter().for_each(|facet| builder.facet(facet));
    builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
}

/// The part of a mesh that is machined as a whole, up to slopes of 85 deg.
pub(crate) fn machined(mesh: &Mesh) -> Workpiece {
    let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false)).unwrap();
    Workpiece::new(mesh, &mesh.visibility(degrees(85.0), &|| false), &selected, None, &|| false)
}

pub(crate) fn workpiece(facets: &[Facet]) -> Workpiece {
    machined(&mesh_of(facets.iter().copied()))
}

pub(crate) fn ranked_on(workpiece: &Workpiece, candidates: &[CandidateCutter], settings: &PlanSettings) -> Ranking {
    rank(workpiece, candidates, settings, SurfaceEvidence::default(), &|| false).unwrap()
}

pub(crate) fn ranked(facets: &[Facet], candidates: &[CandidateCutter], settings: &PlanSettings) -> Ranking {
    ranked_on(&workpiece(facets), candidates, settings)
}
