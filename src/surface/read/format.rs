//! Detection of a file's format, by its content first, then by its media type and name. Formats that are not read are detected
//! only to name them in the fault.

use super::words::{Words, is_word, line_end, starts_number, statements};
use crate::file_fault::{FileFault, FileFaultKind, Flaw};
use std::fmt;

/// The largest number of bytes examined, more than a licence text in comments at the start of a file has.
pub(super) const HEAD: usize = 1 << 16;

/// The accepted formats, for the text of faults.
pub(super) const EXPECTED: &str = "points in text, PCD, STL, OBJ, PLY or 3MF";

/// The format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Points in lines of text: CSV, TSV, XYZ, PTS and the like.
    Text,
    /// PCD of the Point Cloud Library, with data in text.
    Pcd,
    /// STL in text.
    StlAscii,
    /// STL in 50-byte records.
    StlBinary,
    /// Wavefront OBJ.
    Obj,
    /// PLY with a body of text.
    PlyAscii,
    /// PLY with a binary body, little-endian.
    PlyLittleEndian,
    /// PLY with a binary body, big-endian.
    PlyBigEndian,
    /// 3MF, the 3D Manufacturing Format.
    ThreeMf,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Text => "text",
            Self::Pcd => "ASCII PCD",
            Self::StlAscii => "ASCII STL",
            Self::StlBinary => "binary STL",
            Self::Obj => "OBJ",
            Self::PlyAscii => "ASCII PLY",
            Self::PlyLittleEndian => "binary PLY, little-endian",
            Self::PlyBigEndian => "binary PLY, big-endian",
            Self::ThreeMf => "3MF",
        })
    }
}

/// The format that a file's sender states, used if the content is ambiguous.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FormatHint(Option<NamedFormat>);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NamedFormat {
    Text,
    Stl,
    Obj,
    Ply,
    ThreeMf,
}

impl FormatHint {
    /// The format that a media type states, with or without parameters; otherwise the format of a file name's
    /// extension. General media types such as `text/plain` and `application/octet-stream` state no format.
    #[must_use]
    pub fn new(media_type: Option<&str>, file_name: Option<&str>) -> Self {
        Self(media_type.and_then(by_media_type).or_else(|| file_name.and_then(by_name)))
    }
}

fn by_media_type(media_type: &str) -> Option<NamedFormat> {
    let essence = media_type.split(';').next().unwrap_or_default().trim().to_ascii_lowercase();
    match essence.as_str() {
        "text/csv" | "text/tab-separated-values" => Some(NamedFormat::Text),
        "model/stl" | "model/x.stl-ascii" | "model/x.stl-binary" | "application/sla" | "application/vnd.ms-pki.stl" => {
            Some(NamedFormat::Stl)
        }
        "model/obj" | "application/wavefront-obj" => Some(NamedFormat::Obj),
        "model/ply" | "application/ply" => Some(NamedFormat::Ply),
        "model/3mf" | "application/vnd.ms-package.3dmanufacturing-3dmodel+xml" => Some(NamedFormat::ThreeMf),
        _ => None,
    }
}

fn by_name(name: &str) -> Option<NamedFormat> {
    let (_, extension) = name.rsplit_once('.')?;
    match extension.trim().to_ascii_lowercase().as_str() {
        "csv" | "tsv" | "txt" | "xyz" | "asc" | "dat" | "pts" | "pcd" => Some(NamedFormat::Text),
        "stl" | "stla" | "stlb" => Some(NamedFormat::Stl),
        "obj" => Some(NamedFormat::Obj),
        "ply" => Some(NamedFormat::Ply),
        "3mf" => Some(NamedFormat::ThreeMf),
        _ => None,
    }
}

/// The reader of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FormatFamily {
    Text,
    Pcd,
    StlAscii,
    StlBinary,
    Obj,
    Ply,
    ThreeMf,
}

