//! `POST /v1/path-check` and `/v1/path-check/upload`: what a path leaves on a surface, whoever made it.

use super::parameters::{DEFAULT_MAX_SLOPE, FACING, MAX_SLOPE, SELECT};
use super::path_check_answer::{GougeAnswer, PathCheckAnswer, PlaceAnswer, ResidualAnswer, StandardErrors};
use super::path_object::{MOST_POINTS, PATH, read_program};
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
use crate::http::reading::{Choice, Components, Faulted, Faults, JsonPath, Members, Object, ObjectSchema, Quantity, members};
use crate::http::wire::{AnyCutter, MACHINE, Machine, SURFACE, SelectKind, SurfaceWithSource, UNIT, Warning};
use crate::http::worker_pool::Work;
use crate::milling::Cutter;
use crate::motion;
use crate::path::program::Program;
use crate::path::{Finding, Finish, Milled, Obstacles, PathLengths, Places, Reach, findings};
use crate::planning::machined_surface::NoMachinedSurface;
use crate::quantity::{Angle, Length, Speed};
use crate::surface::mesh::FacetClass;
use crate::surface::{Facing, Mesh, ReceivedSurface, Unit};
use axum::extract::State;
use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};

/// The places on the surface at which the path is looked at: a share of 1 % has a standard error of 0.05 %.
const PLACES: usize = 40_000;

/// The length in bytes of the shortest block of a program that states a point.
const SHORTEST_BLOCK: usize = 3;

/// The largest program in a form.
const LARGEST_PROGRAM: usize = 32 << 20;

const PARAMETERS: &str = "parameters";

/// The largest part with parameters.
const LARGEST_PARAMETERS: usize = 1 << 18;

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
