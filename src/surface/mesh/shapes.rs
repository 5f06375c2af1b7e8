//! Surfaces for the tests of this module and of its parent.

use super::{FinishFacet, Mesh, MeshBuilder, Selection};
use crate::quantity::Angle;
use crate::surface::{Facing, Grid, Sink, Unit};

/// A grid of `rows` x `columns` points, u and v from 0 to 1.
pub(super) fn grid(rows: u32, columns: u32, at: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut grid = Grid::into_sink(rows as usize, columns as usize, MeshBuilder::new()).unwrap();
    for row in 0..rows {
        for column in 0..columns {
            grid.point(at(f64::from(column) / f64::from(columns - 1), f64::from(row) / f64::from(rows - 1)));
        }
    }
    grid.finish().unwrap().finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
}

/// A closed box, each side two triangles that face outwards.
pub(in crate::surface) fn solid_box(min: [f64; 3], max: [f64; 3]) -> Vec<[[f64; 3]; 3]> {
    let at = |x: usize, y: usize, z: usize| [[min[0], max[0]][x], [min[1], max[1]][y], [min[2], max[2]][z]];
    let quad = |a, b, c, d| [[a, b, c], [a, c, d]];
    [
        quad(at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)),
        quad(at(0, 0, 0), at(0, 1, 0), at(1, 1, 0), at(1, 0, 0)),
        quad(at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)),
        quad(at(0, 1, 0), at(0, 1, 1), at(1, 1, 1), at(1, 1, 0)),
        quad(at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)),
        quad(at(1, 0, 0), at(1, 1, 0), at(1, 1, 1), at(1, 0, 1)),
    ]
    .concat()
}

pub(super) fn mesh(facets: &[[[f64; 3]; 3]]) -> Mesh {
    let mut builder = MeshBuilder::new();
    for &facet in facets {
        builder.facet(facet);
    }
    builder.finish(Unit::Millimetre, Facing::Up, &|| false).unwrap()
}

pub(super) fn degrees(value: f64) -> Angle {
    Angle::from_degrees(value).unwrap()
}

/// All facets visible from above, up to 85 deg.
pub(super) fn finish_facets(mesh: &Mesh) -> Vec<FinishFacet> {
    let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false)).unwrap();
    mesh.facets_for_finishing(&mesh.visibility(degrees(85.0), &|| false), &selected, &|| false)
}

/// Pseudo-random numbers from 0 to 1 (Knuth's multiplier).
pub(super) fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        #[allow(clippy::cast_precision_loss)]
        let value = (state >> 11) as f64 / (1_u64 << 53) as f64;
        value
    }
}
