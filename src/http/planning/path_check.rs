//! `POST /v1/path-check` and `/v1/path-check/upload`: what a path leaves on a surface, whoever made it.

use super::parameters::{DEFAULT_MAX_SLOPE, FACING, MAX_SLOPE, SELECT};
use super::simulation::report;
use super::upload::{read_file, read_small};
use crate::budget::{Job, LONGEST_WAIT_OF_PLAN};
use crate::cancellation::CancelFlag;
use crate::http::app_state::AppState;
use crate::http::codes::{FileFault, RequestFault};
use crate::http::document::described;
use crate::http::json_body::{JsonBody, WrittenJson, read_text};
use crate::http::multipart::Form;
use crate::http::problem::{Problem, Problems, UploadProblems};
use crate::http::reading::{
    Choice, Components, Faulted, Faults, JsonPath, Kind, List, Members, Object, ObjectSchema, Quantity, Whole, members, text,
};
use crate::http::wire::{AnyCutter, MACHINE, Machine, PathPoints, SURFACE, SelectKind, SurfaceWithSource, UNIT, Warning, answer};
use crate::http::worker_pool::Work;
use crate::milling::Cutter;
use crate::motion;
use crate::path::program::{Dialect, Program, ProgramPoint, Reached, ReadSettings, read};
use crate::path::{Finding, FindingKind, Finish, Milled, Obstacles, PathLengths, Places, Reach, Residual, findings};
use crate::planning::machined_surface::NoMachinedSurface;
use crate::quantity::{Angle, Length, Speed};
use crate::surface::mesh::FacetClass;
use crate::surface::{Facing, Mesh, ReceivedSurface, Unit};
use axum::extract::State;
use serde::Serialize;
use serde_json::value::RawValue;
use std::collections::BTreeSet;
use utoipa::ToSchema;
use utoipa::openapi::schema::{ArrayBuilder, KnownFormat, ObjectBuilder, OneOfBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};

/// The most points of a path, arcs in chords.
const MOST_POINTS: usize = 1_000_000;

/// The places on the surface at which the path is looked at: a share of 1 % has a standard error of 0.05 %.
const PLACES: usize = 40_000;

/// The length in bytes of the shortest block of a program that states a point.
const SHORTEST_BLOCK: usize = 3;

/// The largest program in a form.
const LARGEST_PROGRAM: usize = 32 << 20;

const PARAMETERS: &str = "parameters";

/// The largest part with parameters.
const LARGEST_PARAMETERS: usize = 1 << 18;

/// The distance in mm between an arc and its chords: a fiftieth of the smallest usual tolerance, 5 um.
const SAGITTA: f64 = 1e-4;

/// The place of the cutter that a path states.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum TipPoint {
    #[default]
    LowestPoint,
    Centre,
}

members! {
    /// The members beside the surface and the path.
    struct PathCheckMembers {
        cutter: required PATH_CUTTER: AnyCutter = ("cutter", AnyCutter, "the cutter that runs the path"),
        tip: optional TIP_POINT: Choice<TipPoint> = ("tip", Choice { name: Some("TipPoint"),
            words: &[("lowest_point", TipPoint::LowestPoint), ("centre", TipPoint::Centre)] },
            "the place of the cutter that the path states: its lowest point (default), or the centre of the ball or of the corner, on the axis"),
        scallop_height: required TOLERANCE: Quantity<Length> = ("scallop_height_mm", Quantity::length(0.01),
            "the tolerance: the height that may be left"),
        machine: required MACHINE: Machine,
        max_slope: optional MAX_SLOPE: Quantity<Angle>,
        unit: optional UNIT: Choice<Unit>,
        facing: optional FACING: Choice<Facing>,
        select: optional SELECT: SelectKind,
    }
}

const PATH: crate::http::reading::Member<PathKind> =
    crate::http::reading::Member::new("path", "the path of the cutter: a program, or points", PathKind);

