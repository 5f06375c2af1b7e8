//! Runs along the feet of walls: the border of where the tip stands on what is to be machined, as far as it touches a wall
//! there. Lines that end at a wall leave triangles between their ends, and lines beside a wall a strip.

use super::judged::Judged;
use super::runs::{Run, RunMaker, RunTip};
use super::stations::Station;
use crate::path::Touch;
use rayon::prelude::*;
use std::collections::{HashMap, HashSet};

/// Cells of the raster in a cutter's radius. A border that bends twice within a cell is cut short there.
const CELLS_IN_RADIUS: f64 = 8.0;

/// The most cells of the raster beside places that are left standing.
const MOST_CELLS: usize = 100_000;

/// The width in mm to which the border is narrowed down.
const EXACT: f64 = 1e-5;

/// The most halvings of a chord along the border.
const MOST_HALVINGS: u32 = 12;

/// A node of the raster, or of its cells the one with the lowest coordinates.
type Node = [i32; 2];

/// The edge of a cell from a node in the direction of x (0) or y (1).
type Edge = (Node, usize);

/// A position of the axis, and how the tip rests there if that is on what is to be machined.
#[derive(Debug, Clone, Copy)]
struct Probe {
    axis: [f64; 2],
    height: f64,
    standing: Option<(usize, Touch)>,
}

/// The runs along borders beside stations that the cutter can reach and a path leaves standing.
pub(super) fn border_runs(maker: &RunMaker, stations: &[Station], judged: &[Judged], height: f64) -> Vec<Run> {
    let cell = maker.prepared.profile.outer_radius() / CELLS_IN_RADIUS;
    let stands = |(station, judged): &(&Station, &Judged)| station.lift <= height && judged.left.is_none_or(|left| left > 1.5 * height);
    let mut cells: HashSet<Node> = HashSet::new();
    for (station, _) in stations.iter().zip(judged).filter(stands) {
        #[expect(clippy::cast_possible_truncation, reason = "extents over cells are under 2^31")]
        let own = station.axis.map(|part| (part / cell).floor() as i32);
        for x in -2..=2 {
            for y in -2..=2 {
                cells.insert([own[0] + x, own[1] + y]);
            }
        }
    }
    if cells.is_empty() || cells.len() > MOST_CELLS {
        return Vec::new();
    }
    let tracer = Tracer { maker, cell };
    let mut nodes: Vec<Node> = cells.iter().flat_map(|&[x, y]| [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]]).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let probes: HashMap<Node, Probe> = nodes.par_iter().map(|&node| (node, tracer.probe(tracer.at(node)))).collect();
    let mut cells: Vec<Node> = cells.into_iter().collect();
    cells.sort_unstable();
    let segments: Vec<[Edge; 2]> = cells.iter().flat_map(|&cell| segments_of(cell, &probes)).collect();
    let mut edges: Vec<Edge> = segments.iter().flatten().copied().collect();
    edges.sort_unstable();
    edges.dedup();
    let crossings: HashMap<Edge, Option<Probe>> = edges.par_iter().map(|&edge| (edge, tracer.crossing(edge, &probes))).collect();
    chains(&segments)
        .into_par_iter()
        .flat_map_iter(|chain| {
            let points: Vec<Option<Probe>> = chain.iter().map(|edge| crossings.get(edge).copied().flatten()).collect();
            points.split(Option::is_none).filter(|stretch| stretch.len() > 1).map(|stretch| tracer.run(stretch)).collect::<Vec<_>>()
        })
        .collect()
}

/// The lines of the border through a cell, each from one of its edges to another.
fn segments_of([x, y]: Node, probes: &HashMap<Node, Probe>) -> Vec<[Edge; 2]> {
    let stands = |node: Node| probes.get(&node).is_some_and(|probe| probe.standing.is_some());
    let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
    let edges: [Edge; 4] = [([x, y], 0), ([x + 1, y], 1), ([x, y + 1], 0), ([x, y], 1)];
    let crossed: Vec<Edge> = (0..4).filter(|side| stands(corners[*side]) != stands(corners[(side + 1) % 4])).map(|side| edges[side]).collect();
    match crossed[..] {
        [a, b] => vec![[a, b]],
        // Two corners opposite each other: each is cut off.
        [a, b, c, d] if stands(corners[0]) => vec![[a, d], [b, c]],
        [a, b, c, d] => vec![[a, b], [c, d]],
        _ => Vec::new(),
    }
}

