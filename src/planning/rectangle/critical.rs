//! The critical slope and the critical form factor, at which both cutters take the same time.

use super::{CutterComparison, InclinedRectangle};
use crate::milling::{Model, NoAnswer};
use crate::motion::{TravelCase, travel_time};
use crate::numerics::bracketed_root;
use crate::quantity::{Angle, Area, FormFactor, Length};
use std::convert::Infallible;

/// The critical slope s_c: below it the toroidal cutter up and down the slope is faster, above it the ball-end cutter
/// along the long side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CriticalSlope {
    /// Both take the same time at this slope.
    At(Angle),
    /// The toroidal cutter is faster on every slope up to a wall.
    ToroidalAlways,
    /// The ball-end cutter is faster on every slope down to 1e-6 deg, which counts as a floor.
    BallEndAlways,
}

impl CriticalSlope {
    /// s_c as an angle: 90 deg if the toroidal cutter is always faster, 0 if the ball-end cutter is.
    #[must_use]
    pub fn angle(self) -> Angle {
        match self {
            Self::At(slope) => slope,
            Self::ToroidalAlways => Angle::RIGHT,
            Self::BallEndAlways => Angle::ZERO,
        }
    }

    /// Whether the toroidal cutter is faster at `slope`.
    #[must_use]
    pub fn favours_toroidal(self, slope: Angle) -> bool {
        match self {
            Self::At(critical) => slope.radians() < critical.radians(),
            Self::ToroidalAlways => true,
            Self::BallEndAlways => false,
        }
    }
}

/// The critical form factor mu_c: below it the toroidal cutter is faster, above it the ball-end cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CriticalFormFactor {
    /// Both take the same time at this form factor.
    At(FormFactor),
    /// The ball-end cutter is faster even on a square.
    BallEndAlways,
}

impl CriticalFormFactor {
    /// mu_c: 1 if the ball-end cutter is always faster.
    #[must_use]
    pub fn form_factor(self) -> FormFactor {
        match self {
            Self::At(form_factor) => form_factor,
            Self::BallEndAlways => FormFactor::SQUARE,
        }
    }
}

/// Two times count as equal up to this relative difference. Each is the result of a dozen rounded operations, 3e-15,
/// and equal cutters on a square must have equal times.
const TIE: f64 = 1e-13;

/// The flattest slope at which times are compared, in degrees: 17 nm over a metre. A flatter slope counts as a
/// floor.
const FLATTEST: f64 = 1e-6;

/// The critical slope s_c(mu, chi) of a rectangle: T1(s_c) = T2.
///
/// It has a closed form if passes reach the feed rate and only the jerk limits the steps between them [Herraz et al.
/// 2020, eq. 10-14, eq. 13 with its sign corrected]. Otherwise the root is bracketed; T1 grows with s, but is constant where
/// the bound of the floor holds, so there is at most one.
///
/// # Errors
/// The [`NoAnswer`] of the step-over on a slope that the search evaluates.
pub fn critical_slope(job: &CutterComparison, rectangle: InclinedRectangle) -> Result<CriticalSlope, NoAnswer> {
    let on_wall = excess_at_slope(job, rectangle, Angle::RIGHT)?;
    if on_wall < -TIE {
        return Ok(CriticalSlope::ToroidalAlways);
    }
    if on_wall <= TIE {
        return Ok(CriticalSlope::At(Angle::RIGHT));
    }
    match critical_slope_in_closed_form(job, rectangle) {
        Some(slope) => Ok(CriticalSlope::At(slope)),
        None => critical_slope_by_bracketing(job, rectangle),
    }
}

/// ln(T1/T2) at a slope, negative if the toroidal cutter is faster.
fn excess_at_slope(job: &CutterComparison, rectangle: InclinedRectangle, slope: Angle) -> Result<f64, NoAnswer> {
    let zigzag = rectangle.up_and_down(job.toroidal_step_over(slope)?, job.machine());
    Ok((zigzag.time.seconds() / ball_end_time(job, rectangle)).ln())
}

