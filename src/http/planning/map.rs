//! The surface of an answer as a raster, for drawing.

use super::simulation::Simulation;
use crate::http::wire::answer;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::zigzag::heights;
use crate::quantity::Length;

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
        /// The scallop height of the recommended plan on that facet, by model `envelope`; null where nothing is machined or
        /// the cutter does not reach the surface.
        scallop_height_mm: Vec<Option<f64>>,
        /// The height that the recommended cutter leaves uncut because it does not fit; null where nothing is machined.
        uncut_mm: Vec<Option<f32>>,
    }
}

impl MapAnswer {
    /// The map of the fastest plan; `None` without a plan. Once `stop` returns true, the result must be discarded.
    pub(super) fn new(machined: &MachinedSurface, simulation: &Simulation, stop: Stop) -> Option<Self> {
        let plan = simulation.ranking.plans.first()?;
        let view = &machined.view;
        let frame = view.frame;
        let facet_of_cell: Vec<Option<u32>> = (0..frame.cells()).map(|cell| machined.facet_of_cell(cell)).collect();
        let mut seen: Vec<u32> = facet_of_cell.iter().flatten().copied().collect();
        seen.sort_unstable();
        seen.dedup();
        let candidate = &simulation.candidates[plan.candidate];
        let heights = heights(plan, &machined.facets, candidate, &simulation.settings, &seen, stop);
        let height_of = |facet: u32| seen.binary_search(&facet).ok().and_then(|place| heights[place]).map(Length::mm);
        let slope_of = |facet: usize| {
            let ([x, y, z], _) = machined.mesh.normal_and_area(facet);
            x.hypot(y).atan2(z.abs()).to_degrees()
        };
        Some(Self {
            columns: frame.columns,
            rows: frame.rows,
            cell_mm: frame.cell,
            origin_mm: frame.origin,
            z_mm: view.heights.iter().map(|&z| z.is_finite().then_some(z)).collect(),
            slope_deg: view.of_facets(slope_of).values,
            scallop_height_mm: facet_of_cell.iter().map(|facet| facet.and_then(height_of)).collect(),
            uncut_mm: machined.uncut_heights(candidate, simulation.settings.scallop_height, stop).values,
        })
    }
}
