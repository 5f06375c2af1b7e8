//! Measures the speed of the readers on one core, compared with adding up the same bytes:
//! `cargo bench --bench readers [facets]`.
//!
//! Every file has the same surface, a million facets unless stated otherwise (text: their vertices twice). The shortest
//! of several times is printed, because other work on the machine can only make it longer. "sums" adds the sums of the
//! service, and "welded" also its mesh, with facets merged or points thinned beyond 500,000 of them.

use scallopd::surface::read::{FormatHint, Reader};
use scallopd::surface::{MeshBuilder, SampledSurface, Sink};
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const REPETITIONS: usize = 9;

/// Adds up the coordinates, so that the compiler cannot omit any.
#[derive(Default)]
struct Sum([f64; 3]);

impl Sink for Sum {
    fn point(&mut self, point: [f64; 3]) {
        self.0 = [self.0[0] + point[0], self.0[1] + point[1], self.0[2] + point[2]];
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        for corner in corners {
            self.point(corner);
        }
    }
}

/// The sums of the service, and the mesh if it is wanted.
#[derive(Default)]
struct Received {
    sampled: SampledSurface,
    mesh: Option<MeshBuilder>,
}

impl Sink for Received {
    fn point(&mut self, point: [f64; 3]) {
        self.sampled.point(point);
        if let Some(mesh) = &mut self.mesh {
            mesh.point(point);
        }
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        self.sampled.facet(corners);
        if let Some(mesh) = &mut self.mesh {
            mesh.facet(corners);
        }
    }
}

/// A wavy surface: vertices in rows, triangles by number.
struct Surface {
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Surface {
    fn of(facets: u32) -> Self {
        let side = (f64::from(facets) / 2.0).sqrt().ceil() + 1.0;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a root of 32 bits")]
        let side = side as u32;
        let vertex = |row: u32, column: u32| {
            let (x, y) = (f64::from(column) * 0.137, f64::from(row) * 0.0731);
            [x, y, (0.03 * x).sin() * 20.0 + (0.02 * y).cos() * 7.0]
        };
        let vertices = (0..side).flat_map(|row| (0..side).map(move |column| vertex(row, column))).collect();
        let number = |row: u32, column: u32| (row * side + column) as usize;
        let quads = (1..side).flat_map(|row| (1..side).map(move |column| (row, column)));
        let triangles = quads.flat_map(|(row, column)| {
            let [a, b, c, d] = [number(row - 1, column - 1), number(row - 1, column), number(row, column), number(row, column - 1)];
            [[a, b, c], [a, c, d]]
        });
        Self { vertices, triangles: triangles.collect() }
    }

    fn text(&self, line: impl Fn(&mut String, &[f64; 3])) -> Vec<u8> {
        let mut file = String::new();
        self.vertices.iter().chain(&self.vertices).for_each(|vertex| line(&mut file, vertex));
        file.into_bytes()
    }

    fn ascii_stl(&self) -> Vec<u8> {
        let mut file = "solid\n".to_owned();
        for triangle in &self.triangles {
            file += "  facet normal 0.000000e+00 0.000000e+00 1.000000e+00\n    outer loop\n";
            for [x, y, z] in triangle.map(|vertex| self.vertices[vertex]) {
                let _ = writeln!(file, "      vertex {x:.6e} {y:.6e} {z:.6e}");
            }
            file += "    endloop\n  endfacet\n";
        }
        (file + "endsolid\n").into_bytes()
    }

    fn binary_stl(&self) -> Vec<u8> {
        let mut file = vec![0; 80];
        file.extend(u32::try_from(self.triangles.len()).unwrap_or(u32::MAX).to_le_bytes());
        for triangle in &self.triangles {
            file.extend([0; 12]);
            file.extend(triangle.iter().flat_map(|vertex| single(self.vertices[*vertex])));
            file.extend([0; 2]);
        }
        file
    }

    fn obj(&self) -> Vec<u8> {
        let mut file = String::new();
        for [x, y, z] in &self.vertices {
            let _ = writeln!(file, "v {x:.6} {y:.6} {z:.6}");
        }
        for [a, b, c] in self.triangles.iter().map(|triangle| triangle.map(|vertex| vertex + 1)) {
            let _ = writeln!(file, "f {a} {b} {c}");
        }
        file.into_bytes()
    }

    fn ply_header(&self, encoding: &str) -> String {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.vertices.len(),
            self.triangles.len()
        )
    }

