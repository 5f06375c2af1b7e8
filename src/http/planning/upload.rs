//! `POST /v1/cutter-recommendation/upload`: a form with the surface file, the parameters and tool libraries. The
//! surface is read as it arrives; of the file, only data that its format requires are stored.

use super::answer::RecommendationAnswer;
use super::library::{LARGEST_LIBRARY, LIBRARY, Libraries};
use super::memory::{Resources, bytes_of_machined_surface};
use super::parameters::{ParameterMembers, Parameters};
use super::plan::Task;
use super::recommendation::answer_to;
use crate::cancellation::{CancelFlag, CancelOnDrop};
use crate::http::app_state::AppState;
use crate::http::body::{WrittenJson, read_text};
use crate::http::codes::{FileFault, RequestFault, ServiceProblem};
use crate::http::document::described;
use crate::http::metrics::Metrics;
use crate::http::multipart::{Form, Head};
use crate::http::problem::{Problem, UploadProblems};
use crate::http::reading::{Components, Fault, Faulted, Faults, ObjectSchema};
use crate::http::wire::{MOST_CUTTERS, SURFACE, SurfaceWithSource};
use crate::http::worker_pool::Work;
use crate::json_text::JsonPath;
use crate::memory_budget::{BudgetExceeded, MemoryBudget, Reservation};
use crate::planning::memory::{COARSE_DIAMETERS, RankingSize};
use crate::surface::ReceivedSurface;
use crate::surface::read::{self, Format, FormatHint, Reader};
use crate::tooling::ToolLibrary;
use axum::body::Bytes;
use axum::extract::State;
use std::time::Duration;
use utoipa::openapi::schema::{ArrayBuilder, KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};

const PARAMETERS: &str = "parameters";

/// The longest part with parameters. Parameters with 200 cutters take 40 kB.
const LARGEST_PARAMETERS: usize = 1 << 18;

/// The most memory of a library's tools: ten thousand of some 300 bytes.
const MEMORY_OF_A_LIBRARY: u64 = 3 << 20;

/// The largest 3MF file, compressed, and the most vertices of its meshes.
const LARGEST_ARCHIVE: usize = 64 << 20;
const MOST_VERTICES_OF_A_PACKAGE: usize = 4_000_000;

/// The most memory of the meshes of a 3MF file: 24 bytes a vertex, and two triangles of 12 bytes for each.
const MEMORY_OF_A_PACKAGE: u64 = 48 * MOST_VERTICES_OF_A_PACKAGE as u64;

described!(UploadRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let binary = || ObjectBuilder::new().schema_type(Type::String).format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary)));
    let file = binary().description(Some(
        "the file: points in text (CSV, TSV, XYZ) or PCD with its data in text, STL, OBJ, PLY or 3MF. The format is detected from the content; the part's media type and file name are used if the content is ambiguous. A text with columns other than x, y and z needs a header that names these",
    ));
    let parameters = components.refer("RecommendationParameters", "", |components| {
        let about = "The cutters to choose from, unless they are in libraries, and the machine";
        ObjectSchema::new(about, components).with::<ParameterMembers>().build()
    });
    let library = binary().description(Some(
        "a tool library: Fusion (.json or .tools), FreeCAD (.fctb, or a zip of them; if the zip has .fctl lists, only the tools named there are read) or CSV; its ball-end, bull-nose and flat cutters join cutters. A cutter with a fault is in not_ranked with the code faulty-tool",
    ));
    let libraries = ArrayBuilder::new().items(library).description(Some("tool libraries, a part for each"));
    let form = ObjectSchema::new("A surface file, the parameters and tool libraries, in any order", components);
    form.required_property(SURFACE.name, file).required_property(PARAMETERS, parameters).property(LIBRARY, libraries).build()
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
pub(crate) async fn answer(work: Work, State(AppState { metrics, .. }): State<AppState>, mut form: Form) -> Result<WrittenJson, Problem> {
    let received = Received::read(&mut form, &work, &metrics).await?;
    let resources = Resources::none(&work, Work::LONGEST_WAIT_OF_PLAN);
    let bytes = received.bytes_to_answer(&resources);
    let budget = work.budget().clone();
    let answer = move |memory, cancelled: &CancelFlag| received.answer(resources.with(memory), &budget, cancelled);
    work.run_with_memory(work.budget().open(), bytes, Work::LONGEST_WAIT_OF_PLAN, answer).await?
}

