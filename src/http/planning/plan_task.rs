//! The calculation of a recommendation from surface and parameters, by either method.

use super::answer::{RankedCandidate, RecommendationAnswer, RecommendedCutter};
use super::candidates::{always_faster, outside_range};
use super::confidence_answer::ConfidenceAnswer;
use super::map::MapCells;
use super::parameters::{AnswerPart, FACING, MAX_SLOPE, Method, Parameters, REST_OF, SELECT, unused};
use super::plan_answer::{PassesAnswer, PlanAnswer, Simulation, passes_of_best};
use super::program::ProgramAnswer;
use super::surface_answer::{SurfaceAnswer, UnitDoubt, avoided_mesh, merged, report};
use crate::http::codes::{NotRankedCode, RequestFault, WarningCode};
use crate::http::problem::Problem;
use crate::http::reading::{Faulted, Faults, JsonPath};
use crate::http::wire::{MODEL, NamedCandidate, NotRanked, Source, SurfaceWithSource, Warning};
use crate::milling::{Cutter, CutterKind, Model};
use crate::motion::Machine;
use crate::planning::machined_surface::{MachinedFacets, MachinedSurface, Stop};
use crate::planning::plan::{CandidatePlan, NotRankedReason, OperationsPlan, Pattern, PlanSettings, estimated_times};
use crate::planning::{Confidence, CutterComparison, Evidence, Plan, Recommendation, RectanglePlan, plan_on_rectangle, recommend};
use crate::quantity::{Angle, Length, OutOfRange, Time};
use crate::surface::mesh::Selection;
use crate::surface::{Basis, ReceivedSurface, Shape, ShapeError};

/// The most points of the passes in an answer, some 100 MB of JSON, and of a program, some 40 MB of text.
const MOST_PASS_POINTS: usize = 400_000;
const MOST_PROGRAM_POINTS: usize = 1_000_000;

/// Whether this part of an answer may have the points of a path; a warning says why it is left out.
fn fits(name: &str, points: usize, most: usize, warnings: &mut Vec<Warning>) -> bool {
    let reason = match points {
        0 => "the first candidate's path is too long to be milled".to_owned(),
        _ if points > most => format!("the path has {points} points, more than {most}"),
        _ => return true,
    };
    warnings.push(Warning::new(WarningCode::PassesLeftOut, format!("{name} left out: {reason}")));
    false
}

/// A recommendation to compute: a surface and the parameters.
pub(super) struct Task {
    parameters: Parameters,
    shape: Shape,
    /// The facets; a surface for method `rectangle` may have none.
    machined: Option<MachinedSurface>,
    source: Source,
    pub(super) warnings: Vec<Warning>,
    /// The doubt about the unit that was assumed.
    unit_doubt: Option<UnitDoubt>,
}

