//! The header of PLY: the lines from `ply` to `end_header`.

use super::Format;
use super::input::{Input, ReadError};
use super::words::{CommentedUnit, Words, line_end, unsigned};
use crate::file_fault::{FileFaultKind, Flaw, quoted};
use crate::surface::Unit;

/// The longest header, in bytes; it also bounds the memory for elements and properties.
const LONGEST_HEADER: usize = 1 << 16;

/// A complete header that describes a surface.
#[derive(Debug)]
pub(super) struct PlyHeader {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
    /// The unit that a comment states.
    pub(super) unit: Option<Unit>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) kind: PlyKind,
    /// The name in quotation marks, with special characters escaped.
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlyKind {
    Vertex,
    Face,
    TriStrips,
    Other,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Property {
    /// One number. In a vertex, `axis` is set if it is a coordinate.
    Scalar { number: Type, axis: Option<usize> },
    /// A count and as many items. In a face, `corners` is set if they are its corners.
    List { count: Type, item: Type, corners: bool },
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn of(name: &[u8]) -> Result<Self, Flaw> {
        Ok(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return Err(Flaw::quoting("a type such as float or int32", name)),
        })
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The bytes that a number of this type takes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Reads the header from the start of a file, and leaves the input at the body.
pub(super) fn read(input: &mut Input) -> Result<PlyHeader, ReadError> {
    // The line end of the first line applies to all. After `end_header` and a CR, a LF may be the first byte of binary
    // data: it belongs to the line end only if the first line ends with CR LF.
    let start = input.peek(LONGEST_HEADER)?;
    let first = line_end(start);
    let is_cr_alone = first.is_some_and(|at| start[at] == b'\r' && start.get(at + 1) != Some(&b'\n'));
    let begin = input.offset();
    let mut lines = HeaderLines { number: 0, format: None, elements: Vec::new(), unit: CommentedUnit::default() };
    loop {
        let line = input.line_until(if is_cr_alone { b'\r' } else { b'\n' })?;
        lines.number += 1;
        let Some(line) = line else {
            let flaw = Flaw::new(FileFaultKind::Truncated, "a header that ends with \"end_header\"", "the end of the file");
            return Err(flaw.at_line(lines.number).into());
        };
        let line = if is_cr_alone { line } else { line.strip_suffix(b"\r").unwrap_or(line) };
        let is_end = lines.statement(line).map_err(|flaw| flaw.at_line(lines.number))?;
        if input.offset() - begin > LONGEST_HEADER as u64 {
            let expected = format!("a header of at most {LONGEST_HEADER} bytes");
            return Err(Flaw::new(FileFaultKind::TooLarge, expected, "a longer one").at_line(lines.number).into());
        }
        if is_end {
            let number = lines.number;
            return Ok(lines.header().map_err(|flaw| flaw.at_line(number))?);
        }
    }
}

/// The statements of a header so far.
struct HeaderLines {
    number: u64,
    format: Option<Format>,
    elements: Vec<Element>,
    unit: CommentedUnit,
}

impl HeaderLines {
    fn statement(&mut self, line: &[u8]) -> Result<bool, Flaw> {
        let mut words = Words::of(line);
        let keyword = words.next().unwrap_or_default();
        if self.number == 1 {
            return if keyword == b"ply" { Ok(false) } else { Err(Flaw::quoting("\"ply\"", line)) };
        }
        match keyword {
            b"end_header" => return Ok(true),
            b"format" => self.format(&mut words)?,
            b"element" => self.element(&mut words)?,
            b"property" => self.property(&mut words)?,
            b"comment" | b"obj_info" | b"" => return self.unit.read(line).map(|()| false),
            _ => return Err(Flaw::quoting("format, element, property, comment, obj_info or end_header", line)),
        }
        match words.next() {
            None => Ok(false),
            Some(word) => Err(Flaw::quoting("the end of the line", word)),
        }
    }

    fn format(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let format = match words.next().unwrap_or_default() {
            b"ascii" => Format::PlyAscii,
            b"binary_little_endian" => Format::PlyLittleEndian,
            b"binary_big_endian" => Format::PlyBigEndian,
            other => return Err(Flaw::quoting("ascii, binary_little_endian or binary_big_endian", other)),
        };
        let version = words.next().unwrap_or_default();
        if version != b"1.0" {
            return Err(Flaw::quoting("version 1.0", version));
        }
        if self.format.replace(format).is_some() {
            return Err(Flaw::new(FileFaultKind::Malformed, "one format", "a second one"));
        }
        Ok(())
    }

    fn element(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let name = words.next().ok_or_else(|| Flaw::quoting("the name of an element", b""))?;
        let kind = match name {
            b"vertex" => PlyKind::Vertex,
            b"face" => PlyKind::Face,
            b"tristrips" => PlyKind::TriStrips,
            _ => PlyKind::Other,
        };
        if kind != PlyKind::Other && self.elements.iter().any(|element| element.kind == kind) {
            return Err(Flaw::new(FileFaultKind::Malformed, "one element of this name", quoted(name)));
        }
        let count = words.next().unwrap_or_default();
        let count = unsigned(count).ok_or_else(|| Flaw::quoting("a count of at most 18 digits", count))?;
        self.elements.push(Element { kind, name: quoted(name), count, properties: Vec::new() });
        Ok(())
    }

    fn property(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let Some(element) = self.elements.last_mut() else {
            return Err(Flaw::new(FileFaultKind::Malformed, "an element before its properties", "a property"));
        };
        let first = words.next().unwrap_or_default();
        let property = if first == b"list" {
            let count = Type::of(words.next().unwrap_or_default())?;
            let item = Type::of(words.next().unwrap_or_default())?;
            let name = name(words)?;
            let corners = matches!(element.kind, PlyKind::Face | PlyKind::TriStrips) && matches!(name, b"vertex_indices" | b"vertex_index");
            if !count.is_integer() || (corners && !item.is_integer()) {
                return Err(Flaw::quoting("integers", name));
            }
            Property::List { count, item, corners }
        } else {
            let number = Type::of(first)?;
            let axes: [&[u8]; 3] = [b"x", b"y", b"z"];
            let name = name(words)?;
            let axis = axes.iter().position(|axis| *axis == name).filter(|_| element.kind == PlyKind::Vertex);
            Property::Scalar { number, axis }
        };
        let has_a_role = matches!(property, Property::Scalar { axis: Some(_), .. } | Property::List { corners: true, .. });
        if has_a_role && element.properties.iter().any(|other| other.has_the_same_role_as(&property)) {
            return Err(Flaw::new(FileFaultKind::Malformed, "each coordinate and the corners once", "a second time"));
        }
        element.properties.push(property);
        Ok(())
    }

    /// The header that the lines describe, if it describes a surface.
    fn header(self) -> Result<PlyHeader, Flaw> {
        let missing = |what: &'static str| Flaw::new(FileFaultKind::Malformed, what, "the end of the header without it");
        let format = self.format.ok_or_else(|| missing("a format"))?;
        let place = |kind| self.elements.iter().position(|element| element.kind == kind);
        let vertex = place(PlyKind::Vertex).ok_or_else(|| missing("an element vertex"))?;
        let has = |element: &Element, wanted: &dyn Fn(&Property) -> bool| element.properties.iter().any(wanted);
        for (axis, name) in ["a vertex property x", "a vertex property y", "a vertex property z"].into_iter().enumerate() {
            if !has(&self.elements[vertex], &|property| matches!(property, Property::Scalar { axis: Some(other), .. } if *other == axis)) {
                return Err(missing(name));
            }
        }
        for (kind, list, order) in [
            (PlyKind::Face, "a list vertex_indices of the faces", "the element face before vertex"),
            (PlyKind::TriStrips, "a list vertex_indices of the triangle strips", "the element tristrips before vertex"),
        ] {
            let Some(face) = place(kind).filter(|face| self.elements[*face].count > 0) else { continue };
            if !has(&self.elements[face], &|property| matches!(property, Property::List { corners: true, .. })) {
                return Err(missing(list));
            }
            if face < vertex {
                return Err(Flaw::new(FileFaultKind::Malformed, "vertices before faces", order));
            }
        }
        Ok(PlyHeader { format, elements: self.elements, unit: self.unit.unit() })
    }
}

impl Property {
    fn has_the_same_role_as(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Scalar { axis: one, .. }, Self::Scalar { axis: other, .. }) => one == other,
            (Self::List { corners: one, .. }, Self::List { corners: other, .. }) => one == other,
            _ => false,
        }
    }
}

fn name<'a>(words: &mut Words<'a>) -> Result<&'a [u8], Flaw> {
    words.next().ok_or_else(|| Flaw::quoting("the name of a property", b""))
}
