//! Files that would take far more memory or time than their size.

use super::*;

/// A source that delivers a head and then the same part again and again, and counts the bytes.
struct Endless<'a> {
    head: &'a [u8],
    part: &'a [u8],
    delivered: usize,
}

impl Read for Endless<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        assert!(self.delivered < 100_000_000, "100 MB have been taken");
        let mut rest = if self.head.is_empty() { self.part } else { std::mem::take(&mut self.head) };
        let read = rest.read(buffer)?;
        self.delivered += read;
        Ok(read)
    }
}

/// Reads an endless file until it is refused; returns the number of bytes taken and the fault.
fn refused_after(head: &[u8], part: &[u8], name: &str) -> (usize, FileFault) {
    let mut source = Endless { head, part, delivered: 0 };
    let result = Reader::new(FormatHint::new(None, Some(name))).read(&mut source, &mut Recorder::default());
    (source.delivered, fault(result.unwrap_err()))
}

#[test]
fn a_line_of_100_mb_is_refused_as_soon_as_it_is_too_long() {
    for (head, name, line) in [
        ("1 2 3\n", "a.csv", 2),
        ("# ", "a.csv", 1),
        ("solid part\n", "a.stl", 2),
        ("v 0 0 0\nf", "a.obj", 2),
        ("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n", "a.ply", 8),
    ] {
        let (bytes, fault) = refused_after(head.as_bytes(), &[b' '; 1000], name);
        assert!(bytes <= 2 * (1 << 16) + 2000, "{bytes} bytes were taken of {head:?}");
        assert_eq!(fault.kind(), FileFaultKind::TooLarge);
        assert_eq!(fault.to_string(), format!("line {line}: expected at most 65536 bytes in a line, found a longer one"));
    }
}

#[test]
fn a_statement_of_endless_lines_is_refused() {
    let (bytes, fault) = refused_after(b"v 0 0 0\nf ", b"1 1 1 1 \\\n", "a.obj");
    assert!(bytes < 3 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "at most 65536 bytes in a line");
}

#[test]
fn an_endless_header_is_refused() {
    let (bytes, fault) = refused_after(b"ply\nformat ascii 1.0\n", b"comment on and on\n", "a.ply");
    assert!(bytes < 2 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "a header of at most 65536 bytes");
}

#[test]
fn an_endless_face_is_refused() {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty uchar x\nproperty uchar y\nproperty uchar z\nelement face 1\nproperty list uint uchar vertex_index\nend_header\nabc";
    let head = [head.as_bytes(), &u32::MAX.to_le_bytes()].concat();
    let (bytes, fault) = refused_after(&head, &[0; 1000], "a.ply");
    assert!(bytes < 2 * (1 << 16), "{bytes}");
    assert_eq!(fault.expected(), "at most 65536 corners in a face");
}

#[test]
fn a_list_of_four_billion_numbers_is_skipped_up_to_the_end_of_the_file() {
    let head = "ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty list uint double w\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    let file = [head.as_bytes(), &[0xff; 4], &[0; 5000]].concat();
    let sentence =
        format!("byte {}: expected 1 rows of the element \"vertex\", as the header says, found the end of the file after 0", file.len());
    assert_eq!(refusal(file), sentence);
}

#[test]
fn vertices_are_limited() {
    let ply = |count: usize| {
        let head = format!(
            "ply\nformat ascii 1.0\nelement vertex {count}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
        );
        format!("{head}{}3 0 1 2\n", "0 0 0\n".repeat(count))
    };
    let obj = |count: usize| format!("{}f 1 2 3\n", "v 0 0 0\n".repeat(count));
    let result = |file: String| {
        let reader = Reader::new(FormatHint::default()).with_vertex_limit(10);
        reader.read(file.as_bytes(), &mut Recorder::default()).map(|summary| summary.facets).map_err(fault)
    };
    for file in [ply(10), obj(10)] {
        assert_eq!(result(file), Ok(1));
    }
    for (file, line) in [(ply(11), 9), (obj(11), 11)] {
        assert_eq!(result(file).unwrap_err().to_string(), format!("line {line}: expected at most 10 vertices, found more"));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn stated_counts_take_no_memory() {
    let pages = || -> u64 {
        let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
        statm.split_whitespace().next().unwrap().parse().unwrap()
    };
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 20000000\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\nproperty list uint int vertex_index\nend_header\n";
    let stl = [&[0; 80][..], &[0xff; 4], &[0; 50]].concat();
    // More than the 64 KiB that determine the format, so that the bodies are being read.
    let padding = vec![0; 1 << 17];
    for file in [[head.as_bytes(), &padding].concat(), [&stl, &padding[..]].concat()] {
        let before = pages();
        let measure = || assert!(pages() < before + (128 << 20) / 4096, "more than 128 MiB for a count");
        let result = Reader::new(FormatHint::default()).read(AtEnd(&file, measure), &mut Nothing);
        assert_eq!(fault(result.unwrap_err()).kind(), FileFaultKind::Truncated);
    }
}

/// A source that calls a function at its end.
struct AtEnd<'a, F>(&'a [u8], F);

impl<F: FnMut()> Read for AtEnd<'_, F> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.0.is_empty() {
            self.1();
        }
        self.0.read(buffer)
    }
}

/// A sink that drops all.
struct Nothing;

impl Sink for Nothing {
    fn point(&mut self, _: [f64; 3]) {}
    fn facet(&mut self, _: [[f64; 3]; 3]) {}
}

#[test]
fn an_empty_file_is_refused() {
    assert_eq!(refusal(""), "byte 0: expected a surface, found an empty file");
}
