//! The check of a path: its parameters, its figures, and the answer.

use super::confidence_answer::ConfidenceAnswer;
use super::map::PathMapAnswer;
use super::parameters::{AVOID, DEFAULT_MAX_SLOPE, FACING, MAX_SLOPE, SELECT};
use super::path_feeds::{FeedsAnswer, PathMoves};
use super::path_object::{CuttersByNumber, PATH, PATH_CUTTER, PATH_CUTTERS, PathCutters, StatedPath};
use super::program::ProgramAnswer;
use super::surface_answer::{avoided_mesh, merged, report};
use super::upload::given_once;
use crate::cancellation::CancelFlag;
use crate::file_fault::FileFault;
use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Faulted, Faults, Flag, List, Members, Object, Quantity, Renamed, members};
use crate::http::wire::{
    CandidateKind, MACHINE, MachineKind, OnePoint, ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, SURFACE, SelectKind, StatedSurface,
    SurfaceWithSource, UNIT, Warning, answer, plan_tolerance,
};
use crate::milling::{Profile, ra_um};
use crate::motion;
use crate::path::program::{Dialect, ProgramPoint, with_feeds};
use crate::path::{
    DropCutter, Finding, FindingKind, Finish, Left, Milled, Move, ON_EDGES, Passage, PathLengths, Place, Places, Reach, Residual,
    WithMarks, findings, idle_length,
};
use crate::planning::machined_surface::{MachinedFacets, Stop};
use crate::planning::{Confidence, PathEvidence};
use crate::quantity::{Angle, Length};
use crate::surface::{Facing, Mesh, ReceivedSurface, Unit};
use serde::Serialize;
use utoipa::ToSchema;

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
            "the place of the cutter that the path states: its lowest point (default), or the point of the axis that is as high as the centre of the ball or of the corner, and for other shapes as that of the arc at the tip"),
        origin: optional PATH_ORIGIN: OnePoint = ("origin_mm", OnePoint,
            "where the path's zero point is in the coordinates of the surface, such as a corner of the stock; absent = at the zero point of the surface"),
        roughness: optional ROUGHNESS: RoughnessKind,
        tolerance: optional TOLERANCE: Quantity<Length> = ("scallop_tolerance_mm", Quantity::length(0.01),
            "the height that may be left"),
        scallop_height: optional SCALLOP_HEIGHT: Renamed<Length>,
        machine: required MACHINE: MachineKind,
        max_slope: optional MAX_SLOPE: Quantity<Angle>,
        unit: optional UNIT: Choice<Unit>,
        facing: optional FACING: Choice<Facing>,
        select: optional SELECT: SelectKind,
        avoid: optional AVOID: StatedSurface,
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
    /// The facets of the surface and of `avoid` together; `None` without `avoid`.
    with_avoided: Option<Mesh>,
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
        avoid_part: Option<Result<SurfaceWithSource, FileFault>>,
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
            origin,
            roughness,
            tolerance,
            scallop_height,
            machine,
            max_slope,
            unit,
            facing,
            select,
            avoid,
            include,
            old_feeds,
        } = members;
        let path_at = root.member(PATH.name);
        let tolerance = plan_tolerance(tolerance, scallop_height, roughness, &TOLERANCE, &root, faults);
        // The faults of what is to be avoided and of the cutters are found even if the surface has some.
        let avoid = avoid.and_then(|member| given_once(avoid_part, member, faults));
        let path = path.and_then(|path| Ok((PathCutters::of(cutter?, cutters?, &path.program, &root, &path_at, faults)?, path)));
        let (include, old_feeds) = (include?.unwrap_or_else(|| vec![PathPart::Places]), old_feeds?.unwrap_or_default());
        if include.contains(&PathPart::Program) && path.as_ref().is_ok_and(|(_, path)| path.text.is_none()) {
            let detail = "program in include needs the program of a path, not tip_mm";
            return Err(faults.add(&root.member(PATH_INCLUDE.name), RequestFault::ConflictingFields, detail));
        }
        let (requested, mut warnings) = (unit?, Vec::new());
        let avoid = avoid?.map(|avoid| avoided_mesh(avoid, requested, &mut warnings, faults, &stop)).transpose();
        let (surface, facing) = (surface?, facing?.unwrap_or_default());
        let (selection, max_slope) =
            (select?.unwrap_or_default(), max_slope?.unwrap_or_else(|| Angle::from_radians(DEFAULT_MAX_SLOPE.to_radians())));
        let unit = surface.unit_of(requested, faults)?;
        let shape = surface.surface.sampled.shape(unit, facing);
        warnings.extend(shape.map_or_else(|_| Vec::new(), |shape| surface.warnings(&shape)));
        let SurfaceWithSource { surface: ReceivedSurface { mesh, .. }, .. } = surface;
        let surface = MachinedFacets::new(mesh, unit, facing, &selection, max_slope, &stop);
        let surface = surface.map_err(|reason| report(reason, &at, faults))?;
        warnings.extend(merged(&surface.mesh));
        let with_avoided = avoid?.map(|avoid| {
            let mut whole = surface.mesh.clone();
            whole.append(&avoid);
            whole
        });
        let ((cutters, mut path), machine, tolerance) = (path?, machine?, tolerance?.height);
        let (origin, is_centre) = (origin?.unwrap_or_default(), tip? == Some(TipPoint::Centre));
        for ProgramPoint { point, tool, .. } in &mut path.program.points {
            (0..3).for_each(|axis| point[axis] += origin[axis]);
            if is_centre {
                point[2] -= cutters.of_tool(*tool).candidate.cutter.corner_radius().mm();
            }
        }
        let check = Self { surface, with_avoided, cutters, tolerance, machine, path, include, old_feeds, warnings };
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
        let machined: Vec<u32> = self.surface.machined().collect();
        let mesh = self.with_avoided.as_ref().unwrap_or(&self.surface.mesh);
        let tolerance = self.tolerance.mm();
        let drop = DropCutter::of_mesh(mesh, stop);
        let places = Places::draw(mesh, &machined, PLACES, 1).seen_from_above(&drop).with_cuts(mesh, &machined, &drop, ON_EDGES);
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
        let map = if self.includes(PathPart::Map) { Some(PathMapAnswer::new(&self.surface.mesh, &machined, &milled, stop)?) } else { None };
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
            missed_or_cut_share: finish.uncut_share.value + finish.gouge_share.value,
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
        Dialect::Klartext => "klartext",
        Dialect::Apt => "apt",
        Dialect::Columns => "columns",
    }
}

