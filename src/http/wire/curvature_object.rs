//! The curvature of the surface at a contact: a radius across the feed, or the full curvature in one of two forms.

use crate::http::codes::RequestFault;
use crate::http::reading::{
    AddMembers, AnyMember, Components, Faulted, Faults, Form, JsonPath, Kind, Members, NumberPair, Object, Quantity, at_most_one, members,
};
use crate::milling::{CurvatureOutOfRange, SurfaceCurvature};
use crate::quantity::{Angle, OutOfRange};
use serde_json::value::RawValue;
use utoipa::openapi::{RefOr, Schema};

const RADIUS: Quantity<SurfaceCurvature> = Quantity::new(SurfaceCurvature::from_radius_mm, 120.0)
    .down_to(-SurfaceCurvature::LARGEST_RADIUS, "; the bounds are those of its magnitude; leave the field out for a plane");

const fn per_mm(example: f64) -> Quantity<f64> {
    Quantity::new(|value| OutOfRange::check(value, -SurfaceCurvature::LARGEST_PER_MM, SurfaceCurvature::LARGEST_PER_MM), example)
}

members! {
    /// The members for the curvature, of which at most one may be given.
    pub(super) struct CurvatureMembers {
        radius: optional SURFACE_RADIUS: Quantity<SurfaceCurvature> = ("surface_radius_mm", RADIUS,
            "the surface's radius of curvature across the feed: positive convex, negative concave, at least 1e-6 in magnitude, absent = plane; along the feed the surface is straight; or give surface_curvature"),
        curvature: optional SURFACE_CURVATURE: CurvatureKind = ("surface_curvature", CurvatureKind,
            "the surface's curvature in every direction; absent = plane; or give surface_radius_mm"),
    }
}
members! {
    /// A curvature by its components in the axes of the feed.
    pub(super) struct ComponentMembers {
        along: optional ALONG: Quantity<f64> = ("along_per_mm", per_mm(-0.004),
            "1/radius along the feed: positive convex, negative concave; absent = 0"),
        across: optional ACROSS: Quantity<f64> = ("across_per_mm", per_mm(0.01),
            "1/radius across the feed: positive convex, negative concave; absent = 0"),
        twist: optional TWIST: Quantity<f64> = ("twist_per_mm", per_mm(0.001),
            "the twist k_FT; the axis across points to the left of the feed seen from outside; absent = 0"),
    }
}
members! {
    /// A curvature by its principal curvatures.
    pub(super) struct PrincipalMembers {
        principal: required PRINCIPAL: NumberPair = ("principal_per_mm", NumberPair { of: per_mm(0.012), example: [0.012, -0.005] },
            "the two principal curvatures, 1/radius: positive convex, negative concave"),
        angle: required PRINCIPAL_ANGLE: Quantity<Angle> = ("angle_deg", Quantity::new(Angle::from_degrees, 30.0),
            "angle from the feed to the first principal direction, counter-clockwise seen from outside"),
    }
}

/// A curvature, and the member that states it, to which faults of the curvature point.
#[derive(Debug, Clone, Copy)]
pub(super) struct StatedCurvature {
    pub(super) curvature: SurfaceCurvature,
    pub(super) member: &'static str,
}

impl CurvatureMembers {
    /// The curvature, if one is given.
    pub(super) fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Option<StatedCurvature>, Faulted> {
        let of = |member: &'static str| move |curvature: SurfaceCurvature| StatedCurvature { curvature, member };
        let by_radius = self.radius.map(|stated| stated.map(of(SURFACE_RADIUS.name)));
        let curvature = self.curvature.map(|stated| stated.map(of(SURFACE_CURVATURE.name)));
        at_most_one(by_radius, curvature).unwrap_or_else(|| {
            let detail = "give surface_radius_mm or surface_curvature, not both";
            Err(faults.add(&path.member(SURFACE_CURVATURE.name), RequestFault::ConflictingFields, detail))
        })
    }
}

/// The object of a curvature, in one of two forms.
#[derive(Debug)]
pub(super) struct CurvatureKind;

impl ComponentMembers {
    fn curvature(&self) -> Result<Result<SurfaceCurvature, CurvatureOutOfRange>, Faulted> {
        let [along, across, twist] = [self.along?, self.across?, self.twist?].map(|component| component.unwrap_or(0.0));
        Ok(SurfaceCurvature::from_components_per_mm(along, across, twist))
    }
}

impl PrincipalMembers {
    fn curvature(&self) -> Result<Result<SurfaceCurvature, CurvatureOutOfRange>, Faulted> {
        Ok(SurfaceCurvature::from_principal_per_mm(self.principal?, self.angle?))
    }
}

impl Kind for CurvatureKind {
    type Value = SurfaceCurvature;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<SurfaceCurvature, Faulted> {
        let curvature = Object::open(raw, path, faults)?.read(faults, |object, faults| {
            if !object.has_any_of::<PrincipalMembers>() {
                return ComponentMembers::read(object, faults).curvature();
            }
            let forms = "give along_per_mm, across_per_mm and twist_per_mm, or principal_per_mm and angle_deg";
            match object.one_of::<PrincipalMembers, ComponentMembers>(forms, faults)? {
                Form::First(principal) => principal.curvature(),
                Form::Second(components) => components.curvature(),
            }
        })?;
        curvature.map_err(|error| faults.add(&path, RequestFault::OutOfRange, error))
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let forms: [(_, _, AddMembers<'_>); 2] = [
            ("CurvatureComponents", "A curvature by its components along and across the feed", &ComponentMembers::describe),
            ("PrincipalCurvatures", "A curvature by its principal curvatures", &PrincipalMembers::describe),
        ];
        let union = "The surface's curvature at a contact, in one of two forms";
        components.refer("SurfaceCurvature", about, |components| components.one_of(union, &forms).into())
    }

    fn columns(&self) -> Option<Vec<&'static dyn AnyMember>> {
        Some(ComponentMembers::DECLARED.iter().chain(PrincipalMembers::DECLARED).map(|declared| declared.member).collect())
    }

    fn column_schema(&self, about: &str, most: usize, components: &mut Components) -> RefOr<Schema> {
        let columns = "Columns of curvatures, each contact in one of two forms";
        let members = self.columns().unwrap_or_default();
        components.refer_object("SurfaceCurvatureColumns", about, columns, &|schema| schema.with_columns(members.iter().copied(), most))
    }
}
