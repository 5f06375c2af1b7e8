//! What makes an answer doubtful although it stands: assumptions of the models that creak.

use super::{CutterKind, EffectiveRadius, Pass};
use crate::quantity::Length;
use std::fmt;

/// An assumption that is strained, with the figures that show it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Concern {
    /// Runout is not small against the feed per tooth: some teeth may leave no mark, and then the feed's share is no bound.
    RunoutNotSmall {
        /// sqrt(rr^2 + ar^2) over f_z.
        ratio: f64,
    },
    /// The step-over is wide against the groove, whose circle fits the cutter near the contact only.
    StepOverWide {
        /// Step-over over the effective diameter.
        ratio: f64,
    },
    /// The feed per tooth is long against the mark, whose circle fits the cutter near the contact only.
    FeedLong {
        /// Feed per tooth over the transverse effective diameter.
        ratio: f64,
    },
    /// The groove's circle is wider than any cut that the cutter can make.
    RadiusBeyondCutter {
        /// The effective radius; `None` where it is infinite.
        effective_radius: Option<Length>,
        /// The cutter's diameter.
        diameter: Length,
    },
    /// A flat-end cutter's corner leaves sharp marks, and wears.
    SharpMarks,
}

impl fmt::Display for Concern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RunoutNotSmall { ratio } => {
                write!(
                    f,
                    "the runout is {:.1} % of the feed per tooth, which is not small: some teeth may leave no mark, and the feed's share is then no bound",
                    ratio * 100.0
                )
            }
            Self::StepOverWide { ratio } => write!(
                f,
                "the step-over is {:.1} % of the effective diameter; the circle that stands for the cutter fits it near the contact only",
                ratio * 100.0
            ),
            Self::FeedLong { ratio } => write!(
                f,
                "the feed per tooth is {:.1} % of the transverse effective diameter; the circle that stands for the cutter fits it near the contact only",
                ratio * 100.0
            ),
            Self::RadiusBeyondCutter { effective_radius: Some(radius), diameter } => write!(
                f,
                "the effective radius, {:.3} mm, exceeds the cutter's diameter, {:.3} mm: the groove is flatter than the cutter is wide, and the scallop can be far higher than computed",
                radius.mm(),
                diameter.mm()
            ),
            Self::RadiusBeyondCutter { effective_radius: None, .. } => f.write_str("the effective radius is infinite"),
            Self::SharpMarks => {
                f.write_str("a flat-end cutter leaves sharp marks; a small corner radius leaves lower ones and lasts longer")
            }
        }
    }
}

/// The share from which runout is no longer small, and from which a chord is no longer short against its circle. At a fifth of the
/// diameter, the height of the circle and that of its parabola differ by 1 %, which is what neglecting the next order costs.
const A_FIFTH: f64 = 0.2;

/// The concerns that hold for any model.
pub fn concerns(pass: &Pass, feed_per_tooth: Option<Length>) -> impl Iterator<Item = Concern> + use<> {
    let runout = feed_per_tooth.and_then(|feed| {
        let ratio = pass.runout.magnitude().mm() / feed.mm();
        (ratio > A_FIFTH).then_some(Concern::RunoutNotSmall { ratio })
    });
    let sharp = (pass.cutter.kind() == CutterKind::FlatEnd).then_some(Concern::SharpMarks);
    [runout, sharp].into_iter().flatten()
}

/// The concerns that hold for a model with a circle in place of the cutter.
pub fn circle_concerns(pass: &Pass, step_over: Length, feed_per_tooth: Option<Length>) -> impl Iterator<Item = Concern> + use<> {
    let across = EffectiveRadius::across_feed(pass.cutter, pass.contact).finite();
    let along = EffectiveRadius::along_feed(pass.cutter, pass.contact).finite();
    let diameter = pass.cutter.outer_radius() + pass.cutter.outer_radius();
    let share =
        |chord: Length, radius: Option<Length>| radius.map(|radius| chord.mm() / (2.0 * radius.mm())).filter(|ratio| *ratio > A_FIFTH);
    let wide = share(step_over, across).map(|ratio| Concern::StepOverWide { ratio });
    let long = feed_per_tooth.and_then(|feed| share(feed, along)).map(|ratio| Concern::FeedLong { ratio });
    let beyond =
        across.is_none_or(|radius| radius > diameter).then_some(Concern::RadiusBeyondCutter { effective_radius: across, diameter });
    [wide, long, beyond].into_iter().flatten()
}