members! {
    /// A path: a program, or points.
    struct PathMembers for PathKind ("Path", "A path of the tip: `program`, or `tip_mm` with its rapids and its feed rate") -> Program {
        program: optional PROGRAM: ProgramText = ("program", ProgramText, "the text of a program in G-code, of APT statements, or of columns x, y, z and feed rate"),
        tip: optional TIP: PathPoints = ("tip_mm", PathPoints, "the tip's points [x, y, z] in their order"),
        rapid: optional RAPID: List<Whole> = ("rapid", List { item: Whole { minimum: 1, maximum: 1_000_000, example: 2 },
            about_item: "the index of a point, from 0", fewest: 0, most: MOST_POINTS }, "the points that are reached by a rapid move"),
        feed_rates: optional FEED_RATES: FeedRates = ("feed_rate_mm_min", FeedRates,
            "the feed rate of all moves, or one of the move to each point; absent = the machine's"),
    }
}

impl PathMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Program, Faulted> {
        let (program, tip, rapid, feed_rates) = (self.program?, self.tip?, self.rapid?, self.feed_rates?);
        match (program, tip) {
            (Some(_), _) if rapid.is_some() || feed_rates.is_some() => Err(faults.add(
                path,
                RequestFault::ConflictingFields,
                "rapid and feed_rate_mm_min belong to tip_mm; a program states its own",
            )),
            (Some(program), None) => Ok(program),
            (None, Some(tip)) => {
                let rates = feed_rates.unwrap_or_default();
                if rates.len() > 1 && rates.len() != tip.len() {
                    let detail = format_args!("there are {} points and {} feed rates", tip.len(), rates.len());
                    return Err(faults.add(&path.member(FEED_RATES.name), RequestFault::WrongCount, detail));
                }
                if tip.len() > MOST_POINTS {
                    let detail = format_args!("at most {MOST_POINTS} points, there are {}", tip.len());
                    return Err(faults.add(&path.member(TIP.name), RequestFault::TooManyItems, detail));
                }
                let rate = |index: usize| rates.get(index).or(rates.first()).copied();
                let stated = tip.into_iter().enumerate().map(|(index, point)| stated_point(point, rate(index)));
                let mut points: Vec<ProgramPoint> = stated.collect();
                for index in rapid.unwrap_or_default() {
                    let Some(point) = points.get_mut(index as usize) else {
                        let detail = format_args!("there is no point {index}");
                        return Err(faults.add(&path.member(RAPID.name), RequestFault::OutOfRange, detail));
                    };
                    point.reached = Reached::Rapid;
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

fn stated_point(point: [f64; 3], feed_rate: Option<Speed>) -> ProgramPoint {
    ProgramPoint { point, reached: Reached::Feed, feed_rate: feed_rate.map(Speed::mm_min), line: 0, tool: 0, spindle_speed: None }
}

/// The text of a program. Its arcs become chords later, when the tolerance is known; what is wrong with it is found here.
struct ProgramText;

impl Kind for ProgramText {
    type Value = Program;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Program, Faulted> {
        let program = text(raw, path, faults)?;
        read_program(&program, &path, faults)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about)).min_length(Some(1));
        schema.examples(["G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F3000\nX40"]).into()
    }
}

/// A program, with its faults recorded at `path`.
fn read_program(text: &str, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Program, Faulted> {
    let program = read(text, &ReadSettings { sagitta: SAGITTA, most_points: MOST_POINTS }).map_err(|found| {
        let mut faulted = Faulted;
        for fault in found {
            faulted = faults.add(path, RequestFault::FaultyProgram, fault);
        }
        faulted
    })?;
    let tools: BTreeSet<u32> = program.points.iter().filter(|point| point.reached == Reached::Feed).map(|point| point.tool).collect();
    if tools.len() > 1 {
        let detail = format_args!("the program cuts with {} tools; send the part of one tool at a time", tools.len());
        return Err(faults.add(path, RequestFault::FaultyProgram, detail));
    }
    Ok(program)
}

/// One feed rate, or an array of them.
struct FeedRates;

impl Kind for FeedRates {
    type Value = Vec<Speed>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Vec<Speed>, Faulted> {
        const ONE: Quantity<Speed> = Quantity::new(Speed::from_mm_min, 3000.0);
        if raw.get().starts_with('[') {
            return List { item: ONE, about_item: "a feed rate", fewest: 1, most: MOST_POINTS }.read(raw, path, faults);
        }
        ONE.read(raw, path, faults).map(|rate| vec![rate])
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let one = || Quantity::new(Speed::from_mm_min, 3000.0);
        let each = one().schema("", components);
        let several = ArrayBuilder::new().items(each.clone()).min_items(Some(1));
        OneOfBuilder::new().item(each).item(several).description(Some(about)).into()
    }
}

answer! {
    /// What a path leaves on a surface.
    pub(crate) struct PathCheckAnswer {
        /// The number of moves, arcs in chords.
        moves: usize,
        /// The length of the moves at the feed rate.
        cutting_length_mm: f64 [minimum = 0],
        /// The length of the rapid moves.
        rapid_length_mm: f64 [minimum = 0],
        /// The time of all moves, without stops at corners; the tool stops where moves at the feed rate and rapid moves meet.
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
    #[expect(clippy::struct_field_names, reason = "the wire names")]
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
    let schema = ObjectSchema::new("A surface, a path and its cutter", components).required(&SURFACE).required(&PATH);
    schema.with::<PathCheckMembers>().build()
}

/// What a path leaves
///
/// Mills the path on the surface by the cutter's solid, without a formula of a scallop's height: what is left over the
/// area, where it cuts into the part, what it misses, and how long it takes on a control that stops only where cutting and
/// rapid moves meet.
#[utoipa::path(
    post, path = "/v1/path-check", tag = "planning", operation_id = "path_check",
    request_body = PathCheckRequest,
    responses((status = 200, description = "What the path leaves, with the worst places", body = PathCheckAnswer), Problems),
)]
pub(crate) async fn answer(work: Work, body: JsonBody) -> Result<WrittenJson, Problem> {
    let bytes = body.json().len();
    let job =
        Job::PathCheck { json: bytes, facets: bytes / 20, points: (bytes / SHORTEST_BLOCK).min(MOST_POINTS), threads: work.threads() };
    work.answer(job, move |cancelled| {
        let check = body.read(|object, faults| {
            let surface = object.required(&SURFACE, faults);
            let path = object.required(&PATH, faults);
            Check::read(object, surface, path, faults, cancelled)
        })?;
        drop(body);
        written(check, cancelled)
    })
    .await
}

described!(PathCheckUpload, describe_upload);

fn describe_upload(components: &mut Components) -> RefOr<Schema> {
    let binary = || ObjectBuilder::new().schema_type(Type::String).format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary)));
    let surface = binary().description(Some("the surface file, in any format of a recommendation's upload"));
    let path =
        binary().description(Some("the program: G-code, APT or cutter location statements, or columns x, y, z and feed rate in mm/min"));
    let parameters = components.refer("PathCheckParameters", "", |components| {
        ObjectSchema::new("The cutter, the tolerance and the machine", components).with::<PathCheckMembers>().build()
    });
    let form = ObjectSchema::new("A surface file, a program and the parameters, in any order", components);
    form.required_property(SURFACE.name, surface).required_property(PATH.name, path).required_property(PARAMETERS, parameters).build()
}

