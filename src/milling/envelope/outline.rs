//! The outline of the cutter's section at a height, as a polygon: the part of the section that is visible from the
//! contact. The polygon is coarse, but never includes another lobe of the section.
//!
//! On a concave surface {H <= p} need not be convex, and it can have several parts. The part that counts is the one
//! **visible from the contact**: a point belongs to it if H stays below p on the whole line from the contact to the
//! point. This part never shrinks when p rises. It changes continuously with every input, because the greatest H on a
//! line does, except when p passes a ridge of H beside the contact: there it grows suddenly, so that the step-over
//! jumps and the height does not. On planes and convex surfaces it is the whole section.
//!
//! A row is the set of points of this part at one offset t. A pass clears the offset t down to p if its row contains an
//! interval as long as the distance of the marks. The height for a step-over s is the least p at which the cleared
//! offsets fill an interval as wide as s.

use super::body::{Body, Ray};
use super::section::Pattern;
use crate::numerics::hypotenuse;

/// Lines from the contact, by which the polygon is made: a first round of them evenly, then where the polygon's sides
/// are longest, the last ones beside its corners furthest across the feed.
const LINES: usize = 42;
const FIRST_LINES: usize = 14;
const EVEN_LINES: usize = 32;

/// The cosine and the sine of the angle between the first lines.
const FIRST_TURN: [f64; 2] = [0.900_968_867_902_419_1, 0.433_883_739_117_558_1];

/// The largest number of steps of the search for a corner, more than [`CLOSE`] needs.
const MOST_STEPS: usize = 40;

/// How near to the edge a corner of the polygon is, as a share of its distance from the contact.
const CLOSE: f64 = 1e-3;

/// The directions of the lines, which are chosen at one height and used at all heights.
#[derive(Debug)]
pub(super) struct Outlook<'a> {
    body: &'a Body,
    /// Places further from the contact are left out, in mm.
    furthest: f64,
    directions: [[f64; 2]; LINES],
    first: Outline,
}

/// The outline at a height: the furthest visible point (x, t) in each direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    corners: [[f64; 2]; LINES],
}

/// An end of the cleared offsets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub(super) t: f64,
    /// Where the chords' front ends are along the feed, as in [`super::newton::Place`].
    pub(super) x: [f64; 2],
    /// Whether the deepest tooth alone clears it, or all teeth equally deep.
    pub(super) is_deep: bool,
}

/// The offsets that a pass clears.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cleared {
    pub(super) left: Edge,
    pub(super) right: Edge,
}

impl Cleared {
    pub(super) fn width(&self) -> f64 {
        self.right.t - self.left.t
    }

    /// The same with all places `factor` times as far from the contact.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let [left, right] = [self.left, self.right].map(|edge| Edge { t: factor * edge.t, x: edge.x.map(|x| factor * x), ..edge });
        Self { left, right }
    }
}

