//! The parameters of the calculations: those of the whole request, and those that each contact may override.

use super::curvature_object::{CurvatureMembers, SURFACE_RADIUS, StatedCurvature};
use super::cutter_object::{AnyCutter, StatedCutter};
use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Declared, Faulted, Faults, JsonPath, Member, Members, Object, Quantity, at_most_one, members};
use crate::milling::{Model, Runout, StepOver, SurfaceCurvature};
use crate::quantity::{Length, OutOfRange};

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
            None if self.stated.step_over => Err(missing_step_over(path, faults)),
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
        member_of(self.step_over.ok().flatten())
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

members! {
    /// The members for the step-over, of which at most one may be given.
    struct StepOverMembers {
        along_surface: optional STEP_OVER: Quantity<Length> = ("step_over_mm", Quantity::length(0.687),
            "step-over s along the surface, perpendicular to the feed; or give step_over_xy_mm"),
        seen_from_above: optional STEP_OVER_XY: Quantity<Length> = ("step_over_xy_mm", Quantity::length(0.65),
            "step-over d between parallel vertical planes, seen from above; or give step_over_mm"),
    }
}

impl StepOverMembers {
    /// The step-over, if one is given.
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Option<StepOver>, Faulted> {
        let along_surface = self.along_surface.map(|stated| stated.map(StepOver::AlongSurface));
        let seen_from_above = self.seen_from_above.map(|stated| stated.map(StepOver::SeenFromAbove));
        at_most_one(along_surface, seen_from_above).unwrap_or_else(|| {
            let detail = "give step_over_mm or step_over_xy_mm, not both";
            Err(faults.add(&path.member(STEP_OVER_XY.name), RequestFault::ConflictingFields, detail))
        })
    }
}

/// Records the fault of a missing step-over.
fn missing_step_over(path: &JsonPath<'_>, faults: &mut Faults) -> Faulted {
    let detail = "give step_over_mm (along the surface) or step_over_xy_mm (seen from above)";
    faults.add(&path.member(STEP_OVER.name), RequestFault::MissingField, detail)
}

/// The member in which a step-over was given.
fn member_of(step_over: Option<StepOver>) -> &'static str {
    match step_over {
        Some(StepOver::SeenFromAbove(_)) => STEP_OVER_XY.name,
        Some(StepOver::AlongSurface(_)) | None => STEP_OVER.name,
    }
}

members! {
    /// The feed per tooth.
    pub(super) struct FeedMembers {
        feed_per_tooth: optional FEED_PER_TOOTH: Quantity<Feed> = ("feed_per_tooth_mm", Quantity::new(Feed::from_mm, 0.3).down_to(0.0, "; or 0 for no tooth marks"),
            "feed per tooth f_z, at least 1e-6; 0 or absent = no tooth marks"),
    }
}

/// A stated feed per tooth. 0 means no tooth marks and overrides the default.
#[derive(Debug, Clone, Copy)]
pub(super) enum Feed {
    NoMarks,
    PerTooth(Length),
}

impl Feed {
    fn from_mm(feed: f64) -> Result<Self, OutOfRange> {
        if feed == 0.0 { Ok(Self::NoMarks) } else { Length::from_mm(feed).map(Self::PerTooth) }
    }

    /// The feed per tooth; `None` without tooth marks.
    fn per_tooth(self) -> Option<Length> {
        match self {
            Self::PerTooth(length) => Some(length),
            Self::NoMarks => None,
        }
    }
}

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

members! {
    /// The members of a runout.
    pub(crate) struct RunoutMembers for RunoutObject ("Runout", "The deviation of the teeth from their common circle") -> Runout {
        radial: optional RADIAL: Quantity<f64> = ("radial_mm", Quantity::new(|mm| Runout::NONE.with_radial_mm(mm).map(|_| mm), 0.005),
            "radial runout: how much further one tooth protrudes than the next; absent = 0"),
        axial: optional AXIAL: Quantity<f64> = ("axial_mm", Quantity::new(|mm| Runout::NONE.with_axial_mm(mm).map(|_| mm), 0.002),
            "axial runout: how much lower one tooth is than the next; if the feed climbs, a positive value shortens the distance between tooth marks and a negative one lengthens it; a feed down the slope is treated like a feed up the slope; absent = 0"),
    }
}

impl RunoutMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Runout, Faulted> {
        let (radial, axial) = (self.radial?.unwrap_or(0.0), self.axial?.unwrap_or(0.0));
        let runout = Runout::NONE.with_radial_mm(radial).and_then(|runout| runout.with_axial_mm(axial));
        runout.map_err(|bounds| faults.add(path, RequestFault::OutOfRange, bounds))
    }
}
