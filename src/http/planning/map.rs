//! The surface of an answer as a raster, for drawing.

use crate::http::wire::{NamedCandidate, answer};
use crate::milling::Cutter;
use crate::path::Milled;
use crate::planning::machined_surface::{MAP_SIDE, MachinedSurface, Stop};
use crate::planning::plan::{LeftAt, PlanSettings, Ranking, left_at, left_at_by_all, lifts_at};
use crate::quantity::Length;
use crate::surface::Mesh;
use rayon::prelude::*;
use std::collections::HashSet;

answer! {
    /// The surface seen from above on square cells, at most 256 x 256. Arrays of figures have one item for each cell, row
    /// by row from the lowest y, and in a row from the lowest x; null for a cell without a figure.
    #[schema(as = SurfaceMap)]
    pub(crate) struct MapAnswer {
        /// The number of cells in a row.
        columns: usize,
        /// The number of rows.
        rows: usize,
        /// The side of a cell.
        cell_mm: f64 [minimum = 0],
        /// x and y of the corner of the first cell.
        origin_mm: [f64; 2] [min_items = 2, max_items = 2],
        /// The height of the surface at the middle of each cell; null where there is no surface.
        z_mm: Vec<Option<f64>>,
        /// The slope of the facet seen there; null where there is no surface.
        slope_deg: Vec<Option<f64>>,
        /// The height that the plan leaves there, milled, tooth marks included; null where nothing is machined or
        /// the cutter cannot reach the surface.
        scallop_height_mm: Vec<Option<f64>>,
        /// The height that the plan leaves where no cutter of it fits, milled; 0 where it fits; null where
        /// nothing is machined, or no move comes over the surface.
        uncut_mm: Vec<Option<f64>>,
    }
}

answer! {
    /// The surface of a checked path seen from above on square cells, at most 256 x 256. Arrays of figures have one item for
    /// each cell, row by row from the lowest y, and in a row from the lowest x; null for a cell without a figure.
    #[schema(as = PathMap)]
    pub(crate) struct PathMapAnswer {
        /// The number of cells in a row.
        columns: usize,
        /// The number of rows.
        rows: usize,
        /// The side of a cell.
        cell_mm: f64 [minimum = 0],
        /// x and y of the corner of the first cell.
        origin_mm: [f64; 2] [min_items = 2, max_items = 2],
        /// The height of the surface at the middle of each cell; null where there is no surface.
        z_mm: Vec<Option<f64>>,
        /// The slope of the facet seen there; null where there is no surface.
        slope_deg: Vec<Option<f64>>,
        /// What the path leaves there along the normal, negative in a cut; null where nothing is selected or no move comes over
        /// the surface.
        scallop_height_mm: Vec<Option<f64>>,
    }
}

impl PathMapAnswer {
    /// The map of what a path leaves on the selected facets. `None` once `stop` returns true.
    pub(super) fn new(mesh: &Mesh, facets: &[u32], milled: &Milled, stop: Stop) -> Option<Self> {
        let view = mesh.seen_from_above(MAP_SIDE, stop);
        let frame = view.frame;
        let selected: HashSet<u32> = facets.iter().copied().collect();
        let left = |cell: usize| {
            let facet = view.facet(cell).filter(|facet| u32::try_from(*facet).is_ok_and(|facet| selected.contains(&facet)))?;
            let (normal, _) = mesh.normal_and_area(facet);
            milled.left_at(view.middle(cell), normal).map(|left| left.height)
        };
        let rows: Vec<Vec<Option<f64>>> = (0..frame.rows)
            .into_par_iter()
            .map(|row| (row * frame.columns..(row + 1) * frame.columns).map(|cell| if stop() { None } else { left(cell) }).collect())
            .collect();
        (!stop()).then(|| Self {
            columns: frame.columns,
            rows: frame.rows,
            cell_mm: frame.cell,
            origin_mm: frame.origin,
            z_mm: view.heights.iter().map(|&z| z.is_finite().then_some(z)).collect(),
            slope_deg: view.of_facets(|facet| slope_deg(mesh, facet)).values,
            scallop_height_mm: rows.into_iter().flatten().collect(),
        })
    }
}

/// The slope of a facet.
fn slope_deg(mesh: &Mesh, facet: usize) -> f64 {
    let ([x, y, z], _) = mesh.normal_and_area(facet);
    x.hypot(y).atan2(z.abs()).to_degrees()
}