impl Task {
    /// Determines shape and facets of the surface at `path`. Once `stop` returns true, the task must be discarded.
    pub(super) fn new(
        mut parameters: Parameters,
        sourced: SurfaceWithSource,
        path: &JsonPath<'_>,
        faults: &mut Faults,
        stop: Stop,
    ) -> Result<Self, Faulted> {
        let unit = sourced.unit_of(parameters.unit, faults)?;
        let shape = sourced.surface.sampled.shape(unit, parameters.facing);
        let shape = shape.map_err(|error| faults.add(path, shape_code(error), error))?;
        let mut warnings = sourced.warnings(&shape);
        let smallest = parameters.candidates.iter().map(|named| 2.0 * named.candidate.cutter.outer_radius().mm()).reduce(f64::min);
        // A unit that the file or the request states is believed.
        let is_assumed = parameters.unit.is_none() && sourced.is_file() && sourced.unit.is_none();
        let unit_doubt = smallest.filter(|_| is_assumed).and_then(|smallest| UnitDoubt::about(&shape, unit, smallest));
        warnings.extend(unit_doubt.as_ref().map(UnitDoubt::warning));
        warnings.append(&mut parameters.unused);
        if parameters.states_facing && shape.basis == Basis::Points {
            warnings.push(unused(FACING.name, "on points and patches"));
        }
        let SurfaceWithSource { surface: ReceivedSurface { mesh, .. }, source, .. } = sourced;
        let avoid = parameters.avoid.take();
        let avoid = avoid.map(|avoid| avoided_mesh(avoid, parameters.unit, &mut warnings, faults, stop)).transpose();
        let Parameters { facing, ref selection, max_slope, method, .. } = parameters;
        let facets = match MachinedFacets::new(mesh, unit, facing, selection, max_slope, stop) {
            Ok(facets) => Some(facets),
            // Without facets, method `rectangle` has an answer, but with less evidence.
            Err(reason) if method == Method::Rectangle && reason.is_sound() => None,
            Err(reason) => return Err(report(reason, path, faults)),
        };
        let avoid = avoid?;
        let machined = facets.map(|facets| MachinedSurface::new(facets, avoid.as_ref(), stop));
        if machined.is_none() && parameters.states_facets {
            warnings.push(unused(format_args!("{} or {}", SELECT.name, MAX_SLOPE.name), "because no facets are seen from above"));
        }
        // The passes are those of the selected facets.
        let shape = match machined.as_ref().filter(|_| *selection != Selection::all()) {
            Some(machined) => machined.facets.selected_shape(facing).map_err(|error| faults.add(path, shape_code(error), error))?,
            None => shape,
        };
        warnings.extend(machined.as_ref().and_then(|machined| merged(&machined.facets.mesh)));
        if method == Method::Rectangle {
            // The sides of the rectangle do not depend on the cutter.
            let settings = parameters.settings(&shape, parameters.model());
            let first = parameters.candidates.first().map(|named| on_rectangle(named, &settings, &shape));
            if let Some(Err(bounds)) = first {
                let detail = format_args!("both sides of the surface's equivalent rectangle {bounds} mm");
                return Err(faults.add(path, RequestFault::SizeOutOfRange, detail));
            }
        }
        Ok(Self { parameters, shape, machined, source, warnings, unit_doubt })
    }

    /// The answer, or the problem that no cutter fits. Once `stop` returns true, the answer must be discarded.
    pub(super) fn answer(mut self, stop: Stop) -> Result<RecommendationAnswer, Problem> {
        match (self.parameters.method, self.machined.take()) {
            (Method::Surface, Some(machined)) => self.on_surface(&machined, stop),
            (_, machined) => self.on_rectangle(machined.as_ref(), stop),
        }
    }

