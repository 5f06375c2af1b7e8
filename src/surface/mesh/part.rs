//! A part of a surface that is welded independently, so that several threads can weld parts at the same time.

use super::cross;
use super::weld::Welder;
use crate::surface::{Bounds, LARGEST_COORDINATE, Sink};

/// The facets or points of a part of a surface, for [`MeshBuilder::append`](super::MeshBuilder::append). Corners with
/// equal coordinates become one point, and facets without area are counted and left out, as in the whole mesh.
#[derive(Debug)]
pub struct MeshPart {
    pub(super) welder: Welder,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) degenerate: u64,
    pub(super) bounds: Bounds,
    pub(super) out_of_range: bool,
    /// Points that are not part of a facet.
    pub(super) points: Vec<[f64; 3]>,
}

impl Default for MeshPart {
    fn default() -> Self {
        Self { welder: Welder::new(), triangles: Vec::new(), degenerate: 0, bounds: Bounds::NONE, out_of_range: false, points: Vec::new() }
    }
}

impl Sink for MeshPart {
    fn point(&mut self, point: [f64; 3]) {
        if in_range(point) {
            self.points.push(point);
        } else {
            self.out_of_range = true;
        }
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        if !corners.into_iter().all(in_range) {
            self.out_of_range = true;
            return;
        }
        let [a, b, c] = corners;
        let [x, y, z] = cross(a, b, c);
        if x == 0.0 && y == 0.0 && z == 0.0 {
            self.degenerate += 1;
            return;
        }
        for corner in corners {
            self.bounds.include(corner);
        }
        let triangle = corners.map(|corner| self.welder.index(corner));
        self.triangles.push(triangle);
    }
}

/// Whether all coordinates are numbers of at most [`LARGEST_COORDINATE`] in magnitude.
pub(super) fn in_range(point: [f64; 3]) -> bool {
    point.iter().all(|coordinate| coordinate.abs() <= LARGEST_COORDINATE)
}
