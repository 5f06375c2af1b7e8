//! A job: two cutters to compare, the scallop height that they may leave, the machine, and the model.

use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Fault, Faulted, Faults, JsonPath, Members, Object, Quantity, members};
use crate::http::wire::{BallEndCutter, MACHINE, MODEL, Machine, ToroidalCutter};
use crate::milling::Model;
use crate::planning::{Job, JobError};
use crate::quantity::Length;

members! {
    /// The members of a job.
    pub(super) struct JobMembers {
        toroidal: required TOROIDAL: ToroidalCutter = ("toroidal", ToroidalCutter, "the toroidal cutter to compare"),
        ball_end: required BALL_END: BallEndCutter = ("ball_end", BallEndCutter, "the ball-end cutter to compare"),
        scallop_height: required SCALLOP_HEIGHT: Quantity<Length> = ("scallop_height_mm", Quantity::length(0.01),
            "sh, the scallop height that either cutter may leave: at most the toroidal cutter's corner radius and under the ball's radius"),
        machine: required MACHINE: Machine,
        model: optional MODEL: Choice<Model>,
    }
}

/// Reads the members of a job from `object`, which may have others.
pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Job, Faulted> {
    let JobMembers { toroidal, ball_end, scallop_height, machine, model } = JobMembers::read(object, faults);
    let job = Job::new(toroidal?, ball_end?, scallop_height?, machine?.limits, model?.unwrap_or_default());
    job.map_err(|error| faults.push(fault(error, &object.path())))
}

fn fault(error: JobError, path: &JsonPath<'_>) -> Fault {
    match error {
        JobError::NotToroidal | JobError::NotBallEnd => unreachable!("each member is read as a cutter of its kind"),
        JobError::ScallopTooHigh { .. } => Fault::new(&path.member(SCALLOP_HEIGHT.name), RequestFault::ScallopTooHigh, error),
        JobError::BallEnd(cause) => Fault::no_answer(cause, &path.member(SCALLOP_HEIGHT.name), error),
    }
}
