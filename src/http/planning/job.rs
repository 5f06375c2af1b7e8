//! A job: two cutters to compare, the scallop height that they may leave, the machine, and the model.

use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Fault, Faulted, Faults, JsonPath, Members, Object, Quantity, Renamed, members};
use crate::http::wire::{
    BallEndCutter, MACHINE, MODEL, MachineKind, ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, ToroidalCutter, plan_tolerance,
};
use crate::milling::Model;
use crate::motion;
use crate::planning::{CutterComparison, JobError};
use crate::quantity::Length;

members! {
    /// The members of a job.
    pub(super) struct JobMembers {
        toroidal: required TOROIDAL: ToroidalCutter = ("toroidal", ToroidalCutter, "the toroidal cutter to compare"),
        ball_end: required BALL_END: BallEndCutter = ("ball_end", BallEndCutter, "the ball-end cutter to compare"),
        roughness: optional ROUGHNESS: RoughnessKind,
        tolerance: optional TOLERANCE: Quantity<Length> = ("scallop_tolerance_mm", Quantity::length(0.01),
            "sh, the scallop height that either cutter may leave: at most the toroidal cutter's corner radius and under the ball's radius"),
        scallop_height: optional SCALLOP_HEIGHT: Renamed<Length>,
        machine: required MACHINE: MachineKind,
        model: optional MODEL: Choice<Model>,
    }
}

/// A job, the machine with what the job does not need, and the name of the member that states the scallop height.
pub(super) struct StatedJob {
    pub(super) job: CutterComparison,
    pub(super) machine: motion::Machine,
    pub(super) tolerance: &'static str,
}

/// Reads the members of a job from `object`, which may have others.
pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<StatedJob, Faulted> {
    let JobMembers { toroidal, ball_end, roughness, tolerance, scallop_height, machine, model } = JobMembers::read(object, faults);
    let tolerance = plan_tolerance(tolerance, scallop_height, roughness, &TOLERANCE, &object.path(), faults);
    let (toroidal, ball_end, tolerance, machine) = (toroidal?, ball_end?, tolerance?, machine?);
    let job = CutterComparison::new(toroidal, ball_end, tolerance.height, machine.limits, model?.unwrap_or_default());
    let job = job.map_err(|error| faults.push(fault(error, &object.path().member(tolerance.name))))?;
    Ok(StatedJob { job, machine, tolerance: tolerance.name })
}

/// The fault of a job whose scallop height is at `tolerance`.
fn fault(error: JobError, tolerance: &JsonPath<'_>) -> Fault {
    match error {
        JobError::NotToroidal | JobError::NotBallEnd => unreachable!("each member is read as a cutter of its kind"),
        JobError::ScallopTooHigh { .. } => Fault::new(tolerance, RequestFault::ScallopTooHigh, error),
        JobError::BallEnd(cause) => Fault::no_answer(cause, tolerance, error),
    }
}
