//! The selection of facets to machine, and the facets that planning receives: corners, unit normal, area, and the curvature of
//! the surface.

use super::{FacetClass, Mesh, Pieces, Visibility};
use crate::cancellation::collect_until;
use crate::numerics::vector::dot;
use crate::quantity::Angle;
use crate::surface::Bounds;
use std::fmt;

/// The conditions that a facet must meet, all of them, to be machined. The other facets still hide those below them,
/// and must not be gouged.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Selection {
    slope: Option<(Angle, Angle)>,
    bounds: Option<Bounds>,
    pieces: Option<Vec<u32>>,
    facets: Option<Vec<[u32; 2]>>,
}

/// The order in which the facets of a mesh were received.
#[derive(Debug, Clone)]
pub(super) struct FileOrder {
    /// The facets received, those that the mesh left out included.
    pub(super) received: u32,
    /// The number of each facet of the mesh in that order; `None` if it is the facet's place.
    pub(super) numbers: Option<Vec<u32>>,
}

/// The reason why a selection is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SelectionError {
    /// The slope band is empty, or not within 0 to 90 deg.
    SlopeBand,
    /// The box is empty: a smallest coordinate exceeds the largest, or one is not a finite number.
    Box,
    /// The list of pieces is empty.
    NoPieces,
    /// A range of facets begins after its end.
    FacetRange,
    /// The facets were made from points, or merged because they are too many, and have no order in a file.
    NoFacetOrder,
    /// The surface has no facet of that number.
    UnknownFacet {
        /// The number.
        facet: u32,
        /// The number of facets, which are numbered from 0.
        count: u32,
    },
    /// The surface has no piece of that number.
    UnknownPiece {
        /// The number.
        piece: u32,
        /// The number of pieces, which are numbered from 0.
        count: u32,
    },
}

impl fmt::Display for SelectionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SlopeBand => f.write_str("the slope band must go from a smaller to a larger angle within 0 to 90 deg"),
            Self::Box => f.write_str("the box must have finite coordinates, its smallest at most its largest"),
            Self::NoPieces => f.write_str("at least one piece must be listed"),
            Self::FacetRange => f.write_str("a range of facets goes from its first to its last, not back"),
            Self::NoFacetOrder => {
                f.write_str("the facets were made from points, or merged because they are too many, and have no order in the file")
            }
            Self::UnknownFacet { facet, count } => write!(f, "there is no facet {facet}; the surface has {count}, counted from 0"),
            Self::UnknownPiece { piece, count } => write!(f, "there is no piece {piece}; the surface has {count}, counted from 0"),
        }
    }
}

impl std::error::Error for SelectionError {}

impl SelectionError {
    /// Whether it is about the numbers of facets.
    #[must_use]
    pub fn is_about_facets(self) -> bool {
        matches!(self, Self::NoFacetOrder | Self::UnknownFacet { .. } | Self::FacetRange)
    }
}

impl Selection {
    /// Every facet.
    #[must_use]
    pub fn all() -> Self {
        Self::default()
    }

    /// Only facets whose slope lies from `smallest` to `largest`, ends included.
    ///
    /// # Errors
    /// [`SelectionError::SlopeBand`] if `smallest` exceeds `largest`, or one is outside 0 to 90 deg.
    pub fn with_slopes(self, smallest: Angle, largest: Angle) -> Result<Self, SelectionError> {
        let in_order = smallest.radians() >= 0.0 && smallest.radians() <= largest.radians() && largest.radians() <= Angle::RIGHT.radians();
        if in_order { Ok(Self { slope: Some((smallest, largest)), ..self }) } else { Err(SelectionError::SlopeBand) }
    }

    /// Only facets whose centroid lies in the box, in mm, its sides included.
    ///
    /// # Errors
    /// [`SelectionError::Box`] if the box is empty or a coordinate is not finite.
    pub fn with_box(self, min: [f64; 3], max: [f64; 3]) -> Result<Self, SelectionError> {
        let valid = (0..3).all(|axis| min[axis].is_finite() && max[axis].is_finite() && min[axis] <= max[axis]);
        if valid { Ok(Self { bounds: Some(Bounds { min, max }), ..self }) } else { Err(SelectionError::Box) }
    }

    /// Only facets of these pieces.
    ///
    /// # Errors
    /// [`SelectionError::NoPieces`] for an empty list.
    pub fn with_pieces(self, pieces: Vec<u32>) -> Result<Self, SelectionError> {
        if pieces.is_empty() { Err(SelectionError::NoPieces) } else { Ok(Self { pieces: Some(pieces), ..self }) }
    }

    /// Only facets in these ranges, each from its first to its last number in the order of the file, from 0. Facets that
    /// the mesh leaves out count.
    ///
    /// # Errors
    /// [`SelectionError::FacetRange`] for a range that begins after its end.
    pub fn with_facets(self, ranges: Vec<[u32; 2]>) -> Result<Self, SelectionError> {
        let in_order = ranges.iter().all(|[first, last]| first <= last);
        if in_order { Ok(Self { facets: Some(ranges), ..self }) } else { Err(SelectionError::FacetRange) }
    }
}

