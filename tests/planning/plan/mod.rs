//! Zigzag passes simulated on the surface, compared with published and independent times, the published method on
//! planes, laws, and the cutter's solid.

mod hostile;
mod laws;
mod meshes;
mod narrow;
mod passes;
mod published;
mod random_patches;
mod ranking;
mod solid;
mod surfaces;

use scallopd::milling::{Cutter, Model};
use scallopd::motion::{Machine, Preset};
use scallopd::planning::zigzag::{CandidateCutter, Directions, Drive, Ranking, SurfaceEvidence, ZigzagSettings, rank};
use scallopd::quantity::{Angle, Length, SpindleSpeed};
use scallopd::surface::FinishFacet;

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
pub(crate) fn settings(model: Model) -> ZigzagSettings {
    let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
    ZigzagSettings { model, ..ZigzagSettings::new(mm(0.01), machine) }
}

/// The same settings in one direction.
pub(crate) fn in_direction(model: Model, direction: f64) -> ZigzagSettings {
    ZigzagSettings { directions: Directions::Only(vec![degrees(direction)]), ..settings(model) }
}

pub(crate) fn drive(teeth: u32, rpm: f64) -> Drive {
    Drive { teeth, spindle_speed: SpindleSpeed::from_rpm(rpm).unwrap(), max_feed_per_tooth: None }
}

pub(crate) fn ranked(facets: &[FinishFacet], candidates: &[CandidateCutter], settings: &ZigzagSettings) -> Ranking {
    rank(facets, candidates, settings, SurfaceEvidence::default(), &|| false).unwrap()
}
