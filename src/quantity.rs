//! Checked physical quantities: every value is finite and within bounds in which no formula of this crate overflows or
//! underflows. Internal units are mm, rad and s. Conversions from other units belong in `http`.

use crate::numerics::hypotenuse;
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
    /// Returns `value` if it is in `[minimum, maximum]`; NaN is not.
    ///
    /// # Errors
    /// The bounds, when `value` is outside them.
    pub const fn check(value: f64, minimum: f64, maximum: f64) -> Result<f64, Self> {
        if value >= minimum && value <= maximum { Ok(value) } else { Err(Self { minimum, maximum }) }
    }
}

/// Declares a quantity: its checked constructor with the bounds, its constructor for computed values, and its value in
/// the internal unit.
macro_rules! quantity {
    (
        $(#[$about:meta])* $name:ident: $get:ident in $unit:literal;
        $( stated: $from:ident($number:ident in $stated_unit:literal: $smallest:literal to $largest:literal) = $inside:expr; )?
        $( computed: at least $least:expr; )?
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
        pub struct $name(f64);

        impl $name {
            $(
                #[doc = concat!("The smallest value that is accepted, in ", $stated_unit, ".")]
                pub const SMALLEST: f64 = $smallest;
                #[doc = concat!("The largest value that is accepted, in ", $stated_unit, ".")]
                pub const LARGEST: f64 = $largest;

                #[doc = concat!("A user-supplied value, in ", $stated_unit, ".")]
                ///
                /// # Errors
                #[doc = concat!("[`OutOfRange`] outside [`", stringify!($name), "::SMALLEST`] to [`", stringify!($name), "::LARGEST`].")]
                pub const fn $from($number: f64) -> Result<Self, OutOfRange> {
                    match OutOfRange::check($number, Self::SMALLEST, Self::LARGEST) {
                        Ok($number) => Ok(Self($inside)),
                        Err(bounds) => Err(bounds),
                    }
                }
            )?

            $(
                #[doc = concat!("A computed value, in ", $unit, ". The formula's domain makes it finite, and large enough.")]
                pub(crate) fn computed(value: f64) -> Self {
                    debug_assert!(value.is_finite() && value >= $least, concat!(stringify!($name), " cannot be {}"), value);
                    Self(value)
                }
            )?

            #[doc = concat!("The value in ", $unit, ".")]
            #[must_use]
            pub fn $get(self) -> f64 {
                self.0
            }
        }
    };
}

quantity! {
    /// A length: finite and not negative, in millimetres. A user-supplied length (a dimension, a setting, a tolerance) is
    /// from 1 nm to 1 km.
    Length: mm in "mm";
    stated: from_mm(mm in "mm": 1e-6 to 1e6) = mm;
    computed: at least 0.0;
}

impl Length {
    /// Zero length. Only results can be zero: a user-supplied length is at least [`Length::SMALLEST`].
    pub const ZERO: Self = Self(0.0);
}

quantity! {
    /// An area: finite and not negative, in mm^2. The bounds of a user-supplied area are the squares of a length's.
    Area: mm2 in "mm^2";
    stated: from_mm2(mm2 in "mm^2": 1e-12 to 1e12) = mm2;
    computed: at least 0.0;
}

quantity! {
    /// The form factor mu of a rectangle, or of the equivalent rectangle of a surface: long side over short side, at
    /// least 1. The largest is that of a rectangle 1 mm wide and 1 km long.
    FormFactor: ratio in "long sides over short sides";
    stated: new(mu in "long sides over short sides": 1.0 to 1e6) = mu;
    computed: at least 1.0;
}

impl FormFactor {
    /// The form factor of a square.
    pub const SQUARE: Self = Self(1.0);
}

quantity! {
    /// A span of time: finite and not negative, in seconds. A user-supplied one is at most a day.
    Time: seconds in "s";
    stated: from_s(seconds in "s": 0.0 to 86_400.0) = seconds;
    computed: at least 0.0;
}

/// Adds quantities of which the sum of two is another.
macro_rules! sums {
    ($($name:ident),+) => {
        $(
            impl std::ops::Add for $name {
                type Output = Self;
                fn add(self, other: Self) -> Self {
                    Self::computed(self.0 + other.0)
                }
            }
        )+
    };
}
sums!(Length, Time);

quantity! {
    /// A speed of a machine: positive, at most a kilometre a minute. The internal unit is mm/s; feed rates are given in
    /// mm/min.
    Speed: mm_s in "mm/s";
    stated: from_mm_min(mm_min in "mm/min": 1e-3 to 1e6) = mm_min / 60.0;
    computed: at least f64::MIN_POSITIVE;
}

impl Speed {
    /// The speed in mm/min. One that was given in mm/min, with up to nine decimals, is again the same number.
    #[must_use]
    pub fn mm_min(self) -> f64 {
        const STEPS: f64 = 1e9;
        let product = self.0 * 60.0;
        // The conversion to mm/s, and those to a feed per tooth and back, round in the last places.
        let given = (product * STEPS).round() / STEPS;
        if (given - product).abs() <= 8.0 * f64::EPSILON * product { given } else { product }
    }
}

quantity! {
    /// The rotational speed of a spindle: positive, in revolutions per minute. Air-bearing spindles reach 3e5.
    SpindleSpeed: rpm in "rev/min";
    stated: from_rpm(rpm in "rev/min": 1e-3 to 1e6) = rpm;
}

quantity! {
    /// An acceleration of a machine: positive. The internal unit is mm/s^2; data sheets give m/s^2.
    Acceleration: mm_s2 in "mm/s^2";
    stated: from_m_s2(m_s2 in "m/s^2": 1e-4 to 1e5) = m_s2 * 1e3;
}

quantity! {
    /// A jerk, the rate of change of the acceleration: positive. The internal unit is mm/s^3; data sheets give m/s^3. The
    /// largest is in practice a control without a jerk limit.
    Jerk: mm_s3 in "mm/s^3";
    stated: from_m_s3(m_s3 in "m/s^3": 1e-4 to 1e8) = m_s3 * 1e3;
}

/// An angle with its sine and cosine, exact at quarter turns: the cosine of 90 deg is 0, not 6e-17, so that a vertical
/// wall is vertical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angle {
    radians: f64,
    sin: f64,
    cos: f64,
}

