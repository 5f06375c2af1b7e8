//! Curves along which the tip runs level: waterlines, the level curves of T.

use super::drop_cutter::DropCutter;
use super::tip_line::Tip;
use crate::milling::Profile;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// The height in mm over a level up to which T counts as on it: the rounding of T on a level floor at that height.
const ON_LEVEL: f64 = 1e-9;

/// The most times that a chord is halved.
const MOST_SPLITS: u32 = 20;

/// A curve of tips.
#[derive(Debug, Clone, PartialEq)]
pub struct Contour {
    /// The tips in order, the inside on the left seen from above. A closed curve does not repeat its first tip.
    pub tips: Vec<Tip>,
    /// Whether the last tip is joined to the first.
    pub closed: bool,
}

/// The part of the plan view in which curves are sought, and the side of the raster's cells, in mm.
///
/// A region or a gap that has no node of the raster is not found. Curves that leave the area are open and end at its
/// border. A [`LevelMap`] takes eight bytes for each node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// The least x and y.
    pub min: [f64; 2],
    /// The largest x and y.
    pub max: [f64; 2],
    /// The largest distance of neighbouring nodes, over 0.
    pub cell: f64,
}

/// A place where a tip may be, and a facet that limits it nearby.
type Found = ([f64; 2], Option<u32>);

/// The heights of the tips' surface on a raster, from which its level curves are found.
#[derive(Debug, Clone)]
pub struct LevelMap<'a> {
    drop: &'a DropCutter,
    profile: &'a Profile,
    raster: Raster,
    heights: Vec<f64>,
}

impl<'a> LevelMap<'a> {
    /// The heights on the raster of the area. If `stop` returns true the result is incomplete and to be discarded.
    #[must_use]
    pub fn new(drop: &'a DropCutter, profile: &'a Profile, area: &Area, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let raster = Raster::of(area);
        let heights = raster.nodes(|[x, y]| {
            if stop() { f64::NEG_INFINITY } else { drop.drop(profile, x, y, None).map_or(f64::NEG_INFINITY, |touch| touch.height) }
        });
        Self { drop, profile, raster, heights }
    }

    /// The curves T(x, y) = z for each of the levels z in mm, as borders of the region in which a tip at the height z cuts
    /// nothing. Their tips are inside, within a hundredth of the tolerance (over 0) of the border; chords leave the inside by at most
    /// the tolerance, and keep within it of the border. If `stop` returns true the result is incomplete and to be discarded.
    #[must_use]
    pub fn waterlines(&self, levels: &[f64], tolerance: f64, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Vec<Contour>> {
        let of_level = |&level: &f64| {
            let Self { drop, profile, raster, ref heights } = *self;
            Tracer { drop, profile, raster, level, tolerance, stop }.contours(|node| heights[node] <= level + ON_LEVEL)
        };
        levels.par_iter().with_max_len(1).map(of_level).collect()
    }
}

/// The nodes at which labels are taken.
#[derive(Debug, Clone, Copy)]
struct Raster {
    min: [f64; 2],
    step: [f64; 2],
    columns: usize,
    rows: usize,
}

impl Raster {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of nodes that fit the memory")]
    fn of(area: &Area) -> Self {
        let cells = [0, 1].map(|axis| ((area.max[axis] - area.min[axis]) / area.cell).ceil().max(1.0));
        let step = [0, 1].map(|axis| (area.max[axis] - area.min[axis]) / cells[axis]);
        Self { min: area.min, step, columns: cells[0] as usize + 1, rows: cells[1] as usize + 1 }
    }

    #[expect(clippy::cast_precision_loss, reason = "numbers of columns and rows are small")]
    fn place(&self, node: usize) -> [f64; 2] {
        let (column, row) = (node % self.columns, node / self.columns);
        [self.min[0] + column as f64 * self.step[0], self.min[1] + row as f64 * self.step[1]]
    }

