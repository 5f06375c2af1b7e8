//! Evidence for the confidence in method `rectangle`, from the facets of the surface and from the simulation on them.

use super::Weakness;
use crate::planning::rectangle::{CutterChoice, Plan};
use crate::planning::{Confidence, Reason};
use crate::quantity::{Angle, Area, Time};
use crate::surface::Shape;

/// The figures of the surface and of the simulation on it, if there are facets.
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

impl Confidence<Weakness> {
    /// Adds the weaknesses found from the surface and from the simulation on it.
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
