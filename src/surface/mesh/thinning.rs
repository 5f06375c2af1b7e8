//! Points without facets, thinned to one for each cell of a lattice when they exceed a bound.

use crate::surface::Bounds;

/// A cloud of at most `limit` points. If there are more, the point nearest to the centre of each cell of a lattice is
/// kept, unmoved; the cells are the smallest, by powers of two, that leave at most half of the limit.
#[derive(Debug)]
pub(super) struct PointCloud {
    limit: usize,
    points: Vec<[f64; 3]>,
    received: u64,
    exponent: Option<i32>,
}

impl PointCloud {
    pub(super) fn new(limit: usize) -> Self {
        Self { limit: limit.max(4), points: Vec::new(), received: 0, exponent: None }
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
        self.exponent.map(|exponent| 2.0_f64.powi(exponent))
    }

    pub(super) fn add(&mut self, point: [f64; 3]) {
        self.received += 1;
        // Scanners repeat points; repetitions must not cause thinning.
        if self.points.last() == Some(&point) {
            return;
        }
        self.points.push(point);
        if self.points.len() > self.limit {
            self.thin();
        }
    }

    /// The memory held, in bytes.
    pub(super) fn len(&self) -> usize {
        self.points.len()
    }

    /// The further memory in bytes for `more` points, while the vector grows to twice its size.
    pub(super) fn bytes_to_take(&self, more: usize) -> usize {
        let count = (self.points.len() + more).min(self.limit + 1);
        if count > self.points.capacity() { 2 * count * size_of::<[f64; 3]>() } else { 0 }
    }

    pub(super) fn held_bytes(&self) -> usize {
        self.points.capacity() * size_of::<[f64; 3]>()
    }

    pub(super) fn into_points(self) -> Vec<[f64; 3]> {
        self.points
    }

    fn thin(&mut self) {
        self.points.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])).then(b[2].total_cmp(&a[2])));
        self.points.dedup_by(|b, a| a[..2] == b[..2]);
        let mut bounds = Bounds::NONE;
        self.points.iter().for_each(|&point| bounds.include(point));
        #[expect(clippy::cast_precision_loss, reason = "under 2^53")]
        let finest = {
            let extent = (bounds.max[0] - bounds.min[0]).max(bounds.max[1] - bounds.min[1]) / self.limit as f64;
            extent.max(bounds.largest_magnitude() * 2.0_f64.powi(-40)).max(f64::MIN_POSITIVE)
        };
        #[expect(clippy::cast_possible_truncation, reason = "logarithms of doubles are within 1100")]
        let mut exponent = self.exponent.unwrap_or(finest.log2().floor() as i32);
        while self.points.len() > self.limit / 2 {
            let cell = 2.0_f64.powi(exponent);
            // Adding 0 removes the sign of a zero.
            let place = |point: &[f64; 3]| [(point[1] / cell).floor() + 0.0, (point[0] / cell).floor() + 0.0];
            let off_centre = |point: &[f64; 3]| {
                let [row, column] = place(point);
                (point[0] / cell - column - 0.5).powi(2) + (point[1] / cell - row - 0.5).powi(2)
            };
            self.points.sort_unstable_by(|a, b| {
                let ([row, column], [other_row, other_column]) = (place(a), place(b));
                row.total_cmp(&other_row)
                    .then(column.total_cmp(&other_column))
                    .then(off_centre(a).total_cmp(&off_centre(b)))
                    .then(b[2].total_cmp(&a[2]))
            });
            self.points.dedup_by(|b, a| place(a).map(f64::to_bits) == place(b).map(f64::to_bits));
            self.exponent = Some(exponent);
            exponent += 1;
        }
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
        // Each is one of the received points.
        assert!(points.iter().all(|&[x, y, z]| z == x + 200.0 * y));
    }

    #[test]
    fn points_that_repeat_take_no_room() {
        let mut cloud = PointCloud::new(8);
        for i in 0..1000_u32 {
            cloud.add([f64::from(i % 3), 0.0, 1.0]);
        }
        assert_eq!((cloud.received(), cloud.cell()), (1000, None));
    }
}
