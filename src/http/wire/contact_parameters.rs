//! The parameters of the calculations: those of the whole request, and those that each contact may override.

use super::curvature_object::{CurvatureMembers, SURFACE_RADIUS, StatedCurvature};
use super::cutter_object::{AnyCutter, StatedCutter};
use super::feed::{Feed, FeedMembers};
use super::model_member::MODEL;
use super::runout_object::RunoutObject;
use super::step_over_member::{self, StepOverMembers};
use crate::http::reading::{Choice, Declared, Faulted, Faults, JsonPath, Member, Members, Object, Quantity, members};
use crate::milling::{Model, Runout, StepOver, SurfaceCurvature};
use crate::quantity::Length;

/// The tolerance of the calculations that have one.
pub(crate) const TOLERANCE: Member<Quantity<Length>> =
    Member::new("scallop_tolerance_mm", "the scallop height that must not be exceeded", Quantity::length(0.015));

members! {
    /// The members that apply to all contacts of a request.
    pub(crate) struct SharedMembers {
        cutter: required CUTTER: AnyCutter = ("cutter", AnyCutter, "the cutter, one of eight kinds, discriminated by type"),
        runout: optional RUNOUT: RunoutObject = ("runout", RunoutObject, "runout of the teeth, small compared with the feed per tooth; absent = none"),
        model: optional MODEL: Choice<Model>,
    }
}

/// The parameters that apply to all contacts of a request.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SharedParameters {
    pub(crate) tool: StatedCutter,
    pub(crate) runout: Runout,
    pub(crate) model: Model,
}

impl SharedParameters {
    pub(crate) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let SharedMembers { cutter, runout, model } = SharedMembers::read(object, faults);
        Ok(Self { tool: cutter?, runout: runout?.unwrap_or(Runout::NONE), model: model?.unwrap_or_default() })
    }
}

/// Which parameters of a contact a request states; a calculation computes the others.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StatedParameters {
    pub(crate) step_over: bool,
    pub(crate) feed_per_tooth: bool,
}

/// The parameters of a contact that one object of a request states. The faults of each are already recorded.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactParameters {
    pub(super) stated: StatedParameters,
    step_over: Result<Option<StepOver>, Faulted>,
    feed_per_tooth: Result<Option<Feed>, Faulted>,
    curvature: Result<Option<StatedCurvature>, Faulted>,
}

impl ContactParameters {
    /// Reads from `object` the parameters that `stated` allows, all of them optional there.
    pub(crate) fn read(object: &mut Object<'_, '_>, stated: StatedParameters, faults: &mut Faults) -> Self {
        let path = object.path();
        let step_over = if stated.step_over { StepOverMembers::read(object, faults).build(&path, faults) } else { Ok(None) };
        let feed_per_tooth = if stated.feed_per_tooth { FeedMembers::read(object, faults).feed_per_tooth } else { Ok(None) };
        Self { stated, step_over, feed_per_tooth, curvature: CurvatureMembers::read(object, faults).build(&path, faults) }
    }

    /// These parameters, with those of `others` in place of absent ones.
    pub(crate) fn or(self, others: &Self) -> Self {
        Self {
            stated: self.stated,
            step_over: self.step_over.and_then(|own| own.map_or(others.step_over, |s| Ok(Some(s)))),
            feed_per_tooth: self.feed_per_tooth.and_then(|own| own.map_or(others.feed_per_tooth, |f| Ok(Some(f)))),
            curvature: self.curvature.and_then(|own| own.map_or(others.curvature, |c| Ok(Some(c)))),
        }
    }

    /// The step-over; a missing one is a fault if the request must state it.
    pub(crate) fn step_over(&self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Option<StepOver>, Faulted> {
        match self.step_over? {
            None if self.stated.step_over => Err(step_over_member::missing(path, faults)),
            step_over => Ok(step_over),
        }
    }

    /// The feed per tooth; `None` for no tooth marks.
    pub(crate) fn feed_per_tooth(&self) -> Result<Option<Length>, Faulted> {
        self.feed_per_tooth.map(|feed| feed.and_then(Feed::per_tooth))
    }

    pub(crate) fn curvature(&self) -> Result<SurfaceCurvature, Faulted> {
        self.curvature.map(|stated| stated.map_or(SurfaceCurvature::PLANE, |stated| stated.curvature))
    }

    /// The member that states the curvature.
    pub(super) fn curvature_member(&self) -> &'static str {
        self.curvature.ok().flatten().map_or(SURFACE_RADIUS.name, |stated| stated.member)
    }

    /// The member that states the step-over.
    pub(crate) fn step_over_member(&self) -> &'static str {
        step_over_member::member_of(self.step_over.ok().flatten())
    }
}

impl StatedParameters {
    /// The name of a contact with these parameters of its own, after the form in which the contact is.
    pub(super) fn name(self, form: &str) -> String {
        let of_parameters = match (self.step_over, self.feed_per_tooth) {
            (true, true) => "Parameters",
            (true, false) => "StepOver",
            (false, true) => "Feed",
            (false, false) => "Curvature",
        };
        format!("{form}With{of_parameters}")
    }

    /// The members of these parameters, none of which is required.
    pub(crate) fn members(self) -> impl Iterator<Item = &'static Declared> {
        let step_over = if self.step_over { StepOverMembers::DECLARED } else { &[] };
        let feed = if self.feed_per_tooth { FeedMembers::DECLARED } else { &[] };
        step_over.iter().chain(feed).chain(CurvatureMembers::DECLARED)
    }
}
