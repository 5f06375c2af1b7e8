//! Writes a wavy surface to a file, in the formats and sizes that `benches/uploads` sends:
//! `surface_file FORMAT COUNT FILE`.
//!
//! COUNT is the number of points for `csv` and `json`, of facets for the others. Coordinates have four decimals (0.1
//! um) in text, seven digits in ASCII STL, as CAD systems write it, and single precision in binary files.

use std::fs::File;
use std::io::{BufWriter, Error, Result, Write};

fn main() -> Result<()> {
    let [_, format, count, path] = &std::env::args().collect::<Vec<_>>()[..] else {
        return Err(Error::other("three arguments are expected: format, count, file"));
    };
    let count = count.parse().map_err(Error::other)?;
    let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
    match format.as_str() {
        "csv" => csv(&mut file, count),
        "json" => json(&mut file, count),
        "stl" => binary_stl(&mut file, count),
        "ascii-stl" => ascii_stl(&mut file, count),
        "ply" => ply(&mut file, count),
        "obj" => obj(&mut file, count),
        _ => Err(Error::other("known formats: csv, json, stl, ascii-stl, ply, obj")),
    }?;
    file.flush()
}

/// Vertices in rows, as many rows as columns.
struct Grid {
    side: u32,
}

impl Grid {
    /// A grid of at least `facets` triangles, two to a quad.
    fn of_facets(facets: u32) -> Self {
        let mut side = 2;
        while u64::from(side - 1) * u64::from(side - 1) * 2 < u64::from(facets) {
            side += 1;
        }
        Self { side }
    }

    fn vertices(&self) -> impl Iterator<Item = [f64; 3]> {
        let side = self.side;
        (0..side).flat_map(move |row| (0..side).map(move |column| at(row, column)))
    }

    /// Triangles as rows and columns of their corners.
    fn triangles(&self) -> impl Iterator<Item = [[u32; 2]; 3]> {
        let quads = self.side - 1;
        (0..quads).flat_map(move |row| (0..quads).map(move |column| (row, column))).flat_map(|(row, column)| {
            let [a, b, c, d] = [[row, column], [row, column + 1], [row + 1, column + 1], [row + 1, column]];
            [[a, b, c], [a, c, d]]
        })
    }

    fn number(&self, [row, column]: [u32; 2]) -> u32 {
        row * self.side + column
    }
}

fn at(row: u32, column: u32) -> [f64; 3] {
    let (x, y) = (f64::from(column) * 0.137, f64::from(row) * 0.0731);
    [x, y, (0.03 * x).sin() * 20.0 + (0.02 * y).cos() * 7.0]
}

fn points(count: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..count).map(|index| at(index / 4000, index % 4000))
}

fn csv(file: &mut impl Write, count: u32) -> Result<()> {
    writeln!(file, "x,y,z")?;
    points(count).try_for_each(|[x, y, z]| writeln!(file, "{x:.4},{y:.4},{z:.4}"))
}

/// The points only, without the other members of a request.
fn json(file: &mut impl Write, count: u32) -> Result<()> {
    for (index, [x, y, z]) in points(count).enumerate() {
        write!(file, "{}[{x:.4},{y:.4},{z:.4}]", if index == 0 { "[" } else { "," })?;
    }
    write!(file, "]")
}

fn binary_stl(file: &mut impl Write, count: u32) -> Result<()> {
    file.write_all(&[0; 80])?;
    file.write_all(&count.to_le_bytes())?;
    for triangle in Grid::of_facets(count).triangles().take(count as usize) {
        file.write_all(&[0; 12])?;
        triangle.iter().try_for_each(|[row, column]| write_single(file, at(*row, *column)))?;
        file.write_all(&[0; 2])?;
    }
    Ok(())
}

fn ascii_stl(file: &mut impl Write, count: u32) -> Result<()> {
    writeln!(file, "solid wave")?;
    for triangle in Grid::of_facets(count).triangles().take(count as usize) {
        writeln!(file, "  facet normal 0.000000e+00 0.000000e+00 1.000000e+00\n    outer loop")?;
        for [x, y, z] in triangle.map(|[row, column]| at(row, column)) {
            writeln!(file, "      vertex {x:.6e} {y:.6e} {z:.6e}")?;
        }
        writeln!(file, "    endloop\n  endfacet")?;
    }
    writeln!(file, "endsolid wave")
}

fn ply(file: &mut impl Write, count: u32) -> Result<()> {
    let grid = Grid::of_facets(count);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {count}\nproperty list uchar int vertex_indices\nend_header\n",
        grid.side * grid.side
    )?;
    grid.vertices().try_for_each(|vertex| write_single(file, vertex))?;
    for triangle in grid.triangles().take(count as usize) {
        file.write_all(&[3])?;
        triangle.iter().try_for_each(|corner| file.write_all(&grid.number(*corner).to_le_bytes()))?;
    }
    Ok(())
}

fn obj(file: &mut impl Write, count: u32) -> Result<()> {
    let grid = Grid::of_facets(count);
    grid.vertices().try_for_each(|[x, y, z]| writeln!(file, "v {x:.4} {y:.4} {z:.4}"))?;
    for triangle in grid.triangles().take(count as usize) {
        let [a, b, c] = triangle.map(|corner| grid.number(corner) + 1);
        writeln!(file, "f {a} {b} {c}")?;
    }
    Ok(())
}

#[allow(clippy::cast_possible_truncation, reason = "to single precision")]
fn write_single(file: &mut impl Write, vertex: [f64; 3]) -> Result<()> {
    vertex.into_iter().try_for_each(|value| file.write_all(&(value as f32).to_le_bytes()))
}
