//! A received surface with its format, its unit, and the warnings of its reader.

use super::Warning;
use crate::http::codes::{RequestFault, WarningCode, same_names};
use crate::http::reading::{Choice, Faulted, Faults, JsonPath, Member};
use crate::surface::read::{FarOutside, Format, Notes, ReadSummary};
use crate::surface::{Basis, ReceivedSurface, Shape, Unit};
use serde::Serialize;
use utoipa::ToSchema;

/// The form in which a surface was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Source {
    /// JSON points.
    Points,
    /// A JSON grid.
    Grid,
    /// A JSON mesh.
    Mesh,
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
    /// A binary PLY file, little-endian.
    PlyLittleEndian,
    /// A binary PLY file, big-endian.
    PlyBigEndian,
    /// A PCD file with data in text.
    Pcd,
    /// A 3MF package.
    #[serde(rename = "3mf")]
    ThreeMf,
}

same_names!(Format => Source: Text, StlAscii, StlBinary, Obj, PlyAscii, PlyLittleEndian, PlyBigEndian, Pcd, ThreeMf);

/// A surface with its source.
#[derive(Debug)]
pub(crate) struct SurfaceWithSource {
    pub(crate) surface: ReceivedSurface,
    pub(crate) source: Source,
    /// The unit that the file states.
    pub(crate) unit: Option<Unit>,
    /// Notes of the file's reader on data that it left out or found unusual.
    pub(crate) notes: Notes,
}

impl SurfaceWithSource {
    /// A surface of a JSON request, of which nothing is left out.
    pub(crate) fn stated(mut surface: ReceivedSurface, source: Source) -> Self {
        surface.leave_out_duplicates();
        Self { surface, source, unit: None, notes: Notes::default() }
    }

    /// A surface of a file.
    pub(crate) fn of_file(mut surface: ReceivedSurface, summary: ReadSummary) -> Self {
        surface.leave_out_duplicates();
        Self { surface, source: summary.format.into(), unit: summary.unit, notes: summary.notes }
    }

    /// Whether the surface was sent as a file.
    pub(crate) fn is_file(&self) -> bool {
        !matches!(self.source, Source::Points | Source::Grid | Source::Mesh | Source::Bezier)
    }

    /// The unit of the coordinates: the request's, otherwise the file's, otherwise mm.
    ///
    /// A 3MF file always states its unit, and the request must not state another. Names of columns and comments may be
    /// wrong, so that the request's unit counts more than theirs.
    pub(crate) fn unit_of(&self, requested: Option<Unit>, faults: &mut Faults) -> Result<Unit, Faulted> {
        match (requested, self.unit) {
            (Some(requested), Some(own)) if requested != own && self.source == Source::ThreeMf => {
                let detail = format_args!("the 3MF file states its unit, {}; omit `unit` or state the same", UNIT.kind.word(&own));
                Err(faults.add(&JsonPath::Root.member(UNIT.name), RequestFault::ConflictingFields, detail))
            }
            (requested, own) => Ok(requested.or(own).unwrap_or_default()),
        }
    }

    /// Warnings about how the surface was read.
    pub(crate) fn warnings(&self, shape: &Shape) -> Vec<Warning> {
        let degenerate = self.surface.sampled.degenerate_facets();
        let degenerate = counted(degenerate, WarningCode::DegenerateFacets, "facets have no area and were left out");
        let duplicates = self.surface.mesh.duplicate_facets();
        let duplicates = counted(duplicates, WarningCode::DuplicateFacets, "facets have the same corners as another one and were left out");
        let of_facets = [degenerate, duplicates, self.left_out_facets(shape), of_basis(shape.basis)];
        of_facets.into_iter().flatten().chain(of_notes(&self.notes)).collect()
    }

    fn left_out_facets(&self, shape: &Shape) -> Option<Warning> {
        let all = self.surface.sampled.facets();
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
            "no facet points up, so the facets that point down were taken as the outer side of the surface",
        )),
        Basis::Walls => {
            Some(Warning::new(WarningCode::WallsOnly, "all facets are vertical; a cutter from above reaches them with its side only"))
        }
        Basis::Points | Basis::FacetsUp | Basis::AllFacets => None,
    }
}

fn of_notes(notes: &Notes) -> impl Iterator<Item = Warning> + use<> {
    let crossed = "polygons have an outline that crosses itself, and an area that is uncertain";
    let missing_end = "the file ends inside a solid, after a whole facet; it may have been cut off";
    let warnings = [
        counted(notes.further_columns, WarningCode::FurtherColumns, "columns other than x, y and z were left out"),
        counted(notes.trailing_bytes, WarningCode::TrailingBytes, "bytes after the end that the file's counts give were left out"),
        counted(notes.other_elements, WarningCode::OtherElements, "elements other than vertices and faces were left out"),
        counted(notes.missing_points, WarningCode::MissingPoints, "points without coordinates were left out"),
        counted(notes.crossed_polygons, WarningCode::CrossedPolygons, crossed),
        notes.far_outside.map(|far| Warning::new(WarningCode::PointFarOutside, far_outside(far))),
        (!notes.volumes.is_empty()).then(|| {
            let detail = format!("left out by the slicer's settings in the file: {}", notes.volumes.join(", "));
            Warning::new(WarningCode::VolumesLeftOut, detail)
        }),
        notes.missing_end.then(|| Warning::new(WarningCode::MissingEnd, missing_end)),
    ];
    warnings.into_iter().flatten()
}

fn far_outside(far: FarOutside) -> String {
    let FarOutside { line, axis, value, points, others: [least, most] } = far;
    let axis = ["x", "y", "z"][axis];
    let times = if points > 1 { format!(" and of {} further points", points - 1) } else { String::new() };
    format!(
        "{axis} of the point in line {line}{times} is {value}, all others are from {least} to {most}; it may stand for a missing measurement"
    )
}

/// A warning about so many items, if there are any.
fn counted(count: u64, code: WarningCode, what: &str) -> Option<Warning> {
    (count > 0).then(|| Warning::new(code, format!("{count} {what}")))
}

/// The member `unit` of a recommendation.
pub(crate) const UNIT: Member<Choice<Unit>> = Member::new(
    "unit",
    "the unit of the surface's coordinates; absent = the one that the file states, otherwise mm",
    Choice {
        name: Some("Unit"),
        words: &[
            ("mm", Unit::Millimetre),
            ("cm", Unit::Centimetre),
            ("m", Unit::Metre),
            ("inch", Unit::Inch),
            ("um", Unit::Micrometre),
            ("foot", Unit::Foot),
        ],
    },
);