answer! {
    /// Where one cutter does not fit, on the cells of `map`.
    pub(crate) struct CutterMap {
        /// The position of the cutter in the request, from 0; cutters of libraries follow.
        cutter: usize,
        /// The height by which other facets hold the cutter over its contact with the surface at each cell; 0 where it fits, null
        /// where nothing is machined.
        uncut_mm: Vec<Option<f64>>,
    }
}

/// The most cutters beside that of the map of which an answer says where they do not fit.
pub(super) const MOST_MAPS: usize = 16;

/// The cells of a map on which something is machined.
pub(super) struct MapCells<'a> {
    machined: &'a MachinedSurface,
    settings: &'a PlanSettings,
    /// Their places in the raster.
    places: Vec<usize>,
    /// Their facets and their middles, in the same order.
    points: Vec<(usize, [f64; 3])>,
}

/// Two figures of each cell.
struct Heights {
    scallops: Vec<Option<f64>>,
    uncut: Vec<Option<f64>>,
}

impl<'a> MapCells<'a> {
    pub(super) fn new(machined: &'a MachinedSurface, settings: &'a PlanSettings) -> Self {
        let view = &machined.view;
        let target = |cell: usize| machined.workpiece.target_of(u32::try_from(view.facet(cell)?).ok()?);
        let (places, points) = (0..view.frame.cells()).filter_map(|cell| Some((cell, (target(cell)?, view.middle(cell))))).unzip();
        Self { machined, settings, places, points }
    }

    /// The map of the plan of several operations, else of the fastest; `None` without a plan. Once `stop` returns true, the
    /// result must be discarded.
    pub(super) fn map(&self, ranking: &Ranking, stop: Stop) -> Option<MapAnswer> {
        let Self { machined, settings, points, .. } = self;
        let left = match &ranking.operations {
            Some(operations) => left_at_by_all(&machined.workpiece, operations, settings, points, stop),
            None => left_at(&machined.workpiece, ranking.plans.first()?, settings, points, stop),
        }?;
        let Heights { scallops, uncut } = self.heights(&left);
        let view = &machined.view;
        Some(MapAnswer {
            columns: view.frame.columns,
            rows: view.frame.rows,
            cell_mm: view.frame.cell,
            origin_mm: view.frame.origin,
            z_mm: view.heights.iter().map(|&z| z.is_finite().then_some(z)).collect(),
            slope_deg: view.of_facets(|facet| slope_deg(&machined.facets.mesh, facet)).values,
            scallop_height_mm: scallops,
            uncut_mm: uncut,
        })
    }

    /// Where the first cutters that the map does not show do not fit: those with a plan, fastest first, then the others. Once `stop`
    /// returns true, the result must be discarded.
    pub(super) fn of_cutters(&self, candidates: &[NamedCandidate], ranking: &Ranking, stop: Stop) -> Vec<CutterMap> {
        let shown = usize::from(ranking.operations.is_none());
        let ranked = ranking.plans.iter().map(|plan| plan.candidate).skip(shown);
        let others = ranking.not_ranked.iter().map(|not_ranked| not_ranked.candidate);
        let map = |cutter: usize| CutterMap { cutter, uncut_mm: self.lifts(candidates[cutter].candidate.cutter, stop) };
        ranked.chain(others).take(MOST_MAPS).take_while(|_| !stop()).map(map).collect()
    }

    fn heights(&self, left: &[LeftAt]) -> Heights {
        let nothing = vec![None; self.machined.view.frame.cells()];
        let (mut scallops, mut uncut) = (nothing.clone(), nothing);
        for (&cell, left) in self.places.iter().zip(left) {
            let height = left.height.map(Length::mm);
            if left.is_reached {
                (scallops[cell], uncut[cell]) = (height, Some(0.0));
            } else {
                uncut[cell] = height;
            }
        }
        Heights { scallops, uncut }
    }

    fn lifts(&self, cutter: Cutter, stop: Stop) -> Vec<Option<f64>> {
        let mut lifts = vec![None; self.machined.view.frame.cells()];
        for (&cell, lift) in self.places.iter().zip(lifts_at(&self.machined.workpiece, cutter, self.settings, &self.points, stop)) {
            lifts[cell] = Some(lift.mm());
        }
        lifts
    }
}
