//! A cloud of single points, which keeps one for each cell of a lattice if there are more than a limit; and welding: numbering
//! points so that equal points have the same number.

use crate::cancellation::CancelFlag;
use crate::surface::Bounds;
use hashbrown::HashTable;
use std::hash::{BuildHasher, RandomState};

/// A cloud of at most `limit` points. If there are more, the point nearest to the centre of each cell of a lattice is
/// kept, unmoved. The size of the cells is the smallest power of two that leaves at most half of the limit. It doubles
/// if later points exceed the limit.
#[derive(Debug)]
pub(super) struct PointCloud {
    limit: usize,
    /// The points, as long as they have not been thinned.
    points: Vec<[f64; 3]>,
    received: u64,
    cells: Option<Cells>,
    cancel: CancelFlag,
}

impl PointCloud {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit: limit.max(4), points: Vec::new(), received: 0, cells: None, cancel: CancelFlag::default() }
    }

    /// The same cloud with a cancel flag: once `cancel` is set, points are lost, and the cloud must be discarded.
    pub(super) fn with_cancel_flag(self, cancel: &CancelFlag) -> Self {
        Self { cancel: cancel.clone(), ..self }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.received == 0
    }

    /// The number of points received.
    pub(super) fn received(&self) -> u64 {
        self.received
    }

    /// The side of the cells, if points were thinned.
    pub(super) fn cell(&self) -> Option<f64> {
        self.cells.as_ref().map(|cells| cells.side)
    }

    pub(super) fn add(&mut self, point: [f64; 3]) {
        self.received += 1;
        if let Some(cells) = &mut self.cells {
            cells.add(point);
            if cells.points.len() > self.limit {
                let first = cells.exponent + 1;
                let points = std::mem::take(&mut cells.points);
                self.cells = Some(Cells::fitting(first, first, &points, self.limit / 2, &self.cancel));
            }
            return;
        }
        // Scanners repeat points, and repetitions must not cause thinning.
        if self.points.last() == Some(&point) {
            return;
        }
        self.points.push(point);
        if self.points.len() > self.limit {
            self.thin();
        }
    }

    /// The number of points stored.
    pub(super) fn len(&self) -> usize {
        self.cells.as_ref().map_or(self.points.len(), |cells| cells.points.len())
    }

    pub(super) fn into_points(self) -> Vec<[f64; 3]> {
        self.cells.map_or(self.points, |cells| cells.points)
    }

    fn thin(&mut self) {
        // Of points above each other only the highest counts, so that a surface scanned several times at the same
        // places is not thinned.
        self.points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(b[2].total_cmp(&a[2])));
        self.points.dedup_by(|b, a| a[..2] == b[..2]);
        if self.points.len() <= self.limit / 2 {
            return;
        }
        let mut bounds = Bounds::NONE;
        self.points.iter().for_each(|&point| bounds.include(point));
        let [width, depth] = [0, 1].map(|axis| bounds.max[axis] - bounds.min[axis]);
        let least = (bounds.largest_magnitude() * 2.0_f64.powi(-40)).max(f64::MIN_POSITIVE);
        #[expect(clippy::cast_precision_loss, reason = "under 2^53")]
        let [finest, usual] = [width.max(depth) / self.limit as f64, (width * depth / (self.limit / 2) as f64).sqrt()];
        #[expect(clippy::cast_possible_truncation, reason = "logarithms of doubles are within 1100")]
        let [finest, usual] = [finest, usual].map(|side| side.max(least).log2().floor() as i32);
        self.cells = Some(Cells::fitting(finest, usual, &std::mem::take(&mut self.points), self.limit / 2, &self.cancel));
    }
}

/// One point of each cell of a square lattice.
#[derive(Debug)]
struct Cells {
    exponent: i32,
    side: f64,
    /// 1 / side, which is exact for a power of two.
    by_side: f64,
    points: Vec<[f64; 3]>,
    /// Maps a cell to its point.
    table: HashTable<u32>,
    keys: HashKeys,
}

impl Cells {
    /// Cells with room for `room` points.
    fn new(exponent: i32, room: usize) -> Self {
        let side = 2.0_f64.powi(exponent);
        let (points, table) = (Vec::with_capacity(room), HashTable::with_capacity(room));
        Self { exponent, side, by_side: side.recip(), points, table, keys: HashKeys::random() }
    }

