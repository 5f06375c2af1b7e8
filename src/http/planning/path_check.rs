//! `POST /v1/path-check` and `/v1/path-check/upload`: what a path leaves on a surface, whoever made it.

use super::checked_path::{PathCheckAnswer, PathCheckMembers, PathToCheck};
use super::parameters::AVOID;
use super::path_object::{MOST_POINTS, PATH, StatedPath, read_path_file};
use super::recommendation::{BYTES_OF_JSON, likely_facets};
use super::upload::{ABOUT_AVOID, binary, read_file, read_small};
use crate::budget::{Job, LONGEST_WAIT_OF_PLAN};
use crate::cancellation::CancelFlag;
use crate::http::app_state::AppState;
use crate::http::codes::{FileFaultCode, RequestFault};
use crate::http::document::described;
use crate::http::json_body::{JsonBody, WrittenJson, read_text};
use crate::http::multipart::MultipartForm;
use crate::http::overload::Overload;
use crate::http::problem::Problem;
use crate::http::problem_schemas::{Problems, UploadProblems};
use crate::http::reading::{Components, Faulted, Faults, JsonPath, ObjectSchema};
use crate::http::wire::SURFACE;
use crate::http::work::Work;
use crate::path::program::ProgramPoint;
use axum::extract::State;
use utoipa::openapi::{RefOr, Schema};

/// The largest program in a form.
pub(in crate::http) const LARGEST_PROGRAM: usize = 32 << 20;

const PARAMETERS: &str = "parameters";

/// The largest part with parameters.
const LARGEST_PARAMETERS: usize = 1 << 18;

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
    let json = body.json();
    let points = (json.len() / BYTES_OF_JSON).min(MOST_POINTS);
    let job = Job::PathCheck { json: json.len(), facets: likely_facets(json), points, threads: work.threads() };
    work.answer(job, move |cancelled| {
        let check = body.read_until(cancelled, |object, faults| {
            let surface = object.required(&SURFACE, faults);
            let path = object.required(&PATH, faults);
            PathToCheck::read(object, surface, path, None, faults, cancelled)
        })?;
        drop(body);
        written(check, cancelled)
    })
    .await
}

described!(PathCheckUpload, describe_upload);

fn describe_upload(components: &mut Components) -> RefOr<Schema> {
    let surface = binary("the surface file, in any format of a recommendation's upload");
    let path = binary(
        "the program: G-code, Heidenhain's Klartext, APT or cutter location statements, columns x, y, z and feed rate in mm/min, or the passes of an answer as JSON",
    );
    let parameters = components.refer("PathCheckParameters", "", |components| {
        ObjectSchema::new("The cutter, the tolerance and the machine", components).with::<PathCheckMembers>().build()
    });
    let form = ObjectSchema::new("A surface file, a program and the parameters, in any order", components);
    let form = form.required_property(SURFACE.name, surface).property(AVOID.name, binary(ABOUT_AVOID));
    form.required_property(PATH.name, path).required_property(PARAMETERS, parameters).build()
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
    mut form: MultipartForm,
) -> Result<WrittenJson, Problem> {
    let input = Job::Upload { bytes: form.stated_length().unwrap_or(u64::MAX) };
    let mut held = work.budget().take(input, LONGEST_WAIT_OF_PLAN).await?;
    let (mut surface, mut avoid, mut path, mut parameters) = (None, None, None, None);
    let mut faults = Faults::default();
    while let Some(head) = form.next().await? {
        match head.name.as_deref() {
            Some(name) if name == SURFACE.name && surface.is_none() => surface = Some(read_file(&mut form, &head, &work, &metrics).await?),
            Some(name) if name == AVOID.name && avoid.is_none() => avoid = Some(read_file(&mut form, &head, &work, &metrics).await?),
            Some(name) if name == PATH.name && path.is_none() => {
                let text = read_small(&mut form, PATH.name, LARGEST_PROGRAM).await?;
                let (read, found) = read_path(text, &work).await?;
                // Arcs become chords: a short program may have many points.
                held.grow_input(points_of(&read) as u64 * size_of::<ProgramPoint>() as u64)?;
                faults.take_in(found, |pointer| Some(pointer.to_owned()));
                path = Some(read);
            }
            Some(PARAMETERS) if parameters.is_none() => {
                parameters = Some(read_small(&mut form, PARAMETERS, LARGEST_PARAMETERS).await?);
            }
            name => {
                let path = JsonPath::Root;
                let path = name.map_or(path, |name| JsonPath::Root.member(name));
                let detail = "the part is unknown or given more than once; known here: surface, avoid, path, parameters";
                faults.add(&path, RequestFault::UnknownField, detail);
            }
        }
    }
    let files = [&surface, &avoid].into_iter().flatten().filter_map(|read| read.as_ref().ok());
    let facets = files.map(|sourced| sourced.surface.mesh.size().facets).sum();
    let points = path.as_ref().map_or(0, points_of);
    let job = Job::PathCheck { json: 0, facets, points, threads: work.threads() };
    work.answer(job, move |cancelled| {
        let missing =
            |name: &str, faults: &mut Faults| faults.add(&JsonPath::Root.member(name), RequestFault::MissingField, "the part is missing");
        let surface = match surface {
            Some(Ok(surface)) => Ok(surface),
            Some(Err(fault)) => Err(faults.add(&JsonPath::Root.member(SURFACE.name), FileFaultCode::from(fault.kind()), fault)),
            None => Err(missing(SURFACE.name, &mut faults)),
        };
        let path = path.unwrap_or_else(|| Err(missing(PATH.name, &mut faults)));
        let Some(parameters) = parameters else {
            missing(PARAMETERS, &mut faults);
            return Err(Problem::faulty_request(faults));
        };
        let check = read_text(&parameters, cancelled, |object, found| {
            found.take_in(faults, |pointer| Some(pointer.to_owned()));
            PathToCheck::read(object, surface, path, avoid, found, cancelled)
        })?;
        drop(held);
        written(check, cancelled)
    })
    .await
}

/// The path in a part of a form, and its faults.
async fn read_path(text: Vec<u8>, work: &Work) -> Result<(Result<StatedPath, Faulted>, Faults), Overload> {
    work.run_reader(move || {
        let mut faults = Faults::default();
        let text = String::from_utf8(text).unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned());
        (read_path_file(text, &JsonPath::Root.member(PATH.name), &mut faults), faults)
    })
    .await
}

/// The number of points of a path; 0 if it could not be read.
fn points_of(path: &Result<StatedPath, Faulted>) -> usize {
    path.as_ref().map_or(0, |path| path.program.points.len())
}

/// Mills a path, and writes the answer.
fn written(check: PathToCheck, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
    WrittenJson::until(cancelled, &check.answer(&|| cancelled.is_cancelled()))
}
