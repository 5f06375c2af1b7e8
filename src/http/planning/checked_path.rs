//! The check of a path: its parameters, and the figures of the answer.

use super::confidence_answer::ConfidenceAnswer;
use super::map::PathMapAnswer;
use super::parameters::{DEFAULT_MAX_SLOPE, FACING, MAX_SLOPE, SELECT};
use super::path_check_answer::{GougeAnswer, PathCheckAnswer, PlaceAnswer, ResidualAnswer, StandardErrors};
use super::path_cutters::{CuttersByNumber, PATH_CUTTER, PATH_CUTTERS, PathCutters};
use super::path_feeds::PathMoves;
use super::path_object::{PATH, StatedPath};
use super::program::ProgramAnswer;
use super::simulation::report;
use crate::cancellation::CancelFlag;
use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Faulted, Faults, Flag, List, Members, Object, Quantity, Renamed, members};
use crate::http::wire::{
    CandidateKind, MACHINE, MachineKind, ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, SURFACE, SelectKind, SurfaceWithSource, UNIT, Warning,
    plan_tolerance,
};
use crate::milling::{Profile, ra_um};
use crate::motion;
use crate::path::program::{Dialect, with_feeds};
use crate::path::{
    DropCutter, Finish, Left, Milled, Move, ON_EDGES, Passage, PathLengths, Place, Places, Reach, WithMarks, findings, idle_length,
};
use crate::planning::machined_surface::{MachinedFacets, Stop};
use crate::planning::{Confidence, PathEvidence};
use crate::quantity::{Angle, Length};
use crate::surface::{Facing, ReceivedSurface, Unit};

/// The places on the surface at which the path is looked at: a share of 1 % has a standard error of 0.05 %.
pub(in crate::http) const PLACES: usize = 40_000;

/// One of so many places is looked at for tooth marks and for moves that cut nothing, which takes longer.
const FEWER: usize = 10;

/// The places for which the largest feeds are found.
pub(in crate::http) const FEED_PLACES: usize = 200_000;

/// Tooth marks are looked for up to this height in tolerances.
const HIGHEST_MARK: f64 = 10.0;

/// The most feed rates over a limit that are listed.
const MOST_OVER_LIMITS: usize = 10;

/// The share of the tolerance under which a move cuts nothing.
const IDLE: f64 = 0.1;

/// The place of the cutter that a path states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum TipPoint {
    #[default]
    LowestPoint,
    Centre,
}

/// What an answer contains on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathPart {
    Map,
    Places,
    Feeds,
    Program,
}

members! {
    /// The members beside the surface and the path.
    pub(super) struct PathCheckMembers {
        cutter: optional PATH_CUTTER: CandidateKind,
        cutters: optional PATH_CUTTERS: CuttersByNumber,
        tip: optional TIP_POINT: Choice<TipPoint> = ("tip", Choice { name: Some("TipPoint"),
            words: &[("lowest_point", TipPoint::LowestPoint), ("centre", TipPoint::Centre)] },
            "the place of the cutter that the path states: its lowest point (default), or the centre of the ball or of the corner, on the axis"),
        roughness: optional ROUGHNESS: RoughnessKind,
        tolerance: optional TOLERANCE: Quantity<Length> = ("scallop_tolerance_mm", Quantity::length(0.01),
            "the height that may be left"),
        scallop_height: optional SCALLOP_HEIGHT: Renamed<Length>,
        machine: required MACHINE: MachineKind,
        max_slope: optional MAX_SLOPE: Quantity<Angle>,
        unit: optional UNIT: Choice<Unit>,
        facing: optional FACING: Choice<Facing>,
        select: optional SELECT: SelectKind,
        include: optional PATH_INCLUDE: List<Choice<PathPart>> = ("include", List { item: Choice { name: Some("PathPart"),
            words: &[("map", PathPart::Map), ("places", PathPart::Places), ("feeds", PathPart::Feeds), ("program", PathPart::Program)] },
            about_item: "what the answer contains", fewest: 0, most: 4 },
            "what the answer contains beside the figures; absent = places. feeds and program need teeth and spindle_speed_rpm of the cutter, or S words"),
        old_feeds: optional OLD_FEEDS: Flag = ("old_feeds_in_comments", Flag,
            "whether the program in the answer has each replaced F word in a comment; absent = false"),
    }
}

/// A path to check.
pub(super) struct PathToCheck {
    surface: MachinedFacets,
    cutters: PathCutters,
    tolerance: Length,
    machine: motion::Machine,
    path: StatedPath,
    include: Vec<PathPart>,
    old_feeds: bool,
    warnings: Vec<Warning>,
}