    /// The smallest cells of at least the size 2^`first` that leave at most `most` of `points`. The search begins at
    /// 2^`likely`. Once `cancel` is set, it ends with any cells.
    fn fitting(first: i32, likely: i32, points: &[[f64; 3]], most: usize, cancel: &CancelFlag) -> Self {
        // Cells of a size are divided by those of half the size, so that smaller cells never leave fewer points.
        let mut exponent = likely.max(first);
        let (mut fitting, mut grown) = (None, false);
        loop {
            match Self::of(exponent, points, most, cancel) {
                Some(cells) if grown || exponent == first || cancel.is_cancelled() => return cells,
                Some(cells) => {
                    fitting = Some(cells);
                    exponent -= 1;
                }
                None => {
                    if let Some(cells) = fitting {
                        return cells;
                    }
                    (exponent, grown) = (exponent + 1, true);
                }
            }
        }
    }

    /// Cells of the size 2^`exponent` with their points, unless they leave more than `most` of `points`. Once `cancel` is
    /// set, the other points are left out.
    fn of(exponent: i32, points: &[[f64; 3]], most: usize, cancel: &CancelFlag) -> Option<Self> {
        /// The number of points between two checks for cancellation, which take less than a millisecond.
        const TURN: usize = 4096;
        let mut cells = Self::new(exponent, points.len().min(most + 1));
        for some in points.chunks(TURN).take_while(|_| !cancel.is_cancelled()) {
            for &point in some {
                cells.add(point);
                if cells.points.len() > most {
                    return None;
                }
            }
        }
        Some(cells)
    }

    fn add(&mut self, point: [f64; 3]) {
        let Self { points, table, keys, by_side, .. } = self;
        let place = |point: &[f64; 3]| [floor(point[1] * *by_side), floor(point[0] * *by_side), 0.0];
        let here = place(&point);
        let hash = keys.hash(here);
        // Coordinates in one cell differ by less than 1 after the division, whose result is exact.
        #[expect(clippy::float_cmp, reason = "whole numbers")]
        if let Some(&index) = table.find(hash, |&index| place(&points[index as usize]) == here) {
            let held = &mut points[index as usize];
            let off_centre =
                |point: &[f64; 3]| (point[0] * *by_side - here[1] - 0.5).powi(2) + (point[1] * *by_side - here[0] - 0.5).powi(2);
            let (new, old) = (off_centre(&point), off_centre(held));
            if new < old || (new == old && point[2] > held[2]) {
                *held = point;
            }
            return;
        }
        let index = u32::try_from(points.len()).expect("the bound on facets keeps point numbers within 32 bits");
        points.push(point);
        table.insert_unique(hash, index, |&other| keys.hash(place(&points[other as usize])));
    }
}

/// The largest whole number that is not above `value`, without the sign of a zero. The standard library's function is a
/// slow call unless SSE4.1 is assumed.
#[expect(clippy::cast_possible_truncation, clippy::cast_precision_loss, reason = "within 2^52, where both are exact")]
fn floor(value: f64) -> f64 {
    const ALL_WHOLE: f64 = (1_u64 << 52) as f64;
    if value.abs() >= ALL_WHOLE {
        return value;
    }
    let truncated = value as i64 as f64;
    if truncated > value { truncated - 1.0 } else { truncated }
}

/// The distinct points so far, and the hash table that finds them: 24 bytes for each point and, on average, 7 bytes of
/// table.
#[derive(Debug)]
pub(super) struct Welder {
    points: Vec<[f64; 3]>,
    table: HashTable<u32>,
    keys: HashKeys,
}

/// Secret factors of a hash function. If they were known, a file could put all its points into one bucket of the table,
/// which would take quadratic time.
#[derive(Debug, Clone, Copy)]
pub(super) struct HashKeys([u64; 3]);

impl Default for Welder {
    fn default() -> Self {
        Self::new()
    }
}

impl Welder {
    pub(super) fn new() -> Self {
        Self { points: Vec::new(), table: HashTable::new(), keys: HashKeys::random() }
    }

    /// The number of a point, from 0 in the order of the first occurrence. 0 and -0 are equal; there is no NaN.
    pub(super) fn index(&mut self, point: [f64; 3]) -> u32 {
        // Adding 0 removes the sign of a zero.
        let point = point.map(|coordinate| coordinate + 0.0);
        let hash = self.keys.hash(point);
        let Self { points, table, keys } = self;
        let same = |&index: &u32| points[index as usize].map(f64::to_bits) == point.map(f64::to_bits);
        if let Some(&index) = table.find(hash, same) {
            return index;
        }
        let index = u32::try_from(points.len()).expect("the bound on facets keeps point numbers within 32 bits");
        points.push(point);
        table.insert_unique(hash, index, |&other| keys.hash(points[other as usize]));
        index
    }

    pub(super) fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    pub(super) fn into_points(self) -> Vec<[f64; 3]> {
        self.points
    }

    pub(super) fn len(&self) -> usize {
        self.points.len()
    }
}