impl<'a> Outlook<'a> {
    /// Chooses the lines for the section at about the height p.
    ///
    /// Sections are up to some thousand times as long along the level line as across it. Directions and sides are
    /// therefore measured in units of the section's extent along either line. Extents over `reach` do not matter.
    pub(super) fn new(body: &'a Body, p: f64, reach: f64) -> Self {
        let mut outlook =
            Self { body, furthest: 4.0 * reach, directions: [[0.0; 2]; LINES], first: Outline { corners: [[0.0; 2]; LINES] } };
        let unit = |steep: f64, level: f64| body.along_feed(steep, level);
        let guess = body.reach().min((p * body.reach()).sqrt());
        let uphill = outlook.exit(unit(-1.0, 0.0), p, guess);
        let downhill = outlook.exit(unit(1.0, 0.0), p, guess);
        let extent = [uphill.max(downhill).min(reach).max(p), body.level_extent(p)];
        // The lines in the order in which they are placed, each with its direction and its place in units of the extent, the
        // lines before and after it, and the square of the side to the line after it.
        let (mut units, mut measured) = ([[0.0; 2]; LINES], [[0.0; 2]; LINES]);
        let (mut before, mut after) = ([0; LINES], [0; LINES]);
        let mut sides = [0.0; LINES];
        let side = |from: [f64; 2], to: [f64; 2]| (from[0] - to[0]).powi(2) + (from[1] - to[1]).powi(2);
        let (mut direction, mut reached) = ([1.0, 0.0], 1.0);
        for i in 0..FIRST_LINES {
            units[i] = direction;
            reached = outlook.place(i, direction, extent, p, reached);
            measured[i] = direction.map(|part| part * reached);
            (before[i], after[i]) = ((i + FIRST_LINES - 1) % FIRST_LINES, (i + 1) % FIRST_LINES);
            let [cos, sin] = FIRST_TURN;
            direction = [cos * direction[0] - sin * direction[1], sin * direction[0] + cos * direction[1]];
        }
        for i in 0..FIRST_LINES {
            sides[i] = side(measured[i], measured[after[i]]);
        }
        for count in FIRST_LINES..LINES {
            let from = if count < EVEN_LINES {
                (1..count).fold(0, |longest, i| if sides[i] > sides[longest] { i } else { longest })
            } else {
                let corners = &outlook.first.corners;
                let sense = if count % 2 == 0 { 1.0 } else { -1.0 };
                let furthest = (1..count).fold(0, |best, i| if corners[i][1] * sense > corners[best][1] * sense { i } else { best });
                if sides[before[furthest]] > sides[furthest] { before[furthest] } else { furthest }
            };
            let to = after[from];
            let middle: [f64; 2] = std::array::from_fn(|i| units[from][i] + units[to][i]);
            let length = hypotenuse(middle[0], middle[1]);
            units[count] = middle.map(|part| part / length);
            let guess = 0.5 * (distance_of(measured[from]) + distance_of(measured[to]));
            let reached = outlook.place(count, units[count], extent, p, guess);
            measured[count] = units[count].map(|part| part * reached);
            (before[count], after[count]) = (from, to);
            (after[from], before[to]) = (count, count);
            sides[from] = side(measured[from], measured[count]);
            sides[count] = side(measured[count], measured[to]);
        }
        // In the order around the contact.
        let (placed, corners) = (outlook.directions, outlook.first.corners);
        let mut line = 0;
        for i in 0..LINES {
            (outlook.directions[i], outlook.first.corners[i]) = (placed[line], corners[line]);
            line = after[line];
        }
        outlook
    }

    /// Places the line number i in a direction that is measured in units of the section's extent along the steepest and
    /// the level line; returns the distance of the section's edge in the same units, of which `guess` is one.
    fn place(&mut self, i: usize, [steep, level]: [f64; 2], extent: [f64; 2], p: f64, guess: f64) -> f64 {
        let along = self.body.along_feed(steep * extent[0], level * extent[1]);
        let unit = hypotenuse(along[0], along[1]);
        let direction = along.map(|part| part / unit);
        let reached = self.exit(direction, p, guess * unit);
        self.directions[i] = direction;
        self.first.corners[i] = direction.map(|part| part * reached);
        reached / unit
    }

    /// The outline at the height for which the lines were chosen.
    pub(super) fn first(&self) -> &Outline {
        &self.first
    }

    /// The outline at the height p. The search starts from `near`, an outline at another height.
    pub(super) fn at(&self, p: f64, near: &Outline) -> Outline {
        let corners = std::array::from_fn(|i| {
            let reached = self.exit(self.directions[i], p, distance_of(near.corners[i]));
            self.directions[i].map(|component| component * reached)
        });
        Outline { corners }
    }

    /// The distance from the contact to the first point outside the section in a direction.
    ///
    /// Along a line, H is convex before and after the flat, and a parabola on the flat. H is therefore evaluated where
    /// the line enters and leaves the flat, where it is nearest to the axis, and where the parabola is highest. Between
    /// neighbouring points of these, the line crosses the section's edge at most once.
    fn exit(&self, direction: [f64; 2], p: f64, start: f64) -> f64 {
        let ray = Ray::new(self.body, direction);
        let (mut low, mut high) = (0.0, f64::INFINITY);
        for turn in ray.turns() {
            if turn > low {
                if ray.distance(turn, p)[0] > 0.0 {
                    high = turn;
                    break;
                }
                low = turn;
            }
        }
        let mut at = start.max(low * (1.0 + CLOSE)).max(1e-3 * p);
        if at >= high {
            at = if high < f64::INFINITY { 0.5 * (low + high) } else { start };
        }
        for _ in 0..MOST_STEPS {
            at = at.min(self.furthest);
            let [value, slope] = ray.distance(at, p);
            if value > 0.0 {
                high = at;
            } else if at >= self.furthest {
                return at;
            } else {
                low = at;
            }
            if high - low <= CLOSE * low {
                break;
            }
            let newton = at - value / slope;
            let safe = slope > 0.0 && newton > low && newton < high;
            if safe && (newton - at).abs() <= CLOSE * at {
                return newton;
            }
            at = if safe && (high < f64::INFINITY || newton < 8.0 * at) {
                newton
            } else if high == f64::INFINITY {
                4.0 * at
            } else if low < high / 16.0 {
                high / 8.0
            } else {
                0.5 * (low + high)
            };
        }
        low
    }
}

