//! What the path of a plan leaves at given points, for maps.

use super::judged::judged;
use super::places::Place;
use super::ranking::CandidatePlan;
use super::settings::PlanSettings;
use super::spread::Heading;
use super::stations::stations;
use super::workpiece::Workpiece;
use crate::path::Milled;
use crate::quantity::Length;

/// What a path leaves at a point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftAt {
    /// The height left along the normal, tooth marks included; `None` where no move comes over the point.
    pub height: Option<Length>,
    /// Whether the cutter can stand where it would finish the point.
    pub is_reached: bool,
}

/// What the path of a milled plan leaves at points of facets of the part that are machined, in the order of the points.
/// `None` for a plan without a path, or once `stop` returns true.
#[must_use]
pub fn left_at(
    workpiece: &Workpiece,
    plan: &CandidatePlan,
    settings: &PlanSettings,
    points: &[(usize, [f64; 3])],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<LeftAt>> {
    let (milled_plan, prepared) = plan.plan.as_ref()?;
    let height = settings.scallop_height.mm();
    let places: Vec<Place> = points.iter().map(|&(target, point)| Place { target, point, area: 1.0 }).collect();
    let stations = stations(workpiece, &prepared.profile, &places, height, stop);
    let milled = Milled::new(&prepared.profile, &milled_plan.tour.moves(), stop)?;
    let along = Heading::of(plan.direction.radians()).along;
    let judged = judged(workpiece, &stations, prepared, along, &milled, height, stop)?;
    let left = stations.iter().zip(&judged).map(|(station, judged)| LeftAt {
        height: judged.left.map(|left| Length::computed(left.max(0.0) + judged.marks)),
        is_reached: station.lift <= height,
    });
    Some(left.collect())
}
