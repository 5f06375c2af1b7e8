//! What given moves of a cutter leave on a surface. The moves are in the cells of a grid in plan view.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]
#![allow(clippy::cast_precision_loss, reason = "counts are below 2^52")]

use super::body::{Body, Ray, Swept};
use crate::milling::Profile;

/// How the tool gets from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MoveKind {
    /// It cuts, at the feed rate.
    Cut,
    /// It goes from one run to the next at the feed rate. It clears what it meets and may gouge like a cut.
    Link,
    /// It goes at the rapid rate through air. Whatever it meets is a collision; it counts for no material cleared.
    Rapid,
}

/// A straight move of the tip, the lowest point of the cutter on its axis. Coordinates in mm are finite.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Move {
    /// Where the move begins.
    pub from: [f64; 3],
    /// Where it ends.
    pub to: [f64; 3],
    /// What the move is for.
    pub kind: MoveKind,
}

/// The levels in cutter radii under which moves are looked for, until there is one. Most places have a level of a few
/// thousandths of the radius, for which few moves come into question.
const CAPS: [f64; 3] = [0.004, 0.1, 2.0];

/// A path milled: the solid swept by a cutter along its moves, as seen from places of a surface.
///
/// K is the cutter's solid relative to its tip, convex and infinitely high. A move from the tip a to the tip b sweeps
/// K + [a, b]. At a place p of a surface with the outward normal n, the ray p + t n enters that solid at the level tau. The
/// least tau over all moves is what is left at p; where it is negative, it is the depth of a gouge. An interval of the
/// ray that ends before t = 0 is a cut into another face of the part and does not count.
///
/// No formula of a scallop's height is used: it holds for any path on any surface.
#[derive(Debug, Clone)]
pub struct Milled {
    tools: Vec<Tool>,
    /// The largest radius.
    radius: f64,
}

/// A cutter and its moves.
#[derive(Debug, Clone)]
struct Tool {
    body: Body,
    clearing: Moves,
    rapid: Moves,
}

/// What is left at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Left {
    /// The height of material over the place along its normal in mm; negative in a gouge.
    pub height: f64,
    /// The index of the move that decides.
    pub by: u32,
}

/// Moves of one kind, and their indices in the path.
#[derive(Debug, Clone)]
struct Moves {
    swept: Vec<Swept>,
    indices: Vec<u32>,
    grid: Option<MoveGrid>,
}

impl Moves {
    fn new(moves: &[Move], radius: f64, stop: &(dyn Fn() -> bool + Sync), wanted: impl Fn(usize, MoveKind) -> bool) -> Self {
        let chosen = moves.iter().enumerate().filter(|(index, each)| wanted(*index, each.kind));
        let indices: Vec<u32> = chosen.map(|(index, _)| index as u32).collect();
        let swept: Vec<Swept> = indices.iter().map(|&index| &moves[index as usize]).map(|each| Swept::new(each.from, each.to)).collect();
        let grid = MoveGrid::new(&swept, radius, stop);
        Self { swept, indices, grid }
    }

    /// The least level below `cap`.
    fn least(&self, body: &Body, ray: &Ray, cap: f64) -> Option<Left> {
        let grid = self.grid.as_ref()?;
        let mut search = Search { body, ray, swept: &self.swept, grid, best: cap, by: None };
        search.run();
        search.by.map(|by| Left { height: search.best, by: self.indices[by as usize] })
    }
}

impl Milled {
    /// The solid swept by a cutter of this profile. `None` once `stop` returns true.
    ///
    /// It takes about 64 bytes for each move, and at most 80 MB for the grids.
    #[must_use]
    pub fn new(profile: &Profile, moves: &[Move], stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        Self::by_several(&[*profile], |_| 0, moves, stop)
    }

    /// The solid swept by several cutters; `tool_of` is the index of the profile that runs the move with an index. `None`
    /// once `stop` returns true.
    #[must_use]
    pub fn by_several(
        profiles: &[Profile],
        tool_of: impl Fn(usize) -> usize,
        moves: &[Move],
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let tools = profiles.iter().enumerate().map(|(tool, profile)| {
            let radius = profile.outer_radius();
            let clearing = Moves::new(moves, radius, stop, |index, kind| kind != MoveKind::Rapid && tool_of(index) == tool);
            let rapid = Moves::new(moves, radius, stop, |index, kind| kind == MoveKind::Rapid && tool_of(index) == tool);
            Tool { body: Body::new(profile), clearing, rapid }
        });
        let tools: Vec<Tool> = tools.collect();
        let radius = profiles.iter().map(Profile::outer_radius).fold(0.0, f64::max);
        (!stop()).then_some(Self { tools, radius })
    }

