//! Which format a file has: by its content first, then by what its sender says of it.

use super::fault::{Fault, FaultKind, Flaw};
use super::lines::{Words, line_end, trimmed};
use std::fmt;

/// The bytes that decide, at most: licence texts in comments at the start of a file are shorter.
pub(super) const HEAD: usize = 1 << 16;

/// A format of a file, as it was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Points in lines of text: CSV, TSV, XYZ and their like.
    Text,
    /// STL in text.
    StlAscii,
    /// STL in 50-byte records.
    StlBinary,
    /// Wavefront OBJ.
    Obj,
    /// PLY with a body of text.
    PlyAscii,
    /// PLY with a binary body, little end first.
    PlyLittleEndian,
    /// PLY with a binary body, big end first.
    PlyBigEndian,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Text => "text",
            Self::StlAscii => "ASCII STL",
            Self::StlBinary => "binary STL",
            Self::Obj => "OBJ",
            Self::PlyAscii => "ASCII PLY",
            Self::PlyLittleEndian => "binary PLY, little-endian",
            Self::PlyBigEndian => "binary PLY, big-endian",
        })
    }
}

/// What the sender of a file says about its format, for content that leaves it open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FormatHint(Option<Said>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Said {
    Text,
    Stl,
    Obj,
    Ply,
}

impl FormatHint {
    /// What a media type, with or without parameters, and a file name tell. The media type counts first; general ones such as
    /// `text/plain` and `application/octet-stream` tell nothing.
    #[must_use]
    pub fn new(media_type: Option<&str>, file_name: Option<&str>) -> Self {
        Self(media_type.and_then(by_media_type).or_else(|| file_name.and_then(by_name)))
    }
}

fn by_media_type(media_type: &str) -> Option<Said> {
    let essence = media_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    match essence.as_str() {
        "text/csv" | "text/tab-separated-values" => Some(Said::Text),
        "model/stl" | "model/x.stl-ascii" | "model/x.stl-binary" | "application/sla" | "application/vnd.ms-pki.stl" => Some(Said::Stl),
        "model/obj" | "application/wavefront-obj" => Some(Said::Obj),
        "model/ply" | "application/ply" => Some(Said::Ply),
        _ => None,
    }
}

fn by_name(name: &str) -> Option<Said> {
    let (_, extension) = name.rsplit_once('.')?;
    match extension.trim().to_ascii_lowercase().as_str() {
        "csv" | "tsv" | "txt" | "xyz" | "asc" | "dat" => Some(Said::Text),
        "stl" | "stla" | "stlb" => Some(Said::Stl),
        "obj" => Some(Said::Obj),
        "ply" => Some(Said::Ply),
        _ => None,
    }
}

/// Which reader a file needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Family {
    Text,
    StlAscii,
    StlBinary,
    Obj,
    Ply,
}

/// What the head of a file shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) format: Family,
    /// The bytes of a byte-order mark, which are no part of the text.
    pub(super) mark: usize,
}

/// The format of a file that begins with `head`: the first [`HEAD`] bytes of it, or all.
pub(super) fn find(head: &[u8], hint: FormatHint) -> Result<Found, Fault> {
    if head.is_empty() {
        return Err(Flaw::new(FaultKind::Empty, "a surface", "an empty file").at_byte(0));
    }
    if let Some(other) = known_but_not_read(head) {
        return Err(Flaw::new(FaultKind::UnknownFormat, "text with points, STL, OBJ or PLY", other).at_byte(0));
    }
    let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let text = &head[mark..];
    if let Some(format) = by_magic(text) {
        return Ok(Found { format, mark });
    }
    if let Some(at) = control_byte(text) {
        return match hint.0 {
            None | Some(Said::Stl) => Ok(Found { format: Family::StlBinary, mark: 0 }),
            Some(_) => {
                Err(Flaw::new(FaultKind::UnknownFormat, "text", format!("the control byte {:#04x}", text[at])).at_byte((mark + at) as u64))
            }
        };
    }
    Ok(Found { format: by_first_statement(text, hint), mark })
}

