//! The extremes of the coordinates of a table, which show numbers that stand for a missing measurement.

use super::FarOutside;

/// A value is far outside if its distance from the others is more than this many times their range, and the range of
/// every other axis.
const FAR: f64 = 10.0;

/// The factor beyond which a value that programs write for missing measurements is far outside.
const FAR_IF_USUAL: f64 = 3.0;

/// Values that programs write for missing measurements, besides those beyond the largest coordinate, which are refused.
const USUAL: [f64; 8] = [-9999.0, -99999.0, -999.0, -32768.0, -32767.0, 9999.0, 99999.0, 32767.0];

/// The smallest and the largest coordinates along each axis.
#[derive(Debug, Default)]
pub(super) struct CoordinateRange {
    /// For each axis, the smallest and the largest value. The largest is stored with the opposite sign.
    ends: [[Option<End>; 2]; 3],
    points: u64,
}

/// The smallest value, and the next larger one.
#[derive(Debug, Clone, Copy)]
struct End {
    value: f64,
    line: u64,
    points: u64,
    next: f64,
}

impl CoordinateRange {
    /// Adds the point of a line.
    #[inline]
    pub(super) fn add(&mut self, point: [f64; 3], line: u64) {
        self.points += 1;
        for (ends, value) in self.ends.iter_mut().zip(point) {
            for (end, value) in ends.iter_mut().zip([value, -value]) {
                match end {
                    Some(end) if value > end.next => {}
                    Some(end) => end.add(value, line),
                    None => *end = Some(End { value, line, points: 1, next: f64::INFINITY }),
                }
            }
        }
    }

    /// The first axis' value that is far outside; `None` for fewer than five points.
    pub(super) fn far_outside(&self) -> Option<FarOutside> {
        if self.points < 5 {
            return None;
        }
        (0..3).find_map(|axis| (0..2).find_map(|side| self.far_at(axis, side)))
    }

    fn far_at(&self, axis: usize, side: usize) -> Option<FarOutside> {
        let (end, opposite) = (self.ends[axis][side]?, self.ends[axis][1 - side]?);
        // At the other end of the axis, the same value may be the next one.
        let range = -opposite.value - end.next;
        let value = if side == 0 { end.value } else { -end.value };
        let is_usual = USUAL.contains(&value);
        let factor = if is_usual { FAR_IF_USUAL } else { FAR };
        let extent = |axis: usize| {
            let [Some(low), Some(high)] = self.ends[axis] else { return 0.0 };
            // Programs write the same value for all coordinates of a missing point.
            if is_usual { (-high.next - low.next).max(0.0) } else { -high.value - low.value }
        };
        let widest = (0..3).filter(|other| *other != axis).map(extent).fold(range.max(0.0), f64::max);
        let is_far = end.next.is_finite() && widest > 0.0 && end.next - end.value > factor * widest && 2 * end.points < self.points;
        let others = if side == 0 { [end.next, -opposite.value] } else { [opposite.value, -end.next] };
        is_far.then_some(FarOutside { line: end.line, axis, value, points: end.points, others })
    }
}

impl End {
    #[cold]
    fn add(&mut self, value: f64, line: u64) {
        if value < self.value {
            *self = Self { value, line, points: 1, next: self.value };
        } else if value > self.value {
            self.next = value;
        } else {
            self.points += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(heights: &[f64]) -> Option<(u64, f64, u64)> {
        let mut extremes = CoordinateRange::default();
        for (index, z) in heights.iter().enumerate() {
            let at = u32::try_from(index).unwrap();
            extremes.add([f64::from(at % 4), f64::from(at / 4), *z], u64::from(at) + 1);
        }
        extremes.far_outside().map(|far| (far.line, far.value, far.points))
    }

    #[test]
    fn a_value_far_outside_is_found_with_its_first_line() {
        for value in [-9999.0, -32768.0, 1e10, -1e6, 9999.0] {
            assert_eq!(found(&[8.0, 8.5, value, 9.0, 8.0, value, 8.25, 8.5]), Some((3, value, 2)), "{value}");
            assert_eq!(found(&[value, 8.0, 8.5, 9.0, 8.0, 8.0, 8.25, 8.5]), Some((1, value, 1)), "{value}");
        }
        // -99 is 36 times the range of 3 mm away; a pin of 20 mm on a plate is not.
        assert_eq!(found(&[8.0, 8.5, 9.0, 8.0, 8.0, 8.25, 8.5, -99.0]), Some((8, -99.0, 1)));
        assert_eq!(found(&[0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 0.0, 0.0]), None);
        assert_eq!(found(&[8.0, 8.5, 9.0, 8.0, 8.0, 8.25, 8.5, 9.5]), None);
        assert_eq!(found(&[8.0, -9999.0, 8.5]), None, "too few points for a judgement");
    }

    #[test]
    fn half_of_the_points_are_no_exception() {
        assert_eq!(found(&[0.0, 0.0, 0.0, 0.0, 1e6, 1e6, 1e6, 1e6]), None);
    }
}
