//! The recommendation of a cutter for a surface by method `rectangle`, its confidence, and the weaknesses of the method on the
//! surface that lower it.
//!
//! Herraz et al. 2020 name these weaknesses, mostly in section 7, but give few figures. The source of each threshold is
//! stated below.

use super::{CriticalSlope, CutterComparison, InclinedRectangle, Plan, plan};
use crate::milling::NoAnswer;
use crate::motion::TravelCase;
use crate::planning::{Confidence, Level, Reason};
use crate::quantity::{Angle, Area, OutOfRange, Time};
use crate::surface::Shape;
use std::fmt;

/// A plan for a surface, with its confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct Recommendation {
    /// Both candidates, with directions.
    pub plan: Plan,
    /// The confidence in the recommendation.
    pub confidence: Confidence<Weakness>,
}

/// The reason why there is no plan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PlanError {
    /// A side of the surface's equivalent rectangle is outside these bounds, in mm.
    Size(OutOfRange),
    /// The toroidal cutter has no step-over; on a level surface the analytic model has none.
    Toroidal(NoAnswer),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size(bounds) => write!(f, "both sides of the surface's equivalent rectangle {bounds} mm"),
            Self::Toroidal(no_answer) => write!(f, "the toroidal cutter up the slope: {no_answer}"),
        }
    }
}

impl std::error::Error for PlanError {}

/// The recommendation for a surface, by the rectangle that has its form factor and characteristic size, at its slope
/// [Herraz et al. 2020, section 6.1].
///
/// A surface without a steepest direction counts as level: its slope is only a rounding error, with which the groove
/// would have a radius of kilometres.
///
/// # Errors
/// [`PlanError`]
pub fn recommend(job: &CutterComparison, shape: &Shape) -> Result<Recommendation, PlanError> {
    let rectangle = InclinedRectangle::from_form(shape.form_factor, shape.characteristic_size).map_err(PlanError::Size)?;
    let slope = if shape.steepest_direction.is_some() { shape.slope } else { Angle::ZERO };
    let mut plan = plan(job, rectangle, slope).map_err(PlanError::Toroidal)?;
    plan.toroidal.direction = shape.steepest_direction;
    plan.ball_end.direction = shape.principal_direction;
    let confidence = Confidence::in_plan(&plan, job, rectangle, shape);
    Ok(Recommendation { plan, confidence })
}

