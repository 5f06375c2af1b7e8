//! How far to trust a recommendation by rectangle: the weaknesses of the method that the surface at hand touches.
//!
//! Herraz et al. 2020 name these weaknesses, mostly in section 7, but give few figures. Each threshold here says where it comes
//! from.

use super::{CriticalSlope, CutterChoice, InclinedRectangle, Job, Plan};
use crate::motion::TravelCase;
use crate::planning::Level;
use crate::quantity::{Angle, Area, Time};
use crate::surface::Shape;
use std::fmt;

/// A weakness of the method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Weakness {
    /// Steepest and principal direction are not perpendicular; figure: the angle between them, in deg. The rectangle has its long side
    /// level, so the further they are from it, the less the times hold [Herraz et al. 2020, section 7.1].
    ///
    /// Passes that cross the rectangle at an angle d from its short side are 1/cos(d) times as long: 1.035 for d = 15 deg, less than
    /// the 5 % by which the paper's own times err (section 4.2.2). At d = 35 deg it is 1.22, and the range is left in which a torus
    /// outdoes a ball whatever its size (section 2.1).
    DirectionsNotPerpendicular,
    /// The surface has no principal direction, or hardly one; figure: the form factor. It comes from eigenvalues that differ by mu^2 - 1,
    /// 0.21 at 1.1, and unevenness of the samples of 2 % turns the direction by 0.02/0.21 = 5 deg. The choice itself is hardly
    /// touched, because there the toroidal cutter is faster on all but steep slopes.
    FormFactorNearOne,
    /// The principal direction is vertical or does not exist; figure: the form factor.
    NoPrincipalDirection,
    /// The surface is almost level, so that its steepest direction is that of its unevenness, and the toroidal cutter's groove is no
    /// circle any more; figure: the slope, in deg. At 1 deg a circle of the effective radius leaves 10 % less than a torus of
    /// R = 5 mm, r = 2 mm, and at 0.2 deg 40 % less.
    SlopeNearZero,
    /// The surface is not flat; figure: sqrt(l3/l1). The method is more accurate where normals vary slowly (section 7.3), and the third
    /// eigenvalue tells it (section 7.4), without a figure in the paper, whose test surfaces have 0.08 and 0.10. A dome whose normals
    /// lean by up to 30 deg has 0.15, one of 45 deg 0.23.
    NotFlat,
    /// The slope is near the critical slope; figure: the difference in deg. The paper's test surface 2 has a critical slope of
    /// 62.6 deg by the method and of 54.7 deg by simulation, 8 deg apart (section 6.2.2).
    SlopeNearCritical,
    /// Both candidates take nearly the same time; figure: the difference against the longer time. The paper's times err by up to 5 % on
    /// average (section 4.2.2), so a smaller difference decides nothing.
    TimesNearlyEqual,
    /// Mean slope and slope of the best plane lie on either side of the critical slope; figure: the mean slope in deg, with the critical
    /// slope as threshold. The paper takes either for the surface's slope and never saw them disagree (section 7.3).
    MeanSlopeDisagrees,
    /// A pass up the slope is too short to reach the feed rate, which the paper assumes and calls acceptable but for very small surfaces
    /// (section 7.2); figure: its length in mm. Times still follow the drives' limits.
    ShortPasses,
    /// A step from pass to pass is so long that it is not limited by the jerk alone, which the paper assumes (section 7.2); figure:
    /// the larger step-over in mm. Times still follow the drives' limits.
    LongSteps,
    /// The surface is smaller than the 100 mm^2 from which the paper shows its critical slope to be unique (section 7.2); figure: the
    /// characteristic size in mm^2.
    SmallSurface,
    /// The passes are so few that their quotient, which is not rounded, counts: the paper's largest error, about one pass
    /// (section 4.2.2); figure: the smaller number of passes. One pass in 20 is its 5 %, one in 5 a fifth.
    FewPasses,
    /// The toroidal cutter's step-over is wider than the cutter, because the model takes its groove for a circle; figure: the
    /// step-over in mm.
    StepOverExceedsCutter,
    /// The mean slope is far from the slope of the best plane; figure: the difference in deg. The step-over of a torus follows the slope: at 17 deg the
    /// effective radius of R = 5 mm, r = 2 mm is 12.3 mm, at 22 deg 10.0 mm, which is 11 % of step-over and time.
    MeanSlopeFarFromPlane,
    /// The area is far from the characteristic size of the rectangle; figure: their difference as a share of the characteristic size. The time
    /// goes with the area.
    AreaFarFromSize,
    /// The surface is in several pieces, which no rectangle stands for; figure: their number.
    SeveralPieces,
    /// The simulation on the surface takes another time than the rectangle; figure: the difference as a share of the simulated time, the larger one of both
    /// candidates.
    SimulationDisagrees,
    /// The simulation on the surface names the other cutter; figure: what the recommended one loses, as a share of the faster one's time.
    SimulationPrefersOther,
}

