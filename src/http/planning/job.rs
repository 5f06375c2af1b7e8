//! The wire form of a job: two cutters to compare, the scallop height that they may leave, the machine, and the model.

use super::machine::MACHINE;
use crate::http::calculation::{BALL_END, MODEL, TOROIDAL};
use crate::http::codes::{NoAnswerCode, RequestFault};
use crate::http::reading::member::StatedLength;
use crate::http::reading::{Fault, Faulted, Faults, Member, Object, ObjectSchema, Place};
use crate::milling::NoAnswer;
use crate::planning::{Job, JobError};

/// The member `scallop_height_mm`.
pub(super) const SCALLOP_HEIGHT: Member<StatedLength> = Member {
    name: "scallop_height_mm",
    about: "sh, the scallop height that either cutter may leave: at most the toroidal cutter's corner radius and under the ball's radius",
    kind: StatedLength { example: 0.01 },
};

/// Takes the members of a job out of `object`, which has others.
pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Job, Faulted> {
    let toroidal = object.required(&TOROIDAL, faults);
    let ball_end = object.required(&BALL_END, faults);
    let scallop_height = object.required(&SCALLOP_HEIGHT, faults);
    let machine = object.required(&MACHINE, faults);
    let model = object.optional(&MODEL, faults);
    let job = Job::new(toroidal?, ball_end?, scallop_height?, machine?, model?.unwrap_or_default());
    job.map_err(|error| faults.push(fault(error, &object.place())))
}

/// Adds these members to a request's schema.
pub(super) fn describe(schema: ObjectSchema) -> ObjectSchema {
    schema.required(&TOROIDAL).required(&BALL_END).required(&SCALLOP_HEIGHT).required(&MACHINE).optional(&MODEL)
}

fn fault(error: JobError, place: &Place<'_>) -> Fault {
    match error {
        JobError::NotToroidal => Fault::new(&place.member(TOROIDAL.name), RequestFault::NotToroidal, error),
        JobError::NotBallEnd => Fault::new(&place.member(BALL_END.name), RequestFault::NotBallEnd, error),
        JobError::ScallopTooHigh { .. } => Fault::new(&place.member(SCALLOP_HEIGHT.name), RequestFault::ScallopTooHigh, error),
        JobError::BallEnd(cause) => no_answer(cause, error, &place.member(SCALLOP_HEIGHT.name)),
    }
}

/// The fault that a cutter has no step-over, described by `detail`.
pub(super) fn no_answer(cause: NoAnswer, detail: impl std::fmt::Display, place: &Place<'_>) -> Fault {
    let (code, figures) = NoAnswerCode::of(cause);
    Fault { figures, ..Fault::new(place, code, detail) }
}
