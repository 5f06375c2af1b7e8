//! What the paths of a plan leave at given points, for maps.

use super::candidate_plan::{CandidatePlan, PlannedPath};
use super::judged::judged;
use super::operations::OperationsPlan;
use super::settings::PlanSettings;
use super::stations::{DrawnPlace, stations};
use super::workpiece::Workpiece;
use crate::milling::Cutter;
use crate::path::Milled;
use crate::quantity::Length;

/// What paths leave at a point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftAt {
    /// The height left along the normal, tooth marks included; `None` where no move comes over the point.
    pub height: Option<Length>,
    /// Whether a cutter can stand where it would finish the point.
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
    left_by(workpiece, &[plan.path.as_ref()?], settings, points, stop)
}

/// What the paths of several operations together leave at points of facets that are machined, in the order of the points. `None`
/// once `stop` returns true.
#[must_use]
pub fn left_at_by_all(
    workpiece: &Workpiece,
    plan: &OperationsPlan,
    settings: &PlanSettings,
    points: &[(usize, [f64; 3])],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<LeftAt>> {
    let paths: Vec<&PlannedPath> = plan.operations.iter().map(|operation| &operation.path).collect();
    left_by(workpiece, &paths, settings, points, stop)
}

/// How high other facets hold a cutter over its contact with points of facets that are machined, in the order of the points; 0
/// where it can stand there. Once `stop` returns true, the result must be discarded.
#[must_use]
pub fn lifts_at(
    workpiece: &Workpiece,
    cutter: Cutter,
    settings: &PlanSettings,
    points: &[(usize, [f64; 3])],
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Length> {
    let height = settings.scallop_height.mm();
    let lifts = stations(workpiece, &cutter.profile(), &places_of(points), height, stop);
    lifts.iter().map(|station| Length::computed(if station.lift <= height { 0.0 } else { station.lift })).collect()
}

fn places_of(points: &[(usize, [f64; 3])]) -> Vec<DrawnPlace> {
    points.iter().map(|&(target, point)| DrawnPlace { target, point, area: 1.0 }).collect()
}

fn left_by(
    workpiece: &Workpiece,
    paths: &[&PlannedPath],
    settings: &PlanSettings,
    points: &[(usize, [f64; 3])],
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<LeftAt>> {
    let height = settings.scallop_height.mm();
    let places = places_of(points);
    let mut all = vec![LeftAt { height: None, is_reached: false }; points.len()];
    for PlannedPath { plan, prepared } in paths {
        let stations = stations(workpiece, &prepared.profile, &places, height, stop);
        let milled = Milled::new(&prepared.profile, &plan.tour.moves(), stop)?;
        let judged = judged(workpiece, &stations, prepared, &plan.family, &milled, height, stop)?;
        for ((all, station), judged) in all.iter_mut().zip(&stations).zip(&judged) {
            let left = judged.left.map(|left| Length::computed(left.max(0.0) + judged.marks));
            let less = |before: Length| left.map_or(before, |left| if left.mm() < before.mm() { left } else { before });
            all.height = all.height.map_or(left, |before| Some(less(before)));
            all.is_reached |= station.lift <= height;
        }
    }
    Some(all)
}