impl Angle {
    /// The angle 0.
    pub const ZERO: Self = Self { radians: 0.0, sin: 0.0, cos: 1.0 };

    /// A right angle, 90 deg.
    pub const RIGHT: Self = Self { radians: std::f64::consts::FRAC_PI_2, sin: 1.0, cos: 0.0 };

    /// An angle given in degrees, which may be any finite number. Whole turns are subtracted exactly before sine and
    /// cosine are computed.
    ///
    /// # Errors
    /// [`OutOfRange`] when `degrees` is not finite.
    pub fn from_degrees(degrees: f64) -> Result<Self, OutOfRange> {
        OutOfRange::check(degrees, -f64::MAX, f64::MAX)?;
        // The remainder takes as long as sine and cosine.
        let in_turn = if degrees.abs() < 360.0 { degrees } else { degrees % 360.0 };
        // Rounded by a cast, which takes less time than the library's function.
        #[expect(clippy::cast_possible_truncation, reason = "from -4 to 4")]
        let quarter = (in_turn / 90.0 + 0.5_f64.copysign(in_turn)) as i32;
        let (sin, cos) = (in_turn - 90.0 * f64::from(quarter)).to_radians().sin_cos();
        let (sin, cos) = match quarter.rem_euclid(4) {
            0 => (sin, cos),
            1 => (cos, -sin),
            2 => (-sin, -cos),
            _ => (-cos, sin),
        };
        // Adding 0 removes the sign of a negative zero, which a division would turn into a negative infinity.
        Ok(Self { radians: in_turn.to_radians(), sin: sin + 0.0, cos: cos + 0.0 })
    }

    /// The angle of the vector (x, y) from the X axis; `None` for the null vector.
    pub(crate) fn of_vector(x: f64, y: f64) -> Option<Self> {
        let length = hypotenuse(x, y);
        (length > 0.0).then(|| Self { radians: y.atan2(x), sin: y / length, cos: x / length })
    }

    /// The direction of the line along (x, y), from the X axis counter-clockwise, in [0, pi); `None` for the null
    /// vector.
    ///
    /// Computed vectors have rounding errors, and a vector just below the X axis would give a line of almost pi in
    /// place of 0. Within 1e-12 of an axis, the line is therefore the axis.
    pub(crate) fn of_line(x: f64, y: f64) -> Option<Self> {
        if y.abs() <= 1e-12 * x.abs() {
            return (x != 0.0).then_some(Self::ZERO);
        }
        if x.abs() <= 1e-12 * y.abs() {
            return Some(Self::RIGHT);
        }
        if y < 0.0 { Self::of_vector(-x, -y) } else { Self::of_vector(x, y) }
    }