/// The critical slope of a rectangle on which the ball-end cutter is faster on a wall. The search uses the logarithms
/// of T1 and s, because T1 is nearly a power of s on gentle slopes.
fn critical_slope_by_bracketing(job: &CutterComparison, rectangle: InclinedRectangle) -> Result<CriticalSlope, NoAnswer> {
    let (flattest, wall) = (FLATTEST.to_radians(), Angle::RIGHT.radians());
    // The exponential of the wall's logarithm may exceed the wall by a rounding error.
    let slope = |logarithm: f64| Angle::from_radians(logarithm.exp().min(wall));
    if excess_at_slope(job, rectangle, slope(flattest.ln()))? >= 0.0 {
        return Ok(CriticalSlope::BallEndAlways);
    }
    let logarithm = bracketed_root(flattest.ln(), wall.ln(), |logarithm| excess_at_slope(job, rectangle, slope(logarithm)))?;
    Ok(CriticalSlope::At(slope(logarithm)))
}

/// T2, the time of the ball-end cutter along the long side, in s.
fn ball_end_time(job: &CutterComparison, rectangle: InclinedRectangle) -> f64 {
    rectangle.along_the_long_side(job.ball_end_step_over(), job.machine()).time.seconds()
}

/// The critical slope in closed form. With z = cbrt(sod1), T1 = T2 reads z^3 - p z - q = 0, p = 4 w / (T2 cbrt(2J)), q
/// = w t(h) / T2. `None` unless the assumptions hold: the analytic model, passes that reach the feed rate, steps that
/// only the jerk limits and that are shorter than on a floor, and a single real root.
fn critical_slope_in_closed_form(job: &CutterComparison, rectangle: InclinedRectangle) -> Option<Angle> {
    let machine = job.machine();
    if job.model() != Model::Analytic || !TravelCase::of(rectangle.height(), machine).reaches_feed_rate() {
        return None;
    }
    let width_by_time = rectangle.width().mm() / ball_end_time(job, rectangle);
    let p = 4.0 * width_by_time / (2.0 * machine.jerk.mm_s3()).cbrt();
    let q = width_by_time * travel_time(rectangle.height(), machine).seconds();
    let discriminant = (q / 2.0).powi(2) - (p / 3.0).powi(3);
    if discriminant < 0.0 {
        return None;
    }
    // Cardano's two cube roots have the product p/3. Computing the smaller one directly would cancel, so it is derived
    // from the product.
    let larger = (q / 2.0 + discriminant.sqrt()).cbrt();
    let step_over = (larger + p / (3.0 * larger)).powi(3);
    if TravelCase::of(Length::computed(step_over), machine) != TravelCase::JerkOnly {
        return None;
    }
    // R_eff = sh/2 + sod1^2/(8 sh) = (R - r)/sin(s_c) + r
    let (scallop, cutter) = (job.scallop_height().mm(), job.toroidal());
    if step_over >= cutter.step_over_on_floor(job.scallop_height()).mm() {
        return None;
    }
    let effective_radius = scallop / 2.0 + step_over * step_over / (8.0 * scallop);
    let sin = cutter.core_radius().mm() / (effective_radius - cutter.corner_radius().mm());
    (sin > 0.0 && sin <= 1.0).then(|| Angle::of_vector(((1.0 - sin) * (1.0 + sin)).sqrt(), sin)).flatten()
}