/// What a program in a file leaves
///
/// The same as `/v1/path-check`, for a surface in a file and a program in another.
#[utoipa::path(
    post, path = "/v1/path-check/upload", tag = "planning", operation_id = "path_check_upload",
    request_body(content = PathCheckUpload, content_type = "multipart/form-data", encoding(("parameters" = (content_type = "application/json")))),
    responses((status = 200, description = "What the path leaves, with the worst places", body = PathCheckAnswer), UploadProblems),
)]
pub(crate) async fn answer_upload(
    work: Work,
    State(AppState { metrics, .. }): State<AppState>,
    mut form: Form,
) -> Result<WrittenJson, Problem> {
    let input = Job::Upload { bytes: form.stated_length().unwrap_or(u64::MAX) };
    let held = work.budget().take(input, LONGEST_WAIT_OF_PLAN).await?;
    let (mut surface, mut program, mut parameters) = (None, None, None);
    let mut faults = Faults::default();
    while let Some(head) = form.next().await? {
        match head.name.as_deref() {
            Some(name) if name == SURFACE.name && surface.is_none() => surface = Some(read_file(&mut form, &head, &work, &metrics).await?),
            Some(name) if name == PATH.name && program.is_none() => {
                program = Some(read_small(&mut form, PATH.name, LARGEST_PROGRAM).await?);
            }
            Some(PARAMETERS) if parameters.is_none() => {
                parameters = Some(read_small(&mut form, PARAMETERS, LARGEST_PARAMETERS).await?);
            }
            name => {
                let path = JsonPath::Root;
                let path = name.map_or(path, |name| JsonPath::Root.member(name));
                let detail = "the part is unknown or given more than once; known here: surface, path, parameters";
                faults.add(&path, RequestFault::UnknownField, detail);
            }
        }
    }
    let facets = surface.as_ref().and_then(|surface| surface.as_ref().ok()).map_or(0, |sourced| sourced.surface.mesh.size().facets);
    let points = (program.as_ref().map_or(0, Vec::len) / SHORTEST_BLOCK).min(MOST_POINTS);
    let job = Job::PathCheck { json: 0, facets, points, threads: work.threads() };
    work.answer(job, move |cancelled| {
        let missing =
            |name: &str, faults: &mut Faults| faults.add(&JsonPath::Root.member(name), RequestFault::MissingField, "the part is missing");
        let surface = match surface {
            Some(Ok(surface)) => Ok(surface),
            Some(Err(fault)) => Err(faults.add(&JsonPath::Root.member(SURFACE.name), FileFault::from(fault.kind()), fault)),
            None => Err(missing(SURFACE.name, &mut faults)),
        };
        let path = program.ok_or(()).map_err(|()| missing(PATH.name, &mut faults)).and_then(|bytes| {
            let text = String::from_utf8_lossy(&bytes);
            read_program(&text, &JsonPath::Root.member(PATH.name), &mut faults)
        });
        let Some(parameters) = parameters else {
            missing(PARAMETERS, &mut faults);
            return Err(Problem::faulty_request(faults));
        };
        let check = read_text(&parameters, |object, found| {
            found.take_in(faults, |pointer| Some(pointer.to_owned()));
            Check::read(object, surface, path, found, cancelled)
        })?;
        drop(held);
        written(check, cancelled)
    })
    .await
}