/// A weakness of the method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Weakness {
    /// Steepest and principal direction are not perpendicular. Figure: the angle between them, in deg. The rectangle
    /// has its long side level, so the times are less accurate the further the angle is from 90 deg [Herraz et al.
    /// 2020, section 7.1].
    ///
    /// Passes that cross the rectangle at an angle d from its short side are 1/cos(d) times as long. For d = 15 deg
    /// that is 1.035, less than the 5 % error of the paper's own times (section 4.2.2). For d = 35 deg it is 1.22,
    /// outside the range in which a torus is better than a ball at any size (section 2.1).
    DirectionsNotPerpendicular,
    /// The principal direction is weakly defined. Figure: the form factor. The eigenvalues differ by mu^2 - 1, which is
    /// 0.21 at 1.1, so that an unevenness of the samples of 2 % turns the direction by 0.02/0.21 = 5 deg. The choice of
    /// the cutter is hardly affected, because at such form factors the toroidal cutter is faster on all except steep
    /// slopes.
    FormFactorNearOne,
    /// The principal direction is vertical or does not exist. Figure: the form factor.
    NoPrincipalDirection,
    /// The surface is almost level, so that unevenness determines its steepest direction, and the toroidal cutter's
    /// groove is not a circle. Figure: the slope, in deg. A circle of the effective radius leaves 10 % less than a
    /// torus of R = 5 mm, r = 2 mm at 1 deg, and 40 % less at 0.2 deg. Under 0.34 deg the published bound of the
    /// step-over holds instead of the circle, with which the torus leaves two to three times the height.
    SlopeNearZero,
    /// The surface is not flat. Figure: sqrt(l3/l1). The method is more accurate if normals vary slowly (section 7.3),
    /// which the third eigenvalue measures (section 7.4). The paper gives no threshold; its test surfaces have 0.08 and
    /// 0.10. A dome whose normals are inclined by up to 30 deg has 0.15, one of 45 deg 0.23.
    NotFlat,
    /// The slope is near the critical slope. Figure: the difference in deg. The paper's test surface 2 has a critical
    /// slope of 62.6 deg by the method and of 54.7 deg by simulation, a difference of 8 deg (section 6.2.2).
    SlopeNearCritical,
    /// Both candidates take nearly the same time. Figure: the difference as a share of the longer time. The error of
    /// the paper's times is up to 5 % on average (section 4.2.2), so a smaller difference is not significant.
    TimesNearlyEqual,
    /// The mean slope and the slope of the best-fit plane are on opposite sides of the critical slope. Figure: the mean
    /// slope in deg, with the critical slope as threshold. The paper uses either as the surface's slope and has no case
    /// in which they disagree (section 7.3).
    MeanSlopeDisagrees,
    /// A pass up the slope is too short to reach the feed rate. The paper assumes that passes reach it, and calls the
    /// assumption acceptable except for very small surfaces (section 7.2). Figure: the length of the pass in mm. The
    /// times are still computed with the limits of the drives.
    ShortPasses,
    /// A step from pass to pass is so long that not only the jerk limits it, as the paper assumes (section 7.2).
    /// Figure: the larger step-over in mm. The times are still computed with the limits of the drives.
    LongSteps,
    /// The surface is smaller than 100 mm^2, from which on the paper shows that the critical slope is unique (section
    /// 7.2). Figure: the characteristic size in mm^2.
    SmallSurface,
    /// There are so few passes that it matters that their number is not rounded, which is the paper's largest error,
    /// about one pass (section 4.2.2). Figure: the smaller number of passes. One pass in 20 is 5 %, one in 5 a fifth.
    FewPasses,
    /// The mean slope is far from the slope of the best-fit plane. Figure: the difference in deg. The step-over of a
    /// torus depends on the slope: the effective radius of R = 5 mm, r = 2 mm is 12.3 mm at 17 deg and 10.0 mm at 22
    /// deg, which changes step-over and time by 11 %.
    MeanSlopeFarFromPlane,
    /// The area is far from the characteristic size of the rectangle. Figure: their difference as a share of the
    /// characteristic size. The time is proportional to the area.
    AreaFarFromSize,
    /// The surface has several pieces, which no rectangle can represent. Figure: their number.
    SeveralPieces,
    /// The time simulated on the surface differs from that on the rectangle. Figure: the difference as a share of the
    /// simulated time, the larger of both candidates.
    SimulationDisagrees,
    /// In the simulation on the surface the other cutter is faster. Figure: the additional time of the recommended one,
    /// as a share of the faster one's time.
    SimulationPrefersOther,
}

