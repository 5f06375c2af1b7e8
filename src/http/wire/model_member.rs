//! The models of the scallop height, by their names on the wire.

use crate::http::reading::{Choice, Member};
use crate::milling::Model;

/// The member `model` of requests.
pub(crate) const MODEL: Member<Choice<Model>> = Member::new(
    "model",
    "analytic (default): the published closed formulas, with a circle in place of the cutter; envelope: an upper bound by the cutter's exact shape, at every slope",
    Choice { name: Some("Model"), words: &[("analytic", Model::Analytic), ("envelope", Model::Envelope)] },
);

/// The member `model` of recommendations.
pub(crate) const PLAN_MODEL: Member<Choice<Model>> = Member {
    about: "envelope (default in method surface): the cutter's exact shape, in method surface with the curvature of each facet; analytic (default in method rectangle): the published closed formulas, with a circle in place of the cutter",
    ..MODEL
};
