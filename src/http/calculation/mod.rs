//! The calculations at contacts: scallop height, largest feed, largest step-over and fastest cutting parameters, each
//! for one contact and for many. Each endpoint has a file with its own members and figures; the code that reads
//! requests and writes answers is shared.

mod batch;
mod calculations;
mod column;
mod fastest_parameters;
mod feed_limits;
mod max_feed;
mod max_step_over;
mod scallop_height;
mod single;

use calculations::{Texts, operations_of};
use fastest_parameters::FastestParameters;
use max_feed::MaxFeed;
use max_step_over::MaxStepOver;
use scallop_height::ScallopHeightOperation;

use super::document::examples;
use super::reading::{Faulted, Faults, Members};
use super::routes::Routes;
use super::wire::{ContactParameters, Figure, Figures, Heights, SharedParameters, StatedParameters};
use crate::cancellation::CancelFlag;
use crate::milling::{EvaluatedPass, NoAnswer, StepOver};
use crate::quantity::Length;

/// The routes of all calculations.
pub(super) fn routes() -> Routes {
    operations_of::<ScallopHeightOperation>(examples!("scallop_height"))
        .merge(operations_of::<MaxFeed>(examples!("max_feed")))
        .merge(operations_of::<MaxStepOver>(examples!("step_over")))
        .merge(operations_of::<FastestParameters>(examples!("cutting_parameters")))
}

/// The inputs of a calculation at a contact.
pub(crate) struct Inputs<'a> {
    shared: &'a SharedParameters,
    pass: &'a EvaluatedPass,
    /// `None` if the request states none.
    step_over: Option<StepOver>,
    feed_per_tooth: Option<Length>,
    /// The heights that the figures must have at least.
    heights: Heights,
    /// The figures of a cancelled calculation are discarded.
    cancel: &'a CancelFlag,
}

impl Inputs<'_> {
    /// The step-over along the surface, for a calculation whose requests state one.
    fn stated_step_over(&self) -> Result<Length, NoAnswer> {
        let stated = self.step_over.unwrap_or_else(|| unreachable!("a request of this calculation states a step-over"));
        stated.along_surface(self.pass.pass().contact)
    }
}

/// A calculation at a contact: its members, its figures and its formula.
pub(crate) trait Calculation: Sized + Send + Sync {
    /// The texts of the documentation.
    const TEXTS: Texts;
    /// The parameters of a contact that a request must state.
    const STATED: StatedParameters;
    /// Whether a single answer takes too long for a thread that serves connections.
    const TAKES_LONG: bool = false;
    /// The members that are specific to requests of this calculation.
    type Members: Members;
    /// The figures of an answer, in their order.
    const FIGURES: &'static [&'static [Figure]];

    /// The calculation that the members of a request describe.
    fn new(members: Self::Members, shared: Result<&SharedParameters, Faulted>, faults: &mut Faults) -> Result<Self, Faulted>;

    /// The figures at a contact.
    fn compute(&self, inputs: &Inputs<'_>) -> Result<Figures, NoAnswer>;

    /// The member that determines the step-over. Faults of the step-over point to it.
    fn step_over_member(&self, stated: &ContactParameters) -> &'static str {
        stated.step_over_member()
    }

    /// The figures of an answer.
    fn figures() -> impl Iterator<Item = &'static Figure> {
        Self::FIGURES.iter().copied().flatten()
    }
}
