//! Plans of several operations: which are worth planning by their estimates, and the fastest that is planned.

use super::candidate_plan::{CandidatePlan, MilledFigures, PlannedPath};
use super::estimate::{least_seconds, seconds};
use super::family::{Family, Heading};
use super::judged::{FinishFigures, Judged, KEPT, judged};
use super::milled_plan::{MOST_WITH_OPERATIONS, NoPlan, Planner};
use super::settings::{CandidateCutter, Pattern, PlanSettings};
use super::spacing::{Prepared, rows_of};
use super::stations::{Cells, DrawnPlace, ESTIMATED_ON, JUDGED_ON, Region, Set, Station, drawn, drawn_until, stations};
use super::workpiece::Workpiece;
use crate::path::Milled;
use crate::quantity::{Angle, Length, Time};
use rayon::prelude::*;
use std::cell::Cell;

/// The slopes in deg at which a surface is divided: flats from the rest, and shallow from steep.
const SPLITS: [f64; 4] = [1.0, 20.0, 35.0, 50.0];

/// The angle in deg between the directions that are tried.
const DIRECTIONS_APART: u16 = 15;

/// A part with a smaller share of the area is not worth an operation.
const SMALLEST_PART: f64 = 0.005;

/// The divisions whose leftovers a smaller cutter is tried on.
const TRIED_WITH_REST: usize = 4;

/// A cutter with the stations of the places on which operations are estimated: station i belongs to place i for every tool.
pub(super) struct Tool {
    pub(super) prepared: Prepared,
    pub(super) stations: Vec<Station>,
}

/// An operation to plan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Planned {
    /// The position among the tools.
    pub(super) tool: usize,
    pub(super) family: Family,
    /// The slopes of the facets that it machines, in rad.
    pub(super) slopes: [f64; 2],
    /// Whether it machines only what the operations before it cannot reach.
    pub(super) is_rest: bool,
    /// The estimated time.
    pub(super) seconds: f64,
}

impl Planned {
    /// Whether both have the same cutter and lines, and so the same estimate that they machine the same facets.
    fn is_alike(&self, other: &Self) -> bool {
        (self.tool, self.family, self.is_rest, self.seconds) == (other.tool, other.family, other.is_rest, other.seconds)
    }

    /// Whether both are the same operation. What a rest machines depends on the operations before it.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.is_alike(other) && self.has_such_lines(other)
    }

    /// Whether both have planes or both have levels, on the same slopes.
    #[expect(clippy::float_cmp, reason = "bounds are those of a list")]
    pub(super) fn has_such_lines(&self, other: &Self) -> bool {
        !self.is_rest && !other.is_rest && self.slopes == other.slopes && self.family.is_like(&other.family)
    }
}

/// Operations in their order.
#[derive(Debug, Clone)]
pub(super) struct Arrangement {
    pub(super) operations: Vec<Planned>,
    /// The estimated time, tool changes included.
    pub(super) seconds: f64,
}

impl Arrangement {
    /// The number of tool changes.
    pub(super) fn tool_changes(&self) -> usize {
        self.operations.windows(2).filter(|pair| pair[0].tool != pair[1].tool).count()
    }

    /// The time of the tool changes in s.
    #[expect(clippy::cast_precision_loss, reason = "a few")]
    pub(super) fn change_seconds(&self, settings: &PlanSettings) -> f64 {
        self.tool_changes() as f64 * settings.machine.change_time().seconds()
    }
}

/// What arrangements are found from.
pub(super) struct Arranger<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) settings: &'a PlanSettings,
    pub(super) tools: &'a [Tool],
    /// The most operations.
    pub(super) most: usize,
}

