//! A contact of a batch, with its own parameters. A contact without faults is parsed in one pass directly into numbers.
//! If that fails, the contact is read again by the reader that collects faults.

use super::contact::{self, FormSlots, StatedContact};
use super::parameters::{ContactParameters, ParameterSlots, StatedParameters};
use crate::http::reading::{Components, Faulted, Faults, Object, Slots};
use crate::json_text::{JsonPath, JsonText, PlainJson, Unusual};
use utoipa::openapi::{RefOr, Schema};

/// A contact and its own parameters.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BatchContact {
    pub(crate) contact: StatedContact,
    pub(crate) parameters: ContactParameters,
}

impl BatchContact {
    /// Reads a contact whose own parameters override `defaults`.
    pub(crate) fn read(raw: JsonText<'_>, defaults: &ContactParameters, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let plain = Self::read_plain(&mut PlainJson::new(raw.get().as_bytes()), defaults);
        plain.map_or_else(|| Self::read_faulty(raw, defaults, path, faults), Ok)
    }

    /// Reads the next contact of `json`, whose syntax has not been checked. The outer error means that no JSON value
    /// follows, or that only the general reader can read it.
    #[inline]
    pub(crate) fn read_next(
        json: &mut PlainJson<'_>,
        defaults: &ContactParameters,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Result<Self, Faulted>, Unusual> {
        json.skip_blank();
        let first = json.position();
        if let Some(plain) = Self::read_plain(json, defaults) {
            return Ok(Ok(plain));
        }
        json.seek(first);
        Ok(Self::read_faulty(json.value(&|| faults.is_cancelled())?, defaults, path, faults))
    }

    /// Reads a contact that cannot be read in one pass, and records all its faults.
    pub(super) fn read_faulty(
        raw: JsonText<'_>,
        defaults: &ContactParameters,
        path: JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let contact = contact::read(&mut object, faults);
        let parameters = ContactParameters::read(&mut object, defaults.stated, faults).or(defaults);
        object.close(faults)?;
        parameters.step_over(&path, faults)?;
        // The faults of the defaults are recorded with the request. A contact fails because of them only if it uses
        // them.
        if faults.is_empty() { Ok(Self { contact: contact?, parameters }) } else { Err(Faulted) }
    }

    /// The contact, or `None` if it cannot be read in one pass.
    #[inline]
    fn read_plain(json: &mut PlainJson<'_>, defaults: &ContactParameters) -> Option<Self> {
        let mut slots = ContactSlots::default();
        // Filled in place: the slots are large, and a result would copy them.
        json.object(|name, json| slots.fill(name, json)).ok()?;
        Self::accept(&slots, defaults)
    }

    /// The contact from its values, with `defaults` for the parameters that it does not state; `None` if there is a
    /// fault.
    #[inline]
    pub(super) fn accept((contact, parameters): &ContactSlots, defaults: &ContactParameters) -> Option<Self> {
        let contact = contact::accept(*contact)?;
        Some(Self { contact, parameters: ContactParameters::accept(parameters, defaults)? })
    }
}

/// The values of a contact's members.
pub(super) type ContactSlots = (FormSlots, ParameterSlots);

/// The schema of a contact with the parameters that `stated` allows.
pub(super) fn batch_contact_schemas(stated: StatedParameters, components: &mut Components) -> RefOr<Schema> {
    let names = ["AngleContact", "VectorContact"].map(|form| stated.name(form));
    contact::forms(names.each_ref().map(String::as_str), "A contact with its own parameters", components, &|schema| {
        ContactParameters::describe(schema, stated)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: StatedParameters = StatedParameters { step_over: true, feed_per_tooth: true };
    const NONE: StatedParameters = StatedParameters { step_over: false, feed_per_tooth: false };

    /// The results of the two readers, in one pass and with faults; `None` if there are faults.
    fn both(text: &str, stated: StatedParameters) -> [Option<String>; 2] {
        let raw = JsonText::known(text);
        let defaults = ContactParameters::with_step_over(stated);
        let slow = BatchContact::read_faulty(raw, &defaults, JsonPath::Root, &mut Faults::default()).ok();
        let plain = BatchContact::read_plain(&mut PlainJson::new(text.as_bytes()), &defaults);
        [plain, slow].map(|read| read.map(|read| format!("{read:?}")))
    }

    #[test]
    fn both_readers_agree_on_contacts_without_faults() {
        for text in [
            r#"{"slope_deg":40,"feed_angle_deg":-1e3}"#,
            r#"{"feed_angle_deg":359.123456,"slope_deg":0}"#,
            r#"{"normal":[-0.64,0,0.77],"feed":[1,0,0.84]}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":0.687,"feed_per_tooth_mm":0}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_xy_mm":0.65,"feed_per_tooth_mm":0.3,"surface_radius_mm":-120}"#,
            r#"{"normal":[-0.64,0,0.77],"feed":[1,0,0.84],"tool_axis":[0.1,0,0.99]}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{}}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"along_per_mm":-0.004,"across_per_mm":0.01,"twist_per_mm":0.001}}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"principal_per_mm":[0.012,-0.005],"angle_deg":30}}"#,
        ] {
            let [plain, slow] = both(text, ALL);
            assert!(plain.is_some(), "{text}");
            assert_eq!(plain, slow, "{text}");
        }
    }

    #[test]
    fn both_readers_refuse_contacts_with_faults() {
        for (text, stated) in [
            (r#"{"slope_deg":91,"feed_angle_deg":30}"#, ALL),
            (r#"{"slope_deg":"40","feed_angle_deg":30}"#, ALL),
            (r#"{"slope_deg":40,"slope_deg":40,"feed_angle_deg":30}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":1e999}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":null}"#, ALL),
            (r#"{"slope_deg":40}"#, ALL),
            (r#"{"normal":[0,0],"feed":[1,0,0]}"#, ALL),
            (r#"{"normal":[0,0,1,1],"feed":[1,0,0]}"#, ALL),
            (r#"{"normal":[0,0,1],"feed":[0,0,1]}"#, ALL),
            (r#"{"normal":[0,0,1],"feed":[1,0,0],"slope_deg":0}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":0}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":1,"step_over_xy_mm":1}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":1}"#, NONE),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_xy_mm":1}"#, NONE),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"feed_per_tooth_mm":1}"#, NONE),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"feed_per_tooth_mm":-0.1}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_radius_mm":0}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_radius_mm":null}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"slope":40}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"tool_axis":[0,0,1]}"#, ALL),
            (r#"{"normal":[0,0,1],"feed":[1,0,0],"tool_axis":[0,0,0]}"#, ALL),
            (r#"{"normal":[0,0,1],"feed":[1,0,0],"tool_axis":[0,0,-1]}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{},"surface_radius_mm":5}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"along_per_mm":1e7}}"#, ALL),
            (
                r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"along_per_mm":0.1,"angle_deg":0,"principal_per_mm":[0,0]}}"#,
                ALL,
            ),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"principal_per_mm":[0,0]}}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":{"principal_per_mm":[0],"angle_deg":0}}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":0.1}"#, ALL),
            (r#"{"slope_deg":40,"feed_angle_deg":30,"surface_curvature":null}"#, ALL),
            ("[40, 30]", ALL),
        ] {
            assert_eq!(both(text, stated), [None, None], "{text}");
        }
    }
}
