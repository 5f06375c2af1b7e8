//! The surface's curvature at a contact.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, PlainKind, members, number};
use crate::milling::SurfaceCurvature;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

pub(super) const SURFACE_RADIUS: Member<SurfaceRadius> = Member {
    name: "surface_radius_mm",
    about: "the surface's radius of curvature across the feed: positive convex, negative concave, absent = plane; at least 1e-6 in magnitude",
    kind: SurfaceRadius,
};

members! {
    /// The members of a curvature.
    pub(super) plain struct CurvatureMembers / CurvatureSlots {
        radius: optional SURFACE_RADIUS: SurfaceRadius,
    }
}

/// A radius with the sign of the curvature.
pub(super) struct SurfaceRadius;

impl Kind for SurfaceRadius {
    type Value = SurfaceCurvature;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<SurfaceCurvature, Faulted> {
        let radius = number(raw, path, faults)?;
        SurfaceCurvature::from_radius_mm(radius).map_err(|bounds| {
            let detail = format_args!("the radius without its sign {bounds}, found {raw}; leave the field out for a plane");
            faults.add(&path, RequestFault::OutOfRange, detail)
        })
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let largest = SurfaceCurvature::LARGEST_RADIUS;
        let schema = ObjectBuilder::new().schema_type(Type::Number).description(Some(about)).examples([120.0]);
        schema.minimum(Some(-largest)).maximum(Some(largest)).into()
    }
}

impl PlainKind for SurfaceRadius {
    type Plain = f64;

    fn accept(&self, plain: f64) -> Option<SurfaceCurvature> {
        SurfaceCurvature::from_radius_mm(plain).ok()
    }
}