impl Mesh {
    /// Whether each facet is in one of the ranges of numbers in the order of the file.
    fn in_ranges(&self, ranges: &[[u32; 2]]) -> Result<Vec<bool>, SelectionError> {
        let order = self.order.as_ref().ok_or(SelectionError::NoFacetOrder)?;
        let mut listed = vec![false; order.received as usize];
        for [first, last] in ranges {
            let unknown = SelectionError::UnknownFacet { facet: *last, count: order.received };
            listed.get_mut(*first as usize..=*last as usize).ok_or(unknown)?.fill(true);
        }
        Ok(match &order.numbers {
            None => listed,
            Some(numbers) => numbers.iter().map(|number| listed[*number as usize]).collect(),
        })
    }

    /// Whether each facet meets the conditions of a selection, by its own slope (whichever side is up), centroid, piece and
    /// number.
    ///
    /// # Errors
    /// [`SelectionError::UnknownPiece`] for a number that is not a piece's, and the same for facets.
    pub fn selected(&self, selection: &Selection, pieces: &Pieces) -> Result<Vec<bool>, SelectionError> {
        let listed = match &selection.pieces {
            None => None,
            Some(list) => {
                let mut listed = vec![false; pieces.count() as usize];
                for &piece in list {
                    let place = listed.get_mut(piece as usize);
                    *place.ok_or(SelectionError::UnknownPiece { piece, count: pieces.count() })? = true;
                }
                Some(listed)
            }
        };
        let in_ranges = selection.facets.as_deref().map(|ranges| self.in_ranges(ranges)).transpose()?;
        let is_listed = |facet: usize| in_ranges.as_ref().is_none_or(|listed| listed[facet]);
        let in_band = |facet: usize| {
            selection.slope.is_none_or(|(smallest, largest)| {
                let ([x, y, z], _) = self.normal_and_area(facet);
                let slope = x.hypot(y).atan2(z.abs());
                slope >= smallest.radians() && slope <= largest.radians()
            })
        };
        let in_box = |facet: usize| {
            selection.bounds.is_none_or(|Bounds { min, max }| {
                let centre = self.centroid(facet);
                (0..3).all(|axis| centre[axis] >= min[axis] && centre[axis] <= max[axis])
            })
        };
        let in_pieces = |facet: usize| listed.as_ref().is_none_or(|listed| listed[pieces.of_facets()[facet] as usize]);
        Ok((0..self.triangles().len()).map(|facet| is_listed(facet) && in_pieces(facet) && in_box(facet) && in_band(facet)).collect())
    }

    /// The facets to plan for: visible from above, selected and not vertical, in the order of the mesh. Facets steeper
    /// than the limit of [`Mesh::visibility`] are included, because passes cross them although they do not limit the
    /// spacing; [`FinishFacet::slope`] identifies them. `selected` is the result of [`Mesh::selected`].
    ///
    /// Once `stop` returns true, it returns early, and the result must be discarded.
    #[must_use]
    pub fn facets_for_finishing(&self, visibility: &Visibility, selected: &[bool], stop: &(dyn Fn() -> bool + Sync)) -> Vec<FinishFacet> {
        let wanted: Vec<u32> = (0_u32..)
            .zip(visibility.classes().iter().zip(selected))
            .filter(|&(_, (class, selected))| *selected && matches!(class, FacetClass::Machined | FacetClass::Steep { wall: false }))
            .map(|(facet, _)| facet)
            .collect();
        let curvatures = self.curvatures(visibility, &wanted, stop);
        collect_until(curvatures.len(), stop, |index| {
            let (facet, curvature) = (wanted[index] as usize, curvatures[index]);
            let (mut corners, (mut normal, area)) = (self.corners(facet), self.normal_and_area(facet));
            if visibility.is_seen_from_behind(facet) {
                corners.swap(1, 2);
                normal = normal.map(|part| -part);
            }
            FinishFacet { corners, normal, area, curvature }
        })
    }
}

/// A facet that is to be finished: visible from above and selected.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FinishFacet {
    /// The corners in mm, counter-clockwise seen from above.
    pub corners: [[f64; 3]; 3],
    /// The unit normal that points out of the part; its z is positive.
    pub normal: [f64; 3],
    /// The area in mm^2.
    pub area: f64,
    /// The curvature tensor of the surface in 1/mm, positive where the surface is convex: the symmetric 3 x 3 matrix K
    /// as xx, xy, xz, yy, yz, zz. It maps the normal to 0; the normal curvature along a unit tangent vector t is t'Kt,
    /// the twist of perpendicular tangents t and u is t'Ku.
    pub curvature: [f64; 6],
}

impl FinishFacet {
    /// The angle between the normal and the vertical, from 0 to under 90 deg: atan2(|(n_x, n_y)|, n_z), exact near both
    /// ends.
    #[must_use]
    pub fn slope(&self) -> Angle {
        let [x, y, z] = self.normal;
        Angle::from_radians(x.hypot(y).atan2(z))
    }

    /// t'Ku. If t = u is a unit tangent vector, that is the normal curvature along it; if t and u are perpendicular,
    /// the twist.
    #[must_use]
    pub fn curvature_between(&self, t: [f64; 3], u: [f64; 3]) -> f64 {
        let [xx, xy, xz, yy, yz, zz] = self.curvature;
        let ku = [xx * u[0] + xy * u[1] + xz * u[2], xy * u[0] + yy * u[1] + yz * u[2], xz * u[0] + yz * u[1] + zz * u[2]];
        dot(t, ku)
    }
}
