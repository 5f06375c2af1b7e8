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

use super::body::Body;
use super::section::Pattern;

/// The number of lines from the contact, each of which has one corner of the polygon. The first [`FIRST_LINES`] are
/// spread evenly. The next, up to [`EVEN_LINES`], divide the longest side of the polygon. The last ones are next to the
/// corners that are furthest across the feed.
const LINES: usize = 48;
const FIRST_LINES: usize = 16;
const EVEN_LINES: usize = 36;

/// The largest number of steps of the search for a corner, more than [`CLOSE`] needs.
const MOST_STEPS: usize = 40;

/// The relative accuracy of a corner's distance from the contact.
const CLOSE: f64 = 1e-6;

/// The directions of the lines, which are chosen at one height and used at all heights.
#[derive(Debug)]
pub(super) struct Outlook<'a> {
    body: &'a Body,
    directions: [[f64; 2]; LINES],
    first: Outline,
    height: f64,
}

/// The outline at a height: the furthest visible point (x, t) in each direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Outline {
    corners: [[f64; 2]; LINES],
}

/// The interval of offsets that a pass clears. At each of its ends, the coordinate along the feed of the chord between
/// the marks.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cleared {
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) left_x: f64,
    pub(super) right_x: f64,
}

impl Cleared {
    pub(super) fn width(&self) -> f64 {
        self.right - self.left
    }
}

impl<'a> Outlook<'a> {
    /// Chooses the lines for the section at about the height p.
    pub(super) fn new(body: &'a Body, p: f64) -> Self {
        let (along, across) = (body.along_steepest(), body.along_level());
        let mut outlook = Self { body, directions: [[0.0; 2]; LINES], first: Outline { corners: [[0.0; 2]; LINES] }, height: p };
        let mut start = body.reach().min((p * body.reach()).sqrt());
        #[expect(clippy::cast_precision_loss, reason = "at most 16")]
        for i in 0..FIRST_LINES {
            let (level, steep) = (i as f64 * (std::f64::consts::TAU / FIRST_LINES as f64)).sin_cos();
            let direction = [steep * along + level * across, level * along - steep * across];
            start = outlook.exit(direction, p, start);
            outlook.place(i, direction, start);
        }
        for count in FIRST_LINES..LINES {
            let corners = &outlook.first.corners;
            let side = |i: usize| {
                let (from, to) = (corners[i], corners[if i + 1 == count { 0 } else { i + 1 }]);
                (from[0] - to[0]).powi(2) + (from[1] - to[1]).powi(2)
            };
            let longest = if count < EVEN_LINES {
                (0..count).fold((0, 0.0), |longest, i| if side(i) > longest.1 { (i, side(i)) } else { longest }).0
            } else {
                let sense = if count % 2 == 0 { 1.0 } else { -1.0 };
                let furthest = (0..count).fold(0, |best, i| if corners[i][1] * sense > corners[best][1] * sense { i } else { best });
                let before = if furthest == 0 { count - 1 } else { furthest - 1 };
                if side(before) > side(furthest) { before } else { furthest }
            };
            let (from, to) = (outlook.directions[longest], outlook.directions[if longest + 1 == count { 0 } else { longest + 1 }]);
            let middle = [from[0] + to[0], from[1] + to[1]];
            let length = middle[0].hypot(middle[1]);
            let direction = middle.map(|component| component / length);
            outlook.directions[longest + 1..=count].rotate_right(1);
            outlook.first.corners[longest + 1..=count].rotate_right(1);
            let reached = outlook.exit(direction, p, distance_of(outlook.first.corners[longest]));
            outlook.place(longest + 1, direction, reached);
        }
        outlook
    }

    fn place(&mut self, i: usize, direction: [f64; 2], reached: f64) {
        self.directions[i] = direction;
        self.first.corners[i] = direction.map(|component| component * reached);
    }