/// The result of detection.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Detected {
    pub(super) format: FormatFamily,
    /// The length of a byte-order mark, which is not part of the text.
    pub(super) mark: usize,
}

/// Detects the format of a file that begins with `head`, which is its first [`HEAD`] bytes or the whole file. A file
/// with `is_decoded` was converted to UTF-8 and is text.
pub(super) fn detect(head: &[u8], hint: FormatHint, is_decoded: bool) -> Result<Detected, FileFault> {
    if head.is_empty() {
        return Err(Flaw::new(FileFaultKind::Empty, "a surface", "an empty file").at_byte(0));
    }
    if let Some((_, name)) = KNOWN_AT_START.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Err(unknown(*name).at_byte(0));
    }
    if crate::archive::Archive::is_archive(head) {
        return Ok(Detected { format: FormatFamily::ThreeMf, mark: 0 });
    }
    if is_utf_16(head) {
        return Err(unknown("UTF-16 text without a byte-order mark; save it as UTF-8").at_byte(0));
    }
    let mark = if head.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
    let text = &head[mark..];
    if let Some(format) = by_magic(text) {
        return Ok(Detected { format, mark });
    }
    if let Some(at) = control_byte(text) {
        return match hint.0 {
            Some(NamedFormat::Stl) if !is_decoded => Ok(Detected { format: FormatFamily::StlBinary, mark: 0 }),
            _ if !is_decoded && is_binary_stl(head) => Ok(Detected { format: FormatFamily::StlBinary, mark: 0 }),
            None => Err(unknown("a binary file of no known format").at_byte((mark + at) as u64)),
            Some(_) => {
                Err(unknown(format!("a file with the control byte {:#04x}, which is not text", text[at])).at_byte((mark + at) as u64))
            }
        };
    }
    if let Some(name) = by_statement(text) {
        return Err(unknown(name).at_byte(mark as u64));
    }
    Ok(Detected { format: by_first_statement(text, hint), mark })
}

fn unknown(found: impl Into<std::borrow::Cow<'static, str>>) -> Flaw {
    Flaw::new(FileFaultKind::UnknownFormat, EXPECTED, found)
}

/// Whether a file without a byte-order mark is text in UTF-16: text in the Latin alphabet then has a null byte in every
/// unit. A binary STL's header may have them too, but its numbers do not.
fn is_utf_16(head: &[u8]) -> bool {
    let every_second_null = |odd: usize| head.len() >= 4 && head.iter().skip(odd).step_by(2).all(|byte| *byte == 0);
    head.iter().any(|byte| *byte != 0) && (every_second_null(0) || every_second_null(1))
}

/// Whether a binary file is an STL: its length fits its count, or its first records contain plausible coordinates. A
/// file too short for one record is not.
fn is_binary_stl(head: &[u8]) -> bool {
    let Some((start, records)) = head.split_at_checked(84) else { return false };
    let count = start.last_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    if head.len() < HEAD && head.len() as u64 == 84 + 50 * u64::from(count) {
        return true;
    }
    // Coordinates of a part are between a fraction of a nanometre and 1e12; other bytes, read as numbers, have
    // exponents of all sizes.
    let is_plausible = |bytes: &[u8; 4]| {
        let size = f32::from_le_bytes(*bytes).abs();
        size == 0.0 || (1e-20..=1e12).contains(&size)
    };
    let (records, _) = records.as_chunks::<50>();
    let checked = records.iter().take(16);
    let plausible = checked.clone().filter(|record| record[12..48].as_chunks::<4>().0.iter().all(is_plausible)).count();
    plausible * 4 >= checked.len() * 3
}

