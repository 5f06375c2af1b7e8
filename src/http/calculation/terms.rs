//! What a calculation is asked beside the contact: the setup, the same for a whole tool path, and the terms, which may differ from
//! contact to contact.

use super::cutter::{CUTTER, StatedCutter};
use crate::http::codes::RequestFault;
use crate::http::reading::member::{Choice, Kind, Number, StatedLength, in_range, number};
use crate::http::reading::{Faulted, Faults, Member, Object, ObjectSchema, Place};
use crate::milling::{Model, Runout, StepOver, SurfaceCurvature};
use crate::quantity::{Length, OutOfRange};
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

/// The member `model` of every calculation.
pub(crate) const MODEL: Member<Choice<Model>> = Member {
    name: "model",
    about: "analytic (default): the published closed formulas, a circle in place of the cutter; envelope: the cutter's exact shape, a bound that holds, with an answer at every slope",
    kind: Choice { words: &[("analytic", Model::Analytic), ("envelope", Model::Envelope)] },
};
const RUNOUT: Member<RunoutKind> = Member {
    name: "runout",
    about: "how far the teeth run out; small against the feed per tooth. Absent = the cutter runs true",
    kind: RunoutKind,
};
const RADIAL: Member<Number> = Member {
    name: "radial_mm",
    about: "radial runout, by how much one tooth stands out further than the next; absent = 0",
    kind: Number { minimum: 0.0, maximum: Runout::LARGEST, example: 0.005 },
};
const AXIAL: Member<Number> = Member {
    name: "axial_mm",
    about: "axial runout, by how much one tooth stands lower than the next: positive it shortens, negative it lengthens the step between marks where the feed climbs; absent = 0",
    kind: Number { minimum: -Runout::LARGEST, maximum: Runout::LARGEST, example: 0.002 },
};
const STEP_OVER: Member<StatedLength> = Member {
    name: "step_over_mm",
    about: "step-over s along the surface, perpendicular to the feed; or give step_over_xy_mm",
    kind: StatedLength { example: 0.687 },
};
const STEP_OVER_XY: Member<StatedLength> = Member {
    name: "step_over_xy_mm",
    about: "step-over d between parallel vertical planes, seen from above; or give step_over_mm",
    kind: StatedLength { example: 0.65 },
};
const FEED_PER_TOOTH: Member<FeedKind> =
    Member { name: "feed_per_tooth_mm", about: "feed per tooth f_z, at least 1e-6; 0 or absent = no feed marks", kind: FeedKind };
const SURFACE_RADIUS: Member<SurfaceRadius> = Member {
    name: "surface_radius_mm",
    about: "the surface's radius of curvature across the feed: positive convex, negative concave, absent = plane; at least 1e-6 in magnitude",
    kind: SurfaceRadius,
};
/// The member of the calculations that keep a tolerance.
pub(super) const TOLERANCE: Member<StatedLength> =
    Member { name: "scallop_tolerance_mm", about: "the scallop height to keep", kind: StatedLength { example: 0.015 } };

struct RunoutKind;

impl Kind for RunoutKind {
    type Value = Runout;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Runout, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let (radial, axial) = (object.optional(&RADIAL, faults), object.optional(&AXIAL, faults));
        object.close(faults)?;
        let (radial, axial) = (radial?.unwrap_or(0.0), axial?.unwrap_or(0.0));
        in_range(Runout::NONE.with_radial_mm(radial).and_then(|runout| runout.with_axial_mm(axial)), raw, place, faults)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        ObjectSchema::new(about).optional(&RADIAL).optional(&AXIAL).build()
    }
}

/// A stated feed per tooth, which may be 0 and then stands for no marks, also where a default says otherwise.
#[derive(Debug, Clone, Copy)]
enum Feed {
    NoMarks,
    PerTooth(Length),
}

impl Feed {
    fn from_mm(feed: f64) -> Result<Self, OutOfRange> {
        if feed == 0.0 { Ok(Self::NoMarks) } else { Length::from_mm(feed).map(Self::PerTooth) }
    }
}

struct FeedKind;

impl Kind for FeedKind {
    type Value = Feed;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<Feed, Faulted> {
        in_range(Feed::from_mm(number(raw, place, faults)?), raw, place, faults)
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        Number { minimum: 0.0, maximum: Length::LARGEST, example: 0.3 }.schema(about)
    }
}

struct SurfaceRadius;

impl Kind for SurfaceRadius {
    type Value = SurfaceCurvature;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<SurfaceCurvature, Faulted> {
        let radius = number(raw, place, faults)?;
        SurfaceCurvature::from_radius_mm(radius).map_err(|bounds| {
            faults.add(
                &place,
                RequestFault::OutOfRange,
                format_args!("the radius without its sign {bounds}, found {raw}; leave the field out for a plane"),
            )
        })
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let largest = SurfaceCurvature::LARGEST_RADIUS;
        Number { minimum: -largest, maximum: largest, example: 120.0 }.schema(about)
    }
}

/// What holds for all contacts of a request.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    pub(crate) tool: StatedCutter,
    pub(crate) runout: Runout,
    pub(crate) model: Model,
}