    /// The level of material left at a place with the unit normal n, n_z >= 0: the least over all cuts and links. `None`
    /// if none of them comes within the cutter's diameter over the place.
    #[must_use]
    pub fn left_at(&self, point: [f64; 3], normal: [f64; 3]) -> Option<Left> {
        CAPS.iter().find_map(|cap| self.least(cap * self.radius, point, normal, |tool| &tool.clearing))
    }

    /// How deep a rapid move cuts below a place, as a negative height. `None` if none does.
    #[must_use]
    pub fn collision_at(&self, point: [f64; 3], normal: [f64; 3]) -> Option<Left> {
        self.least(0.0, point, normal, |tool| &tool.rapid)
    }

    fn least(&self, cap: f64, point: [f64; 3], normal: [f64; 3], moves: impl Fn(&Tool) -> &Moves) -> Option<Left> {
        let mut best: Option<Left> = None;
        for tool in &self.tools {
            let cap = best.map_or(cap, |best| best.height);
            best = moves(tool).least(&tool.body, &tool.body.ray(point, normal), cap).or(best);
        }
        best
    }

    /// The cut or link that passes nearest, in plan view, to where the cutter touches a place: the one that was to finish it.
    /// Moves more than half the radius above the place do not count.
    #[must_use]
    pub fn nearest_at(&self, point: [f64; 3], normal: [f64; 3]) -> Option<u32> {
        let mut nearest = (f64::INFINITY, None);
        for Tool { body, clearing: Moves { swept, indices, grid }, .. } in &self.tools {
            let Some(grid) = grid else { continue };
            let ray = body.ray(point, normal);
            let (x, y) = (point[0] + ray.tip[0], point[1] + ray.tip[1]);
            let cells = grid.around(x, y, body.outer_radius());
            for row in cells.rows.0..=cells.rows.1 {
                for column in cells.columns.0..=cells.columns.1 {
                    for &at in grid.moves_in(column, row) {
                        let swept = &swept[at as usize];
                        let distance = swept.distance_squared(x, y);
                        if distance < nearest.0 && swept.tangent_plane(&ray) < 0.5 * body.outer_radius() {
                            nearest = (distance, Some(indices[at as usize]));
                        }
                    }
                }
            }
        }
        nearest.1
    }

    /// The cuts and links, in their order, that take more than `least` mm off what those before them left at a place.
    pub(super) fn cuts_at(&self, point: [f64; 3], normal: [f64; 3], least: f64) -> Vec<u32> {
        let mut all: Vec<(u32, usize, u32)> = Vec::new();
        for (tool, Tool { body, clearing, .. }) in self.tools.iter().enumerate() {
            let Some(grid) = &clearing.grid else { continue };
            let cells = grid.around(point[0], point[1], body.outer_radius() + 1e-6);
            for row in cells.rows.0..=cells.rows.1 {
                for column in cells.columns.0..=cells.columns.1 {
                    all.extend(grid.moves_in(column, row).iter().map(|&at| (clearing.indices[at as usize], tool, at)));
                }
            }
        }
        all.sort_unstable();
        all.dedup();
        let rays: Vec<Ray> = self.tools.iter().map(|tool| tool.body.ray(point, normal)).collect();
        let mut left = CAPS[CAPS.len() - 1] * self.radius;
        let mut cuts = Vec::new();
        for (index, tool, at) in all {
            let (body, swept) = (&self.tools[tool].body, &self.tools[tool].clearing.swept[at as usize]);
            if swept.tangent_plane(&rays[tool]) < left - least
                && let Some(level) = body.entry(swept, &rays[tool], left - least)
            {
                left = level;
                cuts.push(index);
            }
        }
        cuts
    }