/// PLY, PCD, and STL that begins as its specification requires.
fn by_magic(text: &[u8]) -> Option<FormatFamily> {
    if text.starts_with(b"ply") && text.get(3).is_some_and(u8::is_ascii_whitespace) {
        return Some(FormatFamily::Ply);
    }
    let mut statements = statements(text);
    let first = statements.next()?;
    if first.starts_with(b"# .PCD") || is_word(first, b"VERSION") {
        return Some(FormatFamily::Pcd);
    }
    if !is_word(first, b"solid") {
        return is_word(first, b"facet").then_some(FormatFamily::StlAscii);
    }
    // A binary STL's header may begin with `solid` too; then neither text nor a facet follows.
    match statements.next() {
        Some(second) if is_word(second, b"facet") || is_word(second, b"endsolid") => Some(FormatFamily::StlAscii),
        _ if control_byte(text).is_none() => Some(FormatFamily::StlAscii),
        _ => None,
    }
}

/// The position of the first control byte that a text does not have, among the first 134 bytes: the header of a binary
/// STL with 80 bytes, its count with 4, whose highest byte is a control byte for fewer than 150 million facets, and its
/// first record with 50. A control byte after these is a fault in a text.
///
/// Null bytes and Ctrl-Z at the end of a text of several lines do not count: old systems mark the end of a text with
/// them.
fn control_byte(text: &[u8]) -> Option<usize> {
    let is_end = |byte: &u8| matches!(byte, 0 | 0x1a);
    let content = &text[..text.iter().rposition(|byte| !is_end(byte)).map_or(0, |last| last + 1)];
    let text = if line_end(content).is_some() && text.len() != 84 { content } else { text };
    let is_control = |byte: &u8| *byte < b'\t' || *byte == 0x0b || (0x0e..b' ').contains(byte);
    text.iter().take(134).position(is_control)
}