/// What other formats show by their first bytes, and text that is not UTF-8.
fn known_but_not_read(head: &[u8]) -> Option<&'static str> {
    const UTF_16: &str = "UTF-16 text; save it as UTF-8";
    let starts = |magic: &[u8]| head.starts_with(magic);
    // Text in the Latin alphabet has a null byte in every unit of UTF-16. A binary STL's header may, its numbers do not.
    let every_second_null = |odd: usize| head.len() >= 4 && head.iter().skip(odd).step_by(2).all(|byte| *byte == 0);
    let not_all_null = head.iter().any(|byte| *byte != 0);
    match () {
        () if starts(b"\xff\xfe") || starts(b"\xfe\xff") => Some(UTF_16),
        () if not_all_null && (every_second_null(0) || every_second_null(1)) => Some(UTF_16),
        () if starts(b"\x1f\x8b") => Some("a gzip archive inside the upload; send the file itself, or the whole request compressed"),
        () if starts(b"PK\x03\x04") => Some("a ZIP archive, as 3MF and spreadsheets are"),
        () if starts(b"ISO-10303-21") => Some("a STEP file; export it as STL or points"),
        () if starts(b"glTF") => Some("a binary glTF file; export it as STL, OBJ or PLY"),
        () if starts(b"%PDF") => Some("a PDF file"),
        () => None,
    }
}

/// PLY, and STL that begins as its description asks.
fn by_magic(text: &[u8]) -> Option<Family> {
    if text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace) {
        return Some(Family::Ply);
    }
    let mut statements = statements(text);
    let first = statements.next()?;
    if !is_word(first, b"solid") {
        return is_word(first, b"facet").then_some(Family::StlAscii);
    }
    // A binary STL's header may begin with `solid` too; what follows it then is neither text nor a facet.
    match statements.next() {
        Some(second) if is_word(second, b"facet") || is_word(second, b"endsolid") => Some(Family::StlAscii),
        _ if control_byte(text).is_none() => Some(Family::StlAscii),
        _ => None,
    }
}

/// Where the first byte stands that no text has, in the first 134 bytes: a binary STL's header of 80 bytes, its count of 4, whose
/// highest byte is such a control byte up to 150 million facets, and its first record of 50. Further on it is a fault of a text.
fn control_byte(text: &[u8]) -> Option<usize> {
    let is_control = |byte: &u8| *byte < b'\t' || *byte == 0x0b || (0x0e..b' ').contains(byte);
    text.iter().take(134).position(is_control)
}

/// The format of a text without a magic word.
fn by_first_statement(text: &[u8], hint: FormatHint) -> Family {
    let first = statements(text).find(|line| !line.starts_with(b"#") && !line.starts_with(b"//"));
    if first.is_some_and(is_obj) {
        return Family::Obj;
    }
    if first.is_some_and(|line| starts_number(line) || line[0] == b'"') {
        return Family::Text;
    }
    match hint.0 {
        None | Some(Said::Text) => Family::Text,
        Some(Said::Stl) => Family::StlAscii,
        Some(Said::Obj) => Family::Obj,
        Some(Said::Ply) => Family::Ply,
    }
}

/// Whether a line is a statement of OBJ and cannot be the header of a table.
fn is_obj(line: &[u8]) -> bool {
    let mut words = Words::of(line);
    let (Some(keyword), Some(second)) = (words.next(), words.next()) else { return false };
    match keyword {
        b"v" | b"vn" | b"vt" | b"vp" | b"f" | b"l" | b"p" => starts_number(second),
        b"s" => starts_number(second) || second == b"off",
        b"mtllib" | b"usemtl" | b"o" | b"g" => true,
        _ => false,
    }
}

fn starts_number(text: &[u8]) -> bool {
    matches!(text, [b'0'..=b'9', ..] | [b'+' | b'-' | b'.', b'0'..=b'9' | b'.', ..])
}

