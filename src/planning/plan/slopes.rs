//! The slopes at which tables of spacings have their rows.

use std::sync::LazyLock;

/// The sines of the rows' slopes, rising from 0 to 1: slope 0, then from 0.02 deg to 10 deg each a quarter larger than
/// the one before, then every 2.5 deg.
///
/// The square of the step-over is proportional to 1/sin(S) at slopes at which the cutter's corner makes the groove, and
/// constant at those at which its flat does.
static SINES: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let mut degrees = vec![0.0];
    let mut next: f64 = 0.02;
    while next < 9.0 {
        degrees.push(next);
        next *= 1.25;
    }
    degrees.extend((4..=36).map(|step| 2.5 * f64::from(step)));
    degrees.into_iter().map(|slope| if slope >= 90.0 { 1.0 } else { slope.to_radians().sin() }).collect()
});

pub(super) fn sines() -> &'static [f64] {
    &SINES
}

/// A slope between two rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SlopePlace {
    /// The row with the lower slope; not the last one.
    pub(super) row: u32,
    /// The weight of the next row, 0 to 1.
    pub(super) weight: f64,
}

/// The position of a slope between two rows: linear in 1/sin(S), except between the floor and the first row above it,
/// where it is linear in sin(S).
pub(super) fn place_of(sin: f64) -> SlopePlace {
    let sines = sines();
    let row = sines.partition_point(|&row| row <= sin).saturating_sub(1).min(sines.len() - 2);
    let (low, high) = (sines[row], sines[row + 1]);
    let weight = if row == 0 { sin / high } else { (1.0 / low - 1.0 / sin) / (1.0 / low - 1.0 / high) };
    #[expect(clippy::cast_possible_truncation, reason = "some sixty rows")]
    SlopePlace { row: row as u32, weight: weight.clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_span_all_slopes() {
        assert_eq!(place_of(0.0), SlopePlace { row: 0, weight: 0.0 });
        for (row, pair) in sines().windows(2).enumerate() {
            assert!(pair[0] < pair[1]);
            let middle = place_of(f64::midpoint(pair[0], pair[1]));
            assert_eq!(middle.row as usize, row);
            assert!(middle.weight > 0.3 && middle.weight < 0.7);
        }
        let wall = place_of(1.0);
        assert_eq!((wall.row as usize, wall.weight), (sines().len() - 2, 1.0));
    }
}
