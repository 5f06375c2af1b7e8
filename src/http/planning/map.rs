//! The surface of an answer as a raster, for drawing.

use super::simulation::Simulation;
use crate::http::wire::answer;
use crate::planning::machined_surface::{MachinedSurface, Stop};
use crate::planning::plan::left_at;
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
        /// The height that the recommended plan leaves there, milled, tooth marks included; null where nothing is machined or
        /// the cutter cannot reach the surface.
        scallop_height_mm: Vec<Option<f64>>,
        /// The height that the recommended plan leaves where its cutter does not fit, milled; 0 where it fits; null where
        /// nothing is machined, or no move comes over the surface.
        uncut_mm: Vec<Option<f64>>,
    }
}

impl MapAnswer {
    /// The map of the fastest plan; `None` without a plan. Once `stop` returns true, the result must be discarded.
    pub(super) fn new(machined: &MachinedSurface, simulation: &Simulation, stop: Stop) -> Option<Self> {
        let plan = simulation.ranking.plans.first()?;
        let view = &machined.view;
        let frame = view.frame;
        let middle = |cell: usize| {
            let (column, row) = (cell % frame.columns, cell / frame.columns);
            #[expect(clippy::cast_precision_loss, reason = "at most 256")]
            let at = |index: usize, axis: usize| frame.origin[axis] + (index as f64 + 0.5) * frame.cell;
            [at(column, 0), at(row, 1), view.heights[cell]]
        };
        let cells: Vec<(usize, usize)> = (0..frame.cells())
            .filter_map(|cell| {
                let facet = u32::try_from(view.facet(cell)?).ok()?;
                Some((cell, machined.workpiece.target_of(facet)?))
            })
            .collect();
        let points: Vec<_> = cells.iter().map(|&(cell, target)| (target, middle(cell))).collect();
        let left = left_at(&machined.workpiece, plan, &simulation.settings, &points, stop)?;
        let (mut scallops, mut uncut) = (vec![None; frame.cells()], vec![None; frame.cells()]);
        for (&(cell, _), left) in cells.iter().zip(&left) {
            let height = left.height.map(Length::mm);
            if left.is_reached {
                (scallops[cell], uncut[cell]) = (height, Some(0.0));
            } else {
                uncut[cell] = height;
            }
        }
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
            scallop_height_mm: scallops,
            uncut_mm: uncut,
        })
    }
}