    fn on_surface(mut self, machined: &MachinedSurface, stop: Stop) -> Result<RecommendationAnswer, Problem> {
        let (all, by) = ((0..self.parameters.candidates.len()).collect::<Vec<_>>(), self.parameters.model());
        let Some(simulation) = Simulation::run(machined, &self.parameters, &all, &self.shape, by, stop) else {
            return Err(Problem::no_cutter_fits(Vec::new()));
        };
        let (ranking, settings) = (&simulation.ranking, &simulation.settings);
        let named = &self.parameters.candidates;
        let mut not_ranked: Vec<NotRanked> =
            ranking.not_ranked.iter().map(|not_ranked| self.not_ranked(not_ranked.candidate, not_ranked.reason)).collect();
        not_ranked.extend(self.faulty_tools());
        let candidates: Vec<_> = ranking.plans.iter().map(|plan| RankedCandidate::planned(plan, named)).collect();
        let (false, Some(confidence)) = (candidates.is_empty(), &ranking.confidence) else {
            if ranking.rest_share == Some(0.0) {
                let mut faults = Faults::default();
                let detail = "the cutter reaches everything: it leaves nothing over the scallop height";
                faults.add(&JsonPath::Root.member(REST_OF.name), RequestFault::NothingToMachine, detail);
                return Err(Problem::faulty_request(faults));
            }
            let radius = machined.workpiece.smallest_concave_radius();
            return Err(Problem::no_cutter_fits(not_ranked).with_hollow(radius, settings.max_uncut_share));
        };
        self.warnings.extend(ranking.plans.iter().filter(|plan| plan.flutes_too_short).map(|plan| short_flutes(plan.candidate, named)));
        self.warnings.extend(limited_speeds(named, &self.parameters.machine));
        let points =
            ranking.operations.as_ref().map_or_else(|| ranking.plans.first().map_or(0, CandidatePlan::points), OperationsPlan::points);
        let [gives_passes, gives_program] =
            [(AnswerPart::Passes, "passes", MOST_PASS_POINTS), (AnswerPart::Program, "program", MOST_PROGRAM_POINTS)]
                .map(|(part, name, most)| self.parameters.includes(part) && fits(name, points, most, &mut self.warnings));
        let path = if gives_passes || gives_program { passes_of_best(machined, &simulation, stop) } else { None };
        let program = path.as_ref().filter(|_| gives_program).and_then(|path| {
            let first = ranking.plans.first()?.candidate;
            let several = ranking.operations.as_ref().map(|plan| plan.operations.iter().map(|operation| operation.candidate).collect());
            let cutters: Vec<_> = several.unwrap_or_else(|| vec![first]).into_iter().map(|index: usize| &named[index]).collect();
            ProgramAnswer::of(path, &cutters, &self.parameters.machine, &self.parameters.program)
        });
        let passes = path.filter(|_| gives_passes).map(PassesAnswer::of);
        let wants_maps = self.parameters.includes(AnswerPart::Maps);
        let cells = (wants_maps || self.parameters.includes(AnswerPart::Map)).then(|| MapCells::new(machined, settings));
        let map = cells.as_ref().and_then(|cells| cells.map(ranking, stop));
        let maps = cells.filter(|_| wants_maps).map(|cells| cells.of_cutters(named, ranking, stop));
        let plan = match (&ranking.operations, ranking.plans.first()) {
            _ if self.parameters.most_operations < 2 => None,
            (Some(several), _) => Some(PlanAnswer::of_several(several, named)),
            (None, first) => first.and_then(|one| PlanAnswer::of_one(one, self.parameters.pattern, self.parameters.max_slope, named)),
        };
        let published = self.published().map(|published| published.plan);
        let answer = self.answered(candidates, not_ranked, Some(machined), published, confidence.into());
        Ok(RecommendationAnswer { plan, rest_area_share: ranking.rest_share, map, maps, passes, program, ..answer })
    }

    fn on_rectangle(mut self, machined: Option<&MachinedSurface>, stop: Stop) -> Result<RecommendationAnswer, Problem> {
        let named = &self.parameters.candidates;
        let settings = self.parameters.settings(&self.shape, self.parameters.model());
        let slope = if self.shape.steepest_direction.is_some() { self.shape.slope } else { Angle::ZERO };
        let (mut candidates, mut not_ranked) = (Vec::new(), Vec::new());
        for (index, cutter) in named.iter().enumerate().take_while(|_| !stop()) {
            match on_rectangle(cutter, &settings, &self.shape) {
                Ok(Some(plan)) => {
                    self.warnings.extend(on_rectangle_warnings(index, &plan, slope, &settings, named));
                    candidates.push(RankedCandidate::on_rectangle(index, &plan, slope, named));
                }
                _ => not_ranked.push(self.not_ranked(index, NotRankedReason::NoStepOver)),
            }
        }
        self.warnings.extend(limited_speeds(named, &self.parameters.machine));
        not_ranked.extend(self.faulty_tools());
        candidates.sort_by(|a, b| a.machining_time_s.total_cmp(&b.machining_time_s));
        if candidates.is_empty() {
            return Err(Problem::no_cutter_fits(not_ranked));
        }
        let published = self.published();
        let compared = published.as_ref().map(|published| published.plan);
        // The published comparison has one feed rate, no tooth marks, and passes in both directions.
        let is_published = settings.pattern == Pattern::Zigzag && named.iter().all(|named| named.candidate.drive.is_none());
        let published = published.filter(|_| is_published);
        let confidence = self.confidence_in_rectangle(published, &candidates, machined, stop);
        Ok(self.answered(candidates, not_ranked, machined, compared, confidence))
    }

