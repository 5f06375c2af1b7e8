//! A pass evaluated by either model, behind one set of functions; and the warnings about assumptions of a model that are near
//! their limits at a pass.

use super::gouging::NEAR_GOUGING;
use super::{Analytic, EffectiveRadius, Envelope, NoAnswer, Pass, ScallopHeight};
use crate::quantity::Length;
use std::f64::consts::FRAC_PI_2;
use std::fmt;

/// The model that evaluates a pass.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// The published closed formulas, which replace the cutter by a circle of the effective radius.
    #[default]
    Analytic,
    /// The cutter's exact lower body, which gives an upper bound.
    Envelope,
}

/// A pass with the model that evaluates it.
#[derive(Debug, Clone, Copy)]
pub struct EvaluatedPass {
    prepared: PreparedModel,
}

#[derive(Debug, Clone, Copy)]
#[expect(clippy::large_enum_variant, reason = "it is kept by the one that evaluates it, and never in a list")]
enum PreparedModel {
    Analytic(Analytic),
    Envelope(Envelope),
}

impl EvaluatedPass {
    /// Prepares `pass` for `model`.
    ///
    /// # Errors
    /// Those of [`Analytic::new`] and [`Envelope::new`].
    #[inline]
    pub fn new(model: Model, pass: Pass) -> Result<Self, NoAnswer> {
        let prepared = match model {
            Model::Analytic => PreparedModel::Analytic(Analytic::new(pass)?),
            Model::Envelope => PreparedModel::Envelope(Envelope::new(pass)?),
        };
        Ok(Self { prepared })
    }

    /// Prepares the model, or `None` if the cutter does not fit a concave surface. The radius into which it would fit, which the
    /// error of [`EvaluatedPass::new`] states, takes up to a hundred times as long.
    ///
    /// # Errors
    /// The other errors of [`Analytic::new`].
    pub(crate) fn fitting(model: Model, pass: Pass) -> Result<Option<Self>, NoAnswer> {
        let prepared = match model {
            Model::Analytic => Analytic::fitting(pass)?.map(PreparedModel::Analytic),
            Model::Envelope => Envelope::fitting(pass).map(PreparedModel::Envelope),
        };
        Ok(prepared.map(|prepared| Self { prepared }))
    }

    /// The pass itself.
    #[must_use]
    pub fn pass(&self) -> &Pass {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.pass(),
            PreparedModel::Envelope(model) => model.pass(),
        }
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> Model {
        match self.prepared {
            PreparedModel::Analytic(_) => Model::Analytic,
            PreparedModel::Envelope(_) => Model::Envelope,
        }
    }