/// The contents of the form.
#[derive(Debug, Default)]
struct Received {
    parameters: Option<Vec<u8>>,
    surface: Option<Result<SurfaceWithSource, read::Fault>>,
    libraries: Libraries,
    /// Faults of the form itself.
    faults: Vec<Fault>,
    /// The reserved memory of the surface as it was read, until it is prepared for the plan.
    surface_memory: Option<Reservation>,
    /// The reserved memory of the libraries, until the answer is ready.
    library_memory: Vec<Reservation>,
}

impl Received {
    /// Reads the whole form, so that the answer lists the faults of all parts.
    async fn read(form: &mut Form, work: &Work, metrics: &Metrics) -> Result<Self, Problem> {
        let mut received = Self::default();
        while let Some(head) = form.next().await? {
            match head.name.as_deref() {
                Some(name) if name == SURFACE.name && received.surface.is_none() => {
                    let (surface, memory) = read_file(form, &head, work, metrics).await?;
                    received.surface = Some(surface);
                    received.surface_memory = Some(memory);
                }
                Some(PARAMETERS) if received.parameters.is_none() => {
                    received.parameters = Some(read_small(form, PARAMETERS, LARGEST_PARAMETERS, &mut work.budget().reserve(0)?).await?);
                }
                Some(LIBRARY) => received.read_library(form, head.file_name, work).await?,
                name => received.refuse_part(name),
            }
        }
        Ok(received)
    }

    async fn read_library(&mut self, form: &mut Form, file_name: Option<String>, work: &Work) -> Result<(), Problem> {
        let mut memory = work.budget().reserve(0)?;
        let bytes = read_small(form, LIBRARY, LARGEST_LIBRARY, &mut memory).await?;
        let cancel = CancelOnDrop::default();
        let cancelled = CancelFlag::clone(&cancel);
        let library = work.run_piece(move || ToolLibrary::read_until(&bytes, file_name.as_deref(), &cancelled)).await;
        self.libraries.push(library);
        // A library has at most ten thousand tools, each with a name and figures.
        memory.shrink_to(MEMORY_OF_A_LIBRARY);
        self.library_memory.push(memory);
        Ok(())
    }

    /// The memory in bytes to prepare the facets and to rank with plans of the usual size.
    fn bytes_to_answer(&self, resources: &Resources) -> u64 {
        /// The fewest bytes of a candidate in JSON; `{"type":"ball_end","diameter_mm":6}` has more.
        const SHORTEST_CANDIDATE: usize = 24;
        let Some(Ok(surface)) = &self.surface else { return 0 };
        let mesh = &surface.surface.mesh;
        let stated = self.parameters.as_ref().map_or(0, |parameters| parameters.len() / SHORTEST_CANDIDATE);
        let candidates = if self.libraries.is_empty() { stated.min(MOST_CUTTERS) } else { MOST_CUTTERS };
        // Memory for the finer rasters of smaller cutters is added when these are known.
        let size = RankingSize { facets: mesh.size().facets, candidates, diameters: COARSE_DIAMETERS };
        resources.least(mesh.size(), size).max(bytes_of_machined_surface(mesh))
    }

    fn refuse_part(&mut self, name: Option<&str>) {
        let root = JsonPath::Root;
        let fault = match name {
            Some(name) if name == SURFACE.name || name == PARAMETERS => {
                Fault::new(&root.member(name), RequestFault::RepeatedField, "the part is given more than once")
            }
            Some(name) => {
                Fault::new(&root.member(name), RequestFault::UnknownField, "unknown part; known here: surface, parameters, library")
            }
            None => Fault::new(&root, RequestFault::UnknownField, "a part has no name; known here: surface, parameters, library"),
        };
        self.faults.push(fault);
    }

    fn answer(mut self, resources: Resources, budget: &MemoryBudget, cancelled: &CancelFlag) -> Result<WrittenJson, Problem> {
        self.surface_memory.iter_mut().for_each(Reservation::begin_work);
        let Some(parameters) = self.parameters.take() else {
            let mut faults = Faults::default();
            let _ = (self.surface(&mut faults), self.libraries.check(&mut faults));
            let path = JsonPath::Root.member(PARAMETERS);
            faults.add(&path, RequestFault::MissingField, "the part is missing: the cutters and the machine, as JSON");
            return Err(Problem::faulty_request(faults));
        };
        let task = read_text(&parameters, budget, cancelled, |object, faults| {
            let libraries = std::mem::take(&mut self.libraries);
            let warnings: Vec<_> = libraries.warnings().collect();
            let parameters = Parameters::read(object, libraries, faults);
            let surface = self.surface(faults);
            let mut task = Task::new(parameters?, surface?, &JsonPath::Root.member(SURFACE.name), faults, &|| cancelled.is_cancelled())?;
            task.warnings.extend(warnings);
            Ok(task)
        })?;
        drop(self.surface_memory.take());
        answer_to(task, resources, cancelled)
    }