    fn nodes<T: Send>(&self, label: impl Fn([f64; 2]) -> T + Sync + Send) -> Vec<T> {
        (0..self.columns * self.rows).into_par_iter().with_min_len(64).map(|node| label(self.place(node))).collect()
    }
}

/// A line between neighbouring nodes of which one is inside: the node nearer to the first, and whether the other is above
/// it in the next row, or beside it.
type Crossing = (usize, bool);

/// Finds the border of where a cutter with its tip at a level cuts nothing.
struct Tracer<'a> {
    drop: &'a DropCutter,
    profile: &'a Profile,
    raster: Raster,
    level: f64,
    tolerance: f64,
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// What is to be done with a chord.
enum Verdict {
    Keep,
    /// It is to pass through this tip.
    Split(Tip),
    /// It is outside, and no inside is near.
    Remove,
}

impl Tracer<'_> {
    fn contours(&self, is_inside: impl Fn(usize) -> bool + Sync) -> Vec<Contour> {
        let steps = self.steps(&is_inside);
        let mut next: HashMap<Crossing, Crossing> = steps.iter().copied().collect();
        let ends: HashSet<Crossing> = steps.iter().map(|(_, end)| *end).collect();
        let heads = steps.iter().map(|(start, _)| *start).filter(|start| !ends.contains(start));
        let starts: Vec<Crossing> = heads.chain(steps.iter().map(|(start, _)| *start)).collect();
        let mut contours = Vec::new();
        // Open curves from their heads first; what is left are closed ones, from anywhere.
        for start in starts {
            let Some(mut at) = next.remove(&start) else { continue };
            let mut chain = vec![start, at];
            while let Some(then) = next.remove(&at) {
                chain.push(then);
                at = then;
            }
            let closed = at == start;
            if (self.stop)() {
                return Vec::new();
            }
            let tip_on = |near: &mut Option<u32>, crossing: &Crossing| self.tip_on(*crossing, is_inside(crossing.0), near);
            let tips: Vec<Option<Tip>> = chain.par_iter().with_min_len(16).map_init(|| None, tip_on).collect();
            contours.extend(self.refined(&tips.into_iter().flatten().collect::<Vec<_>>(), closed));
        }
        contours
    }

    /// `None` where the tip may not be. `near`, a facet that limits the tip nearby, becomes the one found here: it saves time, and
    /// changes no answer. The search asks mostly this, which the first facet found to lift the cutter answers; what is touched is
    /// sought for the tips of the curves alone.
    fn at(&self, [x, y]: [f64; 2], near: &mut Option<u32>) -> Option<Found> {
        let lifting = self.drop.lifting(self.profile, [x, y, self.level + ON_LEVEL], *near);
        *near = lifting.or(*near);
        lifting.is_none().then_some(([x, y], *near))
    }

    fn tip(&self, ([x, y], near): Found) -> Tip {
        Tip { position: [x, y, self.level], touch: self.drop.drop(self.profile, x, y, near) }
    }

    /// The border's way through the raster's cells, from crossing to crossing, with the inside on the left.
    fn steps(&self, is_inside: &(impl Fn(usize) -> bool + Sync)) -> Vec<(Crossing, Crossing)> {
        let columns = self.raster.columns;
        let of_row = |row: usize| {
            let mut steps = Vec::new();
            for first in row * columns..row * columns + columns - 1 {
                // Counter-clockwise; the crossing k is between the corners k and k + 1.
                let corners = [first, first + 1, first + columns + 1, first + columns];
                let crossings = [(first, false), (first + 1, true), (first + columns, false), (first, true)];
                let inside = corners.map(is_inside);
                let leaves = |k: usize| inside[k] && !inside[(k + 1) % 4];
                let enters = |k: usize| !inside[k] && inside[(k + 1) % 4];
                let is_saddle = leaves(0) && leaves(2) || leaves(1) && leaves(3);
                let are_joined = is_saddle && {
                    let [x, y] = self.raster.place(first);
                    self.at([x + 0.5 * self.raster.step[0], y + 0.5 * self.raster.step[1]], &mut None).is_some()
                };
                for k in (0..4).filter(|k| leaves(*k)) {
                    // In a saddle whose two inside corners are joined, the border goes around the outside corner that
                    // follows, else around the inside corner.
                    let end = if are_joined { Some((k + 1) % 4) } else { (1..4).map(|back| (k + 4 - back) % 4).find(|k| enters(*k)) };
                    steps.extend(end.map(|end| (crossings[k], crossings[end])));
                }
            }
            steps
        };
        (0..self.raster.rows - 1).into_par_iter().flat_map_iter(of_row).collect()
    }

    fn tip_on(&self, (node, is_above): Crossing, is_first_inside: bool, near: &mut Option<u32>) -> Option<Tip> {
        let other = if is_above { node + self.raster.columns } else { node + 1 };
        let [inner, outer] = if is_first_inside { [node, other] } else { [other, node] };
        let found = self.at(self.raster.place(inner), near)?;
        Some(self.last_inside(found, self.raster.place(outer), near))
    }

    /// The last tip inside on the line from a place inside to one outside.
    fn last_inside(&self, mut found: Found, mut outside: [f64; 2], near: &mut Option<u32>) -> Tip {
        let resolution = (1e-2 * self.tolerance).max(1e-9);
        loop {
            let ([x, y], _) = found;
            if (outside[0] - x).hypot(outside[1] - y) <= resolution {
                return self.tip(found);
            }
            let middle = [0.5 * (x + outside[0]), 0.5 * (y + outside[1])];
            match self.at(middle, near) {
                Some(nearer) => found = nearer,
                None => outside = middle,
            }
        }
    }

