//! What given moves of a cutter leave on a surface.

#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_possible_wrap,
    reason = "cells and moves are fewer than 2^32"
)]

use super::body::{Body, Ray, Swept};
use super::move_grid::{Cells, MoveGrid};
use super::moves::{Move, MoveKind};
use crate::milling::Profile;

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
        let chosen = || moves.iter().enumerate().filter(|(index, each)| wanted(*index, each.kind));
        let swept: Vec<Swept> = chosen().map(|(_, each)| Swept::new(each.from, each.to)).collect();
        let indices = chosen().map(|(index, _)| index as u32).collect();
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
