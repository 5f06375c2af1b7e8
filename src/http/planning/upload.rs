//! `POST /v1/cutter-recommendation/upload`: a form with the surface file, the parameters and tool libraries. The
//! surface is read as it arrives; of the file, only data that its format requires are stored.

use super::answer::RecommendationAnswer;
use super::library::{LARGEST_LIBRARY, LIBRARY, Libraries};
use super::parameters::{AVOID, ParameterMembers, Parameters};
use super::plan_task::Task;
use super::recommendation::answer_to;
use crate::budget::{Held, Job, LONGEST_WAIT_OF_PLAN};
use crate::cancellation::{CancelFlag, CancelOnDrop};
use crate::file_fault::FileFault;
use crate::http::app_state::AppState;
use crate::http::codes::{FileFaultCode, RequestFault, ServiceProblem};
use crate::http::document::described;
use crate::http::json_body::{WrittenJson, read_text};
use crate::http::metrics::Metrics;
use crate::http::multipart::{Head, MultipartForm};
use crate::http::problem::Problem;
use crate::http::problem_schemas::UploadProblems;
use crate::http::reading::{Components, Fault, Faulted, Faults, JsonPath, ObjectSchema};
use crate::http::request_body::body_pipe;
use crate::http::wire::{MOST_CUTTERS, SURFACE, SurfaceWithSource};
use crate::http::work::Work;
use crate::surface::ReceivedSurface;
use crate::surface::read::{Format, FormatHint, ReadError, Reader};
use crate::tooling::ToolLibrary;
use axum::extract::State;
use utoipa::openapi::schema::{ArrayBuilder, KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};

const PARAMETERS: &str = "parameters";

/// The longest part with parameters. Parameters with 200 cutters take 40 kB.
const LARGEST_PARAMETERS: usize = 1 << 18;

/// The largest 3MF file, compressed, and the most vertices of its meshes: 24 bytes a vertex, and two triangles of 12
/// bytes for each.
const LARGEST_ARCHIVE: usize = 64 << 20;
const MOST_VERTICES_OF_A_PACKAGE: usize = 4_000_000;

/// The most vertices of an OBJ or PLY file, 24 bytes each.
const MOST_VERTICES: usize = 8_000_000;

described!(UploadRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let file = binary(
        "the file: points in text (CSV, TSV, XYZ) or PCD with its data in text, STL, OBJ, PLY or 3MF. The format is detected from the content; the part's media type and file name are used if the content is ambiguous. A text with columns other than x, y and z needs a header that names these",
    );
    let parameters = components.refer("RecommendationParameters", "", |components| {
        let about = "The cutters to choose from, unless they are in libraries, and the machine";
        ObjectSchema::new(about, components).with::<ParameterMembers>().build()
    });
    let library = binary(
        "a tool library: Fusion (.json or .tools), FreeCAD (.fctb, or a zip of them; if the zip has .fctl lists, only the tools named there are read) or CSV; its finishing cutters join cutters. A cutter with a fault is in not_ranked with the code faulty-tool",
    );
    let libraries = ArrayBuilder::new().items(library).description(Some("tool libraries, a part for each"));
    let form = ObjectSchema::new("A surface file, the parameters and tool libraries, in any order", components);
    form.required_property(SURFACE.name, file)
        .property(AVOID.name, binary(ABOUT_AVOID))
        .required_property(PARAMETERS, parameters)
        .property(LIBRARY, libraries)
        .build()
}

pub(super) const ABOUT_AVOID: &str = "a second surface file, in the same unit and position: never machined and never cut; the member avoid of the parameters is the same in JSON";

/// A part with a file.
pub(super) fn binary(about: &str) -> ObjectBuilder {
    let format = SchemaFormat::KnownFormat(KnownFormat::Binary);
    ObjectBuilder::new().schema_type(Type::String).format(Some(format)).description(Some(about))
}

/// The cutter for a surface in a file
///
/// The same as `/v1/cutter-recommendation`, for a file with points (CSV, TSV, XYZ, PCD) or facets (STL, OBJ, PLY, 3MF),
/// and for cutters from tool libraries.
#[utoipa::path(
    post, path = "/v1/cutter-recommendation/upload", tag = "planning", operation_id = "cutter_recommendation_upload",
    request_body(content = UploadRequest, content_type = "multipart/form-data", encoding(("parameters" = (content_type = "application/json")))),
    responses((status = 200, description = "The recommendation, with all candidates", body = RecommendationAnswer), UploadProblems),
)]
pub(crate) async fn answer(
    work: Work,
    State(AppState { metrics, .. }): State<AppState>,
    mut form: MultipartForm,
) -> Result<WrittenJson, Problem> {
    let input = Job::Upload { bytes: form.stated_length().unwrap_or(u64::MAX) };
    let held = work.budget().take(input, LONGEST_WAIT_OF_PLAN).await?;
    let mut received = Received::read(&mut form, &work, &metrics).await?;
    received.held = Some(held);
    let job = received.job(work.threads());
    work.answer(job, move |cancelled| received.answer(cancelled)).await
}