    /// The answer without map and passes. There is at least one candidate.
    fn answered(
        self,
        candidates: Vec<RankedCandidate>,
        not_ranked: Vec<NotRanked>,
        machined: Option<&MachinedSurface>,
        published: Option<Plan>,
        confidence: ConfidenceAnswer,
    ) -> RecommendationAnswer {
        RecommendationAnswer {
            method: self.parameters.method,
            model: MODEL.kind.word(&self.parameters.model()),
            recommended: RecommendedCutter::of(&candidates[0]),
            candidates,
            not_ranked,
            rest_area_share: None,
            surface: SurfaceAnswer::of(&self.shape, self.source, machined),
            critical_slope_deg: published.map(|plan| plan.critical_slope.angle().degrees()),
            always_faster: published.and_then(|plan| always_faster(plan.critical_slope)),
            critical_form_factor: published.map(|plan| plan.critical_form_factor.form_factor().ratio()),
            plan: None,
            map: None,
            maps: None,
            passes: None,
            program: None,
            confidence: confidence.doubting(self.unit_doubt.as_ref()),
            warnings: self.warnings,
        }
    }

    /// The confidence in plans on the rectangle: the published weaknesses, then those found on the facets and in the
    /// simulation.
    fn confidence_in_rectangle(
        &self,
        published: Option<Recommendation>,
        candidates: &[RankedCandidate],
        machined: Option<&MachinedSurface>,
        stop: Stop,
    ) -> ConfidenceAnswer {
        let times: Vec<Time> = candidates.iter().map(RankedCandidate::time).collect();
        let confidence = published.map_or_else(|| Confidence::of_shape(&self.shape, &times), |published| published.confidence);
        let Some(machined) = machined else { return (&confidence).into() };
        // The order depends on the recommended cutter and the next one.
        let compared: Vec<usize> = candidates.iter().take(2).map(|candidate| candidate.cutter).collect();
        let settings = self.parameters.settings(&self.shape, Model::Envelope);
        let cutters: Vec<_> = compared.iter().map(|&place| self.parameters.candidates[place].candidate).collect();
        // Estimates are enough here, and take no longer on a part of many metres.
        let Some(on_surface) = estimated_times(&machined.workpiece, &cutters, &settings, stop) else {
            return (&confidence).into();
        };
        let figures = machined.workpiece.figures();
        let evidence = Evidence { mean_slope: figures.mean_slope, area: figures.area, pieces: machined.facets.machined_pieces() };
        let simulated = |candidate: &RankedCandidate| {
            let place = compared.iter().position(|&cutter| cutter == candidate.cutter)?;
            Some((candidate.time(), on_surface[place]?))
        };
        let confidence = confidence.with_surface(&self.shape, &evidence);
        // Without a simulation of the recommended cutter, the others cannot be compared with it.
        let times: Vec<_> =
            if candidates.first().and_then(simulated).is_some() { candidates.iter().filter_map(simulated).collect() } else { Vec::new() };
        (&confidence.with_simulation(&times)).into()
    }

    /// The published comparison, if the cutters are exactly one toroidal and one ball-end cutter and it has an answer.
    fn published(&self) -> Option<Recommendation> {
        let of_kind = |kind: CutterKind| move |cutter: &Cutter| cutter.kind() == kind;
        let [one, other] = self.parameters.candidates.as_slice() else { return None };
        let pair = [one.candidate.cutter, other.candidate.cutter];
        let toroidal = pair.into_iter().find(of_kind(CutterKind::Toroidal))?;
        let ball_end = pair.into_iter().find(of_kind(CutterKind::BallEnd))?;
        // The published comparison uses model `analytic`, unless the request states another for method `rectangle`.
        let model = if self.parameters.method == Method::Rectangle { self.parameters.model() } else { Model::Analytic };
        let job = CutterComparison::new(toroidal, ball_end, self.parameters.scallop_height, self.parameters.machine.limits, model).ok()?;
        recommend(&job, &self.shape).ok()
    }

    /// The faulty tools of the libraries, whose positions follow those of the candidates.
    fn faulty_tools(&self) -> impl Iterator<Item = NotRanked> {
        let first = self.parameters.candidates.len();
        let tools = self.parameters.faulty_tools.iter().enumerate();
        tools.map(move |(index, tool)| {
            NotRanked::new(first + index, Some(tool.name().to_owned()), NotRankedCode::FaultyTool, tool.to_string())
        })
    }