impl Arranger<'_> {
    /// Arrangements of at least two operations, the one with the shortest estimate first.
    pub(super) fn arrangements(&self) -> Vec<Arrangement> {
        let whole = [0.0, std::f64::consts::FRAC_PI_2];
        let divisions = SPLITS.iter().map(|split| split.to_radians()).map(|split| vec![[whole[0], split], [split, whole[1]]]);
        let mut found: Vec<Arrangement> = Vec::new();
        for slopes in divisions.chain([vec![whole]]) {
            if slopes.iter().any(|slopes| self.share(|index| self.is_within(index, *slopes)) < SMALLEST_PART) {
                continue;
            }
            let of_parts: Vec<Vec<Planned>> = slopes.iter().map(|slopes| self.of_part(*slopes)).collect();
            found.extend(combined(&of_parts).into_iter().map(|operations| self.arranged(operations)));
        }
        found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        let mut with_rest: Vec<Arrangement> = Vec::new();
        for operations in
            found.iter().filter(|found| found.operations.len() < self.most).map(|found| &found.operations).take(TRIED_WITH_REST)
        {
            with_rest.extend(self.rest_of(operations).map(|rest| {
                let all = operations.iter().copied().chain([rest]).collect();
                self.arranged(all)
            }));
        }
        found.retain(|found| self.share(|index| !self.is_reached(index, &found.operations)) <= self.settings.max_uncut_share);
        found.extend(with_rest);
        found.retain(|found| (2..=self.most).contains(&found.operations.len()));
        found.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
        // Divisions at several slopes are one where no facet lies between the slopes.
        found.dedup_by(|a, b| {
            a.operations.len() == b.operations.len() && a.operations.iter().zip(&b.operations).all(|(a, b)| a.is_alike(b))
        });
        found
    }

    fn arranged(&self, mut operations: Vec<Planned>) -> Arrangement {
        // Operations with the same cutter follow each other; what is left comes last.
        operations.sort_by_key(|operation| (operation.is_rest, operation.tool));
        let mut arrangement = Arrangement { operations, seconds: 0.0 };
        arrangement.seconds =
            arrangement.change_seconds(self.settings) + arrangement.operations.iter().map(|operation| operation.seconds).sum::<f64>();
        arrangement
    }

    /// The shares of the area for which `holds`, by the index of the station.
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    fn share(&self, holds: impl Fn(usize) -> bool) -> f64 {
        let count = self.tools.first().map_or(0, |tool| tool.stations.len());
        (0..count).filter(|index| holds(*index)).count() as f64 / count.max(1) as f64
    }

    fn is_within(&self, index: usize, slopes: [f64; 2]) -> bool {
        self.tools.first().is_some_and(|tool| self.workpiece.is_sloped(tool.stations[index].place.target, slopes))
    }

    /// Whether one of the operations that machine a place reaches it.
    fn is_reached(&self, index: usize, operations: &[Planned]) -> bool {
        let height = self.settings.scallop_height.mm();
        operations
            .iter()
            .any(|operation| self.is_within(index, operation.slopes) && self.tools[operation.tool].stations[index].lift <= height)
    }

    /// The fastest lines of each tool on the facets of these slopes.
    fn of_part(&self, slopes: [f64; 2]) -> Vec<Planned> {
        let of_tool = |tool: usize| self.fastest(tool, slopes, false, &|index| self.is_within(index, slopes));
        (0..self.tools.len()).into_par_iter().filter_map(of_tool).collect()
    }

    /// The fastest operation on what others cannot reach; `None` if they reach nearly all of it, or none keeps what may be left
    /// uncut.
    fn rest_of(&self, operations: &[Planned]) -> Option<Planned> {
        let is_left = |index: usize| !self.is_reached(index, operations);
        if self.share(is_left) < SMALLEST_PART / 10.0 {
            return None;
        }
        let height = self.settings.scallop_height.mm();
        let whole = [0.0, std::f64::consts::FRAC_PI_2];
        let of_tool = |tool: usize| {
            let stations = &self.tools[tool].stations;
            let is_kept = self.share(|index| is_left(index) && stations[index].lift > height) <= self.settings.max_uncut_share;
            if is_kept { self.fastest(tool, whole, true, &is_left) } else { None }
        };
        (0..self.tools.len()).into_par_iter().filter_map(of_tool).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }

    /// The fastest lines of a tool on the stations that `belongs` accepts.
    fn fastest(&self, tool: usize, slopes: [f64; 2], is_rest: bool, belongs: &(dyn Fn(usize) -> bool + Sync)) -> Option<Planned> {
        let Tool { prepared, stations } = &self.tools[tool];
        let of_part: Vec<Station> = stations.iter().enumerate().filter(|(index, _)| belongs(*index)).map(|(_, station)| *station).collect();
        let planes = (0..180 / DIRECTIONS_APART).map(|step| Family::Planes(Heading::of(f64::from(step * DIRECTIONS_APART).to_radians())));
        // Level facets have no level lines.
        let levels = (slopes[0] > 0.0 && self.settings.pattern == Pattern::Zigzag).then_some(Family::Levels);
        let timed = |family: Family| {
            let seconds = seconds(self.workpiece, &of_part, prepared, self.settings, &family)?;
            Some(Planned { tool, family, slopes, is_rest, seconds })
        };
        planes.chain(levels).filter_map(timed).min_by(|a, b| a.seconds.total_cmp(&b.seconds))
    }
}

