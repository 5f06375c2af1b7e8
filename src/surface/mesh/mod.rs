//! A surface as triangles that share corners.

mod finish_facet;

pub use finish_facet::FinishFacet;