    /// lambda, the smallest relative curvature of cutter and surface as a share of the cutter's own: 1 on a plane, 0 if
    /// the cutter gouges.
    #[must_use]
    pub fn relative_curvature(&self) -> f64 {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.relative_curvature(),
            PreparedModel::Envelope(model) => model.relative_curvature(),
        }
    }

    /// The effective radius across the feed, radial runout included; `None` if it is infinite.
    #[must_use]
    pub fn effective_radius(&self) -> Option<Length> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.across_feed(),
            PreparedModel::Envelope(_) => {
                EffectiveRadius::across_feed(self.pass().cutter.widened(self.pass().runout.radial()), self.pass().contact)
            }
        }
        .finite()
    }

    /// The effective radius along the feed; `None` if it is infinite.
    #[must_use]
    pub fn transverse_effective_radius(&self) -> Option<Length> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.along_feed(),
            PreparedModel::Envelope(_) => EffectiveRadius::along_feed(self.pass().cutter, self.pass().contact),
        }
        .finite()
    }

    /// The height that a step-over along the surface and a feed per tooth leave; `None` leaves no marks.
    ///
    /// # Errors
    /// Those of [`Analytic::scallop_height`] and [`Envelope::scallop_height`].
    pub fn scallop_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.scallop_height(step_over, feed_per_tooth),
            PreparedModel::Envelope(model) => model.scallop_height(step_over, feed_per_tooth),
        }
    }

    /// h1, the height that a step-over along the surface alone leaves.
    ///
    /// # Errors
    /// Those of [`EvaluatedPass::scallop_height`] without marks.
    pub fn step_over_height(&self, step_over: Length) -> Result<Length, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.step_over_height(step_over),
            PreparedModel::Envelope(model) => model.step_over_height(step_over),
        }
    }

    /// [`EvaluatedPass::scallop_height`], all of which counts as h1 where the parts take searches of their own.
    pub(crate) fn total_height(&self, step_over: Length, feed_per_tooth: Option<Length>) -> Result<ScallopHeight, NoAnswer> {
        match &self.prepared {
            PreparedModel::Envelope(model) if self.pass().surface.is_plane() => {
                model.total_height(step_over, feed_per_tooth).map(|total| ScallopHeight::of_parts(total, Length::ZERO))
            }
            _ => self.scallop_height(step_over, feed_per_tooth),
        }
    }

    /// [`EvaluatedPass::scallop_height`] for a step-over that alone leaves `step_over_height`.
    pub(crate) fn height_above(
        &self,
        step_over_height: Length,
        step_over: Length,
        feed_per_tooth: Option<Length>,
    ) -> Result<ScallopHeight, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.height_above(step_over_height, feed_per_tooth),
            PreparedModel::Envelope(model) => model.height_above(step_over_height, step_over, feed_per_tooth),
        }
    }

    /// Whether there certainly is a height at every step-over and feed per tooth that the inverses find. Under model
    /// `envelope` on planes these are within the borders of where passes and marks overlap.
    pub(crate) fn inverses_have_heights(&self) -> bool {
        self.model() == Model::Envelope && self.pass().surface.is_plane()
    }

    /// [`EvaluatedPass::max_feed_per_tooth`] for a step-over that alone leaves `step_over_height`.
    pub(crate) fn max_feed_per_tooth_above(
        &self,
        step_over_height: Length,
        tolerance: Length,
        step_over: Length,
    ) -> Result<Length, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.max_feed_per_tooth_above(step_over_height, tolerance),
            PreparedModel::Envelope(model) => model.max_feed_per_tooth_above(step_over_height, tolerance, step_over),
        }
    }

    /// The largest feed per tooth that keeps a tolerance on the height.
    ///
    /// # Errors
    /// Those of [`Analytic::max_feed_per_tooth`] and [`Envelope::max_feed_per_tooth`].
    pub fn max_feed_per_tooth(&self, tolerance: Length, step_over: Length) -> Result<Length, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.max_feed_per_tooth(tolerance, step_over),
            PreparedModel::Envelope(model) => model.max_feed_per_tooth(tolerance, step_over),
        }
    }

    /// The largest step-over along the surface that keeps a tolerance on the height.
    ///
    /// # Errors
    /// Those of [`Analytic::max_step_over`] and [`Envelope::max_step_over`].
    pub fn max_step_over(&self, tolerance: Length, feed_per_tooth: Option<Length>) -> Result<Length, NoAnswer> {
        match &self.prepared {
            PreparedModel::Analytic(model) => model.max_step_over(tolerance, feed_per_tooth),
            PreparedModel::Envelope(model) => model.max_step_over(tolerance, feed_per_tooth),
        }
    }
}

/// An assumption of the model that is near its limit, with its figures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ModelWarning {
    /// Runout is not small compared with the feed per tooth: some teeth may leave no mark, and then the analytic feed
    /// height is not an upper bound.
    RunoutNotSmall {
        /// sqrt(rr^2 + ar^2) over f_z.
        ratio: f64,
    },
    /// The step-over is wide compared with the groove, whose circle approximates the cutter only near the contact.
    StepOverWide {
        /// Step-over over the effective diameter.
        ratio: f64,
    },
    /// The feed per tooth is long compared with the mark, whose circle approximates the cutter only near the contact.
    FeedPerToothLong {
        /// Feed per tooth over the transverse effective diameter.
        ratio: f64,
    },
    /// The groove's circle is wider than any cut that the cutter can make.
    EffectiveRadiusBeyondCutter {
        /// The effective radius; `None` if it is infinite.
        effective_radius: Option<Length>,
        /// The cutter's diameter.
        diameter: Length,
    },
    /// The sharp corner of a flat-end cutter or of a profile leaves sharp marks, and wears.
    SharpMarks,
    /// On a curved surface the slope and feed direction change so much from mark to mark that the height is only
    /// approximate. This is so at every slope under 10 deg; if [`ScallopHeight::largest_turn`](crate::milling::ScallopHeight::largest_turn) exceeds 0.1; and near
    /// walls, if the normal turns by more than a fifth of the remaining angle to 90 deg between two marks.
    CurvatureApproximate,
    /// The normal of a curved surface turns so far that marks between those of the ridge can lie where the surface is level or
    /// upright: the cutter touches with its other side there, which the height leaves out.
    HeightNotABound {
        /// [`ScallopHeight::largest_turn`](crate::milling::ScallopHeight::largest_turn).
        turn: f64,
    },
    /// The cutter fits closely into the concave surface, so that the second order of the surface is not accurate
    /// enough.
    NearGouging {
        /// The smallest relative curvature as a share of the cutter's own: 1 on a plane, 0 if the cutter gouges.
        lambda: f64,
    },
}