    /// Calls `each` with the cutter and the index of every cut and link in whose reach the point is, some of them more than
    /// once.
    pub(super) fn each_near(&self, point: [f64; 3], mut each: impl FnMut(&Body, u32)) {
        let [x, y, z] = point;
        for Tool { body, clearing: Moves { swept, indices, grid }, .. } in &self.tools {
            let Some(grid) = grid else { continue };
            let cells = grid.around(x, y, body.outer_radius() + 1e-6);
            for row in cells.rows.0..=cells.rows.1 {
                for column in cells.columns.0..=cells.columns.1 {
                    let (lowest, distance) = grid.bound(column, row, x, y);
                    if lowest >= z || lowest + body.low(distance) > z {
                        continue;
                    }
                    for &at in grid.moves_in(column, row) {
                        let swept = &swept[at as usize];
                        if swept.lowest < z && swept.lowest + body.low(swept.distance_squared(x, y).sqrt()) <= z {
                            each(body, indices[at as usize]);
                        }
                    }
                }
            }
        }
    }
}

/// The search for the least level at one place.
struct Search<'a> {
    body: &'a Body,
    ray: &'a Ray,
    swept: &'a [Swept],
    grid: &'a MoveGrid,
    best: f64,
    by: Option<u32>,
}

/// What a move must come near to for a level under the best: the points of the ray from t = 0 to the best, in a disc of
/// plan view and under a height.
struct Target {
    centre: [f64; 2],
    half_width: f64,
    top: f64,
}

impl Search<'_> {
    /// Cells in rings around the one where the tip stands that touches the place: the first moves found there leave so
    /// little that most others are ruled out.
    fn run(&mut self) {
        let [x, y, _] = self.ray.point;
        let touching = self.grid.place(x + self.ray.tip[0], y + self.ray.tip[1]);
        let mut target = self.target();
        let mut cells = self.cells(&target);
        let mut ring = 0;
        while ring <= farthest(touching, cells) {
            let before = self.best;
            let rows = ((touching.1 - ring).max(cells.rows.0), (touching.1 + ring).min(cells.rows.1));
            for row in rows.0..=rows.1 {
                let whole = (row - touching.1).abs() == ring;
                let columns = ((touching.0 - ring).max(cells.columns.0), (touching.0 + ring).min(cells.columns.1));
                if whole {
                    (columns.0..=columns.1).for_each(|column| self.cell(column, row, &mut target));
                } else {
                    [touching.0 - ring, touching.0 + ring]
                        .into_iter()
                        .filter(|column| (cells.columns.0..=cells.columns.1).contains(column))
                        .for_each(|column| self.cell(column, row, &mut target));
                }
            }
            if self.best < before {
                cells = self.cells(&target);
            }
            ring += 1;
        }
    }

    fn target(&self) -> Target {
        let (p, n) = (self.ray.point, self.ray.normal);
        let t = self.best.max(0.0);
        let half = 0.5 * t;
        Target { centre: [p[0] + half * n[0], p[1] + half * n[1]], half_width: half * n[0].hypot(n[1]), top: p[2] + (t * n[2]).max(0.0) }
    }

    fn cells(&self, target: &Target) -> Cells {
        self.grid.around(target.centre[0], target.centre[1], self.body.outer_radius() + target.half_width + 1e-6)
    }

    #[inline]
    fn cell(&mut self, column: isize, row: isize, target: &mut Target) {
        let (lowest, distance) = self.grid.bound(column, row, target.centre[0], target.centre[1]);
        // A cell without moves has an infinite lowest height.
        if lowest >= target.top {
            return;
        }
        let (along, from_tip) = self.grid.least_along(column, row, lowest, self.ray.standing(), self.ray.normal);
        if self.ray.rules_out(along, from_tip, self.best) || lowest + self.body.low((distance - target.half_width).max(0.0)) >= target.top {
            return;
        }
        for &index in self.grid.moves_in(column, row) {
            let swept = &self.swept[index as usize];
            if swept.lowest >= target.top || self.by == Some(index) || self.ray.rules_out_move(swept, self.best) {
                continue;
            }
            let distance = (swept.distance_squared(target.centre[0], target.centre[1]).sqrt() - target.half_width).max(0.0);
            if swept.lowest + self.body.low(distance) >= target.top {
                continue;
            }
            if let Some(level) = self.body.entry(swept, self.ray, self.best) {
                self.best = level;
                self.by = Some(index);
                *target = self.target();
            }
        }
    }
}

