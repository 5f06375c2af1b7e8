//! `POST /v1/cutter-recommendation/upload`: the surface as a file, the parameters beside it in a part of their own. The file passes
//! through its reader as it arrives and is never held.

use super::answer::RecommendationAnswer;
use super::multipart::{Form, Head};
use super::recommendation::Parameters;
use crate::http::body::{WrittenJson, read_text};
use crate::http::codes::{FileFault, RequestFault, ServiceProblem};
use crate::http::document::described;
use crate::http::metrics::Metrics;
use crate::http::problem::{Problem, UploadProblems};
use crate::http::reading::{Components, Fault, Faulted, Faults, JsonPath, ObjectSchema};
use crate::http::wire::{SURFACE, Sourced};
use crate::http::worker_pool::Work;
use crate::surface::SampledSurface;
use crate::surface::read::{self, Format, Hint, Lot, Reader};
use axum::body::Bytes;
use axum::extract::State;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use utoipa::openapi::schema::{KnownFormat, ObjectBuilder, SchemaFormat, Type};
use utoipa::openapi::{RefOr, Schema};

const PARAMETERS: &str = "parameters";

/// Parameters are some hundred bytes; a part of this size holds something else.
const LARGEST_PARAMETERS: usize = 1 << 16;

described!(UploadRequest, describe_request);

fn describe_request(components: &mut Components) -> RefOr<Schema> {
    let file = ObjectBuilder::new().schema_type(Type::String).format(Some(SchemaFormat::KnownFormat(KnownFormat::Binary))).description(Some(
        "the file: points in text (CSV, TSV, XYZ), STL, OBJ or PLY. Its content shows the format; the part's type and file name help where it does not",
    ));
    let parameters = components.refer("RecommendationParameters", "", |components| {
        Parameters::describe(ObjectSchema::new("Two cutters to compare on a surface, and the machine", components)).build()
    });
    let form = ObjectSchema::new("A surface file and the parameters, in either order", components);
    form.required_property(SURFACE.name, file).required_property(PARAMETERS, parameters).build()
}

/// The cutter for a surface in a file
///
/// The same as `/v1/cutter-recommendation`, for a file with points (CSV, TSV, XYZ) or facets (STL, OBJ, PLY).
#[utoipa::path(
    post, path = "/v1/cutter-recommendation/upload", tag = "planning", operation_id = "cutter_recommendation_upload",
    request_body(content = UploadRequest, content_type = "multipart/form-data", encoding(("parameters" = (content_type = "application/json")))),
    responses((status = 200, description = "The recommendation, with both candidates", body = RecommendationAnswer), UploadProblems),
)]
pub(crate) async fn answer(work: Work, State(metrics): State<Metrics>, mut form: Form) -> Result<WrittenJson, Problem> {
    let received = Received::read(&mut form, &work, &metrics).await?;
    work.run_after_upload(move |_| received.answer()).await?
}

/// What arrived.
#[derive(Debug, Default)]
struct Received {
    parameters: Option<Vec<u8>>,
    surface: Option<Result<Sourced, read::Fault>>,
    /// Of the form itself.
    faults: Vec<Fault>,
}

impl Received {
    /// Takes in the whole form, so that the faults of all parts can be told together.
    async fn read(form: &mut Form, work: &Work, metrics: &Metrics) -> Result<Self, Problem> {
        let mut received = Self::default();
        while let Some(head) = form.next().await? {
            match head.name.as_deref() {
                Some(name) if name == SURFACE.name && received.surface.is_none() => {
                    received.surface = Some(read_file(form, &head, work, metrics).await?);
                }
                Some(PARAMETERS) if received.parameters.is_none() => received.parameters = Some(read_parameters(form).await?),
                name => received.refuse_part(name),
            }
        }
        Ok(received)
    }

    fn refuse_part(&mut self, name: Option<&str>) {
        let root = JsonPath::Root;
        let fault = match name {
            Some(name) if name == SURFACE.name || name == PARAMETERS => {
                Fault::new(&root.member(name), RequestFault::RepeatedField, "the part is given more than once")
            }
            Some(name) => Fault::new(&root.member(name), RequestFault::UnknownField, "unknown part; known here: surface, parameters"),
            None => Fault::new(&root, RequestFault::UnknownField, "a part has no name; known here: surface, parameters"),
        };
        self.faults.push(fault);
    }

    fn answer(self) -> Result<WrittenJson, Problem> {
        let Some(parameters) = &self.parameters else {
            let mut faults = Faults::default();
            let _ = self.surface(&mut faults);
            let path = JsonPath::Root.member(PARAMETERS);
            faults.add(&path, RequestFault::MissingField, "the part is missing: the job and the machine, as JSON");
            return Err(Problem::faulty_request(faults));
        };
        let answer = read_text(parameters, |object, faults| {
            let parameters = Parameters::read(object, faults);
            let surface = self.surface(faults);
            parameters?.answer(surface?, &JsonPath::Root.member(SURFACE.name), faults)
        });
        WrittenJson::of(&answer?)
    }

    /// The surface, with the faults of the form and the file recorded.
    fn surface(&self, faults: &mut Faults) -> Result<&Sourced, Faulted> {
        for fault in &self.faults {
            faults.push(fault.clone());
        }
        let path = JsonPath::Root.member(SURFACE.name);
        match &self.surface {
            Some(Ok(surface)) => Ok(surface),
            Some(Err(fault)) => Err(faults.add(&path, FileFault::from(fault.kind()), fault)),
            None => Err(faults.add(&path, RequestFault::MissingField, "the part is missing: the file with the surface")),
        }
    }
}

