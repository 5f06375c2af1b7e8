//! Evidence for the confidence in method `rectangle`, from the facets of the surface and from the simulation on them.

use super::Weakness;
use crate::planning::{Confidence, Reason};
use crate::quantity::{Angle, Area, Time};
use crate::surface::Shape;

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

impl Confidence<Weakness> {
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