/// Every choice of one operation for each part.
fn combined(of_parts: &[Vec<Planned>]) -> Vec<Vec<Planned>> {
    of_parts.iter().fold(vec![Vec::new()], |chosen, of_part| {
        let with = |chosen: &Vec<Planned>| -> Vec<Vec<Planned>> {
            of_part.iter().map(|operation| chosen.iter().copied().chain([*operation]).collect()).collect()
        };
        chosen.iter().flat_map(with).collect()
    })
}

/// The arrangements that are planned at most, those included whose drafts are too slow.
const MOST_PLANNED: usize = 5;

/// The share of a draft's time that its plan takes at least.
const DRAFT_SURE: f64 = 0.9;

/// The cutters among which operations choose, at most.
const MOST_TOOLS: usize = 12;

/// The lines of an operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lines {
    /// Vertical planes in a direction seen from above, counted from X, cut to and fro.
    Zigzag(Angle),
    /// Such planes, all cut in the direction.
    OneWay(Angle),
    /// Level curves.
    Waterline,
}

/// A plan of several operations.
#[derive(Debug, Clone)]
pub struct OperationsPlan {
    /// The operations in their order.
    pub operations: Vec<OperationPlan>,
    /// The number of tool changes between them.
    pub tool_changes: usize,
    /// The time of all runs, links and tool changes.
    pub time: Time,
    /// What all together leave.
    pub finish: FinishFigures,
}

/// One operation.
#[derive(Debug, Clone)]
pub struct OperationPlan {
    /// The position of the cutter among the candidates.
    pub candidate: usize,
    /// Its lines.
    pub lines: Lines,
    /// The slopes of the facets that it machines, without the overlap at the border.
    pub slopes: [Angle; 2],
    /// The operations before it whose leftovers it machines; `None` if it machines all facets of its slopes.
    pub after: Option<usize>,
    /// The share of the area that it machines.
    pub area_share: f64,
    /// Its figures, over that area.
    pub figures: MilledFigures,
    pub(super) path: PlannedPath,
}

impl OperationsPlan {
    /// The number of points of its path.
    #[must_use]
    pub fn points(&self) -> usize {
        self.operations.iter().map(|operation| operation.path.plan.tour.points.len()).sum()
    }
}

/// What was found of plans of several operations.
#[derive(Default)]
pub(super) struct OperationsSearch {
    /// The fastest of them that keeps the scallop height and is faster than the plan of one operation.
    pub(super) best: Option<OperationsPlan>,
    /// The number of arrangements that are expected to be faster still and were not planned, because too many lines had been computed.
    pub(super) not_planned: usize,
}

/// Plans of at least two and at most `settings.most_operations` operations that may be faster than `single`. Once `stop` returns true,
/// the result must be discarded.
pub(super) fn operations(
    workpiece: &Workpiece,
    candidates: &[CandidateCutter],
    settings: &PlanSettings,
    single: &CandidatePlan,
    samples: &Cell<usize>,
    stop: &(dyn Fn() -> bool + Sync),
) -> OperationsSearch {
    let mut search = OperationsSearch::default();
    if settings.most_operations < 2 {
        return search;
    }
    let tools = tools(workpiece, candidates, settings, single.candidate, stop);
    let mut arrangements = Arranger { workpiece, settings, tools: &tools, most: settings.most_operations }.arrangements();
    let unseen = drawn(workpiece, JUDGED_ON, Set::Last.seed());
    let area = unseen.iter().map(|place| place.area).sum();
    let keeps = single.milled.is_some_and(|milled| milled.finish.far_over_share <= KEPT);
    let mut limit = if keeps { single.time.seconds() } else { f64::INFINITY };
    let mut arranged = Arranged { workpiece, settings, tools: &tools, area, samples, stop, found: Vec::new() };
    for _ in 0..MOST_PLANNED {
        let expected = arrangements.iter().map(|arrangement| arranged.expected(arrangement)).enumerate();
        let faster = expected.filter(|(_, seconds)| *seconds < limit);
        if samples.get() >= MOST_WITH_OPERATIONS {
            search.not_planned = faster.count();
            break;
        }
        let Some((next, _)) = faster.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        let Ok(plan) = arranged.plan(&arrangements.swap_remove(next), &unseen, limit) else { continue };
        let is_kept = plan.finish.far_over_share <= KEPT && plan.finish.uncut_share <= settings.max_uncut_share;
        if is_kept && plan.time.seconds() < limit {
            limit = plan.time.seconds();
            search.best = Some(plan);
        }
    }
    search
}

