//! The facets of a surface with those that are machined.

use super::SurfaceEvidence;
use super::plan::Workpiece;
use crate::quantity::Angle;
use crate::surface::mesh::{Closure, FacetClass, Pieces, Selection, SelectionError, ViewFromAbove, Visibility};
use crate::surface::{Facing, Mesh, MeshBuilder, MeshError, SampledSurface, Shape, ShapeError, Sink, Unit};
use std::collections::BTreeSet;

/// Whether the work is cancelled.
pub(crate) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The cells along each side of the raster of maps.
pub(crate) const MAP_SIDE: usize = 256;

/// The facets of a surface, with those that are machined.
pub(crate) struct MachinedFacets {
    pub(crate) mesh: Mesh,
    pub(crate) visibility: Visibility,
    pub(crate) pieces: Pieces,
    /// Whether each facet is selected.
    selected: Vec<bool>,
}

/// A surface to plan on: at least one of its facets is machined.
pub(crate) struct MachinedSurface {
    pub(crate) facets: MachinedFacets,
    /// The part as plans see it.
    pub(crate) workpiece: Workpiece,
    pub(crate) view: ViewFromAbove,
}

/// The reason why a surface has no facets to machine.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NoMachinedSurface {
    Mesh(MeshError),
    Selection(SelectionError),
    NothingToMachine,
}

impl NoMachinedSurface {
    /// Whether the surface is valid and only has no facets that are visible from above.
    pub(crate) fn is_sound(self) -> bool {
        match self {
            Self::Mesh(MeshError::NoTriangulation { .. } | MeshError::NothingFromAbove | MeshError::OnlyDegenerateFacets { .. })
            | Self::NothingToMachine => true,
            Self::Mesh(_) | Self::Selection(_) => false,
        }
    }
}

impl MachinedFacets {
    /// The facets of a surface; at least one is machined.
    ///
    /// Once `stop` returns true, work ends early, and the result must be discarded.
    pub(crate) fn new(
        mesh: MeshBuilder,
        unit: Unit,
        facing: Facing,
        selection: &Selection,
        max_slope: Angle,
        stop: Stop,
    ) -> Result<Self, NoMachinedSurface> {
        let go_on = || if stop() { Err(NoMachinedSurface::NothingToMachine) } else { Ok(()) };
        let mut mesh = mesh.finish(unit, facing, stop).map_err(NoMachinedSurface::Mesh)?;
        go_on()?;
        let pieces = mesh.pieces(stop);
        mesh.turn_solids_outwards(&pieces);
        go_on()?;
        let selected = mesh.selected(selection, &pieces).map_err(NoMachinedSurface::Selection)?;
        go_on()?;
        let visibility = mesh.visibility(max_slope, stop);
        go_on()?;
        let facets = Self { mesh, visibility, pieces, selected };
        if facets.machined().next().is_none() { Err(NoMachinedSurface::NothingToMachine) } else { Ok(facets) }
    }

    /// The facets that are machined.
    pub(crate) fn machined(&self) -> impl Iterator<Item = u32> {
        let classes = self.visibility.classes().iter().zip(&self.selected).zip(0..);
        classes.filter(|((class, selected), _)| **selected && **class == FacetClass::Machined).map(|(_, facet)| facet)
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

    /// The figures of the surface on which the confidence in plans and checks depends.
    pub(crate) fn evidence(&self) -> SurfaceEvidence {
        let from_behind = self.visibility.share_from_behind();
        SurfaceEvidence {
            hidden_area_share: self.hidden_area_share(),
            pieces: self.machined_pieces(),
            turned_area_share: from_behind.min(1.0 - from_behind),
            missing_area: self.missing_area(),
        }
    }

    /// The number of pieces with a machined facet.
    pub(crate) fn machined_pieces(&self) -> usize {
        self.machined().map(|facet| self.pieces.of_facets()[facet as usize]).collect::<BTreeSet<_>>().len()
    }

    /// The share of the whole area that is seen from above.
    pub(crate) fn visible_area_share(&self) -> f64 {
        let shares = self.visibility.shares();
        (1.0 - shares.hidden - shares.overhanging).clamp(0.0, 1.0)
    }

    /// The share of the selected area that is hidden from above or overhangs. The facets of a closed solid that point down
    /// are its underside, which every solid has, so that they do not count.
    fn hidden_area_share(&self) -> f64 {
        let (mut hidden, mut whole) = (0.0, 0.0);
        let facets = self.visibility.classes().iter().zip(self.pieces.of_facets()).zip(&self.selected).enumerate();
        for (facet, ((class, piece), _)) in facets.filter(|(_, (_, selected))| **selected) {
            let is_underside = *class == FacetClass::Overhanging && self.pieces.closures()[*piece as usize] != Closure::Open;
            if !is_underside {
                let (_, area) = self.mesh.normal_and_area(facet);
                whole += area;
                hidden += (1.0 - self.visibility.visible_share(facet)) * area;
            }
        }
        if whole > 0.0 { hidden / whole } else { 0.0 }
    }

    /// The largest area in mm^2 that a piece with a selected facet lacks to be a closed solid.
    fn missing_area(&self) -> f64 {
        let of_selected = self.pieces.of_facets().iter().zip(&self.selected).filter(|(_, selected)| **selected);
        of_selected.map(|(piece, _)| self.pieces.missing_areas()[*piece as usize]).fold(0.0, f64::max)
    }
}

impl MachinedSurface {
    /// Prepares a surface for plans. The facets of `avoid` are never cut.
    ///
    /// Once `stop` returns true, work ends early, and the result must be discarded.
    pub(crate) fn new(facets: MachinedFacets, avoid: Option<&Mesh>, stop: Stop) -> Self {
        let MachinedFacets { mesh, visibility, selected, .. } = &facets;
        let view = mesh.seen_from_above(MAP_SIDE, stop);
        let workpiece = Workpiece::new(mesh, visibility, selected, avoid, stop);
        Self { facets, workpiece, view }
    }
}