/// The contents of the form.
#[derive(Debug, Default)]
struct Received {
    parameters: Option<Vec<u8>>,
    surface: Option<Result<SurfaceWithSource, FileFault>>,
    /// The surface that is not cut.
    avoid: Option<Result<SurfaceWithSource, FileFault>>,
    libraries: Libraries,
    /// Faults of the form itself.
    faults: Vec<Fault>,
    /// The memory of the form, until the surface is prepared for the plan.
    held: Option<Held>,
}

impl Received {
    /// Reads the whole form, so that the answer lists the faults of all parts.
    async fn read(form: &mut MultipartForm, work: &Work, metrics: &Metrics) -> Result<Self, Problem> {
        let mut received = Self::default();
        while let Some(head) = form.next().await? {
            match head.name.as_deref() {
                Some(name) if name == SURFACE.name && received.surface.is_none() => {
                    received.surface = Some(read_file(form, &head, work, metrics).await?);
                }
                Some(name) if name == AVOID.name && received.avoid.is_none() => {
                    received.avoid = Some(read_file(form, &head, work, metrics).await?);
                }
                Some(PARAMETERS) if received.parameters.is_none() => {
                    received.parameters = Some(read_small(form, PARAMETERS, LARGEST_PARAMETERS).await?);
                }
                Some(LIBRARY) => received.read_library(form, head.file_name, work).await?,
                name => received.refuse_part(name),
            }
        }
        Ok(received)
    }

    async fn read_library(&mut self, form: &mut MultipartForm, file_name: Option<String>, work: &Work) -> Result<(), Problem> {
        let bytes = read_small(form, LIBRARY, LARGEST_LIBRARY).await?;
        let library = work.run_piece(move |cancel| ToolLibrary::read_until(&bytes, file_name.as_deref(), cancel)).await;
        self.libraries.push(library);
        Ok(())
    }

    /// The plan on the surface. Cutters in parameters take more than 24 bytes each; libraries may have the most.
    fn job(&self, threads: usize) -> Job {
        let files = [&self.surface, &self.avoid].into_iter().flatten().filter_map(|read| read.as_ref().ok());
        let facets = files.map(|sourced| sourced.surface.mesh.size().facets).sum();
        let stated = self.parameters.as_ref().map_or(0, |parameters| parameters.len() / 24);
        let cutters = if self.libraries.is_empty() { stated.min(MOST_CUTTERS) } else { MOST_CUTTERS };
        Job::Plan { json: 0, facets, cutters, threads }
    }

    fn refuse_part(&mut self, name: Option<&str>) {
        let root = JsonPath::Root;
        let fault = match name {
            Some(name) if [SURFACE.name, AVOID.name, PARAMETERS].contains(&name) => {
                Fault::new(&root.member(name), RequestFault::RepeatedField, "the part is given more than once")
            }
            Some(name) => {
                Fault::new(&root.member(name), RequestFault::UnknownField, "unknown part; known here: surface, avoid, parameters, library")
            }
            None => Fault::new(&root, RequestFault::UnknownField, "a part has no name; known here: surface, avoid, parameters, library"),
        };
        self.faults.push(fault);
    }

    fn answer(mut self, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
        let Some(parameters) = self.parameters.take() else {
            let mut faults = Faults::default();
            let _ = (self.surface(&mut faults), given_once(self.avoid.take(), None, &mut faults), self.libraries.check(&mut faults));
            let path = JsonPath::Root.member(PARAMETERS);
            faults.add(&path, RequestFault::MissingField, "the part is missing: the cutters and the machine, as JSON");
            return Err(Problem::faulty_request(faults));
        };
        let task = read_text(&parameters, cancelled, |object, faults| {
            let libraries = std::mem::take(&mut self.libraries);
            let warnings: Vec<_> = libraries.warnings().collect();
            let mut parameters = Parameters::read(object, libraries, faults);
            let surface = self.surface(faults);
            let member = parameters.as_mut().ok().and_then(|parameters| parameters.avoid.take());
            let avoid = given_once(self.avoid.take(), member, faults);
            let mut parameters = parameters?;
            parameters.avoid = avoid?;
            let mut task = Task::new(parameters, surface?, &JsonPath::Root.member(SURFACE.name), faults, &|| cancelled.is_cancelled())?;
            task.warnings.extend(warnings);
            Ok(task)
        })?;
        drop(self.held.take());
        answer_to(task, cancelled)
    }

