//! A referee for tool paths: the signed distance of points to the solid that a cutter sweeps along straight moves. It knows
//! the cutter's solid and points of a surface, no ray, no raster and no scallop height.

use scallopd::milling::Cutter;
use std::f64::consts::FRAC_PI_2;

/// A convex cutter as a solid over its tip, without an upper end: arcs of its meridian, from the tip outwards.
#[derive(Debug, Clone)]
pub(crate) struct Solid {
    pub(crate) outer: f64,
    arcs: Vec<Arc>,
}

/// An arc of the meridian: the body lies under its tangents.
#[derive(Debug, Clone, Copy)]
struct Arc {
    /// The centre's distance from the axis and height over the tip, in mm.
    centre: [f64; 2],
    radius: f64,
    /// The angles of the normals at its ends, from straight down, and these normals.
    angles: [f64; 2],
    normals: [[f64; 2]; 2],
}

impl Solid {
    /// The solid of arcs given by centre, radius, and the angles of the normals at their ends in rad, which together go from 0 to
    /// a right angle.
    pub(crate) fn new(outer: f64, arcs: &[([f64; 2], f64, [f64; 2])]) -> Self {
        let arc = |&(centre, radius, angles): &([f64; 2], f64, [f64; 2])| Arc {
            centre,
            radius,
            angles,
            normals: angles.map(|angle: f64| [angle.sin(), -angle.cos()]),
        };
        Self { outer, arcs: arcs.iter().map(arc).collect() }
    }

    /// A cutter with the outer radius R and the corner radius r in mm: a ball or a flat at the ends of the range of r.
    pub(crate) fn torus(outer: f64, corner: f64) -> Self {
        Self::new(outer, &[([outer - corner, corner], corner, [0.0, FRAC_PI_2])])
    }

    pub(crate) fn of(cutter: Cutter) -> Self {
        let profile = cutter.profile();
        let arcs: Vec<_> =
            profile.arcs().iter().map(|arc| ([arc.centre_offset, arc.centre_height], arc.radius, [arc.from, arc.to])).collect();
        Self::new(profile.outer_radius(), &arcs)
    }

    /// The signed distance in mm of a point, relative to the tip, to the solid: negative inside. It is a convex function: that of
    /// the tangent plane that the point is farthest over.
    pub(crate) fn distance(&self, point: [f64; 3]) -> f64 {
        self.distance_and_normal(point).0
    }

    /// The signed distance, and the normal of that tangent plane.
    fn distance_and_normal(&self, [x, y, z]: [f64; 3]) -> (f64, [f64; 3]) {
        let rho = (x * x + y * y).sqrt();
        let (mut most, mut meridian) = (f64::NEG_INFINITY, [0.0; 2]);
        for arc in &self.arcs {
            let from_centre = [rho - arc.centre[0], z - arc.centre[1]];
            let along = |normal: [f64; 2]| normal[0] * from_centre[0] + normal[1] * from_centre[1];
            let turn = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
            let [first, last] = arc.normals;
            let is_between = turn(first, from_centre) >= 0.0 && turn(from_centre, last) >= 0.0;
            let length = (from_centre[0] * from_centre[0] + from_centre[1] * from_centre[1]).sqrt();
            let (farthest, normal) = if is_between && length > 0.0 {
                (length, from_centre.map(|part| part / length))
            } else {
                [first, last].map(|normal| (along(normal), normal)).into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
            };
            if farthest - arc.radius > most {
                (most, meridian) = (farthest - arc.radius, normal);
            }
        }
        let [across, up] = meridian;
        let of_rho = if rho > 0.0 { across / rho } else { 0.0 };
        (most, [of_rho * x, of_rho * y, up])
    }

    /// The distance from the axis and the height over the tip of the point whose normal has this angle from straight down.
    pub(crate) fn point(&self, angle: f64) -> [f64; 2] {
        let arc = self.arcs.iter().find(|arc| angle <= arc.angles[1]).unwrap_or(&self.arcs[0]);
        [arc.centre[0] + arc.radius * angle.sin(), arc.centre[1] - arc.radius * angle.cos()]
    }

