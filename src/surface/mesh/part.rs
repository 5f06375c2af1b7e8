//! A part of a surface. Several threads can receive parts at the same time.

use super::left_out::LeftOut;
use super::weld::Welder;
use crate::surface::{Bounds, Sink};

/// The facets or points of a part of a surface, for [`MeshBuilder::append`](super::MeshBuilder::append). Corners with
/// equal coordinates become one point, and facets without area are counted and left out, as in the whole mesh.
#[derive(Debug)]
pub struct MeshPart {
    pub(super) facets: PartFacets,
    pub(super) left_out: LeftOut,
    /// The box around welded facets.
    pub(super) bounds: Bounds,
    /// Points that do not belong to a facet.
    pub(super) points: Vec<[f64; 3]>,
}

/// The approximate number of facets of a part that is a block of 128 KiB. Room for them is made at the start, because a
/// growing table inserts all its entries again.
const USUAL_FACETS: usize = 2_700;

/// The facets of a part.
#[derive(Debug)]
pub(super) enum PartFacets {
    Welded {
        welder: Welder,
        triangles: Vec<[u32; 3]>,
    },
    /// The corners of the facets, for a mesh that has a lattice in place of facets and does not need welding.
    Separate(Vec<[[f64; 3]; 3]>),
}

impl MeshPart {
    fn with(facets: PartFacets) -> Self {
        Self { facets, left_out: LeftOut::default(), bounds: Bounds::NONE, points: Vec::new() }
    }

    /// A part whose facets are not welded.
    pub(super) fn of_separate_facets() -> Self {
        Self::with(PartFacets::Separate(Vec::new()))
    }
}

impl Default for MeshPart {
    fn default() -> Self {
        Self::with(PartFacets::Welded { welder: Welder::new(), triangles: Vec::new() })
    }
}

impl Sink for MeshPart {
    fn point(&mut self, point: [f64; 3]) {
        if self.left_out.accepts_point(point) {
            self.points.push(point);
        }
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        if !self.left_out.accepts_facet(corners) {
            return;
        }
        match &mut self.facets {
            PartFacets::Welded { welder, triangles } => {
                if triangles.is_empty() {
                    triangles.reserve(USUAL_FACETS);
                    welder.reserve(USUAL_FACETS);
                }
                for corner in corners {
                    self.bounds.include(corner);
                }
                triangles.push(corners.map(|corner| welder.index(corner)));
            }
            PartFacets::Separate(facets) => facets.push(corners),
        }
    }
}