/// The lines that are not blank, trimmed.
fn statements(mut text: &[u8]) -> impl Iterator<Item = &[u8]> {
    std::iter::from_fn(move || {
        while !text.is_empty() {
            let end = line_end(text).unwrap_or(text.len());
            let line = trimmed(&text[..end]);
            text = text.get(end + 1..).unwrap_or_default();
            if !line.is_empty() {
                return Some(line);
            }
        }
        None
    })
}

fn is_word(line: &[u8], word: &[u8]) -> bool {
    Words::of(line).next().is_some_and(|first| first.eq_ignore_ascii_case(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn family(head: &[u8], name: &str) -> Family {
        find(head, FormatHint::new(None, Some(name))).unwrap().format
    }

    fn binary_stl(header: &[u8]) -> Vec<u8> {
        let mut file = header.to_vec();
        file.resize(80, b' ');
        file.extend(1_u32.to_le_bytes());
        file.resize(134, 0);
        file
    }

    #[test]
    fn content_speaks_before_the_name() {
        assert_eq!(family(b"1;2;3\n", "part.stl"), Family::Text);
        assert_eq!(family(b"\xef\xbb\xbf-1 2 3\n", "part.obj"), Family::Text);
        assert_eq!(family(b"# a comment\n\nv 1 2 3\n", "points.csv"), Family::Obj);
        assert_eq!(family(b"ply\r\nformat", "points.txt"), Family::Ply);
        assert_eq!(family(b"\n  SOLID part\n facet", "points.txt"), Family::StlAscii);
        assert_eq!(family(&binary_stl(b"made somewhere"), "part"), Family::StlBinary);
    }

    #[test]
    fn a_binary_stl_may_call_itself_solid() {
        assert_eq!(family(&binary_stl(b"solid part"), "part.stl"), Family::StlBinary);
        assert_eq!(family(&binary_stl(b"solid part\nof ours"), ""), Family::StlBinary);
        assert_eq!(family(b"solid \x01part\r\n\r\nFACET normal", ""), Family::StlAscii);
        assert_eq!(family(b"solid", ""), Family::StlAscii);
    }

    #[test]
    fn the_name_decides_where_content_does_not() {
        assert_eq!(family(b"hello\n", "part.STL"), Family::StlAscii);
        assert_eq!(family(b"# nothing\n", "part.obj"), Family::Obj);
        assert_eq!(family(b"hello\n", "part.ply"), Family::Ply);
        assert_eq!(family(b"X Y Z\n", "part"), Family::Text);
    }

    #[test]
    fn the_media_type_counts_before_the_file_name() {
        assert_eq!(FormatHint::new(Some("Model/STL; charset=x"), Some("a.obj")), FormatHint(Some(Said::Stl)));
        assert_eq!(FormatHint::new(Some("text/plain"), Some("a.b.OBJ")), FormatHint(Some(Said::Obj)));
        assert_eq!(FormatHint::new(Some("application/octet-stream"), Some("obj")), FormatHint(None));
        assert_eq!(FormatHint::new(None, None), FormatHint::default());
    }

    #[test]
    fn columns_named_like_obj_statements_are_columns() {
        assert_eq!(family(b"v x y z\n1 2 3 4\n", ""), Family::Text);
        assert_eq!(family(b"s,x,y,z\n", ""), Family::Text);
    }

    #[test]
    fn what_is_known_but_not_read_is_named() {
        for (head, word) in [
            (&b"\xff\xfe1\0"[..], "UTF-16"),
            (b"1\0,\x002\0", "UTF-16"),
            (b"\x001\0,\x002", "UTF-16"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"PK\x03\x04rest", "ZIP"),
            (b"ISO-10303-21;", "STEP"),
        ] {
            let fault = find(head, FormatHint::default()).unwrap_err();
            assert_eq!(fault.kind(), FaultKind::UnknownFormat);
            assert!(fault.found().contains(word), "{fault}");
        }
        let fault = find(b"1,2,3\n1,\x002,3\n", FormatHint::new(None, Some("a.csv"))).unwrap_err();
        assert_eq!(fault.to_string(), "byte 8: expected text, found the control byte 0x00");
        assert_eq!(find(b"", FormatHint::default()).unwrap_err().kind(), FaultKind::Empty);
    }
}