/// The critical form factor mu_c(s, chi) of rectangles of one size at one slope: T1(mu_c) = T2(mu_c).
///
/// It has a closed form if passes reach the feed rate [Herraz et al. 2020, eq. 21 and 22]. Otherwise the root is
/// bracketed; T1 grows and T2 falls with mu.
///
/// # Errors
/// The [`NoAnswer`] of the step-over at that slope.
pub fn critical_form_factor(job: &CutterComparison, characteristic_size: Area, slope: Angle) -> Result<CriticalFormFactor, NoAnswer> {
    let toroidal = job.toroidal_step_over(slope)?;
    let on_square = excess_at_form_factor(job, characteristic_size, toroidal, 1.0);
    if on_square > TIE {
        return Ok(CriticalFormFactor::BallEndAlways);
    }
    if on_square >= -TIE {
        return Ok(CriticalFormFactor::At(FormFactor::SQUARE));
    }
    let closed = critical_form_factor_in_closed_form(job, characteristic_size, toroidal);
    Ok(CriticalFormFactor::At(closed.unwrap_or_else(|| critical_form_factor_by_bracketing(job, characteristic_size, toroidal))))
}

/// ln(T1/T2) at a form factor, with the toroidal cutter's step-over; negative if the toroidal cutter is faster.
fn excess_at_form_factor(job: &CutterComparison, characteristic_size: Area, toroidal: Length, mu: f64) -> f64 {
    let rectangle = InclinedRectangle::of_any_size(mu, characteristic_size);
    (rectangle.up_and_down(toroidal, job.machine()).time.seconds() / ball_end_time(job, rectangle)).ln()
}

/// The critical form factor, by bracketing, at a step-over with which the toroidal cutter is faster on a square.
fn critical_form_factor_by_bracketing(job: &CutterComparison, characteristic_size: Area, toroidal: Length) -> FormFactor {
    // T1 >= w/V = sqrt(mu chi)/V, and T2 is at most its value on a square, so T1 and T2 cross before these bounds do.
    // The bracket ends at twice that form factor, so that rounding does not matter.
    let square = InclinedRectangle::of_any_size(1.0, characteristic_size);
    let longest = job.machine().feed_rate.mm_s() * ball_end_time(job, square);
    let high = (2.0 * longest * longest / characteristic_size.mm2()).ln();
    let Ok(logarithm) = bracketed_root(0.0, high, |logarithm: f64| {
        Ok::<_, Infallible>(excess_at_form_factor(job, characteristic_size, toroidal, logarithm.exp()))
    });
    FormFactor::computed(logarithm.exp())
}

