//! Grids of points in rows and columns, and the facets between neighbours.

use super::{SampledSurface, Sink};
use std::fmt;

/// Builds facets from the points of a grid, which arrive row by row. It stores one row.
///
/// Each quad of neighbours is two facets, divided along the diagonal from its first point to its last. The input does
/// not state the direction of rows and columns. The outer side of the grid is therefore the one with the larger area
/// seen from above.
#[derive(Debug, Clone)]
pub struct Grid<S = SampledSurface> {
    rows: usize,
    columns: usize,
    sink: S,
    received: usize,
    /// The last point of each column so far.
    row: Vec<[f64; 3]>,
    /// The point in the previous row and the previous column.
    corner: [f64; 3],
    /// The area seen from above, positive for facets that point up.
    seen_from_above: f64,
}

/// The reason why points do not make a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GridError {
    /// A grid needs two rows and two columns to have a quad.
    TooFewRowsOrColumns,
    /// There are more or fewer points than rows times columns.
    WrongNumberOfPoints {
        /// Rows times columns.
        expected: usize,
        /// The number of points received.
        received: usize,
    },
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewRowsOrColumns => f.write_str("a grid needs at least 2 rows and 2 columns"),
            Self::WrongNumberOfPoints { expected, received } => {
                write!(f, "rows times columns makes {expected} points, but there are {received}")
            }
        }
    }
}

impl std::error::Error for GridError {}

impl Grid {
    /// An empty grid of this size, whose facets are summed.
    ///
    /// # Errors
    /// [`GridError::TooFewRowsOrColumns`].
    pub fn new(rows: usize, columns: usize) -> Result<Self, GridError> {
        Self::into_sink(rows, columns, SampledSurface::new())
    }
}

impl<S: Sink> Grid<S> {
    /// An empty grid of this size, whose facets are passed to `sink`.
    ///
    /// # Errors
    /// [`GridError::TooFewRowsOrColumns`].
    pub fn into_sink(rows: usize, columns: usize, sink: S) -> Result<Self, GridError> {
        if rows < 2 || columns < 2 {
            return Err(GridError::TooFewRowsOrColumns);
        }
        Ok(Self { rows, columns, sink, received: 0, row: Vec::new(), corner: [0.0; 3], seen_from_above: 0.0 })
    }

    /// The sink with the facets so far.
    pub(super) fn unfinished(self) -> S {
        self.sink
    }

    /// Adds the next point. Points beyond the last are only counted.
    pub fn point(&mut self, point: [f64; 3]) {
        let (row, column) = (self.received / self.columns, self.received % self.columns);
        self.received += 1;
        if row >= self.rows {
            return;
        }
        if row == 0 {
            // Memory grows with the points that arrive, not with the size that the request states.
            self.row.push(point);
            return;
        }
        let above = std::mem::replace(&mut self.row[column], point);
        if column > 0 {
            let left = self.row[column - 1];
            self.facet([self.corner, left, point]);
            self.facet([self.corner, point, above]);
        }
        self.corner = above;
    }

    fn facet(&mut self, corners: [[f64; 3]; 3]) {
        let [a, b, c] = corners;
        self.seen_from_above += (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        self.sink.facet(corners);
    }

    /// The sink with all facets of the grid. They are turned over if a larger area of their backs is seen from above.
    ///
    /// # Errors
    /// [`GridError::WrongNumberOfPoints`].
    pub fn finish(mut self) -> Result<S, GridError> {
        let expected = self.rows.saturating_mul(self.columns);
        if self.received != expected {
            return Err(GridError::WrongNumberOfPoints { expected, received: self.received });
        }
        if self.seen_from_above < 0.0 {
            self.sink.turn_over();
        }
        Ok(self.sink)
    }
}