/// Reads a part that is a surface file; the outer error is the form's, the inner one the file's. While one block is worked on, the next
/// is received; no more than these two are held.
async fn read_file(form: &mut Form, head: &Head, work: &Work, metrics: &Metrics) -> Result<Result<Sourced, read::Fault>, Problem> {
    let mut reader = Reader::new(Hint::new(head.media_type.as_deref(), head.file_name.as_deref()));
    let mut surface = SampledSurface::new();
    // What the reader holds; a block adds a few times its size, for which there is room beside the budget.
    let mut held = work.reserve(0)?;
    let mut received = Block::receive(form, metrics).await?;
    while !received.pieces.is_empty() {
        let block = received;
        let reading = work.run_piece(move || {
            let pushed = block.read(&mut reader, &mut surface);
            (reader, surface, pushed)
        });
        let (worked, next) = tokio::join!(reading, Block::receive(form, metrics));
        let pushed;
        (reader, surface, pushed) = worked;
        held.resize(reader.held_bytes() as u64)?;
        received = next?;
        if let Err(fault) = pushed {
            return Ok(Err(fault));
        }
    }
    let (surface, finished) = work
        .run_piece(move || {
            let finished = reader.finish(&mut surface);
            (surface, finished)
        })
        .await;
    Ok(finished.map(|summary| {
        metrics.upload_facets(format_label(summary.format), if summary.facets > 0 { summary.facets } else { summary.points });
        Sourced { surface, source: summary.format.into(), notes: summary.notes }
    }))
}

/// Consecutive data of a part, as they arrived.
#[derive(Debug, Default)]
struct Block {
    pieces: Vec<Bytes>,
}

impl Block {
    /// About so many bytes at most: large against the cost of changing threads, small against memory.
    const SIZE: usize = 1 << 20;

    /// Pieces may come byte by byte, and each holds on to the buffer in which it was received.
    const PIECES: usize = 64;

    /// The part's next data; no pieces once there are no more.
    async fn receive(form: &mut Form, metrics: &Metrics) -> Result<Self, Problem> {
        let (mut block, mut size) = (Self::default(), 0);
        while size < Self::SIZE && block.pieces.len() < Self::PIECES {
            let Some(piece) = form.chunk().await? else { break };
            size += piece.len();
            block.pieces.push(piece);
        }
        metrics.upload_bytes(size as u64);
        Ok(block)
    }

    /// Passes the pieces to the reader; lots that can be read apart go to all threads. Their sums are added in their order,
    /// so that the same file has the same sums, to the bit.
    fn read(&self, reader: &mut Reader, surface: &mut SampledSurface) -> Result<(), read::Fault> {
        let mut lots = Vec::new();
        self.pieces.iter().try_for_each(|piece| reader.push_in_lots(piece, surface, &mut lots))?;
        let sum = |lot: Lot| {
            let mut part = SampledSurface::new();
            (lot.read(&mut part), part)
        };
        let parts: Vec<_> = lots.into_par_iter().map(sum).collect();
        parts.into_iter().try_for_each(|(read, part)| {
            surface.merge(&part);
            reader.take_in(read)
        })
    }
}

/// The label of a format in the metrics.
fn format_label(format: Format) -> &'static str {
    match format {
        Format::Text => "text",
        Format::StlAscii | Format::StlBinary => "stl",
        Format::Obj => "obj",
        Format::PlyAscii | Format::PlyLittleEndian | Format::PlyBigEndian => "ply",
    }
}

async fn read_parameters(form: &mut Form) -> Result<Vec<u8>, Problem> {
    let mut parameters = Vec::new();
    while let Some(chunk) = form.chunk().await? {
        parameters.extend(chunk);
        if parameters.len() > LARGEST_PARAMETERS {
            let detail = format!("the part parameters is larger than {LARGEST_PARAMETERS} bytes");
            return Err(Problem::new(ServiceProblem::TooLarge, detail));
        }
    }
    Ok(parameters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::{Facing, Unit};

    /// The shape of a text that comes in pieces and blocks of these sizes.
    fn shape(text: &[u8], piece: usize, pieces: usize) -> String {
        let (mut reader, mut surface) = (Reader::new(Hint::default()), SampledSurface::new());
        let all: Vec<Bytes> = text.chunks(piece).map(Bytes::copy_from_slice).collect();
        for pieces in all.chunks(pieces) {
            Block { pieces: pieces.to_vec() }.read(&mut reader, &mut surface).unwrap();
        }
        assert_eq!(reader.finish(&mut surface).unwrap().points, 60_000);
        format!("{:?}", surface.shape(Unit::Millimetre, Facing::Up).unwrap())
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
    fn a_fault_in_a_lot_has_its_line_in_the_file() {
        let text = "1.5,2,3\n".repeat(100_000) + "1.5,2\n" + &"1.5,2,3\n".repeat(100_000);
        let (mut reader, mut surface) = (Reader::new(Hint::default()), SampledSurface::new());
        let block = Block { pieces: vec![Bytes::from(text)] };
        let fault = block.read(&mut reader, &mut surface).unwrap_err();
        assert_eq!(fault.place(), read::Place::Line(100_001));
    }
}
