//! The points of a plan's path, in the order in which they are cut.

use super::candidate::CandidateCutter;
use super::ranking::CandidatePlan;
use super::settings::PlanSettings;
use super::spread::Heading;
use super::workpiece::Workpiece;
use crate::milling::{Contact, EvaluatedPass, Pass, Runout, SurfaceCurvature};
use crate::path::MoveKind;
use crate::quantity::{Length, Speed};
use nalgebra::Vector3;
use rayon::prelude::*;
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
    /// The points at which runs begin.
    pub run_starts: Vec<usize>,
}

/// The path of a milled plan; `None` for a plan that was estimated, or that is not the fastest. Once `stop` returns true,
/// the result must be discarded.
#[must_use]
pub fn passes(
    workpiece: &Workpiece,
    plan: &CandidatePlan,
    candidate: &CandidateCutter,
    settings: &PlanSettings,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<Passes> {
    let (milled, _) = plan.plan.as_ref()?;
    let heading = Heading::of(plan.direction.radians());
    let teeth_per_second = plan.milled.as_ref().and_then(|figures| {
        let feed = figures.feed_per_tooth?.mm();
        (feed > 0.0).then(|| figures.feed_rate.mm_s() / feed)
    });
    let points = &milled.tour.points;
    let point = |index: usize| {
        let point = &points[index];
        let feed_per_tooth = teeth_per_second.map(|teeth| Length::computed(point.rate / teeth));
        let cut = point.of_run.and_then(|tip| {
            let target = tip.target.filter(|_| !stop())?;
            let step_over_xy = farther_line(&milled.lines, heading.of_point([tip.tip[0], tip.tip[1]])[1]);
            let tangent = &workpiece.tangents[target];
            let (cos_alpha, _) = tangent.alpha(heading.along);
            let step_over = Length::computed(step_over_xy / tangent.ratio_squared(cos_alpha).sqrt());
            let (curvature, scallop_height) = height_at(workpiece, target, &heading, candidate, settings, step_over, feed_per_tooth);
            let normal = Vector3::from(workpiece.targets[target].normal).normalize().into();
            Some(CutPoint { contact: tip.contact, normal, step_over, scallop_height, curvature })
        });
        PassPoint { tip: point.tip, kind: point.kind, cut, feed_per_tooth, feed_rate: Speed::computed(point.rate) }
    };
    Some(Passes {
        points: (0..points.len()).into_par_iter().with_min_len(64).map(point).collect(),
        run_starts: milled.tour.run_starts.clone(),
    })
}

/// The distance from a line to the farther of its neighbours; of a single line, its distance to the border is not known, and
/// the distance is 0.
fn farther_line(lines: &[f64], across: f64) -> f64 {
    let nearest = lines.partition_point(|line| *line < across - 1e-6).min(lines.len().saturating_sub(1));
    let gap = |from: usize, to: usize| lines.get(to).zip(lines.get(from)).map_or(0.0, |(to, from)| (to - from).abs());
    let before = nearest.checked_sub(1).map_or(0.0, |before| gap(before, nearest));
    before.max(gap(nearest, nearest + 1))
}

/// The curvature of a target in the axes of the feed, and the scallop height there.
fn height_at(
    workpiece: &Workpiece,
    target: usize,
    heading: &Heading,
    candidate: &CandidateCutter,
    settings: &PlanSettings,
    step_over: Length,
    feed_per_tooth: Option<Length>,
) -> ([f64; 3], Option<Length>) {
    let facet = &workpiece.targets[target];
    let normal = Vector3::from(facet.normal);
    let [u, v] = heading.along;
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