    /// The distance of a point from the solid that the cutter sweeps from one tip to another, where it is below `cap`; else `cap`.
    ///
    /// The distance is convex along the move, and so nowhere under its tangents. Between two tips on both sides of the least one the
    /// next is where their tangents meet, until what these allow is no less than what is known.
    fn swept_distance(&self, point: [f64; 3], [from, to]: [[f64; 3]; 2], cap: f64) -> f64 {
        let along = [0, 1, 2].map(|axis| to[axis] - from[axis]);
        let at = |l: f64| {
            let (distance, normal) = self.distance_and_normal([0, 1, 2].map(|axis| point[axis] - from[axis] - l * along[axis]));
            (l, distance, -(normal[0] * along[0] + normal[1] * along[1] + normal[2] * along[2]))
        };
        let middle = at(0.5);
        let mut least = middle.1.min(cap);
        let (_, distance, slope) = middle;
        if distance - 0.5 * slope.abs() >= least {
            return least;
        }
        let end = at(if slope > 0.0 { 0.0 } else { 1.0 });
        least = least.min(end.1);
        let [mut before, mut after] = if slope > 0.0 { [end, middle] } else { [middle, end] };
        for _ in 0..40 {
            if before.2 >= 0.0 || after.2 <= 0.0 {
                break;
            }
            let width = after.0 - before.0;
            // before.1 + before.2 l = after.1 - after.2 (width - l)
            let meet = ((after.1 - before.1 - after.2 * width) / (before.2 - after.2)).clamp(0.0, width);
            if before.1 + before.2 * meet >= least - 1e-7 {
                break;
            }
            let next = at(before.0 + meet.clamp(0.05 * width, 0.95 * width));
            least = least.min(next.1);
            if next.2 > 0.0 { after = next } else { before = next }
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
    cutter: Solid,
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
    pub(crate) fn new(cutter: Solid, moves: impl IntoIterator<Item = [[f64; 3]; 2]>) -> Self {
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
                // The cutter is over its tip and within its outer radius.
                if piece[0][2].min(piece[1][2]) - point[2] < least && is_within(point, piece, self.cutter.outer + least) {
                    least = least.min(self.cutter.swept_distance(point, *piece, least));
                }
            }
        }
        least
    }
}

/// Whether a point, seen from above, may be closer to a piece than `reach`: to its middle it is closer than that and half the
/// piece's length.
fn is_within(point: [f64; 3], piece: &[[f64; 3]; 2], reach: f64) -> bool {
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let [x, y] = middle(piece);
    let reach = reach + 0.5 * square([piece[1][0] - piece[0][0], piece[1][1] - piece[0][1]]).sqrt();
    square([point[0] - x, point[1] - y]) < reach * reach
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
    let [ball, flat, bull_nose] = [(3.0, 3.0), (3.0, 0.0), (5.0, 2.0)].map(|(outer, corner)| Solid::torus(outer, corner));
    let along = |cutter: &Solid| Swept::new(cutter.clone(), [[[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]]);
    for aside in [0.0_f64, 0.3, 1.0, 2.9] {
        // The distance of a point of the plane to a ball that rolls along a line of it.
        let expected = aside.hypot(3.0) - 3.0;
        approx::assert_abs_diff_eq!(along(&ball).distance([7.3, aside, 0.0], 5.0), expected, epsilon = 1e-6);
        approx::assert_abs_diff_eq!(along(&flat).distance([7.3, aside, 0.0], 5.0), 0.0, epsilon = 1e-9);
        let expected = (aside - 3.0).max(0.0).hypot(2.0) - 2.0;
        approx::assert_abs_diff_eq!(along(&bull_nose).distance([7.3, aside, 0.0], 5.0), expected, epsilon = 1e-6);
    }
    // Beside the end of the path, over the floor in the cutter, and farther than the cap.
    approx::assert_abs_diff_eq!(along(&flat).distance([24.0, 0.0, 1.0], 5.0), 1.0, epsilon = 1e-9);
    approx::assert_abs_diff_eq!(along(&flat).distance([7.3, 0.0, 0.5], 5.0), -0.5, epsilon = 1e-9);
    approx::assert_abs_diff_eq!(along(&ball).distance([7.3, 9.0, 0.0], 0.4), 0.4, epsilon = 1e-12);
}

#[test]
fn solids_of_other_shapes_have_their_distances() {
    // A cone of 60 deg from the axis with a ball of 1 mm, up to a radius of 4 mm: the ball ends where its normal is 30 deg from straight
    // down.
    let side = FRAC_PI_2 / 3.0;
    let rise = (4.0 - side.sin()) * side.tan();
    let cone = Solid::new(4.0, &[([0.0, 1.0], 1.0, [0.0, side]), ([4.0, 1.0 - side.cos() + rise], 0.0, [side, FRAC_PI_2])]);
    for (point, expected) in [
        ([0.0, 0.0, -0.5], 0.5),
        // Off the cone's side by 0.2 mm, under its ball, beside its shank, and in the middle of the ball.
        ([2.0 + 0.2 * side.sin(), 0.0, 1.0 - side.cos() + (2.0 - side.sin()) * side.tan() - 0.2 * side.cos()], 0.2),
        ([0.0, 0.3, 1.0 - (1.44_f64 - 0.09).sqrt()], 0.2),
        ([0.0, 4.5, 9.0], 0.5),
        ([0.0, 0.0, 1.0], -1.0),
    ] {
        approx::assert_abs_diff_eq!(cone.distance(point), expected, epsilon = 1e-12);
    }
    let ball = Cutter::ball_end(scallopd::quantity::Length::from_mm(6.0).unwrap());
    let [one, other] = [Solid::of(ball), Solid::torus(3.0, 3.0)];
    for point in [[1.0, 2.0, -0.3], [0.1, 0.0, 0.2], [4.0, 1.0, 8.0]] {
        approx::assert_abs_diff_eq!(one.distance(point), other.distance(point), epsilon = 1e-12);
    }
}
