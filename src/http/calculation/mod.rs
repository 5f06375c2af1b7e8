//! The calculations at contacts: scallop height, maximum feed, maximum step-over, each for one contact and for many.
//!
//! One file per endpoint holds what is particular to it; the rest is what they share: the wire forms of cutter, contact and terms,
//! the figures of the answers, and how a request with one contact and one with many is answered.

mod batch;
mod column;
mod contact;
mod cutter;
mod figures;
pub(crate) mod max_feed;
mod plain;
mod refusal;
pub(crate) mod scallop_height;
mod single;
pub(crate) mod step_over;
mod terms;
mod warning;

use crate::milling::{JudgedPass, NoAnswer};
use crate::quantity::Length;
use figures::Figures;

use super::reading::{Faulted, Faults, Object, ObjectSchema};
pub(crate) use cutter::{BALL_END, TOROIDAL};
pub(crate) use terms::MODEL;
use terms::Setup;
pub(crate) use warning::Warning;

/// What tells one calculation from the others.
pub(crate) trait Calculation: Sized + Send + Sync {
    /// Whether a request states a step-over, and a feed per tooth; what is sought is not stated.
    const STATES: terms::Stated;
    /// The names of the request's schemas in the API document, for one contact and for many.
    const SCHEMAS: [&'static str; 2];
    /// The figures of an answer.
    type Figures: Figures;

    /// Takes the members of a request that only this calculation has; the setup is for faults that show only beside it.
    fn read(object: &mut Object<'_, '_>, setup: Result<&Setup, Faulted>, faults: &mut Faults) -> Result<Self, Faulted>;

    /// Adds these members to a request's schema.
    fn describe(schema: ObjectSchema) -> ObjectSchema;

    /// Works out one contact. `step_over` is along the surface, and there where the calculation states one.
    fn work_out(
        &self,
        setup: &Setup,
        pass: &JudgedPass,
        step_over: Option<Length>,
        feed_per_tooth: Option<Length>,
    ) -> Result<Self::Figures, NoAnswer>;
}
