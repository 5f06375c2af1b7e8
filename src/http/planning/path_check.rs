//! `POST /v1/path-check`: what a path leaves on a surface, whoever made it.

use super::memory::bytes_to_read;
use super::parameters::{DEFAULT_MAX_SLOPE, FACING, MAX_SLOPE, SELECT};
use super::simulation::{on_threads, report};
use crate::cancellation::CancelFlag;
use crate::http::body::{JsonBody, WrittenJson};
use crate::http::codes::RequestFault;
use crate::http::document::described;
use crate::http::problem::{Problem, Problems};
use crate::http::reading::{Components, Faulted, Faults, Kind, List, Members, Object, ObjectSchema, Quantity, Whole, members, text};
use crate::http::wire::{CUTTER, PathMachine, PathPoints, SURFACE, SurfaceWithSource, UNIT, Warning, answer};
use crate::http::worker_pool::Work;
use crate::json_text::{JsonPath, JsonText};
use crate::memory_budget::Reservation;
use crate::motion;
use crate::path::program::{Dialect, Program, ProgramPoint, Reached, ReadSettings, read};
use crate::path::{Finding, FindingKind, Finish, Milled, Obstacles, PathLengths, Places, Reach, Residual, findings};
use crate::planning::machined_surface::NoMachinedSurface;
use crate::quantity::{Angle, Length, Speed};
use crate::surface::mesh::{FacetClass, Selection};
use crate::surface::{Mesh, ReceivedSurface};
use serde::Serialize;
use std::time::Duration;
use utoipa::ToSchema;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The most points of a path, arcs in chords.
const MOST_POINTS: usize = 1_000_000;

/// The places on the surface at which the path is looked at: a share of 1 % has a standard error of 0.05 %.
const PLACES: usize = 40_000;

/// The memory in bytes of a point of the path with its moves, and the length of the shortest block of a program.
const BYTES_OF_A_POINT: usize = 400;
const SHORTEST_BLOCK: usize = 3;

/// The memory of the places and their results, and of the facets in a grid for each byte of the body.
const BYTES_OF_PLACES: usize = 400 * PLACES;
const BYTES_OF_OBSTACLES: usize = 40;

members! {
    /// The members beside the surface.
    struct PathCheckMembers {
        path: required PATH: PathKind = ("path", PathKind, "the path of the tip: a program, or points"),
        cutter: required CUTTER: crate::http::wire::AnyCutter,
        scallop_height: required SCALLOP_HEIGHT: Quantity<Length> = ("scallop_height_mm", Quantity::length(0.01),
            "the tolerance: the height that may be left"),
        machine: required PATH_MACHINE: PathMachine = ("machine", PathMachine, "the machine that runs the path"),
        max_slope: optional MAX_SLOPE: Quantity<Angle>,
        unit: optional UNIT: crate::http::reading::Choice<crate::surface::Unit>,
        facing: optional FACING: crate::http::reading::Choice<crate::surface::Facing>,
        select: optional SELECT: crate::http::wire::SelectKind,
    }
}
members! {
    /// A path: a program, or points.
    struct PathMembers for PathKind ("Path", "A path of the tip: `program`, or `tip_mm` with its rapids and its feed rate") -> Program {
        program: optional PROGRAM: ProgramText = ("program", ProgramText, "the text of a program in G-code, of APT statements, or of columns x, y, z and feed rate"),
        tip: optional TIP: PathPoints = ("tip_mm", PathPoints, "the tip's points [x, y, z] in their order"),
        rapid: optional RAPID: List<Whole> = ("rapid", List { item: Whole { minimum: 1, maximum: 1_000_000, example: 2 },
            about_item: "the index of a point, from 0", fewest: 0, most: MOST_POINTS }, "the points that are reached by a rapid move"),
        feed_rate: optional FEED_RATE: Quantity<Speed> = ("feed_rate_mm_min", Quantity::new(Speed::from_mm_min, 3000.0),
            "the feed rate along the points; absent = the machine's"),
    }
}