    /// The height for which the lines were chosen.
    pub(super) fn height(&self) -> f64 {
        self.height
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
        let outside = |length: f64| self.body.distance(length * direction[0], length * direction[1], p);
        let (mut low, mut high) = (0.0, f64::INFINITY);
        for turn in self.body.turns(direction) {
            if turn > low {
                if outside(turn).value > 0.0 {
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
            let place = outside(at);
            let slope = place.by_feed * direction[0] + place.by_side * direction[1];
            if place.value > 0.0 {
                high = at;
            } else {
                low = at;
            }
            if high - low <= CLOSE * low {
                break;
            }
            let newton = at - place.value / slope;
            let safe = slope > 0.0 && newton > low && newton < high;
            if safe && (newton - at).abs() <= CLOSE * at {
                return newton;
            }
            at = if safe && (high < f64::INFINITY || newton < 8.0 * at) {
                newton
            } else if high == f64::INFINITY {
                if low > FURTHEST {
                    break;
                }
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
    x.hypot(t)
}

/// The largest distance that is considered, in mm.
const FURTHEST: f64 = 2e6;

/// A row of the outline: the ends of its intervals, in rising order.
#[derive(Debug, Clone, Copy)]
struct Row {
    ends: [f64; 8],
    count: usize,
}

impl Outline {
    /// The row at the offset t. At most four intervals are stored.
    fn row(&self, t: f64) -> Row {
        let mut row = Row { ends: [0.0; 8], count: 0 };
        let mut from = self.corners[LINES - 1];
        for to in self.corners {
            if (from[1] <= t) != (to[1] <= t) && row.count < row.ends.len() {
                row.ends[row.count] = from[0] + (t - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                row.count += 1;
            }
            from = to;
        }
        row.ends[..row.count].sort_unstable_by(f64::total_cmp);
        row
    }

    /// The widest interval of offsets that marks of equal depth, f apart, clear; `None` if there is none.
    pub(super) fn cleared(&self, f: f64) -> Option<Cleared> {
        self.widest(f, |t| {
            let row = self.row(t);
            let longest = row.ends[..row.count].chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
            Some((longest[1] - longest[0] - f, longest[1]))
        })
    }

    /// The widest interval of offsets that a pattern of deep and shallow marks clears. `shallow` is the outline for the
    /// shallow marks; `None` if these do not reach the height.
    pub(super) fn cleared_by(&self, pattern: &Pattern, shallow: Option<&Self>) -> Option<Cleared> {
        let f = pattern.spacing;
        self.widest(f, |t| {
            let row = self.row(t);
            let deep = row.ends[..row.count].chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
            let alone = deep[1] - deep[0] - pattern.deep_spacing;
            let alternating = shallow.and_then(|shallow| {
                let row = shallow.row(t);
                let inside = row.ends[..row.count].chunks_exact(2).filter(|ends| ends[1] > deep[0] && ends[0] < deep[1]);
                let ends = inside.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
                let mixed = (ends[1] - deep[0]).min(deep[1] - ends[0]) - f;
                Some(if pattern.shallow_pairs { mixed.min(ends[1] - ends[0] - f) } else { mixed })
            });
            Some((alternating.map_or(alone, |alternating| alternating.max(alone)), deep[1]))
        })
    }

    /// The widest interval of offsets at which `excess` is not negative. It is evaluated at the rows through the
    /// corners and interpolated linearly between them.
    fn widest(&self, f: f64, excess: impl Fn(f64) -> Option<(f64, f64)>) -> Option<Cleared> {
        let mut offsets = self.corners.map(|corner| corner[1]);
        offsets.sort_unstable_by(f64::total_cmp);
        if f <= 0.0 {
            let x_at = |t: f64| self.corners.iter().find(|corner| corner[1].to_bits() == t.to_bits()).map_or(0.0, |corner| corner[0]);
            let (left, right) = (offsets[0], offsets[LINES - 1]);
            return Some(Cleared { left, right, left_x: x_at(left), right_x: x_at(right) });
        }
        let mut best = None::<Cleared>;
        let mut open = None::<(f64, f64)>;
        let mut before = None::<(f64, f64, f64)>;
        // The rows at the outermost corners have no length.
        for i in 0..=LINES {
            let t = if i == LINES { offsets[LINES - 1] } else { offsets[i] };
            let found = if i == LINES { None } else { excess(t) };
            let (value, x) = found.unwrap_or((-f, before.map_or(0.0, |before| before.2)));
            let crossing = before.map(|(before_t, before_value, _)| before_t + (t - before_t) * before_value / (before_value - value));
            if value >= 0.0 && open.is_none() {
                open = Some((before.filter(|before| before.1 < 0.0).and(crossing).unwrap_or(t), x));
            }
            if value < 0.0
                && let (Some((left, left_x)), Some(right), Some((_, _, right_x))) = (open, crossing, before)
            {
                let cleared = Cleared { left, right, left_x, right_x };
                if best.is_none_or(|best| best.width() < cleared.width()) {
                    best = Some(cleared);
                }
                open = None;
            }
            before = Some((t, value, x));
        }
        best
    }
}