answer! {
    /// What a path leaves on a surface.
    pub(crate) struct PathCheckAnswer {
        /// The number of moves, arcs in chords.
        pub(super) moves: usize,
        /// The length of the moves at the feed rate.
        pub(super) cutting_length_mm: f64 [minimum = 0],
        /// The length of the rapid moves.
        pub(super) rapid_length_mm: f64 [minimum = 0],
        /// The time of all moves. The control stops where moves at the feed rate and rapid moves meet; it rounds corners
        /// within the machine's path tolerance, or, if none is stated, stops in those of more than 45°.
        pub(super) machining_time_s: f64 [minimum = 0],
        /// The material left over the selected area that is seen from above, along its normal; negative where the part is
        /// cut. Absent if the path comes over no place.
        pub(super) residual_mm?: ResidualAnswer,
        /// The share of the area left over 1.02 times the tolerance, uncut area included.
        pub(super) over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area left over the tolerance that the cutter could reach.
        pub(super) reachable_over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area over which no move at the feed rate comes.
        pub(super) uncut_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area with ridges of at least half the tolerance.
        pub(super) used_share: f64 [minimum = 0, maximum = 1],
        /// Cuts into the part: into the selected area, and into all else that is seen from above, walls and `avoid` included.
        pub(super) gouge: GougeAnswer,
        /// The standard errors of the shares.
        pub(super) standard_error: StandardErrors,
        /// Ra of the geometry, in um, at `residual_mm.p99` as a scallop height: 99 % of the area are smoother.
        pub(super) ra_um: f64 [minimum = 0],
        /// What is left with tooth marks of the worst phase, over the places where it is under ten times the tolerance. Absent
        /// if teeth, spindle speed or a feed rate is not known.
        pub(super) scallop_height_with_marks_mm?: ResidualAnswer,
        /// The length of the moves at the feed rate that take nothing over a tenth of the tolerance off what the moves before
        /// them left on the selected area. Moves near one that cuts count as cutting.
        pub(super) idle_length_mm: f64 [minimum = 0],
        /// The worst places of each kind, at most a hundred, no two of a kind closer than the cutter's radius, and at most ten
        /// feed rates over a limit; with `places` in `include`, or without `include`.
        pub(super) places?: Vec<PlaceAnswer> [max_items = 110],
        /// The surface as a raster; with `map` in `include`.
        pub(super) map?: PathMapAnswer,
        /// The largest feeds that keep the tolerance; with `feeds` in `include`.
        pub(super) feeds?: FeedsAnswer,
        /// The program with the largest feeds; with `program` in `include`.
        pub(super) program?: ProgramAnswer,
        /// The reliability of the figures.
        pub(super) confidence: ConfidenceAnswer,
        /// Facts that need attention.
        pub(super) warnings: Vec<Warning>,
    }

    /// Percentiles over the area of what is left.
    pub(super) struct ResidualAnswer of (residual: Residual) {
        /// The median.
        p50: f64 = residual.p50,
        /// 90 % of the area have less.
        p90: f64 = residual.p90,
        /// 99 % of the area have less.
        p99: f64 = residual.p99,
        /// The most that was found.
        max: f64 = residual.max,
    }

    /// Cuts into the part and into what is to be avoided.
    pub(super) struct GougeAnswer of (finish: &Finish) {
        /// The share of the selected area cut by more than 2 um and a fifth of the tolerance.
        share: f64 [minimum = 0, maximum = 1] = finish.gouge_share.value,
        /// The deepest cut of moves at the feed rate.
        depth_mm: f64 [minimum = 0] = finish.gouge.map_or(0.0, |spot| -spot.left.height),
        /// The deepest cut of rapid moves, each of them straight. A control that moves each axis at its own rate takes another way,
        /// unless a move goes along one axis.
        rapid_depth_mm: f64 [minimum = 0] = finish.collision.map_or(0.0, |spot| -spot.left.height),
    }

    /// The standard errors of the shares, which are measured at random places.
    #[expect(clippy::struct_field_names, reason = "the wire names")]
    pub(super) struct StandardErrors of (finish: &Finish) {
        /// Of `over_tolerance_share`.
        over_tolerance_share: f64 [minimum = 0] = finish.over_share.standard_error,
        /// Of `reachable_over_tolerance_share`.
        reachable_over_tolerance_share: f64 [minimum = 0] = finish.over_reachable_share.standard_error,
        /// Of `uncut_share`.
        uncut_share: f64 [minimum = 0] = finish.uncut_share.standard_error,
        /// Of `gouge.share`.
        gouge_share: f64 [minimum = 0] = finish.gouge_share.standard_error,
    }

    /// A place where the path leaves too much or cuts too deep.
    pub(super) struct PlaceAnswer {
        /// What is wrong.
        pub(super) code: PlaceCode,
        /// The place on the surface.
        pub(super) point_mm: [f64; 3] [min_items = 3, max_items = 3],
        /// What is left there, negative in a cut; absent where it is uncut, and of `feed-over-limit`.
        pub(super) value_mm?: f64,
        /// The index of a move, from 0: of a cut the one that cuts deepest, elsewhere the one that was to finish the place. Absent
        /// where it is uncut.
        pub(super) r#move?: usize,
        /// The line of the program that states the move, from 1; absent for points.
        pub(super) line?: u32,
    }
}