/// The cutters that operations choose from: the single plan's, and of the others those of the most different sizes.
fn tools(
    workpiece: &Workpiece,
    candidates: &[CandidateCutter],
    settings: &PlanSettings,
    single: usize,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Tool> {
    let rows = rows_of(workpiece);
    let few = drawn(workpiece, ESTIMATED_ON, 0);
    let height = settings.scallop_height.mm();
    let mut order: Vec<usize> = (0..candidates.len()).collect();
    order.sort_by(|a, b| candidates[*b].cutter.outer_radius().mm().total_cmp(&candidates[*a].cutter.outer_radius().mm()));
    // Evenly over the sizes where there are many.
    let step = order.len().div_ceil(MOST_TOOLS).max(1);
    let mut chosen: Vec<usize> = order.iter().copied().step_by(step).collect();
    if !chosen.contains(&single) {
        chosen.push(single);
    }
    let tool = |index: usize| {
        let prepared = Prepared::new(index, &candidates[index], settings, &rows, stop);
        let stations = stations(workpiece, &prepared.profile, &few, height, stop);
        Tool { prepared, stations }
    };
    let tools: Vec<Tool> = chosen.into_iter().map(tool).collect();
    if stop() { Vec::new() } else { tools }
}

/// What an arrangement is planned from.
struct Arranged<'a> {
    workpiece: &'a Workpiece,
    settings: &'a PlanSettings,
    tools: &'a [Tool],
    /// The area in mm^2 that is seen from above.
    area: f64,
    samples: &'a Cell<usize>,
    stop: &'a (dyn Fn() -> bool + Sync),
    /// The operations that were drafted.
    found: Vec<Found>,
}

/// An operation that was drafted.
struct Found {
    planned: Planned,
    /// Its time in s, by the draft if that is too slow to be planned; infinite without lines.
    seconds: f64,
    plan: Option<OperationPlan>,
}