    fn ascii_ply(&self) -> Vec<u8> {
        let mut file = self.ply_header("ascii");
        for [x, y, z] in &self.vertices {
            let _ = writeln!(file, "{x:.6} {y:.6} {z:.6}");
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(file, "3 {a} {b} {c}");
        }
        file.into_bytes()
    }

    fn binary_ply(&self) -> Vec<u8> {
        let mut file = self.ply_header("binary_little_endian").into_bytes();
        file.extend(self.vertices.iter().flat_map(|vertex| single(*vertex)));
        let index = |vertex: &usize| u32::try_from(*vertex).unwrap_or(u32::MAX).to_le_bytes();
        self.triangles.iter().for_each(|triangle| file.extend([3].into_iter().chain(triangle.iter().flat_map(index))));
        file
    }
}

#[allow(clippy::cast_possible_truncation, reason = "to single precision")]
fn single(vertex: [f64; 3]) -> impl Iterator<Item = u8> {
    vertex.into_iter().flat_map(|value| (value as f32).to_le_bytes())
}

/// The shortest time that `run` takes, in seconds.
fn best(run: impl Fn()) -> f64 {
    let once = || {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64()
    };
    (0..REPETITIONS).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn read(file: &[u8], mut sink: impl Sink) {
    black_box(Reader::new(FormatHint::default()).read(file, &mut sink).expect("a good file"));
    black_box(&mut sink);
}

/// Reads every byte without parsing, as the upper limit of the machine's speed.
fn add_bytes(file: &[u8]) {
    black_box(file.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)));
}

fn main() {
    let facets = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(1_000_000);
    let surface = Surface::of(facets);
    let files: [(&str, &dyn Fn() -> Vec<u8>); 8] = [
        ("CSV, 4 decimals", &|| surface.text(|file, [x, y, z]| _ = writeln!(file, "{x:.4},{y:.4},{z:.4}"))),
        ("CSV, 17 digits", &|| surface.text(|file, [x, y, z]| _ = writeln!(file, "{x},{y},{z}"))),
        ("XYZ, %.18e", &|| surface.text(|file, [x, y, z]| _ = writeln!(file, "{x:.18e} {y:.18e} {z:.18e}"))),
        ("ASCII STL", &|| surface.ascii_stl()),
        ("binary STL", &|| surface.binary_stl()),
        ("OBJ", &|| surface.obj()),
        ("ASCII PLY", &|| surface.ascii_ply()),
        ("binary PLY", &|| surface.binary_ply()),
    ];
    let files = files.map(|(name, file)| (name, file()));
    println!("{:16} {:>8} {:>10} {:>10} {:>10} {:>14}", "MB/s", "MB", "read", "sums", "welded", "sum of bytes");
    for (name, file) in &files {
        let welding = || Received { mesh: Some(MeshBuilder::with_facet_limit(500_000)), ..Received::default() };
        let times = [
            best(|| read(file, Sum::default())),
            best(|| read(file, Received::default())),
            best(|| read(file, welding())),
            best(|| add_bytes(file)),
        ];
        let megabytes = megabytes(file);
        let [reading, sums, welded, adding] = times.map(|time| megabytes / time);
        println!("{name:16} {megabytes:8.1} {reading:10.0} {sums:10.0} {welded:10.0} {adding:14.0}");
    }
}

#[allow(clippy::cast_precision_loss, reason = "far below 2^53")]
fn megabytes(file: &[u8]) -> f64 {
    file.len() as f64 / 1e6
}