/// Segments joined at their edges to chains; a closed chain ends where it begins.
fn chains(segments: &[[Edge; 2]]) -> Vec<Vec<Edge>> {
    let mut at: HashMap<Edge, Vec<usize>> = HashMap::new();
    for (index, ends) in segments.iter().enumerate() {
        for end in ends {
            at.entry(*end).or_default().push(index);
        }
    }
    let mut open = vec![true; segments.len()];
    let mut chains = Vec::new();
    // Open chains begin at an end that no other segment shares.
    let is_end = |index: usize| segments[index].iter().position(|end| at[end].len() == 1);
    let starts = (0..segments.len()).filter_map(|index| is_end(index).map(|end| (index, end))).chain((0..segments.len()).map(|index| (index, 0)));
    for (first, end) in starts {
        if !open[first] {
            continue;
        }
        let mut chain = vec![segments[first][end]];
        let mut next = Some(first);
        while let Some(index) = next {
            open[index] = false;
            let last = chain[chain.len() - 1];
            let [a, b] = segments[index];
            let end = if a == last { b } else { a };
            chain.push(end);
            next = at[&end].iter().copied().find(|other| open[*other]);
        }
        chains.push(chain);
    }
    chains
}

struct Tracer<'a> {
    maker: &'a RunMaker<'a>,
    cell: f64,
}

impl Tracer<'_> {
    fn at(&self, node: Node) -> [f64; 2] {
        node.map(|part| f64::from(part) * self.cell)
    }

    fn probe(&self, axis: [f64; 2]) -> Probe {
        let touch = self.maker.workpiece.drop.drop(&self.maker.prepared.profile, axis[0], axis[1], None);
        let standing = touch.and_then(|touch| Some((self.maker.target_under(axis, &touch)?, touch)));
        Probe { axis, height: touch.map_or(f64::NEG_INFINITY, |touch| touch.height), standing }
    }

    /// The last position that stands on the way from one position to another, and the first that does not.
    fn last_standing(&self, inside: Probe, outside: Probe) -> (Probe, Probe) {
        let (mut inside, mut outside) = (inside, outside);
        while (inside.axis[0] - outside.axis[0]).hypot(inside.axis[1] - outside.axis[1]) > EXACT {
            let middle = self.probe([0, 1].map(|part| f64::midpoint(inside.axis[part], outside.axis[part])));
            if middle.standing.is_some() { inside = middle } else { outside = middle }
        }
        (inside, outside)
    }

    /// Where the border crosses an edge of the raster; `None` if nothing rises there: the surface ends without a wall.
    fn crossing(&self, (node, direction): Edge, probes: &HashMap<Node, Probe>) -> Option<Probe> {
        let mut other = node;
        other[direction] += 1;
        let (one, other) = (*probes.get(&node)?, *probes.get(&other)?);
        let (inside, outside) = if one.standing.is_some() { (one, other) } else { (other, one) };
        let (last, beyond) = self.last_standing(inside, outside);
        let rise = (beyond.height - last.height).max(outside.height - last.height);
        (rise > self.maker.chord_tolerance).then_some(last)
    }

    /// The run through points of the border, with further points until chords keep the tolerance.
    fn run(&self, points: &[Option<Probe>]) -> Run {
        let points: Vec<Probe> = points.iter().flatten().copied().collect();
        let mut all = vec![points[0]];
        for pair in points.windows(2) {
            self.refine(pair[0], pair[1], MOST_HALVINGS, &mut all);
        }
        let tip = |probe: Probe| {
            let (target, contact, normal) = match probe.standing {
                Some((target, touch)) => (Some(target), touch.contact.into(), touch.normal.into()),
                None => (None, [0.0; 3], [0.0, 0.0, 1.0]),
            };
            RunTip { tip: [probe.axis[0], probe.axis[1], probe.height], target, contact, normal }
        };
        Run::along_border(all.into_iter().map(tip).collect())
    }

    /// Adds the border from `a`, which is there already, to `b`.
    fn refine(&self, a: Probe, b: Probe, halvings: u32, all: &mut Vec<Probe>) {
        let tolerance = self.maker.chord_tolerance;
        let chord = [b.axis[0] - a.axis[0], b.axis[1] - a.axis[1]];
        let length = chord[0].hypot(chord[1]);
        if halvings > 0 && length > 4.0 * tolerance {
            let middle = [0, 1].map(|part| f64::midpoint(a.axis[part], b.axis[part]));
            let across = [-chord[1] / length, chord[0] / length];
            let beside = |distance: f64| self.probe([middle[0] + distance * across[0], middle[1] + distance * across[1]]);
            let on_chord = beside(0.0);
            let half = length / 2.0;
            let sides = [beside(half), beside(-half)];
            let found = if on_chord.standing.is_some() {
                // The wall is on the side that does not stand.
                sides.into_iter().find(|side| side.standing.is_none() && side.height > on_chord.height).map(|wall| self.last_standing(on_chord, wall).0)
            } else {
                sides.into_iter().find(|side| side.standing.is_some()).map(|inside| self.last_standing(inside, on_chord).0)
            };
            if let Some(found) = found {
                let off = ((found.axis[0] - middle[0]) * across[0] + (found.axis[1] - middle[1]) * across[1]).abs();
                let bent = (found.height - f64::midpoint(a.height, b.height)).abs();
                if off > tolerance / 2.0 || bent > tolerance / 2.0 {
                    self.refine(a, found, halvings - 1, all);
                    self.refine(found, b, halvings - 1, all);
                    return;
                }
            }
        }
        all.push(b);
    }
}
