//! The tolerance of a plan by its two names, and the roughness of a drawing, which may stand in place of a scallop height.

use crate::http::codes::RequestFault;
use crate::http::reading::{Faulted, Faults, JsonPath, Member, Quantity, Renamed, at_most_one, members};
use crate::milling::{Roughness, RoughnessError};
use crate::quantity::{Length, OutOfRange};

/// The member `roughness`.
pub(crate) const ROUGHNESS: Member<RoughnessKind> = Member::new(
    "roughness",
    "in place of the scallop height: the roughness that the geometry of the surface must keep, as Ra or Rz",
    RoughnessKind,
);

members! {
    /// The members of a roughness.
    pub(crate) struct RoughnessMembers for RoughnessKind ("Roughness", "The roughness of a drawing: Ra or Rz. A profile of equal arcs of the height h has Rz = h and Ra = 0.2566 h") -> Roughness {
        ra: optional RA: Quantity<f64> = ("ra_um", Quantity::new(micrometres, 0.8), "Ra, the arithmetic mean deviation, in um; or give rz_um"),
        rz: optional RZ: Quantity<f64> = ("rz_um", Quantity::new(micrometres, 3.2), "Rz, the height of the profile, in um; or give ra_um"),
        allowance: optional ALLOWANCE: Quantity<f64> = ("allowance", Quantity::new(allowance, 2.0),
            "how much rougher the real surface is than its geometry, by vibration, wear and built-up edges: handbooks say 1.5 to 3; absent = 1"),
    }
}

fn micrometres(value: f64) -> Result<f64, OutOfRange> {
    OutOfRange::check(value, 1e-3, 1e4)
}

fn allowance(value: f64) -> Result<f64, OutOfRange> {
    OutOfRange::check(value, 1.0, 100.0)
}

impl RoughnessMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<Roughness, Faulted> {
        let (ra, rz, allowance) = (self.ra?, self.rz?, self.allowance?.unwrap_or(1.0));
        let roughness = match (ra, rz) {
            (Some(ra), None) => Roughness::from_ra_um(ra, allowance),
            (None, Some(rz)) => Roughness::from_rz_um(rz, allowance),
            (Some(_), Some(_)) => return Err(faults.add(path, RequestFault::ConflictingFields, "give ra_um or rz_um")),
            (None, None) => return Err(faults.add(path, RequestFault::MissingField, "give ra_um or rz_um")),
        };
        let of_error = |error: RoughnessError, faults: &mut Faults| faults.add(path, RequestFault::OutOfRange, error);
        let height = roughness.map_err(|error| of_error(error, faults))?;
        // The smallest roughness with a large allowance is less than the smallest length.
        match Length::from_mm(height.scallop_height().mm()) {
            Ok(_) => Ok(height),
            Err(bounds) => Err(faults.add(path, RequestFault::OutOfRange, format_args!("as a height in mm it {bounds}"))),
        }
    }
}

/// The name that the tolerance of plans had at first.
pub(crate) const SCALLOP_HEIGHT: Member<Renamed<Length>> = Member::new(
    "scallop_height_mm",
    "the older name of scallop_tolerance_mm, which is accepted as before",
    Renamed(Quantity::length(0.01)),
);

/// A tolerance, and the name of the member that states it.
pub(crate) struct StatedTolerance {
    pub(crate) height: Length,
    pub(crate) name: &'static str,
}

/// The tolerance of a plan at `path`, as the member `name`, by its older name, or as a roughness.
pub(crate) fn plan_tolerance(
    tolerance: Result<Option<Length>, Faulted>,
    older: Result<Option<Length>, Faulted>,
    roughness: Result<Option<Roughness>, Faulted>,
    member: &Member<Quantity<Length>>,
    path: &JsonPath<'_>,
    faults: &mut Faults,
) -> Result<StatedTolerance, Faulted> {
    let name = match (&older, &roughness) {
        (Ok(Some(_)), _) => SCALLOP_HEIGHT.name,
        (_, Ok(Some(_))) => ROUGHNESS.name,
        _ => member.name,
    };
    let tolerance = at_most_one(tolerance, older).unwrap_or_else(|| {
        let detail = format_args!("{} is the older name of {}; give one of them", SCALLOP_HEIGHT.name, member.name);
        Err(faults.add(&path.member(SCALLOP_HEIGHT.name), RequestFault::ConflictingFields, detail))
    });
    stated_height(tolerance, roughness, member, path, faults).map(|height| StatedTolerance { height, name })
}

/// The height of an object at `path` that states it as the member `name`, or as a roughness.
pub(crate) fn stated_height(
    height: Result<Option<Length>, Faulted>,
    roughness: Result<Option<Roughness>, Faulted>,
    member: &Member<Quantity<Length>>,
    path: &JsonPath<'_>,
    faults: &mut Faults,
) -> Result<Length, Faulted> {
    match (height?, roughness?) {
        (Some(height), None) => Ok(height),
        (None, Some(roughness)) => Ok(roughness.scallop_height()),
        (Some(_), Some(_)) => {
            let detail = format_args!("{} and {} exclude each other", member.name, ROUGHNESS.name);
            Err(faults.add(&path.member(ROUGHNESS.name), RequestFault::ConflictingFields, detail))
        }
        (None, None) => {
            let detail = format_args!("{} is missing: {}; or give {}", member.name, member.about, ROUGHNESS.name);
            Err(faults.add(&path.member(member.name), RequestFault::MissingField, detail))
        }
    }
}