/// Mills a path, and writes the answer.
fn written(check: Check, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    WrittenJson::until(cancelled, &check.answer(&|| cancelled.is_cancelled()))
}

/// A path to check.
struct Check {
    mesh: Mesh,
    facets: Vec<u32>,
    cutter: Cutter,
    tolerance: Length,
    machine: motion::Machine,
    program: Program,
    warnings: Vec<Warning>,
}

impl Check {
    fn read(
        object: &mut Object<'_, '_>,
        surface: Result<SurfaceWithSource, Faulted>,
        path: Result<Program, Faulted>,
        faults: &mut Faults,
        cancelled: &CancelFlag,
    ) -> Result<Self, Faulted> {
        let stop = || cancelled.is_cancelled();
        let members = PathCheckMembers::read(object, faults);
        let root = object.path();
        let at = root.member(SURFACE.name);
        let PathCheckMembers { cutter, tip, scallop_height, machine, max_slope, unit, facing, select } = members;
        let (surface, facing) = (surface?, facing?.unwrap_or_default());
        let (selection, max_slope) =
            (select?.unwrap_or_default(), max_slope?.unwrap_or_else(|| Angle::from_radians(DEFAULT_MAX_SLOPE.to_radians())));
        let unit = surface.unit_of(unit?, faults)?;
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
        let (mut program, machine, cutter, tolerance) = (path?, machine?, cutter?.cutter, scallop_height?);
        if tip? == Some(TipPoint::Centre) {
            for point in &mut program.points {
                point.point[2] -= cutter.corner_radius().mm();
            }
        }
        Ok(Self { mesh, facets, cutter, tolerance, machine, program, warnings })
    }

    /// The answer; `None` once `stop` returns true.
    fn answer(self, stop: &(dyn Fn() -> bool + Sync)) -> Option<PathCheckAnswer> {
        let (moves, points) = self.program.moves();
        let (profile, tolerance) = (self.cutter.profile(), self.tolerance.mm());
        let feed_of = |point: &usize| {
            let stated = self.program.points[*point].feed_rate.and_then(|feed| Speed::from_mm_min(feed).ok());
            let most = self.machine.limits.feed_rate;
            stated.map_or(most, |stated| if stated < most { stated } else { most })
        };
        let feeds: Vec<Speed> = points.iter().map(feed_of).collect();
        let lengths = PathLengths::new(&moves, &feeds, &self.machine);
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
                line: by.map(|by| self.program.points[points[by]].line).filter(|line| *line > 0),
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