    fn not_ranked(&self, cutter: usize, reason: NotRankedReason) -> NotRanked {
        let uncut = if let NotRankedReason::CannotReach { uncut_share, uncut_height } = reason {
            Some((uncut_share, uncut_height.mm()))
        } else {
            None
        };
        let name = self.parameters.candidates[cutter].name.clone();
        NotRanked {
            uncut_share: uncut.map(|(share, _)| share),
            uncut_height_mm: uncut.map(|(_, height)| height),
            ..NotRanked::new(cutter, name, reason.into(), reason.to_string())
        }
    }
}

fn on_rectangle(named: &NamedCandidate, settings: &PlanSettings, shape: &Shape) -> Result<Option<RectanglePlan>, OutOfRange> {
    plan_on_rectangle(&named.candidate, shape, settings, settings.model)
}

/// The warnings about a cutter's passes on the rectangle: flutes that are shorter than the surface is deep, and an analytic
/// step-over that leaves far more than the scallop height.
fn on_rectangle_warnings(
    place: usize,
    plan: &RectanglePlan,
    slope: Angle,
    settings: &PlanSettings,
    candidates: &[NamedCandidate],
) -> Vec<Warning> {
    let candidate = &candidates[place].candidate;
    let depth = settings.shape.map_or(0.0, |shape| shape.bounds.max[2] - shape.bounds.min[2]);
    let flutes = candidate.flute_length.filter(|flutes| flutes.mm() < depth).map(|_| short_flutes(place, candidates));
    let exceeds = match settings.model {
        Model::Analytic => {
            let named = candidates[place].name.clone().unwrap_or_else(|| format!("cutter {place}"));
            outside_range(&named, candidate.cutter, slope, plan.zigzag.step_over, plan.feed_per_tooth, settings.scallop_height)
        }
        Model::Envelope => None,
    };
    flutes.into_iter().chain(exceeds).collect()
}

fn short_flutes(place: usize, candidates: &[NamedCandidate]) -> Warning {
    let named = &candidates[place];
    let cutter = named.name.clone().unwrap_or_else(|| format!("cutter {place}"));
    let flutes = named.candidate.flute_length.map_or(0.0, Length::mm);
    Warning::new(WarningCode::FlutesTooShort, format!("the flutes of {cutter}, {flutes} mm long, are shorter than the surface is deep"))
}

/// A warning for each cutter whose spindle speed the machine does not reach.
fn limited_speeds(candidates: &[NamedCandidate], machine: &Machine) -> Vec<Warning> {
    let Some(limit) = machine.max_spindle_speed else { return Vec::new() };
    let warning = |(place, named): (usize, &NamedCandidate)| {
        let stated = named.candidate.drive.map(|drive| drive.spindle_speed).filter(|speed| speed.rpm() > limit.rpm())?;
        let cutter = named.name.clone().unwrap_or_else(|| format!("cutter {place}"));
        let (stated, limit) = (stated.rpm(), limit.rpm());
        let detail = format!("the spindle speed of {cutter}, {stated} rpm, is over the machine's largest, {limit} rpm, which is used");
        Some(Warning::new(WarningCode::SpindleSpeedLimited, detail))
    };
    candidates.iter().enumerate().filter_map(warning).collect()
}

fn shape_code(error: ShapeError) -> RequestFault {
    match error {
        ShapeError::TooFewPoints { .. } => RequestFault::TooFewPoints,
        ShapeError::OnlyDegenerateFacets { .. } => RequestFault::OnlyDegenerateFacets,
        ShapeError::AllPointsEqual => RequestFault::AllPointsEqual,
        ShapeError::Collinear => RequestFault::Collinear,
        ShapeError::CoordinateOutOfRange => RequestFault::OutOfRange,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_says_why_a_path_is_left_out() {
        let mut warnings = Vec::new();
        assert!(fits("program", 500_000, MOST_PROGRAM_POINTS, &mut warnings) && warnings.is_empty());
        assert!(!fits("passes", 500_000, MOST_PASS_POINTS, &mut warnings) && !fits("program", 0, MOST_PROGRAM_POINTS, &mut warnings));
        let warnings = serde_json::to_value(&warnings).unwrap();
        assert_eq!(warnings[0]["detail"], "passes left out: the path has 500000 points, more than 400000");
        assert_eq!(warnings[1]["detail"], "program left out: the first candidate's path is too long to be milled");
    }
}