impl PathToCheck {
    pub(super) fn read(
        object: &mut Object<'_, '_>,
        surface: Result<SurfaceWithSource, Faulted>,
        path: Result<StatedPath, Faulted>,
        faults: &mut Faults,
        cancelled: &CancelFlag,
    ) -> Result<Self, Faulted> {
        let stop = || cancelled.is_cancelled();
        let members = PathCheckMembers::read(object, faults);
        let root = object.path();
        let at = root.member(SURFACE.name);
        let PathCheckMembers {
            cutter,
            cutters,
            tip,
            roughness,
            tolerance,
            scallop_height,
            machine,
            max_slope,
            unit,
            facing,
            select,
            include,
            old_feeds,
        } = members;
        let path_at = root.member(PATH.name);
        let tolerance = plan_tolerance(tolerance, scallop_height, roughness, &TOLERANCE, &root, faults);
        // The faults of the cutters are found even if the surface has some.
        let path = path.and_then(|path| Ok((PathCutters::of(cutter?, cutters?, &path.program, &root, &path_at, faults)?, path)));
        let (include, old_feeds) = (include?.unwrap_or_else(|| vec![PathPart::Places]), old_feeds?.unwrap_or_default());
        if include.contains(&PathPart::Program) && path.as_ref().is_ok_and(|(_, path)| path.text.is_none()) {
            let detail = "program in include needs the program of a path, not tip_mm";
            return Err(faults.add(&root.member(PATH_INCLUDE.name), RequestFault::ConflictingFields, detail));
        }
        let (surface, facing) = (surface?, facing?.unwrap_or_default());
        let (selection, max_slope) =
            (select?.unwrap_or_default(), max_slope?.unwrap_or_else(|| Angle::from_radians(DEFAULT_MAX_SLOPE.to_radians())));
        let unit = surface.unit_of(unit?, faults)?;
        let shape = surface.surface.sampled.shape(unit, facing);
        let warnings = shape.map_or_else(|_| Vec::new(), |shape| surface.warnings(&shape));
        let SurfaceWithSource { surface: ReceivedSurface { mesh, .. }, .. } = surface;
        let surface = MachinedFacets::new(mesh, unit, facing, &selection, max_slope, &stop);
        let surface = surface.map_err(|reason| report(reason, &at, faults))?;
        let ((cutters, mut path), machine, tolerance) = (path?, machine?, tolerance?.height);
        if tip? == Some(TipPoint::Centre) {
            for point in &mut path.program.points {
                point.point[2] -= cutters.of_tool(point.tool).candidate.cutter.corner_radius().mm();
            }
        }
        let check = Self { surface, cutters, tolerance, machine, path, include, old_feeds, warnings };
        if (check.includes(PathPart::Feeds) || check.includes(PathPart::Program)) && !check.has_teeth() {
            let detail = "feeds need the cutter's teeth, and its spindle_speed_rpm or S words in the program";
            return Err(faults.add(&root.member(PATH_INCLUDE.name), RequestFault::ConflictingFields, detail));
        }
        Ok(check)
    }

    fn includes(&self, part: PathPart) -> bool {
        self.include.contains(&part)
    }

    fn has_teeth(&self) -> bool {
        let (moves, points) = self.path.program.moves();
        self.moves(&moves, &points).has_teeth()
    }

