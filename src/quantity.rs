//! Physical quantities whose existence proves that they are valid: finite, and inside bounds in which no formula of this crate
//! over- or underflows. Inside they are millimetres, radians and seconds; conversions from other units belong to the border
//! of the program (`http`), not here.

use std::fmt;

/// A number outside the bounds that its quantity allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutOfRange {
    /// The smallest value allowed, in the quantity's own unit.
    pub minimum: f64,
    /// The largest value allowed, in the quantity's own unit.
    pub maximum: f64,
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "must be from {} to {}", self.minimum, self.maximum)
    }
}

impl std::error::Error for OutOfRange {}

impl OutOfRange {
    /// `value` if it lies in `[minimum, maximum]`; NaN lies nowhere.
    ///
    /// # Errors
    /// The bounds, when `value` is outside them.
    pub fn check(value: f64, minimum: f64, maximum: f64) -> Result<f64, Self> {
        if value >= minimum && value <= maximum { Ok(value) } else { Err(Self { minimum, maximum }) }
    }
}

/// A length: finite and not negative, in millimetres.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Length(f64);

impl Length {
    /// No length at all. Only results can be zero: a length that is stated is at least [`Length::SMALLEST`].
    pub const ZERO: Self = Self(0.0);
    /// The smallest length that can be stated, 1 nm, in mm.
    pub const SMALLEST: f64 = 1e-6;
    /// The largest length that can be stated, 1 km, in mm.
    pub const LARGEST: f64 = 1e6;

    /// A length that somebody states (a dimension, a setting, a tolerance), from 1 nm to 1 km, in mm.
    ///
    /// # Errors
    /// [`OutOfRange`] outside these bounds.
    pub fn from_mm(mm: f64) -> Result<Self, OutOfRange> {
        OutOfRange::check(mm, Self::SMALLEST, Self::LARGEST).map(Self)
    }

    /// A length that a formula yields. The formula's domain makes it finite and not negative.
    pub(crate) fn computed(mm: f64) -> Self {
        debug_assert!(mm.is_finite() && mm >= 0.0, "a computed length must be finite and not negative, got {mm}");
        Self(mm)
    }

    /// The length in mm.
    #[must_use]
    pub fn mm(self) -> f64 {
        self.0
    }
}

impl std::ops::Add for Length {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::computed(self.0 + other.0)
    }
}

/// An angle with its sine and cosine, exact at quarter turns: the cosine of 90 deg is 0, not 6e-17, so that a vertical wall is
/// vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    radians: f64,
    sin: f64,
    cos: f64,
}

impl Angle {
    /// The angle 0.
    pub const ZERO: Self = Self { radians: 0.0, sin: 0.0, cos: 1.0 };

    /// An angle given in degrees; any finite number. Whole turns are taken off before the sine and cosine are, exactly.
    ///
    /// # Errors
    /// [`OutOfRange`] when `degrees` is not finite.
    pub fn from_degrees(degrees: f64) -> Result<Self, OutOfRange> {
        OutOfRange::check(degrees, -f64::MAX, f64::MAX)?;
        let in_turn = degrees % 360.0;
        let quarter = (in_turn / 90.0).round();
        let (sin, cos) = (in_turn - 90.0 * quarter).to_radians().sin_cos();
        let (sin, cos) = match quarter.rem_euclid(4.0) {
            0.0 => (sin, cos),
            1.0 => (cos, -sin),
            2.0 => (-sin, -cos),
            _ => (-cos, sin),
        };
        Ok(Self { radians: in_turn.to_radians(), sin, cos })
    }

    /// The angle of the vector (x, y) from the X axis; `None` for the null vector.
    pub(crate) fn of_vector(x: f64, y: f64) -> Option<Self> {
        let length = x.hypot(y);
        (length > 0.0).then(|| Self { radians: y.atan2(x), sin: y / length, cos: x / length })
    }

    /// An angle that a formula yields, in radians.
    pub(crate) fn from_radians(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { radians, sin, cos }
    }

    /// The angle in radians; given in degrees, within (-2 pi, 2 pi).
    #[must_use]
    pub fn radians(self) -> f64 {
        self.radians
    }

    /// The sine.
    #[must_use]
    pub fn sin(self) -> f64 {
        self.sin
    }

    /// The cosine.
    #[must_use]
    pub fn cos(self) -> f64 {
        self.cos
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        for (degrees, sin, cos) in
            [(0.0, 0.0, 1.0), (90.0, 1.0, 0.0), (180.0, 0.0, -1.0), (270.0, -1.0, 0.0), (-90.0, -1.0, 0.0), (3690.0, 1.0, 0.0)]
        {
            let angle = Angle::from_degrees(degrees).unwrap();
            assert_eq!((angle.sin(), angle.cos()), (sin, cos), "{degrees} deg");
        }
    }

    #[test]
    fn reduced_angles_agree_with_the_library_sine() {
        for tenth in -7200..7200 {
            let degrees = f64::from(tenth) / 10.0;
            let angle = Angle::from_degrees(degrees).unwrap();
            // An angle of up to 4 pi carries a rounding of 2e-15 into the library's sine.
            approx::assert_abs_diff_eq!(angle.sin(), degrees.to_radians().sin(), epsilon = 4e-15);
            approx::assert_abs_diff_eq!(angle.cos(), degrees.to_radians().cos(), epsilon = 4e-15);
        }
    }

    #[test]
    fn what_is_not_a_length_is_refused_with_its_bounds() {
        for wrong in [f64::NAN, f64::INFINITY, -1.0, 0.0, 9.9e-7, 1.1e6] {
            assert_eq!(Length::from_mm(wrong), Err(OutOfRange { minimum: 1e-6, maximum: 1e6 }));
        }
    }
}
