//! The points of a plan's path, in the order in which they are cut.

use super::candidate_plan::{CandidatePlan, PlannedPath};
use super::family::Family;
use super::milled_plan::MilledPlan;
use super::operations::OperationsPlan;
use super::runs::RunTip;
use super::settings::{CandidateCutter, PlanSettings};
use super::spacing::Prepared;
use super::stations::AT_ONCE;
use super::tour::TourPoint;
use super::workpiece::Workpiece;
use crate::milling::{Contact, EvaluatedPass, Pass, Runout, SurfaceCurvature};
use crate::path::MoveKind;
use crate::quantity::{Length, Speed};
use nalgebra::Vector3;
use rayon::prelude::*;
use std::iter::once;
use std::num::NonZeroU32;

/// A point of the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassPoint {
    /// The lowest point of the cutter on its axis, in mm.
    pub tip: [f64; 3],
    /// How the tool gets there.
    pub kind: MoveKind,
    /// What the cutter does there; `None` on links and over gaps.
    pub cut: Option<CutPoint>,
    /// The feed per tooth, for cutters with a drive, and the feed rate of the move to the point.
    pub feed_per_tooth: Option<Length>,
    /// The feed rate of the move to the point.
    pub feed_rate: Speed,
}

/// A point at which the cutter finishes the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutPoint {
    /// The contact, in mm.
    pub contact: [f64; 3],
    /// The unit normal of the facet that is finished, to which step-over, height and curvature belong.
    pub normal: [f64; 3],
    /// The step-over along the surface to the farther of the neighbouring lines.
    pub step_over: Length,
    /// The scallop height by the plan's model; `None` if it has none there.
    pub scallop_height: Option<Length>,
    /// The curvature of the surface along the feed, across it, and its twist, in 1/mm.
    pub curvature: [f64; 3],
}

/// The path of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Passes {
    /// The points.
    pub points: Vec<PassPoint>,
    /// The points at which runs begin; the first run of an operation begins with the operation's approach. All points from a run's start
    /// to the next one's have the cutter of the run's operation.
    pub run_starts: Vec<usize>,
    /// The operation of each run.
    pub operations: Vec<usize>,
    /// The points at which operations begin, at the clearance height.
    pub operation_starts: Vec<usize>,
}

/// The path of a milled plan; `None` for a plan that was estimated, or that is not the fastest. Once `stop` returns true,
/// the result must be discarded.
#[must_use]
pub fn passes(workpiece: &Workpiece, plan: &CandidatePlan, settings: &PlanSettings, stop: &(dyn Fn() -> bool + Sync)) -> Option<Passes> {
    Some(of_paths(workpiece, &[plan.path.as_ref()?], settings, stop))
}

/// The paths of all operations, one after the other. Once `stop` returns true, the result must be discarded.
#[must_use]
pub fn passes_of_all(workpiece: &Workpiece, plan: &OperationsPlan, settings: &PlanSettings, stop: &(dyn Fn() -> bool + Sync)) -> Passes {
    let paths: Vec<&PlannedPath> = plan.operations.iter().map(|operation| &operation.path).collect();
    of_paths(workpiece, &paths, settings, stop)
}

fn of_paths(workpiece: &Workpiece, paths: &[&PlannedPath], settings: &PlanSettings, stop: &(dyn Fn() -> bool + Sync)) -> Passes {
    let mut all = Passes { points: Vec::new(), run_starts: Vec::new(), operations: Vec::new(), operation_starts: Vec::new() };
    for (operation, PlannedPath { plan, prepared }) in paths.iter().enumerate() {
        let first = all.points.len();
        all.operation_starts.push(first);
        let points = plan.tour.points.par_iter().with_max_len(AT_ONCE);
        all.points.par_extend(points.map(|point| pass_point(workpiece, plan, prepared, settings, point, stop)));
        let later_runs = plan.tour.run_starts.iter().skip(1).map(|start| first + start);
        all.run_starts.extend(once(first).chain(later_runs));
        all.operations.resize(all.run_starts.len(), operation);
    }
    all
}

fn pass_point(
    workpiece: &Workpiece,
    plan: &MilledPlan,
    prepared: &Prepared,
    settings: &PlanSettings,
    point: &TourPoint,
    stop: &(dyn Fn() -> bool + Sync),
) -> PassPoint {
    let feed_per_tooth = prepared.range.map(|range| Length::computed(point.rate / range.teeth_per_second));
    let RunTip { tip, target, contact } = point.at;
    let cut = target.filter(|_| !stop()).map(|target| {
        let spacing = plan.lines.farther_neighbour(&plan.family, tip);
        let step_over = Length::computed(spacing / plan.family.ratio(&workpiece.tangents[target]));
        let (curvature, scallop_height) =
            height_at(workpiece, target, &plan.family, &prepared.candidate, settings, step_over, feed_per_tooth);
        let normal = Vector3::from(workpiece.targets[target].normal).normalize().into();
        CutPoint { contact, normal, step_over, scallop_height, curvature }
    });
    PassPoint { tip, kind: point.kind, cut, feed_per_tooth, feed_rate: Speed::computed(point.rate) }
}

/// The curvature of a target in the axes of the feed, and the scallop height there.
fn height_at(
    workpiece: &Workpiece,
    target: usize,
    family: &Family,
    candidate: &CandidateCutter,
    settings: &PlanSettings,
    step_over: Length,
    feed_per_tooth: Option<Length>,
) -> ([f64; 3], Option<Length>) {
    let facet = &workpiece.targets[target];
    let normal = Vector3::from(facet.normal);
    let [u, v] = family.along(&workpiece.tangents[target]);
    // The feed in the tangent plane: over the direction seen from above.
    let along = Vector3::new(u, v, -(normal.x * u + normal.y * v) / normal.z).normalize();
    let across = normal.cross(&along);
    let (along, across): ([f64; 3], [f64; 3]) = (along.into(), across.into());
    let curvature =
        [facet.curvature_between(along, along), facet.curvature_between(across, across), facet.curvature_between(along, across)];
    let height = || {
        let contact = Contact::from_vectors(facet.normal, along, None).ok()?;
        let surface = SurfaceCurvature::from_components_per_mm(curvature[0], curvature[1], curvature[2]).ok()?;
        let pass = Pass {
            cutter: candidate.cutter,
            contact,
            surface,
            runout: Runout::NONE,
            teeth: candidate.drive.and_then(|drive| NonZeroU32::new(drive.teeth)),
        };
        let evaluated = EvaluatedPass::fitting(settings.model, pass).ok()??;
        Some(evaluated.scallop_height(step_over, feed_per_tooth).ok()?.total())
    };
    (curvature, height().filter(|_| step_over.mm() > 0.0))
}