/// The format of a text without a magic word.
fn by_first_statement(text: &[u8], hint: FormatHint) -> FormatFamily {
    let first = statements(text).find(|line| !line.starts_with(b"#") && !line.starts_with(b"//"));
    if first.is_some_and(is_obj) {
        return FormatFamily::Obj;
    }
    if first.is_some_and(|line| starts_number(line) || line[0] == b'"') {
        return FormatFamily::Text;
    }
    match hint.0 {
        None | Some(NamedFormat::Text | NamedFormat::ThreeMf) => FormatFamily::Text,
        Some(NamedFormat::Stl) => FormatFamily::StlAscii,
        Some(NamedFormat::Obj) => FormatFamily::Obj,
        Some(NamedFormat::Ply) => FormatFamily::Ply,
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

/// Formats by their first bytes.
const KNOWN_AT_START: [(&[u8], &str); 32] = [
    (b"version https://git-lfs", "a Git LFS pointer in place of the file; fetch the file itself with git lfs pull"),
    (b"\x1f\x8b", "a gzip archive inside the upload; send the file itself, or the whole request compressed"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive; send the file itself"),
    (b"Rar!\x1a\x07", "a RAR archive; send the file itself"),
    (b"BZh", "a bzip2 archive; send the file itself"),
    (b"\xfd7zXZ\0", "an xz archive; send the file itself"),
    (b"\x28\xb5\x2f\xfd", "a Zstandard archive; send the file itself"),
    (b"PK\x07\x08", "a part of a ZIP archive that is split over several files"),
    (b"ISO-10303-21", "a STEP file; export it as STL, 3MF or points"),
    (b"glTF", "a binary glTF file; export it as STL, OBJ, PLY or 3MF"),
    (b"AutoCAD Binary DXF", "a binary DXF file; export it as STL or 3MF"),
    (b"AC10", "a DWG file; export it as STL or 3MF"),
    (b"Kaydara FBX Binary", "an FBX file; export it as STL, OBJ or PLY"),
    (b"BLENDER", "a Blender file; export it as STL, OBJ or PLY"),
    (b"3D Geometry File Format", "a Rhino file; export it as STL, OBJ or 3MF"),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid file; export it as STL or 3MF"),
    (
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "an OLE document, as older Excel and SolidWorks write; export the surface as STL or the points as CSV",
    ),
    (b"%PDF", "a PDF file"),
    (b"\x89PNG", "a PNG image"),
    (b"\xff\xd8\xff", "a JPEG image"),
    (b"GIF8", "a GIF image"),
    (b"II*\0", "a TIFF image"),
    (b"MM\0*", "a TIFF image"),
    (b"RIFF", "a RIFF file, as WebP images are"),
    (b"LASF", "a LAS point cloud; export it as text, PLY or ASCII PCD"),
    (b"ASTM-E57", "an E57 point cloud; export it as text, PLY or ASCII PCD"),
    (b"\x89HDF\r\n\x1a\n", "an HDF5 file; export the points as CSV"),
    (b"\x93NUMPY", "a NumPy array; save the points with numpy.savetxt"),
    (b"SQLite format 3\0", "an SQLite database"),
    (b"\x7fELF", "a program"),
    (b"# vtk DataFile", "a VTK file; export it as STL or PLY"),
    (b"#VRML", "a VRML file; export it as STL, OBJ or PLY"),
];

/// Formats of text by their first statements.
fn by_statement(text: &[u8]) -> Option<&'static str> {
    let mut lines = statements(text);
    let first = lines.next()?;
    let second = lines.next().unwrap_or_default();
    let is_off = [b"OFF".as_slice(), b"COFF", b"NOFF", b"CNOFF", b"STOFF"].iter().any(|word| Words::of(first).next() == Some(word));
    match () {
        () if is_off && (first.len() <= 5 || Words::of(first).nth(1).is_some_and(starts_number)) => {
            Some("an OFF file; export it as STL, OBJ or PLY")
        }
        () if first == b"0" && second == b"SECTION" => Some("a DXF file; export it as STL or 3MF"),
        () if first == b"999" && statements(text).zip(statements(text).skip(1)).take(64).any(|pair| pair == (b"0", b"SECTION")) => {
            Some("a DXF file; export it as STL or 3MF")
        }
        () if is_iges(text) => Some("an IGES file; export it as STL, 3MF or points"),
        () if first[0] == b'{' && memchr::memmem::find(text, b"\"asset\"").is_some() => {
            Some("a glTF file; export it as STL, OBJ, PLY or 3MF")
        }
        () if first[0] == b'{' => Some("JSON; send it to the operation that takes JSON"),
        () if first[0] == b'<' => Some(markup(text)),
        () if is_word(first, b"ncols") => Some("an ESRI ASCII grid of heights; send points x, y, z"),
        () if first == b"DSAA" || first == b"DSBB" => Some("a Surfer grid of heights; send points x, y, z"),
        () if is_gcode(text) => Some("G-code; send the surface, not the program that mills it"),
        () => None,
    }
}

/// A line of IGES has 80 columns. The 73rd is the letter of the section, S in the first line, and the columns after it
/// are the line's number.
fn is_iges(text: &[u8]) -> bool {
    let line = &text[..line_end(text).unwrap_or(text.len())];
    line.len() == 80 && line[72] == b'S' && line[73..].iter().all(|byte| matches!(byte, b' ' | b'0'..=b'9'))
}

fn markup(text: &[u8]) -> &'static str {
    let start = text[..text.len().min(4096)].to_ascii_lowercase();
    let is_page = [b"<html".as_slice(), b"<!doctype html", b"<head>"].iter().any(|tag| memchr::memmem::find(&start, tag).is_some());
    if is_page {
        return "an HTML page, such as a server's error or sign-in page in place of the file";
    }
    let names: [(&[u8], &str); 4] = [
        (b"<amf", "an AMF file; export it as STL or 3MF"),
        (b"<COLLADA", "a COLLADA file; export it as STL, OBJ or PLY"),
        (b"<X3D", "an X3D file; export it as STL, OBJ or PLY"),
        (b"<svg", "an SVG image"),
    ];
    names.into_iter().find(|(tag, _)| memchr::memmem::find(text, tag).is_some()).map_or("an XML file", |(_, name)| name)
}

/// Whether the text is a program in G-code: its first statement is a word such as G21, with or without a block number.
/// `%`, comments and the program number O may come before it.
fn is_gcode(text: &[u8]) -> bool {
    let is_numbered = |word: &[u8], letter: u8| {
        word.len() >= 2 && word[0].eq_ignore_ascii_case(&letter) && word[1..].iter().all(|byte| byte.is_ascii_digit() || *byte == b'.')
    };
    let is_block = |line: &[u8]| {
        let mut words = Words::of(line).peekable();
        words.next_if(|word| is_numbered(word, b'N'));
        words.next().is_some_and(|word| {
            // Words may follow each other without blanks, as in G21G90.
            let end = word[1..].iter().position(u8::is_ascii_alphabetic).map_or(word.len(), |at| at + 1);
            [b'G', b'M', b'T'].into_iter().any(|letter| is_numbered(&word[..end], letter))
        }) && !line.iter().any(|byte| matches!(byte, b',' | b'\t'))
    };
    let is_skipped = |line: &[u8]| line == b"%" || matches!(line[0], b'(' | b';') || is_numbered(line, b'O');
    let first = statements(text).take(1000).find(|line| !is_skipped(line));
    first.is_some_and(is_block) || statements(text).next() == Some(b"%")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn family(head: &[u8], name: &str) -> FormatFamily {
        detect(head, FormatHint::new(None, Some(name)), false).unwrap().format
    }

    fn binary_stl(header: &[u8]) -> Vec<u8> {
        let mut file = header.to_vec();
        file.resize(80, b' ');
        file.extend(1_u32.to_le_bytes());
        file.resize(134, 0);
        file
    }

    #[test]
    fn content_takes_precedence_over_the_name() {
        assert_eq!(family(b"1;2;3\n", "part.stl"), FormatFamily::Text);
        assert_eq!(family(b"\xef\xbb\xbf-1 2 3\n", "part.obj"), FormatFamily::Text);
        assert_eq!(family(b"# a comment\n\nv 1 2 3\n", "points.csv"), FormatFamily::Obj);
        assert_eq!(family(b"ply\r\nformat", "points.txt"), FormatFamily::Ply);
        assert_eq!(family(b"\n  SOLID part\n facet", "points.txt"), FormatFamily::StlAscii);
        assert_eq!(family(&binary_stl(b"made somewhere"), "part"), FormatFamily::StlBinary);
    }

    #[test]
    fn a_binary_stl_may_begin_with_solid() {
        assert_eq!(family(&binary_stl(b"solid part"), "part.stl"), FormatFamily::StlBinary);
        assert_eq!(family(&binary_stl(b"solid part\nof ours"), ""), FormatFamily::StlBinary);
        assert_eq!(family(b"solid \x01part\r\n\r\nFACET normal", ""), FormatFamily::StlAscii);
        assert_eq!(family(b"solid", ""), FormatFamily::StlAscii);
    }

    #[test]
    fn the_name_decides_if_the_content_is_ambiguous() {
        assert_eq!(family(b"hello\n", "part.STL"), FormatFamily::StlAscii);
        assert_eq!(family(b"# nothing\n", "part.obj"), FormatFamily::Obj);
        assert_eq!(family(b"hello\n", "part.ply"), FormatFamily::Ply);
        assert_eq!(family(b"X Y Z\n", "part"), FormatFamily::Text);
    }

    #[test]
    fn the_media_type_takes_precedence_over_the_file_name() {
        assert_eq!(FormatHint::new(Some("Model/STL; charset=x"), Some("a.obj")), FormatHint(Some(NamedFormat::Stl)));
        assert_eq!(FormatHint::new(Some("text/plain"), Some("a.b.OBJ")), FormatHint(Some(NamedFormat::Obj)));
        assert_eq!(FormatHint::new(Some("application/octet-stream"), Some("obj")), FormatHint(None));
        assert_eq!(FormatHint::new(None, None), FormatHint::default());
    }

    #[test]
    fn a_binary_file_is_an_stl_by_its_length_or_its_numbers() {
        let noise: Vec<u8> = (0..2000_u32).map(|index| (index.wrapping_mul(2_654_435_761) >> 24) as u8).collect();
        assert!(detect(&noise, FormatHint::default(), false).is_err());
        assert_eq!(family(&noise, "a.stl"), FormatFamily::StlBinary);
        assert_eq!(family(&[binary_stl(b"longer"), b"and more".to_vec()].concat(), "a"), FormatFamily::StlBinary);
        for name in ["part.stl.txt", "part.obj", "part.csv", "part.3mf", "part.ply", "part.bin", "part"] {
            assert_eq!(family(&binary_stl(b"Exported from somewhere"), name), FormatFamily::StlBinary, "{name}");
        }
    }

    #[test]
    fn columns_named_like_obj_statements_are_columns() {
        assert_eq!(family(b"v x y z\n1 2 3 4\n", ""), FormatFamily::Text);
        assert_eq!(family(b"s,x,y,z\n", ""), FormatFamily::Text);
    }

    #[test]
    fn formats_that_are_not_read_are_named() {
        for (head, word) in [
            (&b"1\0,\x002\0"[..], "UTF-16"),
            (b"\x001\0,\x002", "UTF-16"),
            (b"\x1f\x8b\x08", "gzip"),
            (b"7z\xbc\xaf\x27\x1c\0\x04", "7z"),
            (b"ISO-10303-21;", "STEP"),
            (b"OFF\n8 6 12\n", "OFF"),
            (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "DXF"),
            (b"999\nmade by us\n0\nSECTION\n", "DXF"),
            (b"                                                                        S      1\n", "IGES"),
            (b"{\"scene\": 0, \"asset\": {\"version\": \"2.0\"}}", "glTF"),
            (b"glTF\x02\0\0\0", "glTF"),
            (b"%\nO1000 (PART)\nG21\n", "G-code"),
            (b"(made by us)\nN10 G21 G90\n", "G-code"),
            (b"; made by us\nG21G90\n", "G-code"),
            (b"\x89PNG\r\n\x1a\n", "PNG"),
            (b"\xff\xd8\xff\xe0", "JPEG"),
            (b"%PDF-1.7", "PDF"),
            (b"<?xml version=\"1.0\"?>\n<COLLADA>", "COLLADA"),
            (b"ncols 4\nnrows 6\n", "ESRI"),
            (b"\x01\x02\x03\x04", "binary file"),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n", "Git LFS pointer"),
            (b"<!doctype HTML>\n<title>404</title>", "HTML page"),
            (b"\n\n<HTML lang=\"de\"><body>", "HTML page"),
            (b"<!-- an error --><html>", "HTML page"),
            (b"<?xml version=\"1.0\"?><!DOCTYPE html PUBLIC \"-//W3C//DTD XHTML 1.0\">", "HTML page"),
            (b"<head><title>Sign in</title></head>", "HTML page"),
        ] {
            let fault = detect(head, FormatHint::default(), false).unwrap_err();
            assert_eq!(fault.kind(), FileFaultKind::UnknownFormat);
            assert!(fault.found().contains(word), "{fault}");
        }
        let fault = detect(b"1,2,3\n1,\x002,3\n", FormatHint::new(None, Some("a.csv")), false).unwrap_err();
        let sentence =
            "byte 8: expected points in text, PCD, STL, OBJ, PLY or 3MF, found a file with the control byte 0x00, which is not text";
        assert_eq!(fault.to_string(), sentence);
        assert_eq!(detect(b"", FormatHint::default(), false).unwrap_err().kind(), FileFaultKind::Empty);
    }
}
