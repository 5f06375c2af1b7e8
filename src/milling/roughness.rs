//! Roughness as drawings state it, and the scallop height that keeps it.

use crate::quantity::Length;
use std::fmt;

/// Ra of a profile of equal parabolic arcs of the height 1: 4/(9 sqrt 3).
const RA_OF_ARCS: f64 = 0.256_600_119_639_833_7;

/// A roughness that a surface must keep, and how much rougher a real surface is than its geometry.
///
/// A profile of equal parabolic arcs of the height h has Rz = h and Ra = 4 h/(9 sqrt 3). A profile across the feed through
/// the highest ridge has at most the height h in total, so that a stated Ra is kept by h <= Ra/0.2566. Vibration, wear and
/// built-up edges make real surfaces rougher, by 1.5 to 3 times according to handbooks: the allowance divides the height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Roughness {
    height: f64,
}

/// The reason why numbers are not a roughness.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RoughnessError {
    /// Ra or Rz is not a number from 1e-3 um to 1e4 um.
    Value,
    /// The allowance is not a number from 1 to 100.
    Allowance,
}

impl fmt::Display for RoughnessError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Value => "a roughness must be from 0.001 um to 10000 um",
            Self::Allowance => "the allowance must be from 1 to 100",
        })
    }
}

impl std::error::Error for RoughnessError {}

impl Roughness {
    /// The arithmetic mean deviation Ra in um, from 0.001 to 10000, with an allowance of at least 1.
    ///
    /// # Errors
    /// The [`RoughnessError`] of the number that is out of range.
    pub fn from_ra_um(ra: f64, allowance: f64) -> Result<Self, RoughnessError> {
        Self::new(ra, RA_OF_ARCS, allowance)
    }

    /// The height Rz in um, from 0.001 to 10000, with an allowance of at least 1.
    ///
    /// # Errors
    /// The [`RoughnessError`] of the number that is out of range.
    pub fn from_rz_um(rz: f64, allowance: f64) -> Result<Self, RoughnessError> {
        Self::new(rz, 1.0, allowance)
    }

    fn new(value: f64, of_arcs: f64, allowance: f64) -> Result<Self, RoughnessError> {
        if !(1e-3..=1e4).contains(&value) {
            return Err(RoughnessError::Value);
        }
        if !(1.0..=100.0).contains(&allowance) {
            return Err(RoughnessError::Allowance);
        }
        Ok(Self { height: value / (1e3 * of_arcs * allowance) })
    }

    /// The largest scallop height that keeps the roughness.
    #[must_use]
    pub fn scallop_height(self) -> Length {
        Length::computed(self.height)
    }
}

/// Ra in um of the geometry of a surface with this scallop height: 0.2566 h.
#[must_use]
pub fn ra_um(height: Length) -> f64 {
    1e3 * RA_OF_ARCS * height.mm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn ra_is_the_mean_deviation_of_a_parabola_from_its_mean() {
        assert_relative_eq!(RA_OF_ARCS, 4.0 / (9.0 * 3.0_f64.sqrt()), epsilon = 1e-15);
        let count = 100_000;
        let heights = || (0..count).map(|step| ((f64::from(step) + 0.5) / f64::from(count)).powi(2));
        let mean = heights().sum::<f64>() / f64::from(count);
        let deviation = heights().map(|height| (height - mean).abs()).sum::<f64>() / f64::from(count);
        assert_relative_eq!(deviation, RA_OF_ARCS, epsilon = 1e-8);
    }

    #[test]
    fn a_stated_roughness_is_that_of_its_height() {
        let roughness = Roughness::from_ra_um(0.8, 1.0).unwrap();
        assert_relative_eq!(ra_um(roughness.scallop_height()), 0.8, epsilon = 1e-12);
        assert_relative_eq!(Roughness::from_ra_um(0.8, 2.0).unwrap().scallop_height().mm(), 0.5 * roughness.scallop_height().mm());
        assert_relative_eq!(Roughness::from_rz_um(10.0, 1.0).unwrap().scallop_height().mm(), 0.01, epsilon = 1e-15);
        assert_eq!(Roughness::from_ra_um(0.0, 1.0), Err(RoughnessError::Value));
        assert_eq!(Roughness::from_ra_um(f64::NAN, 1.0), Err(RoughnessError::Value));
        assert_eq!(Roughness::from_rz_um(1.0, 0.5), Err(RoughnessError::Allowance));
    }
}