impl PathMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Program, Faulted> {
        let (program, tip, rapid, feed_rate) = (self.program?, self.tip?, self.rapid?, self.feed_rate?);
        match (program, tip) {
            (Some(_), _) if rapid.is_some() || feed_rate.is_some() => Err(faults.add(
                path,
                RequestFault::ConflictingFields,
                "rapid and feed_rate_mm_min belong to tip_mm; a program states its own",
            )),
            (Some(program), None) => Ok(program),
            (None, Some(tip)) => {
                let mut points: Vec<ProgramPoint> =
                    tip.into_iter().zip(1..).map(|(point, line)| stated_point(point, line, feed_rate)).collect();
                for index in rapid.unwrap_or_default() {
                    match points.get_mut(index as usize) {
                        Some(point) => point.reached = Reached::Rapid,
                        None => {
                            let detail = format_args!("there is no point {index}");
                            return Err(faults.add(&path.member(RAPID.name), RequestFault::OutOfRange, detail));
                        }
                    }
                }
                if let Some(first) = points.first_mut() {
                    first.reached = Reached::FromUnknown;
                }
                Ok(Program { dialect: Dialect::Columns, points })
            }
            (Some(_), Some(_)) => Err(faults.add(path, RequestFault::ConflictingFields, "give program or tip_mm")),
            (None, None) => Err(faults.add(path, RequestFault::MissingField, "give program or tip_mm")),
        }
    }
}

fn stated_point(point: [f64; 3], line: u32, feed_rate: Option<Speed>) -> ProgramPoint {
    ProgramPoint { point, reached: Reached::Feed, feed_rate: feed_rate.map(Speed::mm_min), line, tool: 0, spindle_speed: None }
}

/// The text of a program. Its arcs become chords later, when the tolerance is known; what is wrong with it is found here.
struct ProgramText;

impl Kind for ProgramText {
    type Value = Program;

    fn read(&self, raw: JsonText<'_>, path: JsonPath<'_>, faults: &mut Faults) -> Result<Program, Faulted> {
        let program = text(raw, path, faults)?;
        read(&program, &ReadSettings { sagitta: SAGITTA, most_points: MOST_POINTS }).map_err(|found| {
            for fault in found {
                faults.add(&path, RequestFault::FaultyProgram, fault);
            }
            Faulted
        })
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about)).min_length(Some(1));
        schema.examples(["G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F3000\nX40"]).into()
    }
}

/// The distance in mm between an arc and its chords: a fiftieth of the smallest usual tolerance, 5 um.
const SAGITTA: f64 = 1e-4;

