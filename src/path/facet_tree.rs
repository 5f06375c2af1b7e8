//! The facets of a part in a tree of boxes seen from above, each with two upper bounds of its facets' heights.

use rayon::join;

/// The most facets in a leaf.
const LEAF: usize = 8;

/// The smallest number of facets whose halves are worth two threads, and between which cancellation is looked for.
const PARALLEL: usize = 4096;

/// The steepest bounding plane. Steeper ones would lose digits and bound no better than the highest point.
const STEEPEST: f64 = 30.0;

/// A part of the facets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) min: [f64; 2],
    pub(super) max: [f64; 2],
    /// The height of the highest point.
    pub(super) top: f64,
    /// No point is over the plane z = `offset` + `gradient`.(x, y).
    pub(super) gradient: [f64; 2],
    pub(super) offset: f64,
    /// The tangent of that plane's slope.
    pub(super) tangent: f64,
    /// For a leaf, the place of its first facet; else the index of its second child. The first child follows its parent.
    pub(super) next: u32,
    /// The number of facets of a leaf; 0 for others.
    pub(super) facets: u32,
}

/// The centre of a facet's box, and the facet.
#[derive(Debug, Clone, Copy)]
struct Key {
    centre: [f64; 2],
    facet: u32,
}

/// The tree, and the facets in the order of its leaves.
#[derive(Debug, Clone)]
pub(super) struct FacetTree {
    pub(super) nodes: Vec<Node>,
    pub(super) order: Vec<u32>,
}

impl Node {
    const EMPTY: Self = Self {
        min: [f64::INFINITY; 2],
        max: [f64::NEG_INFINITY; 2],
        top: f64::NEG_INFINITY,
        gradient: [0.0; 2],
        offset: f64::NEG_INFINITY,
        tangent: 0.0,
        next: 0,
        facets: 0,
    };

    fn include(&mut self, other: &Self) {
        for axis in 0..2 {
            self.min[axis] = self.min[axis].min(other.min[axis]);
            self.max[axis] = self.max[axis].max(other.max[axis]);
        }
        self.top = self.top.max(other.top);
    }

    /// Sets the bounding plane's gradient to the mean of the facets seen from above, whose area vectors have this sum.
    fn lean(&mut self, [x, y, z]: [f64; 3]) {
        let gradient = [-x / z, -y / z];
        let tangent = gradient[0].hypot(gradient[1]);
        if tangent < STEEPEST {
            (self.gradient, self.tangent) = (gradient, tangent);
        }
    }

    /// The height of the bounding plane.
    pub(super) fn plane_at(&self, [x, y]: [f64; 2]) -> f64 {
        self.offset + self.gradient[0] * x + self.gradient[1] * y
    }

    /// The square of the distance of a point from the box seen from above.
    pub(super) fn squared_distance(&self, [x, y]: [f64; 2]) -> f64 {
        let dx = (self.min[0] - x).max(x - self.max[0]).max(0.0);
        let dy = (self.min[1] - y).max(y - self.max[1]).max(0.0);
        dx * dx + dy * dy
    }
}

impl FacetTree {
    /// The tree of `count` facets. It is empty if `stop` returned true before it was complete.
    pub(super) fn of(count: usize, corners: &(impl Fn(usize) -> [[f64; 3]; 3] + Sync), stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let nodes = nodes_of(count);
        #[expect(clippy::cast_possible_truncation, reason = "meshes number their facets with 32 bits")]
        let mut keys: Vec<Key> = (0..count)
            .map(|facet| {
                let mid = |axis: usize| {
                    let [a, b, c] = corners(facet).map(|corner| corner[axis]);
                    0.5 * (a.min(b).min(c) + a.max(b).max(c))
                };
                Key { centre: [mid(0), mid(1)], facet: facet as u32 }
            })
            .collect();
        let mut tree = Self { nodes: vec![Node::EMPTY; nodes], order: Vec::new() };
        if count > 0 {
            build(&mut keys, &mut tree.nodes, [0, 0], corners, stop);
        }
        if stop() {
            return Self { nodes: Vec::new(), order: Vec::new() };
        }
        tree.order = keys.iter().map(|key| key.facet).collect();
        tree
    }
}