fn distance_of([x, t]: [f64; 2]) -> f64 {
    hypotenuse(x, t)
}

/// A row of the outline: its intervals' ends in order.
#[derive(Debug, Clone, Copy)]
struct Row {
    ends: [f64; 8],
    count: usize,
}

impl Row {
    /// The longest interval, of those between `least` and `most`.
    fn longest(&self, least: f64, most: f64) -> Option<[f64; 2]> {
        let inside = self.ends[..self.count].chunks_exact(2).filter(|ends| ends[1] > least && ends[0] < most);
        inside.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0]))).map(|ends| [ends[0], ends[1]])
    }
}

impl Outline {
    /// The rows through the corners. For a pattern of deep and shallow marks, `shallow` has the pattern and the outline for the
    /// shallow ones; `None` where these do not reach as deep, and for marks of equal depth.
    pub(super) fn rows(&self, shallow: Option<(&Pattern, &Self)>) -> Rows {
        let mut offsets = self.corners.map(|corner| corner[1]);
        offsets.sort_unstable_by(f64::total_cmp);
        let furthest = |sense: f64| {
            let further = |best: [f64; 2], corner: &[f64; 2]| if sense * corner[1] > sense * best[1] { *corner } else { best };
            let [x, t] = self.corners.iter().fold(self.corners[0], further);
            Edge { t, x: [x; 2], is_deep: true }
        };
        let extent = Cleared { left: furthest(-1.0), right: furthest(1.0) };
        let rows = self.rows_at(&offsets);
        let shallow = shallow.map(|(pattern, outline)| (pattern.shallow_pairs, outline.rows_at(&offsets)));
        let marked = std::array::from_fn(|i| {
            let deep = rows[i].longest(f64::NEG_INFINITY, f64::INFINITY)?;
            let alternating = shallow.as_ref().and_then(|(pairs, rows)| {
                let ends = rows[i].longest(deep[0], deep[1])?;
                let mixed = (ends[1] - deep[0]).min(deep[1] - ends[0]);
                Some(Alternating { length: if *pairs { mixed.min(ends[1] - ends[0]) } else { mixed }, front: ends[1] })
            });
            Some(MarkedRow { deep: deep[1] - deep[0], front: deep[1], alternating })
        });
        Rows { offsets, marked, extent }
    }

    /// The rows at the corners' offsets, which are sorted: each side of the polygon crosses those between its ends.
    fn rows_at(&self, offsets: &[f64; LINES]) -> [Row; LINES] {
        let mut rows = [Row { ends: [0.0; 8], count: 0 }; LINES];
        let mut from = self.corners[LINES - 1];
        for to in self.corners {
            let (left, right) = (from[1].min(to[1]), from[1].max(to[1]));
            let first = offsets.partition_point(|offset| *offset < left);
            for (row, t) in rows.iter_mut().zip(offsets).skip(first).take_while(|(_, offset)| **offset < right) {
                if row.count < row.ends.len() {
                    row.ends[row.count] = from[0] + (t - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                    row.count += 1;
                }
            }
            from = to;
        }
        for row in &mut rows {
            // Most rows have one interval.
            if row.count > 2 {
                row.ends[..row.count].sort_unstable_by(f64::total_cmp);
            } else if row.ends[0] > row.ends[1] && row.count == 2 {
                row.ends.swap(0, 1);
            }
        }
        rows
    }
}

/// What the marks at one offset clear: the longest interval of the section there and of that for the shallow marks.
#[derive(Debug, Clone, Copy)]
struct MarkedRow {
    deep: f64,
    front: f64,
    alternating: Option<Alternating>,
}

/// The largest distance of marks that alternate in depth, and where the shallow one's interval ends ahead.
#[derive(Debug, Clone, Copy)]
struct Alternating {
    length: f64,
    front: f64,
}

/// The rows of an outline through its corners, from left to right.
#[derive(Debug)]
pub(super) struct Rows {
    offsets: [f64; LINES],
    marked: [Option<MarkedRow>; LINES],
    extent: Cleared,
}

impl Rows {
    /// All offsets of the section, which passes without marks clear.
    pub(super) fn extent(&self) -> Cleared {
        self.extent
    }

