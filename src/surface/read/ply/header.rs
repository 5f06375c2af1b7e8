//! The header of PLY: the lines from `ply` to `end_header`.

use super::super::Format;
use super::super::fault::{Fault, FaultKind, Flaw, quoted};
use super::super::lines::Words;

/// The longest header, in bytes; it also bounds the memory for elements and properties.
const LONGEST_HEADER: u64 = 1 << 16;

/// A complete header that describes a surface.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) format: Format,
    pub(super) elements: Vec<Element>,
}

#[derive(Debug)]
pub(super) struct Element {
    pub(super) kind: Kind,
    /// The name in quotation marks, with special characters escaped.
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
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
            _ => return Err(Flaw::malformed("a type such as float or int32", name)),
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

/// Joins chunks into the lines of the header and reads them.
#[derive(Debug)]
pub(super) struct HeaderLines {
    begun: Vec<u8>,
    /// The line end of the first line, which applies to all. After `end_header` and a CR, a LF may be the first byte of
    /// binary data: it belongs to the line end only if the first line ends with CR LF.
    ending: Option<u8>,
    /// Whether the first line ended with a CR, so that a LF may follow and belong to it.
    after_cr: bool,
    ended: u64,
    skipped: u64,
    bytes: u64,
    format: Option<Format>,
    elements: Vec<Element>,
}

impl HeaderLines {
    /// A reader of a header that begins after `skipped` bytes of the file.
    pub(super) fn after(skipped: u64) -> Self {
        Self { begun: Vec::new(), ending: None, after_cr: false, ended: 0, skipped, bytes: 0, format: None, elements: Vec::new() }
    }

    /// The number of complete lines of the header.
    pub(super) fn ended(&self) -> u64 {
        self.ended
    }

    /// The bytes of the file up to the end of the header.
    pub(super) fn bytes(&self) -> u64 {
        self.skipped + self.bytes
    }

    /// A fault of the last line that was read.
    pub(super) fn fault(&self, flaw: Flaw) -> Fault {
        flaw.at_line(self.ended)
    }

    /// The fault of a file that ends in its header.
    pub(super) fn cut_off(&self) -> Fault {
        Flaw::new(FaultKind::Truncated, "a header that ends with \"end_header\"", "the end of the file").at_line(self.ended + 1)
    }

    /// Reads the header's bytes from `chunk`, and returns the header when it is complete.
    pub(super) fn push(&mut self, chunk: &mut &[u8]) -> Result<Option<Header>, Fault> {
        while let Some((&byte, rest)) = chunk.split_first() {
            if self.after_cr && byte != b'\n' {
                // The line ended with CR alone, and this byte belongs to the next line.
                self.after_cr = false;
                self.ending = Some(b'\r');
                self.line()?;
            }
            *chunk = rest;
            self.bytes += 1;
            if self.bytes > LONGEST_HEADER {
                return Err(Flaw::new(FaultKind::TooLarge, format!("a header of at most {LONGEST_HEADER} bytes"), "a longer one")
                    .at_line(self.ended + 1));
            }
            match self.ending {
                None if byte == b'\r' => self.after_cr = true,
                None if byte == b'\n' => {
                    self.after_cr = false;
                    self.ending = Some(b'\n');
                    self.line()?;
                }
                Some(ending) if byte == ending => {
                    if self.line()? {
                        return self.header().map(Some).map_err(|flaw| self.fault(flaw));
                    }
                }
                _ => self.begun.push(byte),
            }
        }
        Ok(None)
    }

    /// Reads the complete line, and returns whether it ends the header.
    fn line(&mut self) -> Result<bool, Fault> {
        let mut line = std::mem::take(&mut self.begun);
        if self.ending == Some(b'\n') && line.last() == Some(&b'\r') {
            line.pop();
        }
        self.ended += 1;
        self.statement(&line).map_err(|flaw| self.fault(flaw))
    }

    fn statement(&mut self, line: &[u8]) -> Result<bool, Flaw> {
        let mut words = Words::of(line);
        let keyword = words.next().unwrap_or_default();
        if self.ended == 1 {
            return if keyword == b"ply" { Ok(false) } else { Err(Flaw::malformed("\"ply\"", line)) };
        }
        match keyword {
            b"end_header" => return Ok(true),
            b"format" => self.format(&mut words)?,
            b"element" => self.element(&mut words)?,
            b"property" => self.property(&mut words)?,
            b"comment" | b"obj_info" | b"" => return Ok(false),
            _ => return Err(Flaw::malformed("format, element, property, comment, obj_info or end_header", line)),
        }
        match words.next() {
            None => Ok(false),
            Some(word) => Err(Flaw::malformed("the end of the line", word)),
        }
    }