impl Arranged<'_> {
    /// The time in s of an arrangement: of each operation what was found, else its estimate, longer by the factor by which it was too
    /// short for such lines on the same slopes, whatever the cutter.
    fn expected(&self, arrangement: &Arrangement) -> f64 {
        let of_operation = |planned: &Planned| {
            let known = self.found.iter().find(|found| found.planned.is_same(planned));
            let alike = self.found.iter().filter(|found| found.planned.has_such_lines(planned));
            let factors = alike.map(|found| found.seconds / found.planned.seconds).filter(|factor| factor.is_finite());
            let factor = factors.fold(1.0, f64::max);
            known.map_or(factor * planned.seconds, |known| known.seconds)
        };
        arrangement.change_seconds(self.settings) + arrangement.operations.iter().map(of_operation).sum::<f64>()
    }

    /// The operations planned and milled together, unless they take longer than `limit` s.
    fn plan(&mut self, arrangement: &Arrangement, unseen: &[DrawnPlace], limit: f64) -> Result<OperationsPlan, NoPlan> {
        let Self { workpiece, settings, tools, stop, .. } = *self;
        let mut operations: Vec<OperationPlan> = Vec::new();
        let mut seconds = arrangement.change_seconds(settings);
        for (index, planned) in arrangement.operations.iter().enumerate() {
            operations.push(self.known_operation(planned, &arrangement.operations[..index], limit - seconds)?);
            seconds += operations[index].figures.tour.seconds;
            if seconds >= limit {
                return Err(NoPlan::NoLines);
            }
        }
        let mut all: Option<(Vec<Station>, Vec<Judged>)> = None;
        for (operation, planned) in operations.iter().zip(&arrangement.operations) {
            let prepared = &tools[planned.tool].prepared;
            let height = settings.scallop_height.mm();
            let on = stations(workpiece, &prepared.profile, unseen, height, stop);
            let milled = Milled::new(&prepared.profile, &operation.path.plan.tour.moves(), stop).ok_or(NoPlan::Stopped)?;
            let judged = judged(workpiece, &on, prepared, &operation.path.plan.family, &milled, height, stop).ok_or(NoPlan::Stopped)?;
            // A place counts as reached if an operation that machines it reaches it.
            let lift = |station: Station| {
                let is_machined = workpiece.is_sloped(station.place.target, planned.slopes);
                Station { lift: if is_machined { station.lift } else { f64::INFINITY }, ..station }
            };
            let on = on.into_iter().map(lift).collect();
            all = Some(match all {
                None => (on, judged),
                Some((before, judged_before)) => {
                    let nearer = before.iter().zip(on).map(|(a, b)| if b.lift < a.lift { b } else { *a }).collect();
                    (nearer, judged_before.iter().zip(&judged).map(|(a, b)| a.together(b)).collect())
                }
            });
        }
        let (on, judged) = all.ok_or(NoPlan::NoRuns)?;
        let mut finish = FinishFigures::of(&on, &judged, settings.scallop_height.mm());
        // The cuts of each operation were looked for on the whole part.
        let deepest = operations.iter().map(|operation| operation.figures.finish.gouge.mm()).fold(finish.gouge.mm(), f64::max);
        finish.gouge = Length::computed(deepest);
        Ok(OperationsPlan { operations, tool_changes: arrangement.tool_changes(), time: Time::computed(seconds), finish })
    }

    /// One operation, planned for the first arrangement that has it, unless it takes far longer than `limit` s. A rest depends on the
    /// operations before it.
    fn known_operation(&mut self, planned: &Planned, before: &[Planned], limit: f64) -> Result<OperationPlan, NoPlan> {
        let known = self.found.iter().position(|found| found.planned.is_same(planned));
        let found = match known.map(|known| self.found.swap_remove(known)) {
            Some(found) if found.plan.is_some() || DRAFT_SURE * found.seconds >= limit => found,
            _ => self.operation(planned, before, limit)?,
        };
        let plan = found.plan.clone();
        self.found.push(found);
        plan.ok_or(NoPlan::NoLines)
    }

    /// One operation, without a plan if it has none or its draft shows that it takes far longer than `limit` s.
    fn operation(&self, planned: &Planned, before: &[Planned], limit: f64) -> Result<Found, NoPlan> {
        let Self { workpiece, settings, tools, samples, stop, .. } = *self;
        let Tool { prepared, .. } = &tools[planned.tool];
        let height = settings.scallop_height.mm();
        let left = |places: Vec<DrawnPlace>| if planned.is_rest { self.left_by(before, places) } else { places };
        let of_set = |set: Set, cells: Option<&Cells>| {
            let belongs = |target: usize| workpiece.is_sloped(target, planned.slopes);
            let places = drawn_until(workpiece, set.count(), set.seed(), &belongs, &left, cells);
            stations(workpiece, &prepared.profile, &places, height, stop)
        };
        let on = of_set(Set::Spaced, None);
        let region = if planned.is_rest {
            Region::of_rest(&on, &prepared.profile, height)
        } else {
            Region::of_targets(workpiece, |target| workpiece.is_sloped(target, overlapping(workpiece, prepared, planned.slopes, target)))
        };
        let planner = Planner { workpiece, prepared, settings, region: &region, stations: &on, further: &of_set, samples, stop };
        let without_plan = |seconds: f64| Found { planned: *planned, seconds, plan: None };
        let draft = match planner.draft(planned.family) {
            Ok(draft) if DRAFT_SURE * draft.seconds < limit => draft,
            Ok(draft) => return Ok(without_plan(draft.seconds)),
            Err(NoPlan::Stopped) => return Err(NoPlan::Stopped),
            Err(_) => return Ok(without_plan(f64::INFINITY)),
        };
        let plan = planner.finished(draft)?;
        let area: f64 = on.iter().map(|station| station.place.area).sum();
        let figures = MilledFigures::of(workpiece, settings, prepared, &plan, least_seconds(workpiece, &on, prepared, height));
        let plan = OperationPlan {
            candidate: prepared.index,
            lines: lines_of(&planned.family, settings.pattern),
            slopes: planned.slopes.map(|slope| Angle::from_radians(slope.min(settings.max_slope.radians()))),
            after: planned.is_rest.then(|| before.len().saturating_sub(1)),
            area_share: (area / self.area).min(1.0),
            figures,
            path: PlannedPath { plan, prepared: prepared.clone() },
        };
        Ok(Found { planned: *planned, seconds: plan.figures.tour.seconds, plan: Some(plan) })
    }

    /// The places that no cutter of these operations reaches among those that it machines.
    fn left_by(&self, operations: &[Planned], places: Vec<DrawnPlace>) -> Vec<DrawnPlace> {
        let Self { workpiece, settings, tools, stop, .. } = *self;
        let height = settings.scallop_height.mm();
        operations.iter().fold(places, |left, operation| {
            let on = stations(workpiece, &tools[operation.tool].prepared.profile, &left, height, stop);
            let is_left = |station: &&Station| station.lift > height || !workpiece.is_sloped(station.place.target, operation.slopes);
            on.iter().filter(is_left).map(|station| station.place).collect()
        })
    }
}