/// A weakness that the surface at hand touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reason {
    /// Which weakness.
    pub weakness: Weakness,
    /// What the confidence falls to on its account.
    pub level: Level,
    /// The figure that shows it, in the unit that the weakness names.
    pub figure: f64,
    /// The threshold that the figure crossed.
    pub threshold: f64,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { figure, threshold, .. } = self;
        match self.weakness {
            Weakness::DirectionsNotPerpendicular => write!(
                f,
                "steepest and principal direction are {figure:.1} deg apart; the method takes them for perpendicular, and is sound from {threshold} deg on"
            ),
            Weakness::FormFactorNearOne => {
                write!(f, "the form factor, {figure:.4}, is under {threshold}, so the principal direction is uncertain")
            }
            Weakness::NoPrincipalDirection => {
                write!(
                    f,
                    "the surface has no principal direction seen from above (form factor {figure:.4}), so the ball-end cutter's is free"
                )
            }
            Weakness::SlopeNearZero => {
                write!(f, "the slope, {figure:.4} deg, is under {threshold} deg, where a surface has hardly a steepest direction")
            }
            Weakness::NotFlat => write!(
                f,
                "the flatness figure, {figure:.3}, exceeds {threshold}: the surface's normals vary much, and a plane stands for it badly"
            ),
            Weakness::SlopeNearCritical => {
                write!(
                    f,
                    "the slope is {figure:.2} deg from the critical slope, nearer than the {threshold} deg by which that may be wrong"
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
                "the mean slope, {figure:.2} deg, lies on the other side of the critical slope, {threshold:.2} deg, than the slope of the plane that fits best"
            ),
            Weakness::ShortPasses => {
                write!(f, "a pass up the slope is {figure:.3} mm long and does not reach the feed rate, which takes {threshold:.3} mm")
            }
            Weakness::LongSteps => write!(
                f,
                "the larger step-over, {figure:.3} mm, is long enough to reach the feed rate or the acceleration, from {threshold:.3} mm on"
            ),
            Weakness::SmallSurface => write!(f, "the characteristic size, {figure:.3} mm2, is under {threshold} mm2"),
            Weakness::FewPasses => {
                write!(f, "there are {figure:.2} passes, fewer than {threshold}, so rounding them to whole ones changes the times")
            }
            Weakness::StepOverExceedsCutter => write!(
                f,
                "the toroidal cutter's step-over, {figure:.3} mm, exceeds its diameter, {threshold} mm: the model's circle is wider than the cutter"
            ),
            Weakness::MeanSlopeFarFromPlane => write!(
                f,
                "the mean slope differs by {figure:.2} deg from that of the plane that fits best, more than {threshold} deg; step-overs follow the slope"
            ),
            Weakness::AreaFarFromSize => write!(
                f,
                "the area differs by {:.1} % from the characteristic size of the rectangle, more than {:.0} %",
                100.0 * figure,
                100.0 * threshold
            ),
            Weakness::SeveralPieces => write!(f, "the surface is in {figure:.0} pieces; one rectangle stands for all of them"),
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

/// How far to trust a recommendation, and why not further.
#[derive(Debug, Clone, PartialEq)]
pub struct Confidence {
    level: Level,
    reasons: Vec<Reason>,
}

impl Confidence {
    /// The level: the lowest of its reasons', high without any.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// What keeps the level from being high, the gravest first.
    #[must_use]
    pub fn reasons(&self) -> &[Reason] {
        &self.reasons
    }

    /// Judges a plan for a surface of this shape.
    pub(super) fn in_plan(plan: &Plan, job: &Job, rectangle: InclinedRectangle, shape: &Shape) -> Self {
        let found = [of_directions(shape), of_form(shape), of_decision(plan, shape), of_assumptions(plan, job, rectangle)];
        Self::from_reasons(found.into_iter().flatten().collect())
    }

    fn from_reasons(mut reasons: Vec<Reason>) -> Self {
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.level));
        Self { level: reasons.first().map_or(Level::High, |reason| reason.level), reasons }
    }

    /// Judges the rectangle that stands for a surface of this shape, for cutters that are not one toroidal and one ball-end. `times` are those of the
    /// candidates on it, fastest first.
    #[must_use]
    pub fn of_shape(shape: &Shape, times: &[Time]) -> Self {
        let mut reasons = [of_directions(shape), of_form(shape)].concat();
        if let [first, second, ..] = times {
            reasons.extend(under(Weakness::TimesNearlyEqual, 1.0 - first.seconds() / second.seconds(), 0.05, 0.05));
        }
        Self::from_reasons(reasons)
    }

    /// Adds what the surface itself and the simulation on it say about a rectangle in its place.
    #[must_use]
    pub fn with_evidence(self, plan: &Plan, shape: &Shape, evidence: &Evidence) -> Self {
        let with_surface = self.with_surface(shape, evidence);
        let Some([toroidal, ball_end]) = evidence.simulated else { return with_surface };
        let (toroidal, ball_end) = ((plan.toroidal.zigzag.time, toroidal), (plan.ball_end.zigzag.time, ball_end));
        with_surface.with_simulation(&match plan.recommended {
            CutterChoice::Toroidal => [toroidal, ball_end],
            CutterChoice::BallEnd => [ball_end, toroidal],
        })
    }

    /// Adds how far the times on the rectangle are from those of passes simulated on the surface. `times` has both, in this order, for each candidate, the
    /// recommended one first.
    #[must_use]
    pub fn with_simulation(self, times: &[(Time, Time)]) -> Self {
        let mut reasons = self.reasons;
        let apart = times.iter().map(|(rectangle, simulated)| (rectangle.seconds() / simulated.seconds() - 1.0).abs());
        reasons.extend(over(Weakness::SimulationDisagrees, apart.fold(0.0, f64::max), 0.1, 0.3));
        if let Some((_, recommended)) = times.first() {
            let fastest = times.iter().map(|(_, simulated)| simulated.seconds()).fold(f64::INFINITY, f64::min);
            // The simulation errs by some 2 % itself.
            reasons.extend(over(Weakness::SimulationPrefersOther, recommended.seconds() / fastest - 1.0, 0.02, 0.05));
        }
        Self::from_reasons(reasons)
    }

    /// Adds what the surface itself says about a rectangle in its place.
    #[must_use]
    pub fn with_surface(self, shape: &Shape, evidence: &Evidence) -> Self {
        let mut reasons = self.reasons;
        let difference = (evidence.mean_slope.degrees() - shape.slope.degrees()).abs();
        reasons.extend(over(Weakness::MeanSlopeFarFromPlane, difference, 5.0, 15.0));
        let size = shape.characteristic_size.mm2();
        reasons.extend(over(Weakness::AreaFarFromSize, (evidence.area.mm2() - size).abs() / size, 0.15, 0.4));
        #[expect(clippy::cast_precision_loss, reason = "a count of pieces")]
        let pieces = evidence.pieces as f64;
        reasons.extend(over(Weakness::SeveralPieces, pieces, 1.0, 1.0));
        Self::from_reasons(reasons)
    }
}