    /// The surface, with the faults of the form and the file recorded.
    fn surface(&mut self, faults: &mut Faults) -> Result<SurfaceWithSource, Faulted> {
        for fault in std::mem::take(&mut self.faults) {
            faults.push(fault);
        }
        let path = JsonPath::Root.member(SURFACE.name);
        match self.surface.take() {
            Some(Ok(surface)) => Ok(surface),
            Some(Err(fault)) => Err(faults.add(&path, FileFaultCode::from(fault.kind()), fault)),
            None => Err(faults.add(&path, RequestFault::MissingField, "the part is missing: the file with the surface")),
        }
    }
}

/// The surface to avoid of a part of the form or of the parameters; that both have one is a fault.
pub(super) fn given_once(
    part: Option<Result<SurfaceWithSource, FileFault>>,
    member: Option<SurfaceWithSource>,
    faults: &mut Faults,
) -> Result<Option<SurfaceWithSource>, Faulted> {
    let path = JsonPath::Root.member(AVOID.name);
    if part.is_some() && member.is_some() {
        return Err(faults.add(&path, RequestFault::ConflictingFields, "avoid is given both as a part and in the parameters"));
    }
    let part = part.transpose().map_err(|fault| faults.add(&path, FileFaultCode::from(fault.kind()), fault))?;
    Ok(part.or(member))
}

/// Reads a part with a surface file on a thread of its own, to which the chunks of the body are passed as they
/// arrive. The outer error is the form's, the inner one the file's.
pub(super) async fn read_file(
    form: &mut MultipartForm,
    head: &Head,
    work: &Work,
    metrics: &Metrics,
) -> Result<Result<SurfaceWithSource, FileFault>, Problem> {
    let hint = FormatHint::new(head.media_type.as_deref(), head.file_name.as_deref());
    let reader = Reader::new(hint).with_vertex_limit(MOST_VERTICES).with_package_vertex_limit(MOST_VERTICES_OF_A_PACKAGE);
    let reader = reader.with_archive_limit(LARGEST_ARCHIVE);
    let cancel = CancelOnDrop::default();
    let mut surface = ReceivedSurface::until(&cancel);
    let (pipe, body) = body_pipe();
    let reading = work.run_reader(move || reader.read(body, &mut surface).map(|summary| (surface, summary)));
    let sending = async move {
        while let Some(chunk) = form.chunk().await? {
            metrics.upload_bytes(chunk.len() as u64);
            if !pipe.send(chunk).await {
                break;
            }
        }
        pipe.end().await;
        // If the body fails, the pipe is dropped here, and the reader ends.
        Ok::<_, Problem>(pipe)
    };
    let (read, sent) = tokio::join!(reading, sending);
    drop(sent?);
    match read? {
        Ok((surface, summary)) => {
            metrics.upload_facets(format_label(summary.format), if summary.facets > 0 { summary.facets } else { summary.points });
            Ok(Ok(SurfaceWithSource::of_file(surface, summary)))
        }
        Err(ReadError::Fault(fault)) => Ok(Err(fault)),
        Err(ReadError::Source(error)) => Err(Problem::new(ServiceProblem::UnreadableBody, error.to_string())),
    }
}

/// The label of a format in the metrics.
fn format_label(format: Format) -> &'static str {
    match format {
        Format::Text => "text",
        Format::Pcd => "pcd",
        Format::StlAscii | Format::StlBinary => "stl",
        Format::Obj => "obj",
        Format::PlyAscii | Format::PlyLittleEndian | Format::PlyBigEndian => "ply",
        Format::ThreeMf => "3mf",
    }
}

/// Reads a part of up to `largest` bytes into memory.
pub(super) async fn read_small(form: &mut MultipartForm, name: &str, largest: usize) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    while let Some(chunk) = form.chunk().await? {
        if bytes.len() + chunk.len() > largest {
            return Err(Problem::new(ServiceProblem::TooLarge, format!("the part {name} is larger than {largest} bytes")));
        }
        bytes.extend(chunk);
    }
    Ok(bytes)
}