impl fmt::Display for ModelWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::RunoutNotSmall { ratio } => {
                write!(
                    f,
                    "the runout is {:.1} % of the feed per tooth, which is not small: some teeth may leave no mark; the published height of the tooth marks is no upper bound with runout, model \"envelope\" has one",
                    ratio * 100.0
                )
            }
            Self::StepOverWide { ratio } => write!(
                f,
                "the step-over is {:.1} % of the effective diameter; the circle that replaces the cutter fits it only near the contact",
                ratio * 100.0
            ),
            Self::FeedPerToothLong { ratio } => write!(
                f,
                "the feed per tooth is {:.1} % of the transverse effective diameter; the circle that replaces the cutter fits it only near the contact",
                ratio * 100.0
            ),
            Self::EffectiveRadiusBeyondCutter { effective_radius: Some(radius), diameter } => write!(
                f,
                "the effective radius, {:.3} mm, exceeds the cutter's diameter, {:.3} mm: the groove's circle is wider than the cutter, and the scallop can be far higher than computed",
                radius.mm(),
                diameter.mm()
            ),
            Self::EffectiveRadiusBeyondCutter { effective_radius: None, .. } => f.write_str("the effective radius is infinite"),
            Self::SharpMarks => {
                f.write_str("a flat-end cutter leaves sharp marks; a small corner radius leaves lower ones and lasts longer")
            }
            Self::CurvatureApproximate => f.write_str(
                "the normal of the curved surface turns between the marks by an angle that is not negligible (as at every slope under 10 deg); the height is approximate, and can be exceeded by a few percent",
            ),
            Self::HeightNotABound { turn } => write!(
                f,
                "between the marks the normal of the curved surface turns by {turn:.2} of the angle to level ground or to a wall; from {TURN_OF_NO_BOUND} on the surface can be level or upright within a step-over, where the cutter touches with its other side: the height is no bound, and near level ground it can be exceeded many times over"
            ),
            Self::NearGouging { lambda } => write!(
                f,
                "the cutter fits closely into the concave surface: the relative curvature is {lambda:.3} of the cutter's own, and below {NEAR_GOUGING} the height can be exceeded"
            ),
        }
    }
}

/// Runout above this share of the feed is not small, and a chord above this share of its circle's diameter is not
/// short. At a fifth of the diameter, the heights of the circle and of its parabola differ by 1 %, the error of
/// neglecting the next order.
const A_FIFTH: f64 = 0.2;

/// The largest turn of the normal between the stated contact and a mark that gives no warning. Simulated heights with
/// larger turns exceed the model's by up to some percent on strongly curved surfaces;
/// `docs/envelope-on-curved-surfaces.md` has the figures.
const SMALL_TURN: f64 = 0.1;

/// The turn of the normal from which on a height is no bound. A ridge's marks are half a step-over away from its place, and with other
/// positions of the passes up to a whole one: where the normal turns half of the way to level ground within half a step-over, such a
/// mark can lie past it.
const TURN_OF_NO_BOUND: f64 = 0.5;

/// The slope in degrees below which heights on curved surfaces are approximate in model `envelope`.
const STEEP_ENOUGH_DEG: f64 = 10.0;