    /// The curves through these tips with chords that keep half of the tolerance, without the tips that the other half
    /// makes needless. A chord that has to be removed divides the curve.
    fn refined(&self, tips: &[Tip], closed: bool) -> Vec<Contour> {
        let chords: Vec<Vec<Option<Tip>>> = tips
            .par_windows(2)
            .with_min_len(4)
            .map(|ends| {
                let mut through = Vec::new();
                self.refine(&ends[0], ends[1], MOST_SPLITS, &mut through);
                through
            })
            .collect();
        let mut curves = vec![tips.first().copied().into_iter().collect::<Vec<_>>()];
        for tip in chords.into_iter().flatten() {
            match (tip, curves.last_mut()) {
                (Some(tip), Some(curve)) => curve.push(tip),
                _ => curves.push(Vec::new()),
            }
        }
        let closed = closed && curves.len() == 1;
        let mut contours = Vec::new();
        for curve in curves.into_iter().filter(|curve| curve.len() > 1) {
            let mut tips = simplified(&curve, 0.5 * self.tolerance);
            if closed {
                tips.pop();
            }
            contours.push(Contour { tips, closed });
        }
        contours
    }

    /// Adds the tips after `a` up to `b`, and `None` in place of a chord that has to be removed.
    fn refine(&self, a: &Tip, b: Tip, splits: u32, through: &mut Vec<Option<Tip>>) {
        let length = distance(a, &b);
        let verdict =
            if splits == 0 || length <= 0.1 * self.tolerance || (self.stop)() { Verdict::Keep } else { self.verdict(a, &b, length) };
        match verdict {
            Verdict::Keep => through.push(Some(b)),
            Verdict::Split(tip) => {
                self.refine(a, tip, splits - 1, through);
                self.refine(&tip, b, splits - 1, through);
            }
            Verdict::Remove => through.extend([None, Some(b)]),
        }
    }

    /// Looks for the border across three places of a chord.
    fn verdict(&self, a: &Tip, b: &Tip, length: f64) -> Verdict {
        let close = 0.5 * self.tolerance;
        let along = [0, 1].map(|axis| (b.position[axis] - a.position[axis]) / length);
        let mut near = a.touch.or(b.touch).map(|touch| touch.facet);
        for share in [0.5, 0.25, 0.75] {
            let [x, y] = [0, 1].map(|axis| a.position[axis] + share * (b.position[axis] - a.position[axis]));
            // The inside is on the left.
            let place = |inwards: f64| [x - along[1] * inwards, y + along[0] * inwards];
            let here = self.at(place(0.0), &mut near);
            let towards = if here.is_some() { -1.0 } else { 1.0 };
            let (mut found, mut outside) = (here, here.is_none().then(|| place(0.0)));
            let mut reach = close;
            while (found.is_none() || outside.is_none()) && reach <= length.max(close) {
                match self.at(place(towards * reach), &mut near) {
                    Some(farther) => found = Some(farther),
                    None => outside = Some(place(towards * reach)),
                }
                reach *= 2.0;
            }
            match (found, outside) {
                // The first place looked at is within half of the tolerance.
                (Some(found), Some(outside)) if reach > 2.0 * close => return Verdict::Split(self.last_inside(found, outside, &mut near)),
                (None, _) => return Verdict::Remove,
                // Near the border, or inside and farther from it than the chord is long.
                _ => {}
            }
        }
        Verdict::Keep
    }
}

fn distance(a: &Tip, b: &Tip) -> f64 {
    (b.position[0] - a.position[0]).hypot(b.position[1] - a.position[1])
}

/// The first and the last tip, and those between that chords without them would miss by more than `tolerance` (Douglas and Peucker
/// 1973).
fn simplified(tips: &[Tip], tolerance: f64) -> Vec<Tip> {
    let mut keep = vec![false; tips.len()];
    let mut parts = vec![(0, tips.len() - 1)];
    while let Some((first, last)) = parts.pop() {
        (keep[first], keep[last]) = (true, true);
        let farthest = (first + 1..last).map(|at| (at, off_chord(&tips[at], &tips[first], &tips[last]))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((at, off)) = farthest
            && off > tolerance
        {
            parts.extend([(first, at), (at, last)]);
        }
    }
    tips.iter().zip(keep).filter(|(_, keep)| *keep).map(|(tip, _)| *tip).collect()
}

/// The distance of a tip from a chord.
fn off_chord(tip: &Tip, a: &Tip, b: &Tip) -> f64 {
    let [along, out] = [b, tip].map(|end| [0, 1].map(|axis| end.position[axis] - a.position[axis]));
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((out[0] * along[0] + out[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (out[0] - share * along[0]).hypot(out[1] - share * along[1])
}

#[cfg(test)]
mod tests;