    fn moves<'a>(&'a self, moves: &'a [Move], points: &'a [usize]) -> PathMoves<'a> {
        PathMoves { program: &self.path.program, cutters: &self.cutters, machine: &self.machine, moves, points }
    }

    /// The answer; `None` once `stop` returns true.
    pub(super) fn answer(self, stop: Stop) -> Option<PathCheckAnswer> {
        let (moves, points) = self.path.program.moves();
        let path = self.moves(&moves, &points);
        let lengths = PathLengths::new(&moves, &path.stated_rates(), &self.machine);
        let profiles: Vec<Profile> = self.cutters.cutters.iter().map(|cutter| cutter.candidate.cutter.profile()).collect();
        let milled = Milled::by_several(&profiles, |at| path.cutter_of(at), &moves, stop)?;
        let (mesh, machined): (_, Vec<u32>) = (&self.surface.mesh, self.surface.machined().collect());
        let tolerance = self.tolerance.mm();
        let drop = DropCutter::of_mesh(mesh, stop);
        let places = Places::draw(mesh, &machined, PLACES, 1).with_edges(mesh, &machined, ON_EDGES).seen_from_above(&drop);
        let reach = Reach::new(&profiles, &drop, &places, tolerance);
        let finish = Finish::new(&milled, mesh, &places, &reach, tolerance, stop)?;
        let fewer: Vec<Place> = places.inside().iter().step_by(FEWER).copied().collect();
        let idle_length_mm = idle_length(&milled, &moves, &fewer, IDLE * tolerance, stop)?;
        let passage = Passage::new(&milled, &moves);
        let with_marks = match path.stated_per_tooth() {
            Some(per_tooth) => Some(passage.with_marks(&fewer, &per_tooth, tolerance, HIGHEST_MARK * tolerance, stop)?),
            None => None,
        };
        let largest = if self.includes(PathPart::Feeds) || self.includes(PathPart::Program) {
            let places = Places::draw(mesh, &machined, FEED_PLACES, 2).seen_from_above(&drop);
            Some(path.largest(&passage, places.inside(), tolerance, stop)?)
        } else {
            None
        };
        let map = if self.includes(PathPart::Map) { Some(PathMapAnswer::new(mesh, &machined, &milled, stop)?) } else { None };
        let found = self.includes(PathPart::Places).then(|| {
            let marked = with_marks.as_ref().map_or_else(Vec::new, |marks| over_by_marks(&finish, &fewer, marks, tolerance));
            let smallest = profiles.iter().map(Profile::outer_radius).fold(f64::INFINITY, f64::min);
            let found = findings(&finish, &places, &marked, tolerance, smallest);
            let over_limits = path.over_limits().into_iter().take(MOST_OVER_LIMITS).map(|at| PlaceAnswer::over_limit(at, &path));
            found.iter().map(|finding| PlaceAnswer::of(finding, &milled, &path)).chain(over_limits).collect()
        });
        let confidence = Confidence::in_path(&PathEvidence {
            surface: self.surface.evidence(),
            tolerance: self.tolerance,
            assumed_feed_share: path.assumed_feed_share(),
            moves_without_corners: if self.machine.path_tolerance.is_some() { 0.0 } else { lengths.moves_per_run },
        });
        Some(PathCheckAnswer {
            moves: moves.len(),
            cutting_length_mm: lengths.cutting,
            rapid_length_mm: lengths.rapid,
            machining_time_s: lengths.time.seconds(),
            residual_mm: finish.residual.map(ResidualAnswer::of),
            over_tolerance_share: finish.over_share.value,
            reachable_over_tolerance_share: finish.over_reachable_share.value,
            uncut_share: finish.uncut_share.value,
            used_share: finish.used_share.value,
            gouge: GougeAnswer::of(&finish),
            standard_error: StandardErrors::of(&finish),
            ra_um: ra_um(finish.residual.map_or(Length::ZERO, |residual| Length::computed(residual.p99.max(0.0)))),
            scallop_height_with_marks_mm: with_marks.and_then(|marks| marks.residual).map(ResidualAnswer::of),
            idle_length_mm,
            places: found,
            map,
            program: largest.as_ref().and_then(|largest| self.program_with(&path.rates_of_points(&largest.rates))),
            feeds: largest.filter(|_| self.includes(PathPart::Feeds)).map(|largest| largest.answer),
            confidence: ConfidenceAnswer::from(&confidence),
            warnings: self.warnings,
        })
    }

    /// The program with the feed rate of each point in mm/min, if it is wanted.
    fn program_with(&self, rates: &[f64]) -> Option<ProgramAnswer> {
        let text = self.path.text.as_ref().filter(|_| self.includes(PathPart::Program))?;
        let text = with_feeds(text, &self.path.program, rates, self.old_feeds);
        Some(ProgramAnswer { text, dialect: word_of(self.path.program.dialect) })
    }
}

/// Of some of the places of `finish`, those where the moves themselves keep the tolerance, with what tooth marks leave.
fn over_by_marks(finish: &Finish, fewer: &[Place], marks: &WithMarks, tolerance: f64) -> Vec<(Place, Left)> {
    let keeps = |swept: &Option<Left>| swept.is_some_and(|swept| swept.height <= tolerance);
    let swept = finish.left.iter().step_by(FEWER);
    let kept = fewer.iter().zip(&marks.left).zip(swept).filter(|(_, swept)| keeps(swept));
    kept.filter_map(|((place, left), _)| left.map(|left| (*place, left))).collect()
}

fn word_of(dialect: Dialect) -> &'static str {
    match dialect {
        Dialect::GCode => "iso",
        Dialect::Apt => "apt",
        Dialect::Columns => "columns",
    }
}