impl EvaluatedPass {
    /// All warnings about this pass at a step-over along the surface and a feed per tooth; `None` leaves no marks.
    /// `largest_turn` is that of the height there.
    ///
    /// The limits of the circle and of the published runout concern model `analytic`, the turning of the normal model
    /// `envelope`.
    pub fn warnings(
        &self,
        step_over: Length,
        feed_per_tooth: Option<Length>,
        largest_turn: f64,
    ) -> impl Iterator<Item = ModelWarning> + use<> {
        let pass = self.pass();
        let circle = match self.model() {
            Model::Analytic => self.circle_warnings(step_over, feed_per_tooth),
            Model::Envelope => [None; 4],
        };
        let is_sharp = pass.cutter.profile().arc_at(pass.contact.slope().radians()).radius == 0.0;
        let sharp = is_sharp.then_some(ModelWarning::SharpMarks);
        let counts = || {
            pass.contact.slope().degrees() < STEEP_ENOUGH_DEG
                || largest_turn > SMALL_TURN
                || turns_towards_wall(pass, step_over, feed_per_tooth)
        };
        let is_curved = self.model() == Model::Envelope && !pass.surface.is_plane();
        let turned = if is_curved && !self.is_bound(largest_turn) {
            Some(ModelWarning::HeightNotABound { turn: largest_turn })
        } else {
            (is_curved && counts()).then_some(ModelWarning::CurvatureApproximate)
        };
        let lambda = self.relative_curvature();
        let near_gouging = (lambda < NEAR_GOUGING).then_some(ModelWarning::NearGouging { lambda });
        circle.into_iter().chain([sharp, turned, near_gouging]).flatten()
    }

    /// Whether an envelope height with this [`ScallopHeight::largest_turn`] is a bound. It is none where a mark within a step-over can
    /// lie where the surface is level or upright, if the touching arc of the profile ends there: the cutter touches with its other side.
    #[must_use]
    pub fn is_bound(&self, largest_turn: f64) -> bool {
        let profile = self.pass().cutter.profile();
        let slope = self.pass().contact.slope().radians();
        let arc = profile.arc_at(slope);
        // The other side of a round tip continues it.
        let is_tip = arc.centre_offset <= 0.0 && arc.from <= 0.0;
        let ends = if !is_tip && slope - arc.from < arc.to - slope { arc.from <= 0.0 } else { arc.to >= FRAC_PI_2 };
        largest_turn < TURN_OF_NO_BOUND || !ends
    }

    /// The warnings of the analytic model, which replaces the cutter by a circle.
    fn circle_warnings(&self, step_over: Length, feed_per_tooth: Option<Length>) -> [Option<ModelWarning>; 4] {
        let pass = self.pass();
        let runout = feed_per_tooth.and_then(|feed| {
            let ratio = pass.runout.magnitude().mm() / feed.mm();
            (ratio > A_FIFTH).then_some(ModelWarning::RunoutNotSmall { ratio })
        });
        let (across, along) = (self.effective_radius(), self.transverse_effective_radius());
        let diameter = pass.cutter.outer_radius() + pass.cutter.outer_radius();
        let share =
            |chord: Length, radius: Option<Length>| radius.map(|radius| chord.mm() / (2.0 * radius.mm())).filter(|ratio| *ratio > A_FIFTH);
        let wide = share(step_over, across).map(|ratio| ModelWarning::StepOverWide { ratio });
        let long = feed_per_tooth.and_then(|feed| share(feed, along)).map(|ratio| ModelWarning::FeedPerToothLong { ratio });
        let beyond = across
            .is_none_or(|radius| radius > diameter)
            .then_some(ModelWarning::EffectiveRadiusBeyondCutter { effective_radius: across, diameter });
        [runout, wide, long, beyond]
    }
}

/// Whether, between passes or marks, the normal of a concave surface turns by more than a fifth of the remaining angle
/// to a wall. A sphere of 60 mm at 85 deg, where simulations keep the height, has a share of 0.23 for 30 um; at 88 deg
/// it has 0.9, and the height is exceeded by half.
fn turns_towards_wall(pass: &Pass, step_over: Length, feed_per_tooth: Option<Length>) -> bool {
    let [_, smallest] = pass.surface.principal_per_mm();
    let furthest = step_over.mm().max(feed_per_tooth.map_or(0.0, Length::mm));
    smallest < 0.0 && -smallest * furthest > A_FIFTH * (FRAC_PI_2 - pass.contact.slope().radians())
}
