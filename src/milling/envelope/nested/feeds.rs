//! The largest feed per tooth whose marks keep a height at an offset: that of chords from end to end of the section's row.

use super::{Left, Value};
use crate::milling::envelope::body::Body;
use crate::milling::envelope::chord::{Accuracy, Chord, Marks};
use crate::milling::envelope::clearing::Clearing;
use crate::milling::envelope::section::FURTHEST;

/// The largest number of steps to an end of a row. Newton's method from outside takes three to six.
const MOST_STEPS: usize = 40;

/// The size of the last step, as a share of the coordinates: some roundings.
const CLOSE: f64 = 4.0 * f64::EPSILON;

/// The size of a step, as a share of the row, under which a step that does not shrink is a rounding error.
const NOISE: f64 = 1e-10;

/// The least length of a row, as a share of the cutter's size, by which steps are measured.
const SHORTEST: f64 = 1e-12;

/// The factor by which steps away from the row grow.
const GROWING: f64 = 4.0;

/// The largest feeds at one contact. Values are feeds times -1.
#[derive(Debug)]
pub(in crate::milling::envelope) struct Feeds<'a> {
    pub(in crate::milling::envelope) body: &'a Body,
    /// The height to keep.
    pub(in crate::milling::envelope) level: f64,
    /// A guess of the feed per tooth.
    pub(in crate::milling::envelope) guess: f64,
}

/// The ends, along the feed, of the rows for the deepest tooth and for the shallowest one.
type Start = [[f64; 2]; 2];

/// An end of a row, and how it moves with the offset.
#[derive(Debug, Clone, Copy)]
struct End {
    x: f64,
    by_side: f64,
}

/// The back and the front end of a row.
type Row = [End; 2];

impl Value for Feeds<'_> {
    type Start = Start;

    fn start(&self) -> Start {
        [[-self.guess / 2.0, self.guess / 2.0]; 2]
    }

    fn reach(&self) -> f64 {
        self.guess / 2.0
    }

    fn left(&self, marks: &Clearing, t: f64, [deepest, shallowest]: &mut Start) -> Left {
        let [length, by_side] = match *marks {
            Clearing::Even { feeds, less, drop } => match self.row(t, self.level - drop, deepest) {
                Ok(row) => {
                    let [length, by_side] = Self::chord(&row, &row);
                    [(length + less) / feeds, by_side / feeds]
                }
                Err(beyond) => return beyond,
            },
            Clearing::Mixed { drop } => match (self.row(t, self.level, deepest), self.row(t, self.level - drop, shallowest)) {
                (Ok(deep), Ok(shallow)) => {
                    let orders = [Self::chord(&deep, &shallow), Self::chord(&shallow, &deep)];
                    if orders[0][0] <= orders[1][0] { orders[0] } else { orders[1] }
                }
                // The shallowest tooth's row is the shorter one.
                (_, Err(beyond)) | (Err(beyond), _) => return beyond,
            },
        };
        Left::At { value: -length, by_side: -by_side }
    }

    /// Marks that clear an offset at one spacing also clear it at every smaller one.
    fn is_kept(&self, _: &Clearing, _: f64, _: f64) -> bool {
        true
    }
}

impl Feeds<'_> {
    /// The length from the back end of a row to the front end of another, and how it grows with the offset.
    fn chord([back, _]: &Row, [_, front]: &Row) -> [f64; 2] {
        [front.x - back.x, front.by_side - back.by_side]
    }

    /// The row at the offset t and the height p, from ends near it, which are replaced.
    fn row(&self, t: f64, p: f64, near: &mut [f64; 2]) -> Result<Row, Left> {
        let reach = (near[1] - near[0]).max(SHORTEST * self.body.reach());
        let row_from = |[back, front]: [f64; 2]| Some([self.end(t, p, -1.0, back, reach)?, self.end(t, p, 1.0, front, reach)?]);
        let row = if let Some(row) = row_from(*near) {
            row
        } else {
            let mut middle = f64::midpoint(near[0], near[1]);
            let chord = Chord::search(self.body, &mut middle, t, p, &Marks::even(0.0), Accuracy::full(p), t.abs() + reach + p);
            if chord.value > 0.0 {
                return Err(Left::Beyond { side: chord.by_side.signum(), step: -chord.value / chord.by_side });
            }
            let outside = |sense: f64| self.outside(t, p, sense, middle, reach);
            outside(-1.0).zip(outside(1.0)).and_then(|(back, front)| row_from([back, front])).ok_or(Left::Unknown)?
        };
        *near = row.map(|end| end.x);
        Ok(row)
    }

    /// A place outside the section, behind (-1) or before (1) one inside it.
    fn outside(&self, t: f64, p: f64, sense: f64, inside: f64, reach: f64) -> Option<f64> {
        let mut away = reach / 2.0;
        loop {
            let x = inside + sense * away;
            if self.body.distance(x, t, p).value > 0.0 {
                return Some(x);
            }
            away *= GROWING;
            if away > FURTHEST {
                return None;
            }
        }
    }

    /// The end of a row behind (-1) or before (1) its middle by Newton's method, which converges monotonically from outside,
    /// because the distance is convex; `None` if it starts on the other side.
    fn end(&self, t: f64, p: f64, sense: f64, near: f64, reach: f64) -> Option<End> {
        let mut x = near;
        let mut last = f64::INFINITY;
        for _ in 0..MOST_STEPS {
            let at = self.body.distance(x, t, p);
            if sense * at.by_feed <= 0.0 {
                return None;
            }
            let step = -at.value / at.by_feed;
            let size = step.abs();
            if size <= CLOSE * (x.abs() + reach) || size <= NOISE * reach && size >= 0.5 * last {
                return Some(End { x: x + step, by_side: -at.by_side / at.by_feed });
            }
            // From inside, near the middle, a step can lead far outside.
            if sense * step > GROWING * (reach + x.abs()) {
                return None;
            }
            x += step;
            last = size;
        }
        None
    }
}