/// The slopes of a part, wider by what a curved facet turns over one step-over, so that neighbouring parts overlap.
fn overlapping(workpiece: &Workpiece, prepared: &Prepared, [from, to]: [f64; 2], target: usize) -> [f64; 2] {
    let tangent = &workpiece.tangents[target];
    let step_over = (prepared.spacing.squared(tangent, 1.0, 0.0)).sqrt();
    let turn = (tangent.curvature[0].abs() * step_over).min(0.2);
    [from - turn, to + turn]
}

fn lines_of(family: &Family, pattern: Pattern) -> Lines {
    match (family, pattern) {
        (Family::Levels, _) => Lines::Waterline,
        (Family::Planes(heading), Pattern::Zigzag) => Lines::Zigzag(heading.angle()),
        (Family::Planes(heading), Pattern::OneWay) => Lines::OneWay(heading.angle()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::Cutter;
    use crate::motion::{Machine, Preset};
    use crate::planning::SurfaceEvidence;
    use crate::planning::plan::rank;
    use crate::surface::mesh::Selection;
    use crate::surface::{Facing, MeshBuilder, Unit};

    #[test]
    fn arrangements_for_which_too_many_lines_were_computed_are_counted() {
        // A floor and a wall of 60 deg.
        let points = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [40.0, 20.0, 0.0], [0.0, 20.0, 0.0], [40.0, 30.0, 17.32], [0.0, 30.0, 17.32]];
        let mut mesh = MeshBuilder::new();
        mesh.indexed(&points, &[[0, 1, 2], [0, 2, 3], [3, 2, 4], [3, 4, 5]]).unwrap();
        let mesh = mesh.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap();
        let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false)).unwrap();
        let visibility = mesh.visibility(Angle::from_degrees(85.0).unwrap(), &|| false);
        let part = Workpiece::new(&mesh, &visibility, &selected, None, &|| false);
        let diameter = Length::from_mm(6.0).unwrap();
        let candidates = [Cutter::flat_end(diameter), Cutter::ball_end(diameter)].map(CandidateCutter::new);
        let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
        let settings = PlanSettings { max_uncut_share: 0.2, ..PlanSettings::new(Length::from_mm(0.01).unwrap(), machine) };
        let single = rank(&part, &candidates, &settings, SurfaceEvidence::default(), &|| false).unwrap().plans.remove(0);
        let settings = PlanSettings { most_operations: 2, ..settings };
        let searched = |samples: usize| operations(&part, &candidates, &settings, &single, &Cell::new(samples), &|| false);
        let whole = searched(0);
        assert!(whole.best.is_some() && whole.not_planned == 0);
        let cut_short = searched(MOST_WITH_OPERATIONS);
        assert!(cut_short.best.is_none() && cut_short.not_planned > 0);
    }
}