    /// A computed angle, in radians.
    pub(crate) fn from_radians(radians: f64) -> Self {
        let (sin, cos) = radians.sin_cos();
        Self { radians, sin, cos }
    }

    /// The angle in radians; given in degrees, within (-2 pi, 2 pi).
    #[must_use]
    pub fn radians(self) -> f64 {
        self.radians
    }

    /// The angle in degrees; given in degrees, within (-360, 360).
    #[must_use]
    pub fn degrees(self) -> f64 {
        self.radians.to_degrees()
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

/// A direction in a plane, by the cosine and sine of its angle from the X axis. The angle itself takes as long as both
/// and is computed where it is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction {
    cos: f64,
    sin: f64,
}

impl Direction {
    /// The direction of the X axis.
    pub const ZERO: Self = Self { cos: 1.0, sin: 0.0 };

    /// The direction of the vector (x, y); `None` for the null vector.
    pub(crate) fn of_vector(x: f64, y: f64) -> Option<Self> {
        let length = hypotenuse(x, y);
        (length > 0.0).then(|| Self { cos: x / length, sin: y / length })
    }

    /// The angle in radians, from -pi to pi.
    #[must_use]
    pub fn radians(self) -> f64 {
        self.sin.atan2(self.cos)
    }

    /// The angle in degrees, from -180 to 180.
    #[must_use]
    pub fn degrees(self) -> f64 {
        self.radians().to_degrees()
    }

    /// The sine of the angle.
    #[must_use]
    pub fn sin(self) -> f64 {
        self.sin
    }

    /// The cosine of the angle.
    #[must_use]
    pub fn cos(self) -> f64 {
        self.cos
    }
}

impl From<Angle> for Direction {
    fn from(angle: Angle) -> Self {
        Self { cos: angle.cos, sin: angle.sin }
    }
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
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
    fn lines_point_from_0_to_under_180_degrees() {
        for (x, y, degrees) in
            [(1.0, 0.0, 0.0), (-1.0, -0.0, 0.0), (0.0, -2.0, 90.0), (-1.0, 1e-20, 0.0), (1.0, -1.0, 135.0), (-3.0, -3.0, 45.0)]
        {
            let line = Angle::of_line(x, y).unwrap();
            // 3/4 pi in degrees is rounded once, to 1.4e-14 deg.
            approx::assert_abs_diff_eq!(line.degrees(), degrees, epsilon = 3e-14);
            assert!(line.degrees() >= 0.0 && line.degrees() < 180.0 && line.degrees().is_sign_positive());
        }
        assert_eq!(Angle::of_line(0.0, 0.0), None);
    }

    #[test]
    fn stated_feed_rates_are_the_same_numbers_again() {
        for tenth in 1..200_000 {
            let stated = f64::from(tenth) / 10.0;
            assert_eq!(Speed::from_mm_min(stated).unwrap().mm_min(), stated);
        }
    }

    #[test]
    fn machine_limits_are_kept_in_millimetres_and_seconds() {
        assert_eq!(Speed::from_mm_min(6000.0).unwrap().mm_s(), 100.0);
        assert_eq!(Acceleration::from_m_s2(6.0).unwrap().mm_s2(), 6000.0);
        assert_eq!(Jerk::from_m_s3(40.0).unwrap().mm_s3(), 40_000.0);
        for wrong in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e9] {
            assert!(Speed::from_mm_min(wrong).is_err() && Acceleration::from_m_s2(wrong).is_err() && Jerk::from_m_s3(wrong).is_err());
        }
        assert_eq!(FormFactor::new(0.99), Err(OutOfRange { minimum: 1.0, maximum: 1e6 }));
        assert_eq!(Area::from_mm2(0.0), Err(OutOfRange { minimum: 1e-12, maximum: 1e12 }));
    }

    #[test]
    fn numbers_that_are_no_lengths_are_refused_with_the_bounds() {
        for wrong in [f64::NAN, f64::INFINITY, -1.0, 0.0, 9.9e-7, 1.1e6] {
            assert_eq!(Length::from_mm(wrong), Err(OutOfRange { minimum: 1e-6, maximum: 1e6 }));
        }
    }
}