    /// The widest interval of offsets that marks f apart, the deepest tooth's `deep_spacing` apart, clear, between the
    /// rows by proportion; `None` where there is none.
    pub(super) fn cleared(&self, f: f64, deep_spacing: f64) -> Option<Cleared> {
        let mut best = None::<Cleared>;
        let mut close = |left: Edge, right: Edge| {
            let cleared = Cleared { left, right };
            if best.is_none_or(|best| best.width() < cleared.width()) {
                best = Some(cleared);
            }
        };
        let mut open = None::<Edge>;
        let mut before = None::<(f64, Edge)>;
        // At the outermost corners rows have no length.
        for i in 0..=LINES {
            let t = self.offsets[i.min(LINES - 1)];
            let marked = self.marked.get(i).copied().flatten();
            let (value, edge) = marked.map_or_else(
                || (-f, Edge { t, ..before.map_or(Edge { t, x: [0.0; 2], is_deep: true }, |(_, edge)| edge) }),
                |row| row.excess(t, f, deep_spacing),
            );
            let crossing = before.map(|(before_value, before)| {
                let share = before_value / (before_value - value);
                let between = |from: f64, to: f64| from + share * (to - from);
                let inside = if value >= 0.0 { edge } else { before };
                let x = std::array::from_fn(|i| if inside.is_deep == edge.is_deep { between(before.x[i], edge.x[i]) } else { inside.x[i] });
                Edge { t: between(before.t, t), x, ..inside }
            });
            if value >= 0.0 && open.is_none() {
                open = Some(before.filter(|(before, _)| *before < 0.0).and(crossing).unwrap_or(edge));
            }
            if value < 0.0
                && let (Some(left), Some(right)) = (open, crossing)
            {
                close(left, right);
                open = None;
            }
            if let (Some(left), Some((before_value, before))) = (open, before)
                && before_value >= 0.0
                && before.is_deep != edge.is_deep
                && let Some([end, start]) = self.gap(i, f, deep_spacing)
            {
                close(left, Edge { t: end, ..before });
                open = Some(Edge { t: start, ..edge });
            }
            before = Some((value, edge));
        }
        best
    }

    /// The offsets between row number i and the row before it that no marks clear although some clear each row: those of one
    /// depth the row before, and those of the other depth this row.
    fn gap(&self, i: usize, f: f64, deep_spacing: f64) -> Option<[f64; 2]> {
        let before = i.checked_sub(1)?;
        let rows = [self.marked[before]?, self.marked.get(i).copied()??].map(|row| row.excesses(f, deep_spacing));
        let [kind, other] = [0, 1].map(|row: usize| usize::from(rows[row][1] > rows[row][0]));
        if kind == other || rows[1][kind] >= 0.0 || rows[0][other] >= 0.0 {
            return None;
        }
        let zero = |kind: usize| {
            let share = rows[0][kind] / (rows[0][kind] - rows[1][kind]);
            self.offsets[before] + share * (self.offsets[i] - self.offsets[before])
        };
        Some([zero(kind), zero(other)]).filter(|[end, start]| end < start)
    }
}

impl MarkedRow {
    /// By how much marks of the deepest tooth alone, and marks that alternate in depth, may be further apart.
    fn excesses(&self, f: f64, deep_spacing: f64) -> [f64; 2] {
        [self.deep - deep_spacing, self.alternating.map_or(0.0, |alternating| alternating.length) - f]
    }

    /// By how much the better kind of marks may be further apart, and the edge that they would have there.
    fn excess(&self, t: f64, f: f64, deep_spacing: f64) -> (f64, Edge) {
        let deep = self.deep - deep_spacing;
        match self.alternating {
            Some(Alternating { length, front }) if length - f > deep => (length - f, Edge { t, x: [front, self.front], is_deep: false }),
            _ => (deep, Edge { t, x: [self.front; 2], is_deep: true }),
        }
    }
}