/// The ring around the cell that contains the farthest of the others; -1 if there are none.
fn farthest(centre: (isize, isize), cells: Cells) -> isize {
    if cells.columns.0 > cells.columns.1 || cells.rows.0 > cells.rows.1 {
        return -1;
    }
    let columns = (centre.0 - cells.columns.0).max(cells.columns.1 - centre.0);
    let rows = (centre.1 - cells.rows.0).max(cells.rows.1 - centre.1);
    columns.max(rows)
}

/// The most cells and the most moves in cells: 16 MB and 64 MB.
const MOST_CELLS: f64 = 4e6;
const MOST_ENTRIES: f64 = 1.6e7;

/// The moves in a cell for which its size is chosen.
const IN_A_CELL: f64 = 6.0;

/// For each cell the moves that cross it.
#[derive(Debug, Clone)]
struct MoveGrid {
    origin: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    /// Where the moves of each cell begin in `entries`, and the end.
    starts: Vec<u32>,
    entries: Vec<u32>,
    /// The lowest height of a tip in each cell; infinite if there is none.
    lowest: Vec<f64>,
}

/// A range of columns and rows, the last ones included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cells {
    pub(super) columns: (isize, isize),
    pub(super) rows: (isize, isize),
}

impl MoveGrid {
    /// `None` if there are no moves, or once `stop` returns true.
    pub(super) fn new(moves: &[Swept], radius: f64, stop: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let (mut min, mut max, mut length) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0.0);
        for swept in moves {
            for [x, y, _] in [swept.start(), swept.end()] {
                (min[0], max[0]) = (min[0].min(x), max[0].max(x));
                (min[1], max[1]) = (min[1].min(y), max[1].max(y));
            }
            length += swept.length();
        }
        if moves.is_empty() {
            return None;
        }
        let cell = cell_size(moves.len(), length, [max[0] - min[0], max[1] - min[1]], radius);
        let count = |axis: usize| ((max[axis] - min[axis]) / cell) as usize + 1;
        let (columns, rows) = (count(0), count(1));
        let mut grid = Self {
            origin: min,
            cell,
            columns,
            rows,
            starts: vec![0; columns * rows + 1],
            entries: Vec::new(),
            lowest: vec![f64::INFINITY; columns * rows],
        };
        for (number, swept) in moves.iter().enumerate() {
            if number % 65536 == 0 && stop() {
                return None;
            }
            let mut counted = std::mem::take(&mut grid.starts);
            let mut lowest = std::mem::take(&mut grid.lowest);
            grid.for_each_cell(swept, |at, z| {
                counted[at + 1] += 1;
                lowest[at] = lowest[at].min(z);
            });
            (grid.starts, grid.lowest) = (counted, lowest);
        }
        for at in 1..grid.starts.len() {
            grid.starts[at] += grid.starts[at - 1];
        }
        let mut next = grid.starts.clone();
        let mut entries = vec![0_u32; *grid.starts.last()? as usize];
        for (number, swept) in moves.iter().enumerate() {
            if number % 65536 == 0 && stop() {
                return None;
            }
            grid.for_each_cell(swept, |at, _| {
                entries[next[at] as usize] = number as u32;
                next[at] += 1;
            });
        }
        grid.entries = entries;
        Some(grid)
    }

    /// Calls `each` with every cell that the move crosses and a bound from below of its heights there.
    fn for_each_cell(&self, swept: &Swept, mut each: impl FnMut(usize, f64)) {
        let (a, b) = (swept.start(), swept.end());
        // Cells are widened by a rounding error on all sides.
        let margin = 1e-9 * self.cell;
        let place = |value: f64, axis: usize, count: usize| (((value - self.origin[axis]) / self.cell).max(0.0) as usize).min(count - 1);
        let clip = |low: f64, high: f64, axis: usize, range: (f64, f64)| {
            let (from, step) = (a[axis], b[axis] - a[axis]);
            if step == 0.0 {
                return range;
            }
            let (one, other) = ((low - from) / step, (high - from) / step);
            (range.0.max(one.min(other)), range.1.min(one.max(other)))
        };
        let (first_row, last_row) = (place(a[1].min(b[1]) - margin, 1, self.rows), place(a[1].max(b[1]) + margin, 1, self.rows));
        for row in first_row..=last_row {
            let low = self.origin[1] + row as f64 * self.cell;
            let in_row = if first_row == last_row { (0.0, 1.0) } else { clip(low - margin, low + self.cell + margin, 1, (0.0, 1.0)) };
            let x_at = |t: f64| a[0] + t * (b[0] - a[0]);
            let (x0, x1) = (x_at(in_row.0), x_at(in_row.1));
            let (first, last) = (place(x0.min(x1) - margin, 0, self.columns), place(x0.max(x1) + margin, 0, self.columns));
            for column in first..=last {
                let low = self.origin[0] + column as f64 * self.cell;
                let range = if first == last { in_row } else { clip(low - margin, low + self.cell + margin, 0, in_row) };
                let z_at = |t: f64| a[2] + t * (b[2] - a[2]);
                let lowest = if range.0 <= range.1 { z_at(range.0).min(z_at(range.1)) } else { swept.lowest };
                each(row * self.columns + column, lowest);
            }
        }
    }

    /// The column and row of a place, also outside the grid.
    #[inline]
    pub(super) fn place(&self, x: f64, y: f64) -> (isize, isize) {
        (((x - self.origin[0]) / self.cell).floor() as isize, ((y - self.origin[1]) / self.cell).floor() as isize)
    }

    /// The cells within the distance `radius` of the place along each axis.
    #[inline]
    pub(super) fn around(&self, x: f64, y: f64, radius: f64) -> Cells {
        let (low, high) = (self.place(x - radius, y - radius), self.place(x + radius, y + radius));
        Cells { columns: (low.0.max(0), high.0.min(self.columns as isize - 1)), rows: (low.1.max(0), high.1.min(self.rows as isize - 1)) }
    }

    /// The lowest tip in a cell of the grid, and the distance in plan view of the place from the cell.
    #[inline]
    pub(super) fn bound(&self, column: isize, row: isize, x: f64, y: f64) -> (f64, f64) {
        let lowest = self.lowest[row as usize * self.columns + column as usize];
        let beyond = |value: f64, axis: usize, at: isize| {
            let low = self.origin[axis] + at as f64 * self.cell;
            (low - value).max(value - low - self.cell).max(0.0)
        };
        let (dx, dy) = (beyond(x, 0, column), beyond(y, 1, row));
        (lowest, (dx * dx + dy * dy).sqrt())
    }

    /// For tips in a cell at `lowest` or higher, the least of n.D, with D from the place `at` to the tip, and the distance in plan view of
    /// `at` from the cell.
    #[inline]
    pub(super) fn least_along(&self, column: isize, row: isize, lowest: f64, at: [f64; 3], normal: [f64; 3]) -> (f64, f64) {
        let (mut along, mut distance) = (normal[2] * (lowest - at[2]), 0.0);
        for (axis, place) in [column, row].into_iter().enumerate() {
            let low = self.origin[axis] + place as f64 * self.cell - at[axis];
            let high = low + self.cell;
            along += (normal[axis] * low).min(normal[axis] * high);
            distance += low.max(-high).max(0.0).powi(2);
        }
        (along, distance.sqrt())
    }

    #[inline]
    pub(super) fn moves_in(&self, column: isize, row: isize) -> &[u32] {
        let at = row as usize * self.columns + column as usize;
        &self.entries[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}

/// The size of cells that hold a few moves each: between a sixteenth of the cutter's radius and the radius, and larger
/// where the grid would need too much memory.
fn cell_size(moves: usize, length: f64, [width, height]: [f64; 2], radius: f64) -> f64 {
    let count = moves as f64;
    // Lines of this length per area and moves per area give cell (cell moves + length) per cell.
    let area = (width.max(radius)) * (height.max(radius));
    let (per_area, line) = (count / area, length / area);
    let ideal = ((line * line + 4.0 * per_area * IN_A_CELL).sqrt() - line) / (2.0 * per_area);
    let most_entries = (MOST_ENTRIES - 4.0 * count).max(0.25 * MOST_ENTRIES);
    ideal
        .clamp(radius / 16.0, radius)
        .max((width * height / MOST_CELLS).sqrt())
        .max(width.max(height) / MOST_CELLS)
        .max(1.3 * length / most_entries)
        .max(1e-6)
}
