//! The inclined rectangle, and the zigzag that finishes it.

use crate::motion::{MachineLimits, travel_time};
use crate::quantity::{Area, FormFactor, Length, OutOfRange, Time};
use std::fmt;

/// A rectangle w x h with w >= h whose long side is level, so that its short side runs along the steepest slope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InclinedRectangle {
    width: Length,
    height: Length,
}

/// The side that should be the short one is longer than the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HeightExceedsWidth;

impl fmt::Display for HeightExceedsWidth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the height, up the slope, must not exceed the width, the level side: the method compares passes along a long level side with passes up a short slope")
    }
}

impl std::error::Error for HeightExceedsWidth {}

impl InclinedRectangle {
    /// A rectangle with the level side w and the side h up the slope.
    ///
    /// # Errors
    /// [`HeightExceedsWidth`] unless w >= h.
    pub fn from_sides(width: Length, height: Length) -> Result<Self, HeightExceedsWidth> {
        if width >= height { Ok(Self { width, height }) } else { Err(HeightExceedsWidth) }
    }

    /// A rectangle with mu = w/h and chi = w h: w = sqrt(mu chi), h = sqrt(chi/mu) [Herraz et al. 2020, eq. 5].
    ///
    /// # Errors
    /// [`OutOfRange`] with the bounds of a length in mm, if a side is outside them.
    pub fn from_form(form_factor: FormFactor, characteristic_size: Area) -> Result<Self, OutOfRange> {
        let Self { width, height } = Self::of_any_size(form_factor.ratio(), characteristic_size);
        Ok(Self { width: Length::from_mm(width.mm())?, height: Length::from_mm(height.mm())? })
    }

    /// As [`InclinedRectangle::from_form`] for mu >= 1, with sides that were computed.
    pub(super) fn of_any_size(mu: f64, characteristic_size: Area) -> Self {
        let (root, chi) = (mu.sqrt(), characteristic_size.mm2().sqrt());
        Self { width: Length::computed(chi * root), height: Length::computed(chi / root) }
    }

    /// w, the level side.
    #[must_use]
    pub fn width(self) -> Length {
        self.width
    }

    /// h, the side up the slope.
    #[must_use]
    pub fn height(self) -> Length {
        self.height
    }

    /// mu = w/h.
    #[must_use]
    pub fn form_factor(self) -> FormFactor {
        FormFactor::computed(self.width.mm() / self.height.mm())
    }

    /// chi = w h.
    #[must_use]
    pub fn characteristic_size(self) -> Area {
        Area::computed(self.width.mm() * self.height.mm())
    }

    /// The zigzag up and down the slope, as the toroidal cutter takes it: n1 = w/sod1 passes of length h.
    #[must_use]
    pub fn up_and_down(self, step_over: Length, machine: MachineLimits) -> Zigzag {
        Zigzag::of(self.width, self.height, step_over, machine)
    }

    /// The zigzag along the long side, as the ball-end cutter takes it: n2 = h/sod2 passes of length w.
    #[must_use]
    pub fn along_the_long_side(self, step_over: Length, machine: MachineLimits) -> Zigzag {
        Zigzag::of(self.height, self.width, step_over, machine)
    }
}

/// A zigzag: passes in alternating directions, with a stop at each corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Zigzag {
    /// sod, the distance between passes.
    pub step_over: Length,
    /// n = side across the passes / sod, the model's quotient, not rounded.
    pub passes: f64,
    /// n (pass + sod).
    pub path_length: Length,
    /// n (t(pass) + t(sod)) with t the time of a straight move from rest to rest [Herraz et al. 2020, eq. 8 and 9].
    pub time: Time,
}

impl Zigzag {
    fn of(across: Length, pass: Length, step_over: Length, machine: MachineLimits) -> Self {
        let passes = across.mm() / step_over.mm();
        let time = travel_time(pass, machine) + travel_time(step_over, machine);
        Self {
            step_over,
            passes,
            path_length: Length::computed(passes * (pass + step_over).mm()),
            time: Time::computed(passes * time.seconds()),
        }
    }

    /// The same passes in `factor` times the time.
    #[must_use]
    pub fn slowed(self, factor: f64) -> Self {
        Self { time: Time::computed(factor * self.time.seconds()), ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::PRESETS;
    use approx::assert_relative_eq;

    fn mm(value: f64) -> Length {
        Length::from_mm(value).unwrap()
    }

    #[test]
    fn sides_and_form_describe_the_same_rectangle() {
        let by_sides = InclinedRectangle::from_sides(mm(56.0), mm(28.0)).unwrap();
        let by_form = InclinedRectangle::from_form(by_sides.form_factor(), by_sides.characteristic_size()).unwrap();
        assert_relative_eq!(by_sides.form_factor().ratio(), 2.0);
        assert_relative_eq!(by_sides.characteristic_size().mm2(), 1568.0);
        assert_relative_eq!(by_form.width().mm(), 56.0, max_relative = 1e-15);
        assert_relative_eq!(by_form.height().mm(), 28.0, max_relative = 1e-15);
    }

    #[test]
    fn rectangles_that_stand_upright_or_leave_the_bounds_are_refused() {
        assert_eq!(InclinedRectangle::from_sides(mm(1.0), mm(1.1)), Err(HeightExceedsWidth));
        let (mu, largest) = (FormFactor::new(4.0).unwrap(), Area::from_mm2(1e12).unwrap());
        assert_eq!(InclinedRectangle::from_form(mu, largest), Err(OutOfRange { minimum: 1e-6, maximum: 1e6 }));
    }

    #[test]
    fn a_zigzag_has_one_step_for_each_pass() {
        let machine = PRESETS[0].limits;
        let rectangle = InclinedRectangle::from_sides(mm(30.0), mm(20.0)).unwrap();
        let zigzag = rectangle.up_and_down(mm(0.5), machine);
        assert_relative_eq!(zigzag.passes, 60.0);
        assert_relative_eq!(zigzag.path_length.mm(), 60.0 * 20.5);
        let pass_and_step = (travel_time(mm(20.0), machine) + travel_time(mm(0.5), machine)).seconds();
        assert_relative_eq!(zigzag.time.seconds(), 60.0 * pass_and_step);
        assert_relative_eq!(rectangle.along_the_long_side(mm(0.5), machine).passes, 40.0);
    }
}
