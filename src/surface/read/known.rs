//! Formats that are not read, and are detected only to name them in the fault.

use super::words::{Words, is_word, line_end, starts_number, statements};

/// Formats by their first bytes.
pub(super) const KNOWN_AT_START: [(&[u8], &str); 32] = [
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
pub(super) fn by_statement(text: &[u8]) -> Option<&'static str> {
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