    /// The surface, with the faults of the form and the file recorded.
    fn surface(&mut self, faults: &mut Faults) -> Result<SurfaceWithSource, Faulted> {
        for fault in std::mem::take(&mut self.faults) {
            faults.push(fault);
        }
        let path = JsonPath::Root.member(SURFACE.name);
        match self.surface.take() {
            Some(Ok(surface)) => Ok(surface),
            Some(Err(fault)) => Err(faults.add(&path, FileFault::from(fault.kind()), fault)),
            None => Err(faults.add(&path, RequestFault::MissingField, "the part is missing: the file with the surface")),
        }
    }
}

/// Reads the part with the surface file. The outer error is the form's, the inner one the file's. While one block is
/// parsed, the next is received; only these two are in memory. If others use the memory, the file waits for its turn,
/// and no data are received meanwhile.
async fn read_file(form: &mut Form, head: &Head, work: &Work, metrics: &Metrics) -> Result<ReadFile, Problem> {
    const LONGEST_WAIT: Duration = Work::LONGEST_WAIT_OF_PLAN;
    let cancel = CancelOnDrop::default();
    let memory = work.budget().open_for_input();
    let mut file = File::new(FormatHint::new(head.media_type.as_deref(), head.file_name.as_deref()), memory, &cancel);
    let place = work.budget().queue_input();
    let mut received = receive_block(form, metrics, FIRST_BLOCK).await?;
    while !received.is_empty() {
        let block = received;
        let bytes = file.bytes_to_take(&block);
        place.grow(&mut file.memory, bytes, LONGEST_WAIT).await?;
        let held = file.memory.bytes();
        let reading = work.run_piece(move || {
            let taken = file.take(&block);
            (file, taken)
        });
        let next = async {
            place.may_grow(held, LONGEST_WAIT).await?;
            receive_block(form, metrics, BLOCK).await
        };
        let (worked, next) = tokio::join!(reading, next);
        let taken;
        (file, taken) = worked;
        if let Err(fault) = taken? {
            return Ok((Err(fault), file.memory));
        }
        received = next?;
    }
    let is_archive = file.reader.is_archive();
    let metrics = metrics.clone();
    if !is_archive {
        return Ok(work.run_piece(move || file.finish(&metrics)).await?);
    }
    // A 3MF package is read as a whole, which takes longer than a short task may.
    let bytes = MEMORY_OF_A_PACKAGE + file.surface.bytes_to_take_package();
    place.grow(&mut file.memory, bytes, LONGEST_WAIT).await?;
    Ok(work.run_after_upload(move |_| file.finish(&metrics)).await??)
}

/// The surface of a file or its fault, with the file's reservation.
type ReadFile = (Result<SurfaceWithSource, read::Fault>, Reservation);

/// A surface file that is being read.
struct File {
    reader: Reader,
    surface: ReceivedSurface,
    memory: Reservation,
}

impl File {
    /// A file to read. Reading ends early once `cancel` is set.
    fn new(hint: FormatHint, memory: Reservation, cancel: &CancelFlag) -> Self {
        let reader = Reader::new(hint).with_package_vertex_limit(MOST_VERTICES_OF_A_PACKAGE).with_archive_limit(LARGEST_ARCHIVE);
        let reader = reader.with_cancel_flag(cancel);
        Self { reader, surface: ReceivedSurface::until(cancel), memory }
    }

    /// The most memory in bytes that reading a block adds.
    fn bytes_to_take(&self, block: &[Bytes]) -> u64 {
        let bytes: usize = block.iter().map(Bytes::len).sum();
        let held = self.reader.held_bytes();
        // A package is collected in one vector, which doubles when it grows.
        let collected = if self.reader.is_archive() { 2 * (held + bytes) } else { 0 };
        let push = self.reader.most_of_push(bytes);
        self.surface.bytes_to_take(push, held / size_of::<[f64; 3]>()) + collected as u64
    }

