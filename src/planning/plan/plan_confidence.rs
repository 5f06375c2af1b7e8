//! The confidence in the order of plans, with its reasons.

use super::candidate_plan::CandidatePlan;
use super::judged::KEPT;
use super::settings::{CandidateCutter, PlanSettings};
use super::workpiece::SurfaceFigures;
use crate::planning::{Confidence, Level, Reason, SurfaceEvidence, SurfaceWeakness};

impl Confidence<SurfaceWeakness> {
    /// The confidence in plans in their order, beside which so many arrangements of several operations were not planned; `None`
    /// without any plan. `sagitta` is the mean distance in mm of the facets from the surface that they stand for.
    pub(super) fn in_plans(
        plans: &[CandidatePlan],
        not_planned: usize,
        candidates: &[CandidateCutter],
        surface: &SurfaceFigures,
        sagitta: f64,
        settings: &PlanSettings,
        evidence: SurfaceEvidence,
    ) -> Option<Self> {
        let best = plans.first()?;
        let PlanSettings { scallop_height, machine, .. } = settings;
        let mut reasons = Vec::new();
        let is_stated = |plan: &CandidatePlan| candidates[plan.candidate].drive.is_some();
        // The machine's feed rate is the largest of all: a cutter that is slower with it is slower with any.
        let stated = if is_stated(best) { 0 } else { plans.iter().filter(|plan| is_stated(plan)).count() };
        let sooner = plans.iter().filter(|plan| plan.milled.is_none() && plan.time.seconds() <= best.time.seconds()).count();
        #[expect(clippy::cast_precision_loss, reason = "counts of candidates, arrangements and pieces")]
        let [stated, sooner, not_planned, pieces] = [stated, sooner, not_planned, evidence.pieces].map(|count| count as f64);
        reasons.extend(Reason::over(SurfaceWeakness::NotMilled, sooner, 0.0, if best.milled.is_some() { f64::INFINITY } else { 0.0 }));
        reasons.extend(Reason::over(SurfaceWeakness::OperationsNotPlanned, not_planned, 0.0, f64::INFINITY));
        reasons.extend(Reason::over(SurfaceWeakness::AssumedFeed, stated, 0.0, f64::INFINITY));
        if let Some(next) = plans.get(1) {
            let lead = (1.0 - best.time.seconds() / next.time.seconds()).abs();
            if lead < 0.02 {
                reasons.push(Reason { weakness: SurfaceWeakness::SmallLead, level: Level::Moderate, figure: lead, threshold: 0.02 });
            }
        }
        let sagittas = sagitta / scallop_height.mm();
        if let Some(milled) = best.milled {
            let size = surface.facet_size.mm() / milled.step_over.median.mm();
            let (coarse, far) = (SurfaceWeakness::CoarseTessellation, if sagittas > 1.0 { 8.0 } else { f64::INFINITY });
            reasons.extend(Reason::over(coarse, size, 2.0, far).filter(|_| sagittas > 0.1));
            reasons.extend(Reason::over(SurfaceWeakness::OverTolerance, milled.finish.far_over_share, KEPT, 0.1));
            reasons.extend(Reason::over(SurfaceWeakness::Gouge, milled.finish.gouge.mm() / scallop_height.mm(), 0.4, 4.0));
        }
        if let Some(path) = best.path.as_ref().filter(|_| machine.path_tolerance.is_none()) {
            let longer = path.plan.tour.seconds_with_stops(machine) / best.time.seconds();
            reasons.extend(Reason::over(SurfaceWeakness::SharpCorners, longer, 1.1, f64::INFINITY));
        }
        reasons.extend(Reason::over(SurfaceWeakness::SteepArea, surface.steep_area_share, 0.02, 0.2));
        reasons.extend(Reason::over(SurfaceWeakness::HiddenArea, evidence.hidden_area_share, 0.02, 0.2));
        reasons.extend(Reason::over(SurfaceWeakness::SeveralPieces, pieces, 1.0, f64::INFINITY));
        reasons.extend(Reason::over(SurfaceWeakness::InconsistentOrientation, evidence.turned_area_share, 0.002, 0.2));
        reasons.extend(Reason::missing_area(SurfaceWeakness::NotClosed, evidence.missing_area, *scallop_height));
        Some(Self::from_reasons(reasons))
    }
}
