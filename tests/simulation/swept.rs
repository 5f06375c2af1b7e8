//! A referee for tool paths: the signed distance of points to the solid that a cutter sweeps along straight moves. It knows
//! the cutter's solid and points of a surface, no ray, no raster and no scallop height.

/// A toroidal cutter as a solid over its tip, without an upper end: R and r in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Torus {
    pub(crate) outer: f64,
    pub(crate) corner: f64,
}

impl Torus {
    /// The signed distance in mm of a point, relative to the tip, to the solid: negative inside. It is a convex function.
    pub(crate) fn distance(self, [x, y, z]: [f64; 3]) -> f64 {
        let Self { outer, corner } = self;
        // Of the core: a cylinder of the radius R - r that begins at the height r over the tip.
        let beside = x.hypot(y) - (outer - corner);
        let below = corner - z;
        let to_core = match (beside > 0.0, below > 0.0) {
            (true, true) => beside.hypot(below),
            _ => beside.max(below),
        };
        to_core - corner
    }

    /// The same for the solid swept from one tip to another, where it is below `cap`; else `cap`. The distance along the
    /// move is convex, and changes by no more than the tip moves.
    fn swept_distance(self, point: [f64; 3], [from, to]: [[f64; 3]; 2], cap: f64) -> f64 {
        let at = |l: f64| self.distance([0, 1, 2].map(|axis| point[axis] - from[axis] - l * (to[axis] - from[axis])));
        let length = distance(from, to);
        let mut least = at(0.5).min(cap);
        if at(0.5) - 0.5 * length >= least {
            return least;
        }
        least = least.min(at(0.0)).min(at(1.0));
        let golden = 0.618_033_988_749_895;
        let (mut low, mut high) = (0.0, 1.0);
        let (mut a, mut b) = (1.0 - golden, golden);
        let (mut at_a, mut at_b) = (at(a), at(b));
        for _ in 0..40 {
            least = least.min(at_a).min(at_b);
            if at_a.min(at_b) - (high - low) * length >= least - 1e-7 || (high - low) * length < 1e-7 {
                break;
            }
            if at_a < at_b {
                (high, b, at_b) = (b, a, at_a);
                a = high - golden * (high - low);
                at_a = at(a);
            } else {
                (low, a, at_a) = (a, b, at_b);
                b = low + golden * (high - low);
                at_b = at(b);
            }
        }
        least
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

/// Moves in pieces, in square cells seen from above.
#[derive(Debug)]
pub(crate) struct Swept {
    cutter: Torus,
    low: [f64; 2],
    cells: [usize; 2],
    starts: Vec<usize>,
    /// The pieces, those of cell c from `starts[c]` to `starts[c + 1]`; each is in the cell of its middle.
    pieces: Vec<[[f64; 3]; 2]>,
}

/// The side of a cell and the longest piece, in mm.
const CELL: f64 = 1.0;
const LONGEST: f64 = 1.0;

impl Swept {
    pub(crate) fn new(cutter: Torus, moves: impl IntoIterator<Item = [[f64; 3]; 2]>) -> Self {
        let mut all: Vec<[[f64; 3]; 2]> = Vec::new();
        for [from, to] in moves {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "thousands")]
            let count = (distance(from, to) / LONGEST).ceil().max(1.0) as u32;
            let at = |part: u32| [0, 1, 2].map(|axis| from[axis] + f64::from(part) / f64::from(count) * (to[axis] - from[axis]));
            all.extend((0..count).map(|part| [at(part), at(part + 1)]));
        }
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for [x, y] in all.iter().map(middle) {
            (low, high) = ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]);
        }
        if all.is_empty() {
            (low, high) = ([0.0; 2], [0.0; 2]);
        }
        let cells = [0, 1].map(|axis| cell(high[axis] - low[axis]) + 1);
        let mut sorted: Vec<(usize, [[f64; 3]; 2])> =
            all.into_iter().map(|piece| (cell(middle(&piece)[1] - low[1]) * cells[0] + cell(middle(&piece)[0] - low[0]), piece)).collect();
        sorted.sort_by_key(|(cell, _)| *cell);
        let starts = (0..=cells[0] * cells[1]).map(|cell| sorted.partition_point(|(other, _)| *other < cell)).collect();
        Self { cutter, low, cells, starts, pieces: sorted.into_iter().map(|(_, piece)| piece).collect() }
    }

    /// The signed distance in mm of a point to the swept solid, at most `cap`. Positive: material is left over the point;
    /// negative: it is cut away.
    pub(crate) fn distance(&self, point: [f64; 3], cap: f64) -> f64 {
        let reach = self.cutter.outer + cap + 0.5 * LONGEST;
        let [columns, rows] = [0, 1].map(|axis| {
            let range = [point[axis] - reach - self.low[axis], point[axis] + reach - self.low[axis]];
            if range[1] < 0.0 { 0..0 } else { cell(range[0].max(0.0))..(cell(range[1]) + 1).min(self.cells[axis]) }
        });
        let mut least = cap;
        for row in rows {
            let from = row * self.cells[0];
            for piece in columns.clone().flat_map(|column| &self.pieces[self.starts[from + column]..self.starts[from + column + 1]]) {
                least = least.min(self.cutter.swept_distance(point, *piece, least));
            }
        }
        least
    }
}

fn middle([a, b]: &[[f64; 3]; 2]) -> [f64; 2] {
    [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])]
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few thousand cells of parts")]
fn cell(from_low: f64) -> usize {
    (from_low / CELL) as usize
}

#[test]
fn a_cutter_along_a_line_leaves_what_its_shape_says() {
    let [ball, flat, bull_nose] = [(3.0, 3.0), (3.0, 0.0), (5.0, 2.0)].map(|(outer, corner)| Torus { outer, corner });
    let along = |cutter: Torus| Swept::new(cutter, [[[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]]);
    for aside in [0.0_f64, 0.3, 1.0, 2.9] {
        // The distance of a point of the plane to a ball that rolls along a line of it.
        let expected = aside.hypot(3.0) - 3.0;
        approx::assert_abs_diff_eq!(along(ball).distance([7.3, aside, 0.0], 5.0), expected, epsilon = 1e-6);
        approx::assert_abs_diff_eq!(along(flat).distance([7.3, aside, 0.0], 5.0), 0.0, epsilon = 1e-9);
        let expected = (aside - 3.0).max(0.0).hypot(2.0) - 2.0;
        approx::assert_abs_diff_eq!(along(bull_nose).distance([7.3, aside, 0.0], 5.0), expected, epsilon = 1e-6);
    }
    // Beside the end of the path, over the floor in the cutter, and farther than the cap.
    approx::assert_abs_diff_eq!(along(flat).distance([24.0, 0.0, 1.0], 5.0), 1.0, epsilon = 1e-9);
    approx::assert_abs_diff_eq!(along(flat).distance([7.3, 0.0, 0.5], 5.0), -0.5, epsilon = 1e-9);
    approx::assert_abs_diff_eq!(along(ball).distance([7.3, 9.0, 0.0], 0.4), 0.4, epsilon = 1e-12);
}