impl fmt::Display for Reason<Weakness> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, threshold, .. } = self;
        match self.weakness {
            Weakness::DirectionsNotPerpendicular => write!(
                f,
                "steepest and principal direction are {figure:.1} deg apart; the method assumes that they are perpendicular, and is accurate from {threshold} deg on"
            ),
            Weakness::FormFactorNearOne => {
                write!(f, "the form factor, {figure:.4}, is under {threshold}, so the principal direction is uncertain")
            }
            Weakness::NoPrincipalDirection => {
                write!(
                    f,
                    "the surface has no principal direction seen from above (form factor {figure:.4}), so the ball-end cutter's direction is free"
                )
            }
            Weakness::SlopeNearZero => {
                write!(f, "the slope, {figure:.4} deg, is under {threshold} deg, so the steepest direction is uncertain")
            }
            Weakness::NotFlat => write!(
                f,
                "the flatness figure, {figure:.3}, exceeds {threshold}: the surface's normals vary much, and a plane is a poor approximation of it"
            ),
            Weakness::SlopeNearCritical => {
                write!(
                    f,
                    "the slope is {figure:.2} deg from the critical slope, less than the error of the critical slope, {threshold} deg"
                )
            }
            Weakness::TimesNearlyEqual => write!(
                f,
                "the times of both cutters differ by {:.1} %, less than the {:.0} % by which they may be wrong",
                100.0 * figure,
                100.0 * threshold
            ),
            Weakness::MeanSlopeDisagrees => write!(
                f,
                "the mean slope, {figure:.2} deg, and the slope of the best-fit plane are on opposite sides of the critical slope, {threshold:.2} deg"
            ),
            Weakness::ShortPasses => {
                write!(
                    f,
                    "a pass up the slope is {figure:.3} mm long and does not reach the feed rate, for which it must be {threshold:.3} mm long"
                )
            }
            Weakness::LongSteps => write!(
                f,
                "the larger step-over, {figure:.3} mm, is long enough to reach the feed rate or the acceleration, as steps from {threshold:.3} mm on are"
            ),
            Weakness::SmallSurface => write!(f, "the characteristic size, {figure:.3} mm2, is under {threshold} mm2"),
            Weakness::FewPasses => {
                write!(f, "there are {figure:.2} passes, fewer than {threshold}, so rounding them to whole ones changes the times")
            }
            Weakness::MeanSlopeFarFromPlane => write!(
                f,
                "the mean slope differs by {figure:.2} deg from that of the best-fit plane, more than {threshold} deg; step-overs depend on the slope"
            ),
            Weakness::AreaFarFromSize => write!(
                f,
                "the area differs by {:.1} % from the characteristic size of the rectangle, more than {:.0} %",
                100.0 * figure,
                100.0 * threshold
            ),
            Weakness::SeveralPieces => write!(f, "the surface has {figure:.0} pieces, which one rectangle represents together"),
            Weakness::SimulationDisagrees => write!(
                f,
                "the time differs by {:.1} % from that of passes simulated on the surface, more than {:.0} %",
                100.0 * figure,
                100.0 * threshold
            ),
            Weakness::SimulationPrefersOther => write!(
                f,
                "passes simulated on the surface are faster with another cutter; the recommended one takes {:.1} % longer",
                100.0 * figure
            ),
        }
    }
}

impl Confidence<Weakness> {
    /// The confidence in a plan for a surface of this shape.
    pub(super) fn in_plan(plan: &Plan, job: &CutterComparison, rectangle: InclinedRectangle, shape: &Shape) -> Self {
        let found = [of_directions(shape), of_form(shape), of_decision(plan, shape), of_assumptions(plan, job, rectangle)];
        Self::from_reasons(found.into_iter().flatten().collect())
    }

    /// The confidence in the equivalent rectangle of a surface of this shape, if the cutters are not exactly one
    /// toroidal and one ball-end cutter. `times` are those of the candidates on the rectangle, fastest first.
    #[must_use]
    pub fn of_shape(shape: &Shape, times: &[Time]) -> Self {
        let mut reasons = [of_directions(shape), of_form(shape)].concat();
        if let [first, second, ..] = times {
            reasons.extend(Reason::under(Weakness::TimesNearlyEqual, 1.0 - first.seconds() / second.seconds(), 0.05, 0.05));
        }
        Self::from_reasons(reasons)
    }

    /// Adds the deviation of the times on the rectangle from those of passes simulated on the surface. `times` has
    /// both, in this order, for each candidate, the recommended one first.
    #[must_use]
    pub fn with_simulation(self, times: &[(Time, Time)]) -> Self {
        let mut reasons = self.into_reasons();
        let apart = times.iter().map(|(rectangle, simulated)| (rectangle.seconds() / simulated.seconds() - 1.0).abs());
        reasons.extend(Reason::over(Weakness::SimulationDisagrees, apart.fold(0.0, f64::max), 0.1, 0.3));
        if let Some((_, recommended)) = times.first() {
            let fastest = times.iter().map(|(_, simulated)| simulated.seconds()).fold(f64::INFINITY, f64::min);
            // The simulation itself has an error of some 2 %.
            reasons.extend(Reason::over(Weakness::SimulationPrefersOther, recommended.seconds() / fastest - 1.0, 0.02, 0.05));
        }
        Self::from_reasons(reasons)
    }

    /// Adds the weaknesses found from the surface itself.
    #[must_use]
    pub fn with_surface(self, shape: &Shape, evidence: &Evidence) -> Self {
        let mut reasons = self.into_reasons();
        let difference = (evidence.mean_slope.degrees() - shape.slope.degrees()).abs();
        reasons.extend(Reason::over(Weakness::MeanSlopeFarFromPlane, difference, 5.0, 15.0));
        let size = shape.characteristic_size.mm2();
        reasons.extend(Reason::over(Weakness::AreaFarFromSize, (evidence.area.mm2() - size).abs() / size, 0.15, 0.4));
        #[expect(clippy::cast_precision_loss, reason = "a count of pieces")]
        let pieces = evidence.pieces as f64;
        reasons.extend(Reason::over(Weakness::SeveralPieces, pieces, 1.0, 1.0));
        Self::from_reasons(reasons)
    }
}