impl Setup {
    pub(super) fn read(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let tool = object.required(&CUTTER, faults);
        let runout = object.optional(&RUNOUT, faults);
        let model = object.optional(&MODEL, faults);
        Ok(Self { tool: tool?, runout: runout?.unwrap_or(Runout::NONE), model: model?.unwrap_or_default() })
    }

    pub(super) fn describe(schema: ObjectSchema) -> ObjectSchema {
        schema.required(&CUTTER).optional(&RUNOUT).optional(&MODEL)
    }
}

/// Which terms a calculation's requests state.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stated {
    pub(crate) step_over: bool,
    pub(crate) feed_per_tooth: bool,
}

/// The terms as far as they are stated at one place of a request, each with the faults already recorded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Terms {
    pub(super) step_over: Result<Option<StepOver>, Faulted>,
    feed_per_tooth: Result<Option<Feed>, Faulted>,
    surface: Result<Option<SurfaceCurvature>, Faulted>,
}

impl Terms {
    /// Takes out of `object` the terms that a calculation states, all of them optional.
    pub(super) fn read(object: &mut Object<'_, '_>, stated: Stated, faults: &mut Faults) -> Self {
        let step_over = if stated.step_over { read_step_over(object, faults) } else { Ok(None) };
        let feed_per_tooth = if stated.feed_per_tooth { object.optional(&FEED_PER_TOOTH, faults) } else { Ok(None) };
        Self { step_over, feed_per_tooth, surface: object.optional(&SURFACE_RADIUS, faults) }
    }

    /// Terms of which none is faulty; `None` for a feed out of its range.
    pub(super) fn plain(step_over: Option<StepOver>, feed_per_tooth_mm: Option<f64>, surface: Option<SurfaceCurvature>) -> Option<Self> {
        let feed_per_tooth = feed_per_tooth_mm.map(Feed::from_mm).transpose().ok()?;
        Some(Self { step_over: Ok(step_over), feed_per_tooth: Ok(feed_per_tooth), surface: Ok(surface) })
    }

    /// These terms, and `others` where these say nothing.
    pub(super) fn or(self, others: Self) -> Self {
        Self {
            step_over: self.step_over.and_then(|stated| stated.map_or(others.step_over, |s| Ok(Some(s)))),
            feed_per_tooth: self.feed_per_tooth.and_then(|stated| stated.map_or(others.feed_per_tooth, |f| Ok(Some(f)))),
            surface: self.surface.and_then(|stated| stated.map_or(others.surface, |c| Ok(Some(c)))),
        }
    }

    /// The step-over, which has to be stated where the calculation states one.
    pub(super) fn step_over(&self, stated: Stated, place: &Place<'_>, faults: &mut Faults) -> Result<Option<StepOver>, Faulted> {
        match self.step_over? {
            None if stated.step_over => Err(faults.add(
                &place.member(STEP_OVER.name),
                RequestFault::MissingField,
                "give step_over_mm (along the surface) or step_over_xy_mm (seen from above)",
            )),
            step_over => Ok(step_over),
        }
    }

    pub(super) fn feed_per_tooth(&self) -> Result<Option<Length>, Faulted> {
        self.feed_per_tooth.map(|feed| match feed {
            Some(Feed::PerTooth(length)) => Some(length),
            Some(Feed::NoMarks) | None => None,
        })
    }

    pub(super) fn surface(&self) -> Result<SurfaceCurvature, Faulted> {
        self.surface.map(|surface| surface.unwrap_or(SurfaceCurvature::PLANE))
    }

    pub(super) fn describe(schema: ObjectSchema, stated: Stated) -> ObjectSchema {
        let schema = if stated.step_over { schema.optional(&STEP_OVER).optional(&STEP_OVER_XY) } else { schema };
        let schema = if stated.feed_per_tooth { schema.optional(&FEED_PER_TOOTH) } else { schema };
        schema.optional(&SURFACE_RADIUS)
    }
}

fn read_step_over(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Option<StepOver>, Faulted> {
    let (along, above) = (object.optional(&STEP_OVER, faults), object.optional(&STEP_OVER_XY, faults));
    match (along?, above?) {
        (Some(_), Some(_)) => Err(faults.add(
            &object.place().member(STEP_OVER_XY.name),
            RequestFault::ConflictingFields,
            "give step_over_mm or step_over_xy_mm, not both",
        )),
        (Some(s), None) => Ok(Some(StepOver::AlongSurface(s))),
        (None, Some(d)) => Ok(Some(StepOver::SeenFromAbove(d))),
        (None, None) => Ok(None),
    }
}

/// The wire name of a step-over in the form in which it was stated.
pub(super) fn step_over_member(step_over: Option<StepOver>) -> &'static str {
    match step_over {
        Some(StepOver::SeenFromAbove(_)) => STEP_OVER_XY.name,
        Some(StepOver::AlongSurface(_)) | None => STEP_OVER.name,
    }
}

/// The wire names of further members to which faults point.
pub(super) mod names {
    pub(in super::super) const FEED_PER_TOOTH: &str = super::FEED_PER_TOOTH.name;
    pub(in super::super) const SURFACE_RADIUS: &str = super::SURFACE_RADIUS.name;
    pub(in super::super) const RUNOUT: &str = super::RUNOUT.name;
    pub(in super::super) const TOLERANCE: &str = super::TOLERANCE.name;
}