/// The critical form factor in closed form. With k = sod2/sod1 and t0 the time that a pass loses to stops, T1 = T2
/// reads a mu + b sqrt(mu) + c = 0, a = k (t0 + t(sod1)), b = -(1 - k) sqrt(chi)/V, c = -(t0 + t(sod2)); c/a < 0, so
/// one root is positive. `None` if a pass would not reach the feed rate, or mu would be under 1.
fn critical_form_factor_in_closed_form(job: &CutterComparison, characteristic_size: Area, toroidal: Length) -> Option<FormFactor> {
    let (machine, ball_end) = (job.machine(), job.ball_end_step_over());
    let ratio = ball_end.mm() / toroidal.mm();
    let stops = machine.time_lost_to_stops();
    let a = ratio * (stops + travel_time(toroidal, machine)).seconds();
    let b = (ratio - 1.0) * characteristic_size.mm2().sqrt() / machine.feed_rate.mm_s();
    let c = -(stops + travel_time(ball_end, machine)).seconds();
    let root_of_discriminant = (b * b - 4.0 * a * c).sqrt();
    // The root has two equivalent forms; this is the one whose terms do not cancel.
    let root = if b < 0.0 { (root_of_discriminant - b) / (2.0 * a) } else { -2.0 * c / (b + root_of_discriminant) };
    let mu = root * root;
    if mu < 1.0 {
        return None;
    }
    let height = InclinedRectangle::of_any_size(mu, characteristic_size).height();
    TravelCase::of(height, machine).reaches_feed_rate().then(|| FormFactor::computed(mu))
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // exact by construction where compared for equality
mod tests {
    use super::*;
    use crate::milling::Cutter;
    use crate::motion::{MachineLimits, Preset};
    use crate::quantity::{Acceleration, Jerk, Speed};
    use approx::{assert_abs_diff_eq, assert_relative_eq};
    use proptest::prelude::*;

    fn mm(value: f64) -> Length {
        Length::from_mm(value).unwrap()
    }

    /// A toroidal cutter 2R x r with a ball-end cutter, on a machine in mm/min, m/s^2 and m/s^3.
    fn job((diameter, corner): (f64, f64), ball: f64, scallop: f64, (v, a, j): (f64, f64, f64)) -> CutterComparison {
        let machine = MachineLimits {
            feed_rate: Speed::from_mm_min(v).unwrap(),
            acceleration: Acceleration::from_m_s2(a).unwrap(),
            jerk: Jerk::from_m_s3(j).unwrap(),
        };
        let toroidal = Cutter::toroidal(mm(diameter), mm(corner)).unwrap();
        CutterComparison::new(toroidal, Cutter::ball_end(mm(ball)), mm(scallop), machine, Model::Analytic).unwrap()
    }

    /// The paper's cutters and machine.
    fn published() -> CutterComparison {
        job((10.0, 2.0), 10.0, 0.01, (5000.0, 6.0, 40.0))
    }

    fn rectangle(mu: f64, chi: f64) -> InclinedRectangle {
        InclinedRectangle::from_form(FormFactor::new(mu).unwrap(), Area::from_mm2(chi).unwrap()).unwrap()
    }

    fn degrees(slope: CriticalSlope) -> f64 {
        slope.angle().degrees()
    }

    #[test]
    fn equal_cutters_on_a_square_have_a_critical_slope_of_90_degrees() {
        for (ball, machine) in [(10.0, (5000.0, 6.0, 40.0)), (10.0, (1e5, 0.1, 100.0))] {
            let job = job((10.0, 2.0), ball, 0.01, machine);
            assert_eq!(critical_slope(&job, rectangle(1.0, 2000.0)).unwrap(), CriticalSlope::At(Angle::RIGHT));
            let on_wall = critical_form_factor(&job, Area::from_mm2(2000.0).unwrap(), Angle::RIGHT).unwrap();
            assert_eq!(on_wall, CriticalFormFactor::At(FormFactor::SQUARE));
        }
    }

    #[test]
    fn a_much_smaller_ball_never_wins_and_a_much_larger_one_wins_early() {
        let small = job((20.0, 4.0), 1.0, 0.01, (5000.0, 6.0, 40.0));
        let answer = critical_slope(&small, rectangle(2.0, 1568.0)).unwrap();
        assert_eq!((answer, degrees(answer)), (CriticalSlope::ToroidalAlways, 90.0));
        assert!(answer.favours_toroidal(Angle::RIGHT));
        let large = job((2.0, 0.5), 200.0, 0.01, (5000.0, 6.0, 40.0));
        assert!(degrees(critical_slope(&large, rectangle(2.0, 1568.0)).unwrap()) < 0.5);
        let steep = Angle::from_degrees(60.0).unwrap();
        let form_factor = critical_form_factor(&large, Area::from_mm2(1568.0).unwrap(), steep).unwrap();
        assert_eq!((form_factor, form_factor.form_factor()), (CriticalFormFactor::BallEndAlways, FormFactor::SQUARE));
    }

    #[test]
    fn a_ball_whose_step_over_spans_the_strip_wins_on_every_slope() {
        // One pass and a fraction along 2000 mm, against at least 2000 mm of steps across it.
        let job = job((10.0, 2.0), 10.0, 0.01, (5000.0, 6.0, 40.0));
        let strip = rectangle(2000.0 / 0.2, 2000.0 * 0.2);
        assert_eq!(critical_slope(&job, strip).unwrap(), CriticalSlope::BallEndAlways);
        assert_eq!(degrees(CriticalSlope::BallEndAlways), 0.0);
    }

    #[test]
    fn a_floor_has_the_critical_form_factor_of_the_bound() {
        let size = Area::from_mm2(1568.0).unwrap();
        let [on_floor, nearly] =
            [0.0, 0.3].map(|slope| critical_form_factor(&published(), size, Angle::from_degrees(slope).unwrap()).unwrap());
        assert_eq!(on_floor, nearly);
        // A ball of 3.5 m takes longer strides than a torus of 10 mm on its floor, 16.7 against 6.4 mm: it wins on every slope.
        let huge = job((10.0, 2.0), 7000.0, 0.01, (5000.0, 6.0, 40.0));
        assert_eq!(critical_slope(&huge, rectangle(4.0, 10_000.0)).unwrap(), CriticalSlope::BallEndAlways);
    }

    #[test]
    fn the_published_rectangles_have_the_closed_form() {
        for (mu, chi) in [(2.0, 1568.0), (2.07, 3315.47), (1.19, 3137.0)] {
            assert!(critical_slope_in_closed_form(&published(), rectangle(mu, chi)).is_some());
        }
    }

    #[test]
    fn the_closed_forms_are_not_used_where_their_assumptions_fail() {
        // Passes of 5 mm do not reach the feed rate, which takes 7.6 mm.
        let small = rectangle(2.0, 50.0);
        assert_eq!(critical_slope_in_closed_form(&published(), small), None);
        assert!(matches!(critical_slope(&published(), small).unwrap(), CriticalSlope::At(_)));
        // Steps of 0.6 mm and more reach the acceleration, after 2 A^3/J^2 = 0.002 mm.
        let jerky = job((10.0, 2.0), 10.0, 0.01, (5000.0, 1.0, 1000.0));
        assert_eq!(critical_slope_in_closed_form(&jerky, rectangle(2.0, 1568.0)), None);
        assert!(matches!(critical_slope(&jerky, rectangle(2.0, 1568.0)).unwrap(), CriticalSlope::At(_)));
    }

    fn jobs() -> impl Strategy<Value = CutterComparison> {
        let machine = prop::sample::select(vec!["hobby_router", "vmc", "five_axis_vmc", "five_axis_gantry", "high_speed_mould"]);
        let ratio = 0.05..0.95_f64;
        (2.0..30.0_f64, ratio, 0.7..1.4_f64, 0.001..0.05_f64, machine).prop_map(|(diameter, ratio, ball, scallop, machine)| {
            let limits = Preset::named(machine).unwrap().limits;
            let toroidal = Cutter::toroidal(mm(diameter), mm(ratio * diameter / 2.0)).unwrap();
            let scallop = mm(scallop.min(ratio * diameter / 4.0));
            CutterComparison::new(toroidal, Cutter::ball_end(mm(diameter * ball)), scallop, limits, Model::Analytic).unwrap()
        })
    }

    /// Form factors and sizes from a few mm^2 to a square metre.
    fn forms() -> impl Strategy<Value = (f64, f64)> {
        (1.0..20.0_f64, (1.0..6.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent)))
    }

    proptest! {
        #[test]
        fn both_cutters_take_the_same_time_at_the_critical_slope(job in jobs(), (mu, chi) in forms()) {
            if let CriticalSlope::At(slope) = critical_slope(&job, rectangle(mu, chi)).unwrap() {
                // T1 changes at most in proportion to the slope. Near 90 deg the slope comes from a sine and is
                // accurate only to the root of its rounding, but sin(s) is accurate, and T1 depends only on it.
                assert_abs_diff_eq!(excess_at_slope(&job, rectangle(mu, chi), slope).unwrap(), 0.0, epsilon = 1e-12);
            }
        }

        #[test]
        fn closed_form_and_bracketing_agree_on_the_slope(job in jobs(), (mu, chi) in forms()) {
            let rectangle = rectangle(mu, chi);
            let has_root = excess_at_slope(&job, rectangle, Angle::RIGHT).unwrap() > TIE;
            if let Some(closed) = critical_slope_in_closed_form(&job, rectangle).filter(|_| has_root) {
                let bracketed = critical_slope_by_bracketing(&job, rectangle).unwrap().angle();
                // The slopes are compared by their sines, on which the times depend: near 90 deg an angle is accurate
                // only to the square root of a rounding error.
                assert_relative_eq!(closed.sin(), bracketed.sin(), max_relative = 1e-11);
            }
        }

        #[test]
        fn closed_form_and_bracketing_agree_on_the_form_factor(job in jobs(), (_, chi) in forms(), slope in 0.1..90.0_f64) {
            let chi = Area::from_mm2(chi).unwrap();
            let toroidal = job.toroidal_step_over(Angle::from_degrees(slope).unwrap()).unwrap();
            let has_root = excess_at_form_factor(&job, chi, toroidal, 1.0) < -TIE;
            if let Some(closed) = critical_form_factor_in_closed_form(&job, chi, toroidal).filter(|_| has_root) {
                assert_relative_eq!(closed.ratio(), critical_form_factor_by_bracketing(&job, chi, toroidal).ratio(), max_relative = 1e-11);
            }
        }

        #[test]
        fn critical_slope_and_critical_form_factor_are_inverse(job in jobs(), (mu, chi) in forms()) {
            if let CriticalSlope::At(slope) = critical_slope(&job, rectangle(mu, chi)).unwrap() {
                let back = critical_form_factor(&job, Area::from_mm2(chi).unwrap(), slope).unwrap();
                // The derivative of ln(T1/T2) by ln(mu) is at least some hundredths, which enlarges its rounding of
                // 1e-14.
                assert_relative_eq!(back.form_factor().ratio(), mu, max_relative = 1e-9);
            }
        }

        #[test]
        fn the_toroidal_cutter_is_faster_below_the_critical_slope_only(job in jobs(), (mu, chi) in forms(), slope in 0.001..90.0_f64) {
            let (rectangle, slope) = (rectangle(mu, chi), Angle::from_degrees(slope).unwrap());
            let excess = excess_at_slope(&job, rectangle, slope).unwrap();
            prop_assume!(excess.abs() > 1e-9);
            prop_assert_eq!(critical_slope(&job, rectangle).unwrap().favours_toroidal(slope), excess < 0.0);
        }

        #[test]
        fn the_critical_slope_falls_with_the_form_factor_and_the_feed_rate_and_rises_with_the_size(
            mu in 1.1..8.0_f64, chi in 1e3..1e5_f64, factor in 1.05..2.0_f64,
        ) {
            // The paper states these laws for its machine and cutters. 1000 mm^2 with mu = 8 has passes of 11 mm; at
            // double the feed rate, the closed form needs 21 mm. So both solutions are tested.
            let of = |job: &CutterComparison, mu, chi| degrees(critical_slope(job, rectangle(mu, chi)).unwrap());
            let here = of(&published(), mu, chi);
            prop_assert!(of(&published(), mu * factor, chi) < here);
            prop_assert!(of(&published(), mu, chi * factor) > here);
            prop_assert!(of(&job((10.0, 2.0), 10.0, 0.01, (5000.0 * factor, 6.0, 40.0)), mu, chi) < here);
        }

        #[test]
        fn the_critical_form_factor_falls_with_the_slope(job in jobs(), chi in 1e2..1e6_f64, slope in 0.1..80.0_f64, more in 0.1..10.0_f64) {
            let at = |slope| critical_form_factor(&job, Area::from_mm2(chi).unwrap(), Angle::from_degrees(slope).unwrap()).unwrap();
            let (gentle, steep) = (at(slope), at(slope + more));
            let step_over = |slope| job.toroidal_step_over(Angle::from_degrees(slope).unwrap()).unwrap();
            // Nearly level slopes have the floor's step-over, and with it one form factor.
            if gentle == CriticalFormFactor::BallEndAlways || step_over(slope) == step_over(slope + more) {
                prop_assert_eq!(steep, gentle);
            } else {
                prop_assert!(steep.form_factor() < gentle.form_factor());
            }
        }
    }
}