/// What the surface itself and the simulation on it say, where there are facets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// The mean slope over the area.
    pub mean_slope: Angle,
    /// The area.
    pub area: Area,
    /// The number of connected pieces.
    pub pieces: usize,
    /// The times of zigzag passes simulated on the surface, of the toroidal and the ball-end cutter.
    pub simulated: Option<[Time; 2]>,
}

/// The reason that a figure gives by falling under `moderate`, or further under `low`.
fn under(weakness: Weakness, figure: f64, moderate: f64, low: f64) -> Option<Reason> {
    let (level, threshold) = if figure < low { (Level::Low, low) } else { (Level::Moderate, moderate) };
    (figure < moderate).then_some(Reason { weakness, level, figure, threshold })
}

/// The reason that a figure gives by rising over `moderate`, or further over `low`.
fn over(weakness: Weakness, figure: f64, moderate: f64, low: f64) -> Option<Reason> {
    let (level, threshold) = if figure > low { (Level::Low, low) } else { (Level::Moderate, moderate) };
    (figure > moderate).then_some(Reason { weakness, level, figure, threshold })
}

/// A threshold that no figure crosses: the weakness has one level only.
const NEVER_LOW: f64 = f64::NEG_INFINITY;

fn of_directions(shape: &Shape) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let (mu, slope) = (shape.form_factor.ratio(), shape.slope.degrees());
    if shape.principal_direction.is_none() {
        reasons.push(Reason { weakness: Weakness::NoPrincipalDirection, level: Level::Low, figure: mu, threshold: 1.0 });
    } else {
        reasons.extend(under(Weakness::FormFactorNearOne, mu, 1.1, NEVER_LOW));
    }
    let no_slope = if shape.steepest_direction.is_none() { 1.0 } else { 0.2 };
    reasons.extend(under(Weakness::SlopeNearZero, slope, 1.0, no_slope));
    if let Some(gap) = shape.direction_gap {
        reasons.extend(under(Weakness::DirectionsNotPerpendicular, gap.degrees(), 75.0, 55.0));
    }
    reasons
}

