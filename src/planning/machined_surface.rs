//! The facets of a surface with those that are machined.

use super::plan::{SurfaceEvidence, Workpiece};
use crate::quantity::Angle;
use crate::surface::mesh::{Closure, FacetClass, Pieces, Selection, SelectionError, ViewFromAbove, Visibility};
use crate::surface::{Facing, Mesh, MeshBuilder, MeshError, SampledSurface, Shape, ShapeError, Sink, Unit};
use std::collections::BTreeSet;

/// Whether the work is cancelled.
pub(crate) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The cells along each side of the raster of maps.
pub(crate) const MAP_SIDE: usize = 256;

/// The facets of a surface, with those that are machined.
pub(crate) struct MachinedSurface {
    pub(crate) mesh: Mesh,
    pub(crate) visibility: Visibility,
    pub(crate) pieces: u32,
    /// The number of pieces with a machined facet.
    pub(crate) machined_pieces: usize,
    /// The share of the selected area that is hidden from above or overhangs, without the undersides of closed solids.
    hidden_area_share: f64,
    /// The area in mm^2 that a solid with selected facets lacks to be closed.
    missing_area: f64,
    /// The part as plans see it.
    pub(crate) workpiece: Workpiece,
    pub(crate) view: ViewFromAbove,
    /// Whether each facet is selected.
    selected: Vec<bool>,
}

/// The reason why a surface has no facets to machine.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NoMachinedSurface {
    Mesh(MeshError),
    /// The surface to avoid has no mesh.
    Avoided(MeshError),
    Selection(SelectionError),
    NothingToMachine,
}

impl NoMachinedSurface {
    /// Whether the surface is valid and only has no facets that are visible from above.
    pub(crate) fn is_sound(self) -> bool {
        match self {
            Self::Mesh(MeshError::NoTriangulation { .. } | MeshError::NothingFromAbove | MeshError::OnlyDegenerateFacets { .. })
            | Self::NothingToMachine => true,
            Self::Mesh(_) | Self::Avoided(_) | Self::Selection(_) => false,
        }
    }
}

impl MachinedSurface {
    /// Prepares the facets of a surface. `avoid` is a second surface, which is never cut.
    ///
    /// Once `stop` returns true, work ends early, and the result must be discarded.
    pub(crate) fn new(
        mesh: MeshBuilder,
        unit: Unit,
        facing: Facing,
        selection: &Selection,
        max_slope: Angle,
        avoid: Option<(MeshBuilder, Unit)>,
        stop: Stop,
    ) -> Result<Self, NoMachinedSurface> {
        let go_on = || if stop() { Err(NoMachinedSurface::NothingToMachine) } else { Ok(()) };
        let mut mesh = mesh.finish_until(unit, facing, stop).map_err(NoMachinedSurface::Mesh)?;
        go_on()?;
        let pieces = mesh.pieces_until(stop);
        mesh.turn_solids_outwards(&pieces);
        go_on()?;
        let selected = mesh.selected(selection, &pieces).map_err(NoMachinedSurface::Selection)?;
        go_on()?;
        let visibility = mesh.visibility_until(max_slope, stop);
        go_on()?;
        let hidden_area_share = hidden_area_share(&mesh, &visibility, &pieces, &selected);
        let machined: Vec<bool> =
            visibility.classes().iter().zip(&selected).map(|(class, selected)| *selected && *class == FacetClass::Machined).collect();
        if !machined.contains(&true) {
            return Err(NoMachinedSurface::NothingToMachine);
        }
        let of_machined = pieces.of_facets().iter().zip(&machined).filter(|(_, machined)| **machined).map(|(piece, _)| *piece);
        let machined_pieces = of_machined.collect::<BTreeSet<_>>().len();
        let missing_area = missing_area(&pieces, &selected);
        let view = mesh.seen_from_above_until(MAP_SIDE, stop);
        go_on()?;
        let avoid =
            avoid.map(|(avoid, unit)| avoid.finish_until(unit, Facing::Any, stop).map_err(NoMachinedSurface::Avoided)).transpose()?;
        let workpiece = Workpiece::new(&mesh, &visibility, &selected, avoid.as_ref(), stop);
        Ok(Self { mesh, visibility, pieces: pieces.count(), machined_pieces, hidden_area_share, missing_area, workpiece, view, selected })
    }

    /// The shape of the selected facets.
    ///
    /// # Errors
    /// [`ShapeError`] if they do not spread over a surface.
    pub(crate) fn selected_shape(&self, facing: Facing) -> Result<Shape, ShapeError> {
        let mut sampled = SampledSurface::new();
        for facet in (0..self.selected.len()).filter(|&facet| self.selected[facet]) {
            sampled.facet(self.mesh.corners(facet));
        }
        sampled.shape(Unit::Millimetre, facing)
    }

    /// The share of the visible area, without walls, whose facets have the opposite orientation: up to a half.
    fn turned_area_share(&self) -> f64 {
        let from_behind = self.visibility.share_from_behind();
        from_behind.min(1.0 - from_behind)
    }

    /// The figures of the surface on which the confidence in a ranking depends.
    pub(crate) fn evidence(&self) -> SurfaceEvidence {
        SurfaceEvidence {
            hidden_area_share: self.hidden_area_share,
            pieces: self.machined_pieces,
            turned_area_share: self.turned_area_share(),
            missing_area: self.missing_area,
        }
    }

    /// The share of the whole area that is seen from above.
    pub(crate) fn visible_area_share(&self) -> f64 {
        let shares = self.visibility.shares();
        (1.0 - shares.hidden - shares.overhanging).clamp(0.0, 1.0)
    }
}

/// The share of the selected area that is hidden from above or overhangs. The facets of a closed solid that point down
/// are its underside, which every solid has, so that they do not count.
pub(crate) fn hidden_area_share(mesh: &Mesh, visibility: &Visibility, pieces: &Pieces, selected: &[bool]) -> f64 {
    let (mut hidden, mut whole) = (0.0, 0.0);
    let facets = visibility.classes().iter().zip(pieces.of_facets()).zip(selected).enumerate();
    for (facet, ((class, piece), _)) in facets.filter(|(_, (_, selected))| **selected) {
        let is_underside = *class == FacetClass::Overhanging && pieces.closures()[*piece as usize] != Closure::Open;
        if !is_underside {
            let (_, area) = mesh.normal_and_area(facet);
            whole += area;
            hidden += (1.0 - visibility.visible_share(facet)) * area;
        }
    }
    if whole > 0.0 { hidden / whole } else { 0.0 }
}

/// The largest area in mm^2 that a piece with a selected facet lacks to be a closed solid.
pub(crate) fn missing_area(pieces: &Pieces, selected: &[bool]) -> f64 {
    let of_selected = pieces.of_facets().iter().zip(selected).filter(|(_, selected)| **selected);
    of_selected.map(|(piece, _)| pieces.missing_areas()[*piece as usize]).fold(0.0, f64::max)
}
