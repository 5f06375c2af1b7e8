//! Readers of surface files: points in text, ASCII PCD, STL, OBJ, PLY and 3MF.
//!
//! A [`Reader`] pulls a file from a source, which may block, and passes points and facets to a [`Sink`]: the facets if the file
//! has any, otherwise the points. Text, PCD and STL are not stored. For OBJ and PLY, whose facets refer to vertices by number,
//! the vertices are stored. For 3MF, whose directory is at its end, the compressed file and its meshes are stored. Memory grows
//! with the data that arrive, not with the counts that a file states.
//!
//! A file that cannot be read, or is ambiguous, is refused with a [`FileFault`](crate::file_fault::FileFault) that names the
//! line or byte. Data that the reader leaves out are counted in the [`ReadSummary`]. Coordinates are passed on in the file's
//! unit, which is in the summary if the file states it. A reader ends early only with an error of its source: a source that is
//! no longer needed returns one.

mod extremes;
mod faces;
mod format;
mod input;
mod obj;
mod pcd;
mod ply;
mod ply_header;
mod stl;
mod text;
mod three_mf;
mod words;

pub use format::{Format, FormatHint};
pub use input::ReadError;
pub use three_mf::DEFAULT_ARCHIVE_LIMIT;

use super::{LARGEST_COORDINATE, Sink, Unit};
use format::{FormatFamily, HEAD};
use input::{Input, Utf16};
use std::io::Read;

/// The default limit on the vertices of an OBJ, PLY or 3MF file, 480 MB of coordinates. [`Reader::with_vertex_limit`]
/// changes it.
pub const DEFAULT_VERTEX_LIMIT: usize = 20_000_000;

/// The result of reading a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadSummary {
    /// The format, detected by the content.
    pub format: Format,
    /// Points passed to the sink.
    pub points: u64,
    /// Facets passed to the sink; a polygon of n corners counts n - 2.
    pub facets: u64,
    /// The unit of the coordinates, if the file states one: 3MF always does, text may in its header, OBJ and PLY in a
    /// comment. A caller must use
    /// this unit.
    pub unit: Option<Unit>,
    /// The data that were left out, or accepted although they are unusual.
    pub notes: Notes,
}

/// Counts of data that a reader left out, or accepted although they are unusual; 0 for a regular file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Notes {
    /// Text and PCD: the columns other than x, y and z in the first line of data.
    pub further_columns: u64,
    /// Binary STL and PLY: bytes after the end that the file's counts give.
    pub trailing_bytes: u64,
    /// OBJ: point and line elements. PLY: rows of elements other than vertices, faces and triangle strips. 3MF: placed
    /// objects of the types `support` and `other`. They are not part of a surface.
    pub other_elements: u64,
    /// OBJ and PLY: polygons whose outline crosses itself or doubles back, so that no triangulation has their area.
    pub crossed_polygons: u64,
    /// PCD: points without coordinates (`nan`), which scanners write if there was no echo.
    pub missing_points: u64,
    /// Text and PCD: a number far outside of all others of its axis, which may stand for a missing measurement.
    pub far_outside: Option<FarOutside>,
    /// 3MF: the volumes that a slicer's settings exclude from the part, each by kind and name; at most 10.
    pub volumes: Vec<String>,
    /// ASCII STL: the file ends inside a solid, at the end of a facet. It may have been cut off.
    pub missing_end: bool,
}

/// A coordinate far outside of all others of its axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarOutside {
    /// The line of the first point with it.
    pub line: u64,
    /// The axis: 0, 1 or 2 for x, y or z.
    pub axis: usize,
    /// The coordinate, in the file's unit.
    pub value: f64,
    /// The number of points with it.
    pub points: u64,
    /// The smallest and the largest of the others.
    pub others: [f64; 2],
}

/// Reads one file, whatever its format.
///
/// The format is detected from the first 64 KiB, and from the [`FormatHint`] if they are ambiguous. Text in UTF-16 with
/// a byte-order mark is converted. The result does not depend on the pieces in which the source delivers the file.
#[derive(Debug, Clone, Copy)]
pub struct Reader {
    hint: FormatHint,
    vertex_limit: usize,
    /// The limit for a 3MF file.
    package_vertex_limit: usize,
    archive_limit: usize,
}

impl Reader {
    /// A reader for one file.
    #[must_use]
    pub fn new(hint: FormatHint) -> Self {
        let (vertex_limit, package_vertex_limit) = (DEFAULT_VERTEX_LIMIT, DEFAULT_VERTEX_LIMIT);
        Self { hint, vertex_limit, package_vertex_limit, archive_limit: DEFAULT_ARCHIVE_LIMIT }
    }

    /// This reader with a limit of `bytes` compressed bytes for a 3MF file.
    #[must_use]
    pub fn with_archive_limit(self, bytes: usize) -> Self {
        Self { archive_limit: bytes, ..self }
    }

    /// The same reader with a limit of `vertices` vertices for an OBJ, PLY or 3MF file, 24 bytes each; a 3MF file may
    /// have twice as many triangles, 12 bytes each, and place four times as many.
    #[must_use]
    pub fn with_vertex_limit(self, vertices: usize) -> Self {
        Self { vertex_limit: vertices, package_vertex_limit: vertices, ..self }
    }

    /// The same reader with another limit for 3MF files, which take 48 bytes for each vertex when they end. Call it
    /// after [`Reader::with_vertex_limit`].
    #[must_use]
    pub fn with_package_vertex_limit(self, vertices: usize) -> Self {
        Self { package_vertex_limit: vertices, ..self }
    }

    /// Reads the file that `source` delivers, and passes its points or facets to `sink`.
    ///
    /// # Errors
    /// [`ReadError`] with the first [`FileFault`](crate::file_fault::FileFault) of the file, or with an error of the source.
    pub fn read(self, mut source: impl Read, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
        let mut input = Input::new(&mut source);
        match Utf16::by_mark(input.peek(2)?) {
            Some(decoder) => self.read_input(&mut Input::new(&mut decoder.of(&mut input)), true, sink),
            None => self.read_input(&mut input, false, sink),
        }
    }

    fn read_input(self, input: &mut Input, is_decoded: bool, sink: &mut dyn Sink) -> Result<ReadSummary, ReadError> {
        let head = input.peek(HEAD)?;
        let detected = format::detect(&head[..head.len().min(HEAD)], self.hint, is_decoded)?;
        input.consume(detected.mark);
        match detected.format {
            FormatFamily::Text => text::read(input, sink),
            FormatFamily::Pcd => pcd::read(input, sink),
            FormatFamily::StlAscii => stl::read_text(input, sink),
            FormatFamily::StlBinary => stl::read_binary(input, sink),
            FormatFamily::Obj => obj::read(input, self.vertex_limit, sink),
            FormatFamily::Ply => ply::read(input, self.vertex_limit, sink),
            FormatFamily::ThreeMf => three_mf::read(input, self, sink),
        }
    }
}