    fn format(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let format = match words.next().unwrap_or_default() {
            b"ascii" => Format::PlyAscii,
            b"binary_little_endian" => Format::PlyLittleEndian,
            b"binary_big_endian" => Format::PlyBigEndian,
            other => return Err(Flaw::malformed("ascii, binary_little_endian or binary_big_endian", other)),
        };
        let version = words.next().unwrap_or_default();
        if version != b"1.0" {
            return Err(Flaw::malformed("version 1.0", version));
        }
        if self.format.replace(format).is_some() {
            return Err(Flaw::new(FaultKind::Malformed, "one format", "a second one"));
        }
        Ok(())
    }

    fn element(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let name = words.next().ok_or_else(|| Flaw::malformed("the name of an element", b""))?;
        let kind = match name {
            b"vertex" => Kind::Vertex,
            b"face" => Kind::Face,
            b"tristrips" => Kind::TriStrips,
            _ => Kind::Other,
        };
        if kind != Kind::Other && self.elements.iter().any(|element| element.kind == kind) {
            return Err(Flaw::new(FaultKind::Malformed, "one element of this name", quoted(name)));
        }
        let count = words.next().unwrap_or_default();
        let count = integer(count).ok_or_else(|| Flaw::malformed("a count of at most 18 digits", count))?;
        self.elements.push(Element { kind, name: quoted(name), count, properties: Vec::new() });
        Ok(())
    }

    fn property(&mut self, words: &mut Words) -> Result<(), Flaw> {
        let Some(element) = self.elements.last_mut() else {
            return Err(Flaw::new(FaultKind::Malformed, "an element before its properties", "a property"));
        };
        let first = words.next().unwrap_or_default();
        let property = if first == b"list" {
            let count = Type::of(words.next().unwrap_or_default())?;
            let item = Type::of(words.next().unwrap_or_default())?;
            let name = name(words)?;
            let corners = matches!(element.kind, Kind::Face | Kind::TriStrips) && matches!(name, b"vertex_indices" | b"vertex_index");
            if !count.is_integer() || (corners && !item.is_integer()) {
                return Err(Flaw::malformed("integers", name));
            }
            Property::List { count, item, corners }
        } else {
            let number = Type::of(first)?;
            let axes: [&[u8]; 3] = [b"x", b"y", b"z"];
            let name = name(words)?;
            let axis = axes.iter().position(|axis| *axis == name).filter(|_| element.kind == Kind::Vertex);
            Property::Scalar { number, axis }
        };
        let has_a_role = matches!(property, Property::Scalar { axis: Some(_), .. } | Property::List { corners: true, .. });
        if has_a_role && element.properties.iter().any(|other| other.has_the_same_role_as(&property)) {
            return Err(Flaw::new(FaultKind::Malformed, "each coordinate and the corners once", "a second time"));
        }
        element.properties.push(property);
        Ok(())
    }

    /// The header that the lines describe, if it describes a surface.
    fn header(&mut self) -> Result<Header, Flaw> {
        let missing = |what: &'static str| Flaw::new(FaultKind::Malformed, what, "the end of the header without it");
        let format = self.format.ok_or_else(|| missing("a format"))?;
        let place = |kind| self.elements.iter().position(|element| element.kind == kind);
        let vertex = place(Kind::Vertex).ok_or_else(|| missing("an element vertex"))?;
        let has = |element: &Element, wanted: &dyn Fn(&Property) -> bool| element.properties.iter().any(wanted);
        for (axis, name) in ["a vertex property x", "a vertex property y", "a vertex property z"].into_iter().enumerate() {
            if !has(&self.elements[vertex], &|property| matches!(property, Property::Scalar { axis: Some(other), .. } if *other == axis)) {
                return Err(missing(name));
            }
        }
        for (kind, list, order) in [
            (Kind::Face, "a list vertex_indices of the faces", "the element face before vertex"),
            (Kind::TriStrips, "a list vertex_indices of the triangle strips", "the element tristrips before vertex"),
        ] {
            let Some(face) = place(kind).filter(|face| self.elements[*face].count > 0) else { continue };
            if !has(&self.elements[face], &|property| matches!(property, Property::List { corners: true, .. })) {
                return Err(missing(list));
            }
            if face < vertex {
                return Err(Flaw::new(FaultKind::Malformed, "vertices before faces", order));
            }
        }
        Ok(Header { format, elements: std::mem::take(&mut self.elements) })
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
    words.next().ok_or_else(|| Flaw::malformed("the name of a property", b""))
}

/// A whole number of at most 18 digits, so that sums of the counts in a header do not overflow.
pub(super) fn integer(word: &[u8]) -> Option<u64> {
    let fits = !word.is_empty() && word.len() <= 18;
    fits.then(|| word.iter().try_fold(0, |value, byte| byte.is_ascii_digit().then(|| value * 10 + u64::from(byte - b'0'))))?
}