/// A threshold that no figure crosses, for a weakness with only one level.
const NEVER_LOW: f64 = f64::NEG_INFINITY;

fn of_directions(shape: &Shape) -> Vec<Reason<Weakness>> {
    let mut reasons = Vec::new();
    let (mu, slope) = (shape.form_factor.ratio(), shape.slope.degrees());
    if shape.principal_direction.is_none() {
        reasons.push(Reason { weakness: Weakness::NoPrincipalDirection, level: Level::Low, figure: mu, threshold: 1.0 });
    } else {
        reasons.extend(Reason::under(Weakness::FormFactorNearOne, mu, 1.1, NEVER_LOW));
    }
    let no_slope = if shape.steepest_direction.is_none() { 1.0 } else { 0.2 };
    reasons.extend(Reason::under(Weakness::SlopeNearZero, slope, 1.0, no_slope));
    if let Some(gap) = shape.direction_gap {
        reasons.extend(Reason::under(Weakness::DirectionsNotPerpendicular, gap.degrees(), 75.0, 55.0));
    }
    reasons
}

fn of_form(shape: &Shape) -> Vec<Reason<Weakness>> {
    Reason::over(Weakness::NotFlat, shape.flatness, 0.15, 0.23).into_iter().collect()
}

fn of_decision(plan: &Plan, shape: &Shape) -> Vec<Reason<Weakness>> {
    let mut reasons = Vec::new();
    let (one, other) = (plan.toroidal.zigzag.time.seconds(), plan.ball_end.zigzag.time.seconds());
    reasons.extend(Reason::under(Weakness::TimesNearlyEqual, (one - other).abs() / one.max(other), 0.05, 0.05));
    if let CriticalSlope::At(critical) = plan.critical_slope {
        let (slope, critical_degrees) = (shape.slope.degrees(), critical.degrees());
        reasons.extend(Reason::under(Weakness::SlopeNearCritical, (slope - critical_degrees).abs(), 8.0, NEVER_LOW));
        let favours = |slope| plan.critical_slope.favours_toroidal(slope);
        if let Some(mean) = shape.mean_slope.filter(|&mean| favours(mean) != favours(shape.slope)) {
            let (figure, threshold) = (mean.degrees(), critical_degrees);
            reasons.push(Reason { weakness: Weakness::MeanSlopeDisagrees, level: Level::Moderate, figure, threshold });
        }
    }
    reasons
}

fn of_assumptions(plan: &Plan, job: &CutterComparison, rectangle: InclinedRectangle) -> Vec<Reason<Weakness>> {
    let (machine, toroidal, ball_end) = (job.machine(), plan.toroidal.zigzag, plan.ball_end.zigzag);
    let mut reasons = Vec::new();
    let reach = machine.shortest_at_feed_rate().mm();
    if !TravelCase::of(rectangle.height(), machine).reaches_feed_rate() {
        let figure = rectangle.height().mm();
        reasons.push(Reason { weakness: Weakness::ShortPasses, level: Level::Moderate, figure, threshold: reach });
    }
    let larger = if toroidal.step_over > ball_end.step_over { toroidal.step_over } else { ball_end.step_over };
    if TravelCase::of(larger, machine) != TravelCase::JerkOnly {
        let threshold = machine.longest_by_jerk_alone().mm();
        reasons.push(Reason { weakness: Weakness::LongSteps, level: Level::Moderate, figure: larger.mm(), threshold });
    }
    reasons.extend(Reason::under(Weakness::SmallSurface, rectangle.characteristic_size().mm2(), 100.0, NEVER_LOW));
    reasons.extend(Reason::under(Weakness::FewPasses, toroidal.passes.min(ball_end.passes), 20.0, 5.0));
    reasons
}

/// The figures of the surface, if there are facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// The mean slope over the area.
    pub mean_slope: Angle,
    /// The area.
    pub area: Area,
    /// The number of connected pieces.
    pub pieces: usize,
}

#[cfg(test)]
mod tests;
