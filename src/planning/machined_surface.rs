//! The facets of a surface with those that are machined, and the reach of cutters on them.

use super::memory::{RankingSize, TRIAL_SIDE};
use super::reach::ReachMap;
use super::zigzag::{CandidateCutter, SurfaceEvidence};
use crate::numerics::raster::Raster;
use crate::quantity::{Angle, Length};
use crate::surface::mesh::{Closure, FacetClass, Pieces, Selection, SelectionError, ViewFromAbove, Visibility};
use crate::surface::{Facing, FinishFacet, Mesh, MeshBuilder, MeshError, Unit};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Whether the work is cancelled.
pub(crate) type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The cells along each side of the raster for the reach of cutters and for maps.
const SIDE: usize = TRIAL_SIDE;

/// The facets of a surface, with those that are machined.
pub(crate) struct MachinedSurface {
    pub(crate) mesh: Mesh,
    pub(crate) visibility: Visibility,
    pub(crate) pieces: u32,
    /// The number of pieces with a machined facet.
    pub(crate) machined_pieces: usize,
    /// Whether each facet of the mesh is selected and not too steep.
    machined: Vec<bool>,
    /// The share of the selected area that is hidden from above or overhangs, without the undersides of closed solids.
    hidden_area_share: f64,
    /// The facets to plan for.
    pub(crate) facets: Vec<FinishFacet>,
    /// For each facet of the mesh, its index among the planned facets; `None` if it is not planned.
    places: Vec<Option<u32>>,
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

impl MachinedSurface {
    /// Prepares the facets of a surface.
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
        let mut mesh = mesh.finish_until(unit, facing, stop).map_err(NoMachinedSurface::Mesh)?;
        go_on()?;
        let pieces = mesh.pieces_until(stop);
        mesh.turn_solids_outwards(&pieces);
        go_on()?;
        let selected = mesh.selected(selection, &pieces).map_err(NoMachinedSurface::Selection)?;
        go_on()?;
        let visibility = mesh.visibility_until(max_slope, stop);
        go_on()?;
        let facets = mesh.facets_for_finishing_until(&visibility, &selected, stop);
        go_on()?;
        let hidden_area_share = hidden_area_share(&mesh, &visibility, &pieces, &selected);
        let mut next = 0;
        let mut machined = Vec::with_capacity(selected.len());
        let mut places = Vec::with_capacity(selected.len());
        for (class, selected) in visibility.classes().iter().zip(&selected) {
            machined.push(*selected && *class == FacetClass::Machined);
            let is_planned = *selected && matches!(class, FacetClass::Machined | FacetClass::Steep { wall: false });
            places.push(is_planned.then_some(next));
            next += u32::from(is_planned);
        }
        if !machined.contains(&true) {
            return Err(NoMachinedSurface::NothingToMachine);
        }
        let of_machined = pieces.of_facets().iter().zip(&machined).filter(|(_, machined)| **machined).map(|(piece, _)| *piece);
        let machined_pieces = of_machined.collect::<BTreeSet<_>>().len();
        let view = mesh.seen_from_above_until(SIDE, stop);
        Ok(Self { mesh, visibility, pieces: pieces.count(), machined_pieces, machined, hidden_area_share, facets, places, view })
    }

    /// The index of a cell's facet among the planned facets.
    pub(crate) fn facet_of_cell(&self, cell: usize) -> Option<u32> {
        self.view.facet(cell).and_then(|facet| self.places[facet])
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
        }
    }

    /// The raster for the reach of cutters.
    pub(crate) fn reach(&self) -> ReachMap {
        ReachMap::new(&self.mesh, &self.view, &self.machined)
    }

    /// The number of cells along each side of the raster for the reach of a candidate.
    fn reach_side(&self, candidate: &CandidateCutter) -> usize {
        RankingSize::of(&self.mesh, std::slice::from_ref(candidate)).reach_side()
    }

    /// The reach of cutters on a raster of this many cells along each side.
    fn reach_on(&self, side: usize, stop: Stop) -> ReachMap {
        if side == SIDE { self.reach() } else { ReachMap::new(&self.mesh, &self.mesh.seen_from_above_until(side, stop), &self.machined) }
    }

    /// The candidates, each with the material that it cannot reach, on a raster that is fine enough for it. `None` once
    /// `stop` returns true.
    pub(crate) fn with_reach(&self, candidates: &[CandidateCutter], scallop_height: Length, stop: Stop) -> Option<Vec<CandidateCutter>> {
        let mut tried = candidates.to_vec();
        let sides: BTreeSet<usize> = candidates.iter().map(|candidate| self.reach_side(candidate)).collect();
        for side in sides {
            let reach = self.reach_on(side, stop);
            let mut of_side: Vec<_> = tried.iter_mut().filter(|candidate| self.reach_side(candidate) == side).collect();
            for some in of_side.chunks_mut(MOST_AT_ONCE) {
                if stop() {
                    return None;
                }
                some.par_iter_mut().for_each(|candidate| {
                    candidate.reach = Some((&reach.uncut_until(candidate.cutter, scallop_height, stop)).into());
                });
            }
        }
        (!stop()).then_some(tried)
    }

    /// The largest height in mm that a candidate leaves uncut in each cell of the view; `None` where nothing is machined.
    /// Once `stop` returns true, the result must be discarded.
    pub(crate) fn uncut_heights(&self, candidate: &CandidateCutter, scallop_height: Length, stop: Stop) -> Raster<Option<f32>> {
        self.reach_on(self.reach_side(candidate), stop).uncut_heights(candidate.cutter, scallop_height, self.view.frame, stop)
    }

    /// The share of the whole area that is seen from above.
    pub(crate) fn visible_area_share(&self) -> f64 {
        let shares = self.visibility.shares();
        (1.0 - shares.hidden - shares.overhanging).clamp(0.0, 1.0)
    }
}

/// The share of the selected area that is hidden from above or overhangs. The facets of a closed solid that point down
/// are its underside, which every solid has, so that they do not count.
fn hidden_area_share(mesh: &Mesh, visibility: &Visibility, pieces: &Pieces, selected: &[bool]) -> f64 {
    let (mut hidden, mut whole) = (0.0, 0.0);
    let facets = visibility.classes().iter().zip(pieces.of_facets()).zip(selected).enumerate();
    for (facet, ((class, piece), _)) in facets.filter(|(_, (_, selected))| **selected) {
        let is_underside = *class == FacetClass::Overhanging && pieces.closures()[*piece as usize] != Closure::Open;
        if !is_underside {
            let (_, area) = mesh.normal_and_area(facet);
            whole += area;
            hidden += if matches!(class, FacetClass::Hidden | FacetClass::Overhanging) { area } else { 0.0 };
        }
    }
    if whole > 0.0 { hidden / whole } else { 0.0 }
}

/// The number of cutters between two checks for cancellation.
const MOST_AT_ONCE: usize = 8;