/// What is wrong at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = PathPlaceCode)]
pub(super) enum PlaceCode {
    /// A rapid move cuts the part.
    Collision,
    /// A move at the feed rate cuts the part.
    Gouge,
    /// More than the tolerance is left where the cutter can reach.
    OverTolerance,
    /// Tooth marks leave more than the tolerance where the path itself does not: the feed of the move is too high.
    FeedTooHigh,
    /// No move comes over a place that the cutter can reach.
    Uncut,
    /// The first move of a tool with a feed rate over the machine's or the cutter's limit; the machine's is kept. The place is
    /// the end of the move.
    FeedOverLimit,
}

impl From<FindingKind> for PlaceCode {
    fn from(kind: FindingKind) -> Self {
        match kind {
            FindingKind::Collision => Self::Collision,
            FindingKind::Gouge => Self::Gouge,
            FindingKind::OverTolerance => Self::OverTolerance,
            FindingKind::FeedTooHigh => Self::FeedTooHigh,
            FindingKind::Uncut => Self::Uncut,
        }
    }
}

impl PlaceAnswer {
    pub(super) fn of(finding: &Finding, milled: &Milled, path: &PathMoves<'_>) -> Self {
        let Finding { kind, place, left } = finding;
        let nearest = if *kind == FindingKind::OverTolerance { milled.nearest_at(place.point, place.normal) } else { None };
        let by = nearest.or(left.map(|left| left.by)).map(|by| by as usize);
        Self {
            code: (*kind).into(),
            point_mm: place.point,
            value_mm: left.map(|left| left.height),
            r#move: by,
            line: by.and_then(|by| path.line_of(by)),
        }
    }

    /// The end of a move with a feed rate over a limit.
    pub(super) fn over_limit(at: usize, path: &PathMoves<'_>) -> Self {
        Self { code: PlaceCode::FeedOverLimit, point_mm: path.moves[at].to, value_mm: None, r#move: Some(at), line: path.line_of(at) }
    }
}
