//! The confidence in a recommendation, with the reasons that lower it; common to both methods.

use crate::quantity::Length;

/// The reliability of a recommendation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// The surface is of the kind for which the method is intended.
    High,
    /// The surface differs from that kind so much that times and critical slope are estimates.
    Moderate,
    /// The recommendation may be wrong; simulate both candidates.
    Low,
}

/// A weakness `W` of a method on a surface, with its figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reason<W> {
    /// The weakness.
    pub weakness: W,
    /// The level to which it lowers the confidence.
    pub level: Level,
    /// The figure on which it is based, in the unit that the weakness states.
    pub figure: f64,
    /// The threshold that the figure crossed.
    pub threshold: f64,
}

impl<W> Reason<W> {
    /// The reason for a figure below the threshold `moderate`, or below the lower threshold `low`.
    pub(super) fn under(weakness: W, figure: f64, moderate: f64, low: f64) -> Option<Self> {
        let (level, threshold) = if figure < low { (Level::Low, low) } else { (Level::Moderate, moderate) };
        (figure < moderate).then_some(Self { weakness, level, figure, threshold })
    }

    /// The reason for a figure above the threshold `moderate`, or above the higher threshold `low`.
    pub(super) fn over(weakness: W, figure: f64, moderate: f64, low: f64) -> Option<Self> {
        let (level, threshold) = if figure > low { (Level::Low, low) } else { (Level::Moderate, moderate) };
        (figure > moderate).then_some(Self { weakness, level, figure, threshold })
    }

    /// The reason for an area in mm^2 that a solid lacks: a ball of 3 mm sinks by 4 % of a scallop height of 0.01 mm into a hole ten
    /// scallop heights wide, and by four scallop heights into one ten times as wide.
    pub(super) fn missing_area(weakness: W, area: f64, scallop_height: Length) -> Option<Self> {
        let [moderate, low] = [10.0, 100.0].map(|heights| (heights * scallop_height.mm()).powi(2));
        Self::over(weakness, area, moderate, low)
    }
}

/// The confidence in a recommendation, with the reasons that lower it.
#[derive(Debug, Clone, PartialEq)]
pub struct Confidence<W> {
    level: Level,
    reasons: Vec<Reason<W>>,
}

impl<W> Confidence<W> {
    pub(super) fn from_reasons(mut reasons: Vec<Reason<W>>) -> Self {
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.level));
        Self { level: reasons.first().map_or(Level::High, |reason| reason.level), reasons }
    }

    pub(super) fn into_reasons(self) -> Vec<Reason<W>> {
        self.reasons
    }

    /// The level: the lowest of the reasons' levels, high if there are none.
    #[must_use]
    pub fn level(&self) -> Level {
        self.level
    }

    /// The reasons why the level is not high, the gravest first.
    #[must_use]
    pub fn reasons(&self) -> &[Reason<W>] {
        &self.reasons
    }
}