    /// Reads a block, for which [`File::bytes_to_take`] has been reserved. Afterwards the memory in use is reserved.
    fn take(&mut self, block: &[Bytes]) -> Result<Result<(), read::Fault>, BudgetExceeded> {
        let pushed = read_block(block, &mut self.reader, &mut self.surface);
        self.memory.resize(self.reader.held_bytes() as u64 + self.surface.held_bytes())?;
        Ok(pushed)
    }

    /// Reads the end of the file, or all of a 3MF package.
    fn finish(self, metrics: &Metrics) -> Result<ReadFile, BudgetExceeded> {
        let Self { reader, mut surface, mut memory } = self;
        let finished = reader.finish(&mut surface);
        memory.resize(surface.held_bytes())?;
        let sourced = finished.map(|summary| {
            metrics.upload_facets(format_label(summary.format), if summary.facets > 0 { summary.facets } else { summary.points });
            SurfaceWithSource::of_file(surface, summary)
        });
        Ok((sourced, memory))
    }
}

/// The approximate size of a block in bytes: large enough for the cost of changing threads not to matter, and small
/// compared with the memory budget.
const BLOCK: usize = 1 << 20;

/// The size of the first block. The memory for it is reserved before the file's format is known, and some formats take
/// a hundred times their bytes.
const FIRST_BLOCK: usize = 1 << 16;

/// The largest number of chunks of a block. A chunk may be one byte, and each keeps its receive buffer in memory.
const MOST_CHUNKS: usize = 64;

/// Receives the part's next block, consecutive chunks of about `most` bytes; an empty one at its end.
async fn receive_block(form: &mut Form, metrics: &Metrics, most: usize) -> Result<Vec<Bytes>, Problem> {
    let (mut block, mut size) = (Vec::new(), 0);
    while size < most && block.len() < MOST_CHUNKS {
        let Some(chunk) = form.chunk().await? else { break };
        size += chunk.len();
        block.push(chunk);
    }
    metrics.upload_bytes(size as u64);
    Ok(block)
}

/// Passes the chunks of a block to the reader, which reads them on all threads. Their sums are added in file order, so
/// that the same file has bitwise the same sums.
fn read_block(block: &[Bytes], reader: &mut Reader, surface: &mut ReceivedSurface) -> Result<(), read::Fault> {
    reader.push_in_parallel(block.iter().map(|chunk| &chunk[..]), surface)
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
async fn read_small(form: &mut Form, name: &str, largest: usize, memory: &mut Reservation) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    while let Some(chunk) = form.chunk().await? {
        if bytes.len() + chunk.len() > largest {
            return Err(Problem::new(ServiceProblem::TooLarge, format!("the part {name} is larger than {largest} bytes")));
        }
        bytes.extend(chunk);
        memory.resize(bytes.capacity() as u64)?;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Facing, Unit};

    /// The shape of a surface in text that arrives in chunks and blocks of these sizes.
    fn shape(text: &[u8], piece: usize, pieces: usize) -> String {
        let (mut reader, mut surface) = (Reader::new(FormatHint::default()), ReceivedSurface::until(&CancelFlag::default()));
        let all: Vec<Bytes> = text.chunks(piece).map(Bytes::copy_from_slice).collect();
        for pieces in all.chunks(pieces) {
            read_block(pieces, &mut reader, &mut surface).unwrap();
        }
        assert_eq!(reader.finish(&mut surface).unwrap().points, 60_000);
        format!("{:?}", surface.sampled.shape(Unit::Millimetre, Facing::Up).unwrap())
    }

    #[test]
    fn a_text_has_the_same_sums_to_the_bit_however_it_arrives() {
        let line = |index: u32| format!("{},{},{}\n", index % 300, f64::from(index) / 700.0, f64::from(index).sqrt());
        let text: String = (0..60_000).map(line).collect();
        let whole = shape(text.as_bytes(), text.len(), 1);
        for (piece, pieces) in [(1000, 3), (16_384, 64), (400_001, 3)] {
            assert_eq!(shape(text.as_bytes(), piece, pieces), whole, "{piece} bytes, {pieces} at a time");
        }
    }

    #[test]
    fn a_fault_in_a_text_block_has_its_line_in_the_file() {
        let text = "1.5,2,3\n".repeat(100_000) + "1.5,2\n" + &"1.5,2,3\n".repeat(100_000);
        let (mut reader, mut surface) = (Reader::new(FormatHint::default()), ReceivedSurface::until(&CancelFlag::default()));
        let fault = read_block(&[Bytes::from(text)], &mut reader, &mut surface).unwrap_err();
        assert_eq!(fault.location(), read::FileLocation::Line(100_001));
    }
}
