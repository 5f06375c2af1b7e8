//! A surface with the form in which it was sent, and the warnings about how it was read.

use super::Warning;
use crate::http::codes::WarningCode;
use crate::surface::read::{Format, Notes};
use crate::surface::{Basis, SampledSurface, Shape};
use serde::Serialize;
use utoipa::ToSchema;

/// In which form a surface was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Source {
    /// JSON points.
    Points,
    /// A JSON grid.
    Grid,
    /// A JSON Bezier patch.
    Bezier,
    /// A file of points in lines of text.
    Text,
    /// A file of STL in text.
    StlAscii,
    /// A file of binary STL.
    StlBinary,
    /// A Wavefront OBJ file.
    Obj,
    /// A PLY file with a body of text.
    PlyAscii,
    /// A binary PLY file, little end first.
    PlyLittleEndian,
    /// A binary PLY file, big end first.
    PlyBigEndian,
    /// A PCD file with data in text.
    Pcd,
    /// A 3MF package.
    #[serde(rename = "3mf")]
    ThreeMf,
}

impl From<Format> for Source {
    fn from(format: Format) -> Self {
        match format {
            Format::Text => Self::Text,
            Format::StlAscii => Self::StlAscii,
            Format::StlBinary => Self::StlBinary,
            Format::Obj => Self::Obj,
            Format::PlyAscii => Self::PlyAscii,
            Format::PlyLittleEndian => Self::PlyLittleEndian,
            Format::PlyBigEndian => Self::PlyBigEndian,
            Format::Pcd => Self::Pcd,
            Format::ThreeMf => Self::ThreeMf,
        }
    }
}

/// A surface with its source.
#[derive(Debug)]
pub(crate) struct Sourced {
    pub(crate) surface: SampledSurface,
    pub(crate) source: Source,
    /// What the reader of a file left out, or took although it looks odd.
    pub(crate) notes: Notes,
}

impl Sourced {
    /// A surface out of a JSON request, of which nothing is left out.
    pub(crate) fn stated(surface: SampledSurface, source: Source) -> Self {
        Self { surface, source, notes: Notes::default() }
    }

    /// What must be looked at in how the surface was taken.
    pub(crate) fn warnings(&self, shape: &Shape) -> Vec<Warning> {
        let of_facets = [self.degenerate_facets(), self.left_out_facets(shape), of_basis(shape.basis)];
        of_facets.into_iter().flatten().chain(of_notes(self.notes)).collect()
    }

    fn degenerate_facets(&self) -> Option<Warning> {
        let count = self.surface.degenerate_facets();
        (count > 0).then(|| Warning::new(WarningCode::DegenerateFacets, format!("{count} facets have no area and were left out")))
    }

    fn left_out_facets(&self, shape: &Shape) -> Option<Warning> {
        let all = self.surface.facets();
        let left_out = if shape.basis == Basis::Points { 0 } else { all.saturating_sub(shape.elements) };
        (left_out > 0).then(|| {
            let detail =
                format!("{left_out} of {all} facets face another way than the surface and were left out; facing \"any\" takes all");
            Warning::new(WarningCode::FacetsLeftOut, detail)
        })
    }
}

fn of_basis(basis: Basis) -> Option<Warning> {
    match basis {
        Basis::FacetsTurnedOver => Some(Warning::new(
            WarningCode::TurnedOver,
            "no facet points up, so those that point down were taken for the outer side of the surface",
        )),
        Basis::Walls => {
            Some(Warning::new(WarningCode::WallsOnly, "all facets are vertical; a cutter from above reaches them with its side only"))
        }
        Basis::Points | Basis::FacetsUp | Basis::AllFacets => None,
    }
}

fn of_notes(notes: Notes) -> impl Iterator<Item = Warning> {
    let counted = [
        (notes.further_columns, WarningCode::FurtherColumns, "columns beside x, y and z were left out"),
        (notes.trailing_bytes, WarningCode::TrailingBytes, "bytes after the end that the file's counts give were left out"),
        (notes.other_elements, WarningCode::OtherElements, "elements other than vertices and faces were left out"),
        (notes.missing_points, WarningCode::MissingPoints, "points without coordinates were left out"),
        (
            notes.crossed_polygons,
            WarningCode::CrossedPolygons,
            "polygons have an outline that crosses itself, and an area that is uncertain",
        ),
    ];
    let counted = counted.into_iter().filter(|(count, ..)| *count > 0);
    let missing_end = "the file ends inside a solid, after a whole facet; it may have been cut off";
    let missing_end = notes.missing_end.then(|| Warning::new(WarningCode::MissingEnd, missing_end));
    counted.map(|(count, code, what)| Warning::new(code, format!("{count} {what}"))).chain(missing_end)
}