/// The number of nodes over this many facets.
fn nodes_of(facets: usize) -> usize {
    if facets == 0 { 0 } else { 2 * facets.div_ceil(LEAF) - 1 }
}

/// Builds the nodes of these facets; `at` is the index of the first of them and the place of the first facet. Returns the
/// sum of the facets' area vectors.
#[expect(clippy::cast_possible_truncation, reason = "there are fewer nodes than facets, whose numbers have 32 bits")]
fn build(
    keys: &mut [Key],
    nodes: &mut [Node],
    [node_at, facet_at]: [usize; 2],
    corners: &(impl Fn(usize) -> [[f64; 3]; 3] + Sync),
    stop: &(dyn Fn() -> bool + Sync),
) -> [f64; 3] {
    let Some((node, rest)) = nodes.split_first_mut() else { return [0.0; 3] };
    if keys.len() <= LEAF {
        *node = Node { next: facet_at as u32, facets: keys.len() as u32, ..Node::EMPTY };
        return fill_leaf(node, keys, corners);
    }
    if keys.len() >= PARALLEL && stop() {
        return [0.0; 3];
    }
    let half = LEAF * (keys.len().div_ceil(LEAF) / 2);
    let axis = longer_axis(keys);
    keys.select_nth_unstable_by(half, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
    let worth_two_threads = keys.len() >= PARALLEL;
    let (first_keys, second_keys) = keys.split_at_mut(half);
    let first_count = nodes_of(half);
    let (first, second) = rest.split_at_mut(first_count);
    let second_at = [node_at + 1 + first_count, facet_at + half];
    let mut one = || build(first_keys, first, [node_at + 1, facet_at], corners, stop);
    let mut other = || build(second_keys, second, second_at, corners, stop);
    let (a, b) = if worth_two_threads { join(one, other) } else { (one(), other()) };
    let area = [0, 1, 2].map(|axis| a[axis] + b[axis]);
    *node = Node { next: second_at[0] as u32, ..Node::EMPTY };
    let children = [&rest[0], &rest[first_count]];
    for child in children {
        node.include(child);
    }
    node.lean(area);
    for child in children {
        // The child's plane over its box, measured from this plane.
        let over = (0..2).fold(child.offset, |over, axis| {
            let steeper = child.gradient[axis] - node.gradient[axis];
            over + (steeper * child.min[axis]).max(steeper * child.max[axis])
        });
        node.offset = node.offset.max(over);
    }
    area
}

fn longer_axis(keys: &[Key]) -> usize {
    let extent = |axis: usize| {
        let ends =
            keys.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[min, max], key| [min.min(key.centre[axis]), max.max(key.centre[axis])]);
        ends[1] - ends[0]
    };
    usize::from(extent(1) > extent(0))
}

fn fill_leaf(node: &mut Node, keys: &[Key], corners: &impl Fn(usize) -> [[f64; 3]; 3]) -> [f64; 3] {
    let mut area = [0.0; 3];
    let facets = || keys.iter().map(|key| corners(key.facet as usize));
    for [a, b, c] in facets() {
        for [x, y, z] in [a, b, c] {
            node.include(&Node { min: [x, y], max: [x, y], top: z, ..Node::EMPTY });
        }
        let (u, v) = ([0, 1, 2].map(|axis| b[axis] - a[axis]), [0, 1, 2].map(|axis| c[axis] - a[axis]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        // Facets count as seen from above, whichever side that is.
        let sign = normal[2].signum();
        area.iter_mut().zip(normal).for_each(|(sum, part)| *sum += sign * part);
    }
    node.lean(area);
    for [x, y, z] in facets().flatten() {
        node.offset = node.offset.max(z - node.gradient[0] * x - node.gradient[1] * y);
    }
    area
}