fn of_form(shape: &Shape) -> Vec<Reason> {
    over(Weakness::NotFlat, shape.flatness, 0.15, 0.23).into_iter().collect()
}

fn of_decision(plan: &Plan, shape: &Shape) -> Vec<Reason> {
    let mut reasons = Vec::new();
    let (one, other) = (plan.toroidal.zigzag.time.seconds(), plan.ball_end.zigzag.time.seconds());
    reasons.extend(under(Weakness::TimesNearlyEqual, (one - other).abs() / one.max(other), 0.05, 0.05));
    if let CriticalSlope::At(critical) = plan.critical_slope {
        let (slope, critical_degrees) = (shape.slope.degrees(), critical.degrees());
        reasons.extend(under(Weakness::SlopeNearCritical, (slope - critical_degrees).abs(), 8.0, NEVER_LOW));
        let favours = |slope| plan.critical_slope.favours_toroidal(slope);
        if let Some(mean) = shape.mean_slope.filter(|&mean| favours(mean) != favours(shape.slope)) {
            let (figure, threshold) = (mean.degrees(), critical_degrees);
            reasons.push(Reason { weakness: Weakness::MeanSlopeDisagrees, level: Level::Moderate, figure, threshold });
        }
    }
    reasons
}

fn of_assumptions(plan: &Plan, job: &Job, rectangle: InclinedRectangle) -> Vec<Reason> {
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
    let diameter = 2.0 * job.toroidal().outer_radius().mm();
    reasons.extend(over(Weakness::StepOverExceedsCutter, toroidal.step_over.mm(), diameter, diameter));
    reasons.extend(under(Weakness::SmallSurface, rectangle.characteristic_size().mm2(), 100.0, NEVER_LOW));
    reasons.extend(under(Weakness::FewPasses, toroidal.passes.min(ball_end.passes), 20.0, 5.0));
    reasons
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::{Cutter, Model, NoAnswer};
    use crate::motion::Preset;
    use crate::planning::{PlanError, recommend};
    use crate::quantity::Length;
    use crate::surface::{Facing, Grid, Unit};

    fn mm(value: f64) -> Length {
        Length::from_mm(value).unwrap()
    }

    /// The published cutters with another scallop height.
    fn job(scallop_height: f64, machine: &str) -> Job {
        let toroidal = Cutter::toroidal(mm(10.0), mm(2.0)).unwrap();
        let machine = Preset::named(machine).unwrap().limits;
        Job::new(toroidal, Cutter::ball_end(mm(10.0)), mm(scallop_height), machine, Model::Analytic).unwrap()
    }

    /// A surface of 41 x 41 points over parameters from -1/2 to 1/2.
    fn surface(at: impl Fn(f64, f64) -> [f64; 3]) -> Shape {
        let mut grid = Grid::new(41, 41).unwrap();
        for (i, j) in (0..41_u8).flat_map(|i| (0..41_u8).map(move |j| (i, j))) {
            grid.point(at(f64::from(i) / 40.0 - 0.5, f64::from(j) / 40.0 - 0.5));
        }
        grid.finish().unwrap().shape(Unit::Millimetre, Facing::Up).unwrap()
    }

    /// A rectangle, its first side along X turned by `turn` in its own plane, which is inclined about X by `slope`, both in deg.
    fn plane(width: f64, height: f64, slope: f64, turn: f64) -> Shape {
        let ((sin, cos), (turn_sin, turn_cos)) = (slope.to_radians().sin_cos(), turn.to_radians().sin_cos());
        surface(|u, v| {
            let (x, y) = (width * u, height * v);
            let (x, y) = (turn_cos * x - turn_sin * y, turn_sin * x + turn_cos * y);
            [x, y * cos, y * sin]
        })
    }

    fn weaknesses(job: &Job, shape: &Shape) -> (Level, Vec<(Weakness, Level)>) {
        let confidence = recommend(job, shape).unwrap().confidence;
        (confidence.level(), confidence.reasons().iter().map(|reason| (reason.weakness, reason.level)).collect())
    }

    /// The weaknesses of a surface with the published job.
    fn published(shape: &Shape) -> (Level, Vec<(Weakness, Level)>) {
        weaknesses(&job(0.01, "five_axis_vmc"), shape)
    }

    #[test]
    fn an_inclined_rectangle_away_from_its_critical_slope_is_trusted() {
        assert_eq!(published(&plane(80.0, 40.0, 15.0, 0.0)), (Level::High, vec![]));
        assert_eq!(published(&plane(80.0, 40.0, 70.0, 0.0)), (Level::High, vec![]));
    }

    #[test]
    fn oblique_directions_weaken_the_answer() {
        use Weakness::DirectionsNotPerpendicular as Oblique;
        for (turn, expected) in [(10.0, None), (20.0, Some(Level::Moderate)), (40.0, Some(Level::Low))] {
            let expected_reasons: Vec<_> = expected.map(|level| (Oblique, level)).into_iter().collect();
            let found = published(&plane(80.0, 40.0, 10.0, turn));
            assert_eq!(found, (expected.unwrap_or(Level::High), expected_reasons), "turned by {turn} deg");
        }
    }

    #[test]
    fn squares_have_no_or_hardly_a_principal_direction() {
        let almost = published(&plane(61.0, 58.0, 30.0, 0.0));
        assert_eq!(almost, (Level::Moderate, vec![(Weakness::FormFactorNearOne, Level::Moderate)]));
        let square = published(&plane(60.0, 60.0, 30.0, 0.0));
        assert_eq!(square, (Level::Low, vec![(Weakness::NoPrincipalDirection, Level::Low)]));
    }

    #[test]
    fn domes_are_graded_by_how_far_their_normals_lean() {
        use Weakness::NotFlat;
        // The cap of a ball of 60 mm, its axis leaning by 15 deg.
        let dome = |half_angle: f64| {
            let (sin, cos) = 15.0_f64.to_radians().sin_cos();
            surface(|u, v| {
                let (around, off_axis) = (std::f64::consts::TAU * u, half_angle.to_radians() * (v + 0.5));
                let (x, y) = (60.0 * off_axis.sin() * around.cos(), 60.0 * off_axis.sin() * around.sin());
                let z = 60.0 * off_axis.cos();
                [x, y * cos - z * sin, y * sin + z * cos]
            })
        };
        for (half_angle, expected) in [(28.0, None), (32.0, Some(Level::Moderate)), (43.0, Some(Level::Moderate)), (47.0, Some(Level::Low))]
        {
            let shape = dome(half_angle);
            // On a ball height is spread evenly: with c = cos(half angle), variances (1 - c)^2/12 and (1 - (1 + c + c^2)/3)/2. The
            // polygons of 40 x 40 fall short of the ball by (2 pi/40)^2/8 = 0.3 %.
            let c = f64::cos(half_angle.to_radians());
            let flatness = (1.0 - c) / 12.0_f64.sqrt() / ((1.0 - (1.0 + c + c * c) / 3.0) / 2.0).sqrt();
            approx::assert_relative_eq!(shape.flatness, flatness, max_relative = 0.01);
            let mut found = published(&shape).1;
            found.retain(|(weakness, _)| *weakness == NotFlat);
            assert_eq!(found, expected.map(|level| (NotFlat, level)).into_iter().collect::<Vec<_>>(), "{half_angle} deg");
        }
    }

    #[test]
    fn gentle_slopes_weaken_the_answer_and_a_level_surface_has_none() {
        use Weakness::SlopeNearZero;
        assert!(published(&plane(80.0, 40.0, 0.9, 0.0)).1.contains(&(SlopeNearZero, Level::Moderate)));
        let nearly_level = published(&plane(80.0, 40.0, 0.05, 0.0)).1;
        assert!(nearly_level.contains(&(SlopeNearZero, Level::Low)));
        assert!(nearly_level.contains(&(Weakness::StepOverExceedsCutter, Level::Low)));
        let level = recommend(&job(0.01, "five_axis_vmc"), &plane(80.0, 40.0, 0.0, 0.0));
        assert_eq!(level.unwrap_err(), PlanError::Toroidal(NoAnswer::FlatFloor));
    }

    #[test]
    fn a_slope_near_the_critical_slope_decides_little() {
        // mu = 2, chi = 3200: between the published critical slopes for 1568 and 3315, 34 and 39 deg.
        let (level, reasons) = published(&plane(80.0, 40.0, 38.0, 0.0));
        assert_eq!(level, Level::Low);
        assert_eq!(reasons, [(Weakness::TimesNearlyEqual, Level::Low), (Weakness::SlopeNearCritical, Level::Moderate)]);
    }

    #[test]
    fn small_surfaces_break_the_assumptions() {
        // Passes of 4 mm do not reach the feed rate within 7.6 mm, and make 36 mm^2.
        let found = published(&plane(9.0, 4.0, 70.0, 0.0)).1;
        for weakness in [Weakness::ShortPasses, Weakness::SmallSurface, Weakness::FewPasses] {
            assert!(found.contains(&(weakness, Level::Moderate)), "{weakness:?} in {found:?}");
        }
        let few = published(&plane(9.0, 2.5, 70.0, 0.0)).1;
        assert!(few.contains(&(Weakness::FewPasses, Level::Low)));
    }

    #[test]
    fn steps_that_reach_the_acceleration_are_named() {
        // The hobby router reaches its acceleration after 2 A^3/J^2 = 2 * 0.4^3/8^2 m = 2 mm; a scallop of 0.2 mm allows steps of 3.9 mm
        // (R_eff = 3/sin(15 deg) + 2 = 13.6 mm; sqrt(8 * 0.2 * 13.6) = 4.7 mm).
        let found = weaknesses(&job(0.2, "hobby_router"), &plane(200.0, 100.0, 15.0, 0.0)).1;
        assert!(found.contains(&(Weakness::LongSteps, Level::Moderate)), "{found:?}");
    }

    #[test]
    fn a_mean_slope_on_the_other_side_is_named() {
        // A gutter along X, steep on both sides: its best plane is gentle, its facets are not.
        let gutter = surface(|u, v| [80.0 * u, 40.0 * v, 4.0 * v + 60.0 * v.abs()]);
        assert!(published(&gutter).1.contains(&(Weakness::MeanSlopeDisagrees, Level::Moderate)));
    }

    #[test]
    fn reasons_come_gravest_first_and_speak_for_themselves() {
        let confidence = recommend(&job(0.01, "five_axis_vmc"), &plane(80.0, 40.0, 38.0, 0.0)).unwrap().confidence;
        assert!(confidence.reasons().is_sorted_by_key(|reason| std::cmp::Reverse(reason.level)));
        let said = confidence.reasons()[0].to_string();
        assert!(said.contains("less than the 5 %"), "{said}");
    }

    #[test]
    fn evidence_from_the_surface_weakens_the_answer_where_it_disagrees() {
        let (job, shape) = (job(0.01, "five_axis_vmc"), plane(80.0, 40.0, 15.0, 0.0));
        let recommendation = recommend(&job, &shape).unwrap();
        let plan = recommendation.plan;
        let times = [plan.toroidal.zigzag.time, plan.ball_end.zigzag.time];
        let agreeing = Evidence { mean_slope: shape.slope, area: shape.characteristic_size, pieces: 1, simulated: Some(times) };
        let with = |evidence: Evidence| {
            let confidence = recommendation.confidence.clone().with_evidence(&plan, &shape, &evidence);
            (confidence.level(), confidence.reasons().iter().map(|reason| reason.weakness).collect::<Vec<_>>())
        };
        assert_eq!(with(agreeing), (Level::High, vec![]));
        let steeper = Evidence { mean_slope: Angle::from_degrees(22.0).unwrap(), ..agreeing };
        assert_eq!(with(steeper), (Level::Moderate, vec![Weakness::MeanSlopeFarFromPlane]));
        let larger = Evidence { area: Area::from_mm2(1.5 * shape.characteristic_size.mm2()).unwrap(), ..agreeing };
        assert_eq!(with(larger), (Level::Low, vec![Weakness::AreaFarFromSize]));
        assert_eq!(with(Evidence { pieces: 2, ..agreeing }), (Level::Low, vec![Weakness::SeveralPieces]));
        let slower = times.map(|time| Time::computed(1.2 * time.seconds()));
        assert_eq!(with(Evidence { simulated: Some(slower), ..agreeing }), (Level::Moderate, vec![Weakness::SimulationDisagrees]));
        // The torus is recommended at 15 deg; simulated, it loses 10 %.
        let other = [Time::computed(1.1 * times[1].seconds()), times[1]];
        let (level, weaknesses) = with(Evidence { simulated: Some(other), ..agreeing });
        assert_eq!(level, Level::Low);
        assert!(weaknesses.contains(&Weakness::SimulationPrefersOther));
    }
}
