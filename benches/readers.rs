//! Measures the speed of the readers on one core, compared with adding up the same bytes:
//! `cargo bench --bench readers [facets]`.
//!
//! Every file has the same surface, a million facets unless stated otherwise (text: their vertices twice), and arrives
//! in chunks of 64 KiB. The shortest of several times is printed, because other work on the machine can only make it
//! longer.
//!
//! The second table has the service's reading, in blocks of a megabyte on two threads, with the sums, and with facets
//! welded and merged or points thinned beyond 500,000 of them: the least processor time of both threads. "sums" leaves
//! out welding, "blocks" leaves out both.

use rayon::ThreadPoolBuilder;
use scallopd::surface::read::{FormatHint, Reader};
use scallopd::surface::{MeshBuilder, MeshPart, PartedSink, SampledSurface, Sink};
use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

const CHUNK: usize = 1 << 16;
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

impl PartedSink for Sum {
    type Part = Self;

    fn part(&self) -> Self {
        Self::default()
    }

    fn append(&mut self, part: Self) {
        self.point(part.0);
    }
}

/// The sums of the service, and the mesh if it is wanted; of the whole file or of a part.
#[derive(Default)]
struct Received<M> {
    sampled: SampledSurface,
    mesh: Option<M>,
}

impl<M: Sink> Sink for Received<M> {
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

impl PartedSink for Received<MeshBuilder> {
    type Part = Received<MeshPart>;

    fn part(&self) -> Received<MeshPart> {
        Received { sampled: SampledSurface::new(), mesh: self.mesh.as_ref().map(MeshBuilder::part) }
    }

    fn append(&mut self, part: Received<MeshPart>) {
        self.sampled.merge(&part.sampled);
        if let (Some(mesh), Some(part)) = (&mut self.mesh, part.mesh) {
            mesh.append(part);
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

/// The processor time of this process, in s.
fn processor_seconds() -> f64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    #[allow(clippy::cast_precision_loss, reason = "far below 2^53")]
    let seconds = now.tv_sec as f64 + 1e-9 * now.tv_nsec as f64;
    seconds
}

/// The least processor time and the shortest time that `run` takes, in s.
fn least(run: impl Fn()) -> [f64; 2] {
    let once = || {
        let (processor, start) = (processor_seconds(), Instant::now());
        run();
        [processor_seconds() - processor, start.elapsed().as_secs_f64()]
    };
    (0..REPETITIONS).map(|_| once()).fold([f64::INFINITY; 2], |least, [processor, time]| [least[0].min(processor), least[1].min(time)])
}

/// Reads a file as the service does, into a sink.
fn read_in_blocks<S: PartedSink>(file: &[u8], mut sink: S) {
    let mut reader = Reader::new(FormatHint::default());
    for some in file.chunks(CHUNK).collect::<Vec<_>>().chunks(16) {
        reader.push_in_parallel(some.iter().copied(), &mut sink).expect("a good file");
    }
    black_box(reader.finish(&mut sink).expect("a good file"));
    black_box(&mut sink);
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

fn read(file: &[u8]) {
    let mut reader = Reader::new(FormatHint::default());
    let mut sum = Sum::default();
    for chunk in file.chunks(CHUNK) {
        reader.push(chunk, &mut sum).expect("the file is clean");
    }
    reader.finish(&mut sum).expect("the file is whole");
    black_box(sum.0);
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
    println!("{:16} {:>8} {:>10} {:>14} {:>8}", "", "MB", "read MB/s", "sum bytes MB/s", "ratio");
    for (name, file) in &files {
        let (reading, adding) = (best(|| read(file)), best(|| add_bytes(file)));
        let megabytes = megabytes(file);
        println!("{name:16} {megabytes:8.1} {:10.0} {:14.0} {:8.1}", megabytes / reading, megabytes / adding, reading / adding);
    }
    let pool = ThreadPoolBuilder::new().num_threads(2).build().expect("two threads");
    println!("\n{:16} {:>10} {:>10} {:>10} {:>12}", "processor ms", "blocks", "sums", "welded", "welded MB/s");
    for (name, file) in &files {
        let (blocks, sums, welded) = pool.install(|| {
            let welding = || Received { mesh: Some(MeshBuilder::with_facet_limit(500_000)), ..Received::default() };
            let blocks = least(|| read_in_blocks(file, Sum::default()));
            (blocks, least(|| read_in_blocks(file, Received::default())), least(|| read_in_blocks(file, welding())))
        });
        let ms = |[processor, _]: [f64; 2]| 1e3 * processor;
        println!("{name:16} {:10.1} {:10.1} {:10.1} {:12.0}", ms(blocks), ms(sums), ms(welded), megabytes(file) / welded[1]);
    }
}

#[allow(clippy::cast_precision_loss, reason = "far below 2^53")]
fn megabytes(file: &[u8]) -> f64 {
    file.len() as f64 / 1e6
}
