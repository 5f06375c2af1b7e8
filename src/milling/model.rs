//! A pass evaluated by either model, behind one set of functions.

use super::{Analytic, EffectiveRadius, Envelope, NoAnswer, Pass, ScallopHeight};
use crate::quantity::Length;

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