impl HashKeys {
    pub(super) fn random() -> Self {
        let random = RandomState::new();
        Self([0_u8, 1, 2].map(|n| random.hash_one(n) | 1))
    }

    /// Each number multiplied by a secret factor, with the high and low half of the product combined by XOR, as in
    /// wyhash.
    pub(super) fn hash(self, numbers: [f64; 3]) -> u64 {
        let keys = self.0;
        let fold = |a: u64, b: u64| {
            let product = u128::from(a) * u128::from(b);
            #[expect(clippy::cast_possible_truncation, reason = "the two halves")]
            let (low, high) = (product as u64, (product >> 64) as u64);
            low ^ high
        };
        let [x, y, z] = numbers.map(f64::to_bits);
        fold(fold(fold(x ^ keys[0], keys[1]) ^ y, keys[2]) ^ z ^ keys[0], keys[1])
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;

    #[test]
    fn a_dense_cloud_keeps_one_point_of_each_cell() {
        let mut cloud = PointCloud::new(1000);
        for i in 0..40_000_u32 {
            cloud.add([f64::from(i % 200), f64::from(i / 200), f64::from(i)]);
        }
        assert_eq!(cloud.received(), 40_000);
        let cell = cloud.cell().unwrap();
        let points = cloud.into_points();
        assert!(points.len() > 200 && points.len() <= 1000, "{} of {cell}", points.len());
        // Each is one of the received points, and the only one of its cell.
        assert!(points.iter().all(|&[x, y, z]| z == x + 200.0 * y));
        let places: std::collections::HashSet<_> =
            points.iter().map(|[x, y, _]| [(x / cell).floor().to_bits(), (y / cell).floor().to_bits()]).collect();
        assert_eq!(places.len(), points.len());
    }

    #[test]
    fn cells_grow_with_the_surface() {
        let mut cloud = PointCloud::new(100);
        for i in 0..100_000_u32 {
            cloud.add([f64::from(i), -f64::from(i % 7) * 1e3, 0.0]);
            assert!(cloud.len() <= 100);
        }
        assert!(cloud.cell().unwrap() >= 1000.0 && cloud.len() > 12, "{:?}", cloud.cell());
    }

    #[test]
    fn the_cells_do_not_depend_on_where_the_search_begins() {
        let points: Vec<[f64; 3]> = (0..3000_u32).map(|i| [f64::from(i * 37 % 101), f64::from(i * 17 % 89), f64::from(i)]).collect();
        let cells = |points: &[[f64; 3]], likely| Cells::fitting(-8, likely, points, 500, &CancelFlag::default());
        for points in [&points[..], &points[..600], &points[..100], &points.iter().map(|p| [p[0], p[0], p[2]]).collect::<Vec<_>>()] {
            let from_below = cells(points, -8);
            for likely in [-9, -3, 1, 2, 3, 10] {
                let found = cells(points, likely);
                assert_eq!((found.exponent, &found.points), (from_below.exponent, &from_below.points), "{likely}");
            }
        }
    }

    #[test]
    fn a_cancelled_cloud_is_not_thinned_further() {
        let cancel = CancelFlag::default();
        cancel.cancel();
        let mut cloud = PointCloud::new(1000).with_cancel_flag(&cancel);
        for i in 0..3000_u32 {
            cloud.add([f64::from(i), 0.0, 0.0]);
        }
        assert!(cloud.len() < 3000);
    }

    #[test]
    fn whole_numbers_below_are_those_of_the_library() {
        for value in [0.0, -0.0, 0.5, -0.5, 1.0, -1.0, 2.5, -2.5, 4_503_599_627_370_495.5, -4_503_599_627_370_495.5, 1e300, -1e300] {
            assert_eq!(floor(value), f64::floor(value), "{value}");
        }
    }

    #[test]
    fn points_that_repeat_take_no_room() {
        let mut cloud = PointCloud::new(8);
        for i in 0..1000_u32 {
            cloud.add([f64::from(i % 3), 0.0, 1.0]);
        }
        assert_eq!((cloud.received(), cloud.cell()), (1000, None));
    }

    #[test]
    fn equal_points_have_one_number_and_others_have_their_own() {
        let mut welder = Welder::new();
        let numbers: Vec<u32> = (0..10_000_u32)
            .map(|i| [f64::from(i % 100), f64::from(i / 100 % 10), -0.0])
            .chain([[0.0; 3], [0.0, 0.0, 1e-300]])
            .map(|point| welder.index(point))
            .collect();
        assert_eq!(numbers[..3], [0, 1, 2]);
        assert!((0..10_000).all(|i| numbers[i] as usize == i % 1000));
        assert_eq!(numbers[10_000..], [0, 1000]);
        assert_eq!(welder.into_points().len(), 1001);
    }
}