answer! {
    /// What a path leaves on a surface.
    pub(crate) struct PathCheckAnswer {
        /// The number of moves, arcs in chords.
        moves: usize,
        /// The length of the moves at the feed rate.
        cutting_length_mm: f64 [minimum = 0],
        /// The length of the rapid moves.
        rapid_length_mm: f64 [minimum = 0],
        /// The time of all moves on the machine.
        machining_time_s: f64 [minimum = 0],
        /// The material left over the selected area that is seen from above, along its normal; negative where the part is
        /// cut. Absent if the path comes over no place.
        residual_mm?: ResidualAnswer,
        /// The share of the area left over 1.02 times the tolerance, uncut area included.
        over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area left over the tolerance that the cutter could reach.
        reachable_over_tolerance_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area over which no move at the feed rate comes.
        uncut_share: f64 [minimum = 0, maximum = 1],
        /// The share of the area with ridges of at least half the tolerance.
        used_share: f64 [minimum = 0, maximum = 1],
        /// Cuts into the part.
        gouge: GougeAnswer,
        /// The standard errors of the shares.
        standard_error: StandardErrors,
        /// The worst places of each kind, at most a hundred, no two of a kind closer than the cutter's radius.
        places: Vec<PlaceAnswer> [max_items = 100],
        /// Facts that need attention.
        warnings: Vec<Warning>,
    }

    /// Percentiles over the area of what is left.
    struct ResidualAnswer of (residual: Residual) {
        /// The median.
        p50: f64 = residual.p50,
        /// 90 % of the area have less.
        p90: f64 = residual.p90,
        /// 99 % of the area have less.
        p99: f64 = residual.p99,
        /// The most that was found.
        max: f64 = residual.max,
    }

    /// Cuts into the part.
    struct GougeAnswer of (finish: &Finish) {
        /// The share of the area cut by more than 2 um and a fifth of the tolerance.
        share: f64 [minimum = 0, maximum = 1] = finish.gouge_share.value,
        /// The deepest cut of moves at the feed rate.
        depth_mm: f64 [minimum = 0] = finish.gouge.map_or(0.0, |spot| -spot.left.height),
        /// The deepest cut of rapid moves.
        rapid_depth_mm: f64 [minimum = 0] = finish.collision.map_or(0.0, |spot| -spot.left.height),
    }

    /// The standard errors of the shares, which are measured at random places.
    struct StandardErrors of (finish: &Finish) {
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
    struct PlaceAnswer {
        /// What is wrong.
        code: PlaceCode,
        /// The place on the surface.
        point_mm: [f64; 3] [min_items = 3, max_items = 3],
        /// What is left there, negative in a cut; absent where it is uncut.
        value_mm?: f64,
        /// The index of the move that decides, from 0; absent where the place is uncut.
        r#move?: usize,
        /// The line of the program that states the move, from 1; absent for points.
        line?: u32,
    }
}

/// What is wrong at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "kebab-case")]
#[schema(as = PathPlaceCode)]
enum PlaceCode {
    /// A rapid move cuts the part.
    Collision,
    /// A move at the feed rate cuts the part.
    Gouge,
    /// More than the tolerance is left where the cutter can reach.
    OverTolerance,
    /// No move comes over a place that the cutter can reach.
    Uncut,
}

described!(PathCheckRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    ObjectSchema::new("A surface, a path and its cutter", components).required(&SURFACE).with::<PathCheckMembers>().build()
}

/// What a path leaves
///
/// Mills the path on the surface by the cutter's solid, without a formula of a scallop's height: what is left over the
/// area, where it cuts into the part, what it misses, and how long it takes.
#[utoipa::path(
    post, path = "/v1/path-check", tag = "planning", operation_id = "path_check",
    request_body = PathCheckRequest,
    responses((status = 200, description = "What the path leaves, with the worst places", body = PathCheckAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    const LONGEST_WAIT: Duration = Work::LONGEST_WAIT_OF_PLAN;
    let size = body.json().len();
    let points = (size / SHORTEST_BLOCK).min(MOST_POINTS);
    let bytes = bytes_to_read(body.json()) + (points * BYTES_OF_A_POINT + BYTES_OF_PLACES + BYTES_OF_OBSTACLES * size) as u64;
    let threads = work.threads();
    let check = move |memory: Reservation, cancelled: &CancelFlag| {
        let check = body.read_until(cancelled, |object, faults| Check::read(object, faults, cancelled))?;
        drop(body);
        let answer = on_threads(threads, || check.answer(&|| cancelled.is_cancelled()))?;
        WrittenJson::until(cancelled, &answer)?.holding(memory)
    };
    work.run_with_memory(work.budget().open(), bytes, LONGEST_WAIT, check).await?
}

/// A path to check.
struct Check {
    mesh: Mesh,
    facets: Vec<u32>,
    cutter: crate::milling::Cutter,
    tolerance: Length,
    machine: motion::Machine,
    path_tolerance: Option<Length>,
    program: Program,
    is_program: bool,
    warnings: Vec<Warning>,
}

impl Check {
    fn read(object: &mut Object<'_, '_>, faults: &mut Faults, cancelled: &CancelFlag) -> Result<Self, Faulted> {
        let stop = || cancelled.is_cancelled();
        let members = PathCheckMembers::read(object, faults);
        let surface = object.required(&SURFACE, faults);
        let root = object.path();
        let at = root.member(SURFACE.name);
        let PathCheckMembers { path, cutter, scallop_height, machine, max_slope, unit, facing, select } = members;
        let (surface, unit, facing) = (surface?, unit?, facing?.unwrap_or_default());
        let (selection, max_slope) =
            (select?.unwrap_or_else(Selection::all), max_slope?.unwrap_or(Angle::from_radians(DEFAULT_MAX_SLOPE.to_radians())));
        let unit = surface.unit_of(unit, &at, faults)?;
        let shape = surface.surface.sampled.shape(unit, facing);
        let warnings = shape.map_or_else(|_| Vec::new(), |shape| surface.warnings(&shape));
        let SurfaceWithSource { surface: ReceivedSurface { mesh, .. }, .. } = surface;
        let mut mesh = mesh.finish_until(unit, facing, &stop).map_err(|error| report(NoMachinedSurface::Mesh(error), &at, faults))?;
        let pieces = mesh.pieces_until(&stop);
        mesh.turn_solids_outwards(&pieces);
        let selected = mesh.selected(&selection, &pieces);
        let selected = selected.map_err(|error| report(NoMachinedSurface::Selection(error), &at, faults))?;
        let visibility = mesh.visibility_until(max_slope, &stop);
        let classes = visibility.classes().iter().zip(&selected).zip(0..);
        let facets: Vec<u32> =
            classes.filter(|((class, selected), _)| **selected && **class == FacetClass::Machined).map(|(_, facet)| facet).collect();
        if facets.is_empty() {
            return Err(report(NoMachinedSurface::NothingToMachine, &at, faults));
        }
        let (program, (machine, path_tolerance)) = (path?, machine?);
        let is_program = program.points.iter().any(|point| point.tool > 0) || program.dialect != Dialect::Columns;
        let (cutter, tolerance) = (cutter?.cutter, scallop_height?);
        Ok(Self { mesh, facets, cutter, tolerance, machine, path_tolerance, program, is_program, warnings })
    }

    /// The answer; once `stop` returns true it must be discarded.
    fn answer(self, stop: &(dyn Fn() -> bool + Sync)) -> Option<PathCheckAnswer> {
        let (moves, points) = self.program.moves();
        let (profile, tolerance) = (self.cutter.profile(), self.tolerance.mm());
        let feed_of = |point: &usize| {
            let stated = self.program.points[*point].feed_rate.and_then(|feed| Speed::from_mm_min(feed).ok());
            let most = self.machine.limits.feed_rate;
            stated.map_or(most, |stated| if stated < most { stated } else { most })
        };
        let feeds: Vec<Speed> = points.iter().map(feed_of).collect();
        let lengths = PathLengths::new(&moves, &feeds, &self.machine, self.path_tolerance);
        let milled = Milled::new(&profile, &moves, stop)?;
        let places = Places::draw(&self.mesh, &self.facets, PLACES, 1);
        let obstacles = Obstacles::new(&self.mesh);
        let reach = Reach::new(&profile, &obstacles, &places, tolerance);
        let finish = Finish::new(&milled, &self.mesh, &places, &reach, tolerance, stop)?;
        let place = |finding: Finding| {
            let by = finding.left.map(|left| left.by as usize);
            PlaceAnswer {
                code: finding.kind.into(),
                point_mm: finding.place.point,
                value_mm: finding.left.map(|left| left.height),
                r#move: by,
                line: by.filter(|_| self.is_program).map(|by| self.program.points[points[by]].line),
            }
        };
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
            places: findings(&finish, &places, tolerance, profile.outer_radius()).into_iter().map(place).collect(),
            warnings: self.warnings,
        })
    }
}

impl From<FindingKind> for PlaceCode {
    fn from(kind: FindingKind) -> Self {
        match kind {
            FindingKind::Collision => Self::Collision,
            FindingKind::Gouge => Self::Gouge,
            FindingKind::OverTolerance => Self::OverTolerance,
            FindingKind::Uncut => Self::Uncut,
        }
    }
}
