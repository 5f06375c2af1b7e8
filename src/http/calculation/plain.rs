//! The short way to read a contact of a batch: nothing but known fields with numbers in their ranges, as nearly all are. Whatever else
//! there is, this way has no answer, and the way over an [`Object`](crate::http::reading::Object) finds the faults and their places.

use super::contact::StatedContact;
use super::terms::{Stated, Terms};
use crate::milling::{Contact, StepOver, SurfaceCurvature};
use crate::quantity::Length;
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

/// The fields of a contact in either form, and of the terms that it may override.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct Fields {
    #[serde(deserialize_with = "not_null")]
    slope_deg: Option<f64>,
    #[serde(deserialize_with = "not_null")]
    feed_angle_deg: Option<f64>,
    #[serde(deserialize_with = "not_null")]
    normal: Option<[f64; 3]>,
    #[serde(deserialize_with = "not_null")]
    feed: Option<[f64; 3]>,
    #[serde(deserialize_with = "not_null")]
    step_over_mm: Option<f64>,
    #[serde(deserialize_with = "not_null")]
    step_over_xy_mm: Option<f64>,
    #[serde(deserialize_with = "not_null")]
    feed_per_tooth_mm: Option<f64>,
    #[serde(deserialize_with = "not_null")]
    surface_radius_mm: Option<f64>,
}

/// A field that is there has a value: null is a fault, not an absence.
fn not_null<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    T::deserialize(deserializer).map(Some)
}

/// The contact and the terms that it states, if it is plain.
pub(super) fn read(raw: &RawValue, stated: Stated) -> Option<(StatedContact, Terms)> {
    // An array would be read as the fields in their order.
    let object = raw.get().starts_with('{').then_some(raw.get())?;
    let fields: Fields = serde_json::from_str(object).ok()?;
    let contact = match (fields.slope_deg, fields.feed_angle_deg, fields.normal, fields.feed) {
        (Some(slope), Some(angle), None, None) => StatedContact::by_angles(Contact::from_degrees(slope, angle).ok()?),
        (None, None, Some(normal), Some(feed)) => StatedContact::by_vectors(Contact::from_vectors(normal, feed, None).ok()?),
        _ => return None,
    };
    let step_over = match (fields.step_over_mm, fields.step_over_xy_mm) {
        (None, None) => None,
        (Some(s), None) if stated.step_over => Some(StepOver::AlongSurface(Length::from_mm(s).ok()?)),
        (None, Some(d)) if stated.step_over => Some(StepOver::SeenFromAbove(Length::from_mm(d).ok()?)),
        _ => return None,
    };
    if fields.feed_per_tooth_mm.is_some() && !stated.feed_per_tooth {
        return None;
    }
    let surface = fields.surface_radius_mm.map(SurfaceCurvature::from_radius_mm).transpose().ok()?;
    Some((contact, Terms::plain(step_over, fields.feed_per_tooth_mm, surface)?))
}

#[cfg(test)]
mod tests {
    use super::super::contact;
    use super::*;
    use crate::http::reading::{Faults, Object, Place};

    const ALL: Stated = Stated { step_over: true, feed_per_tooth: true };
    const NONE: Stated = Stated { step_over: false, feed_per_tooth: false };

    /// What both ways make of a contact; the long one has an answer where it finds no fault.
    fn both(text: &str, stated: Stated) -> [Option<String>; 2] {
        let raw: &RawValue = serde_json::from_str(text).unwrap();
        let mut faults = Faults::default();
        let long = Object::open(raw, Place::Root, &mut faults).and_then(|mut object| {
            let contact = contact::read(&mut object, &mut faults);
            let terms = Terms::read(&mut object, stated, &mut faults);
            object.close(&mut faults)?;
            Ok((contact?, terms))
        });
        let long = long.ok().filter(|_| faults.is_empty());
        [read(raw, stated), long].map(|read| read.map(|read| format!("{read:?}")))
    }

    #[test]
    fn the_short_way_reads_what_the_long_way_reads() {
        for text in [
            r#"{"slope_deg":40,"feed_angle_deg":-1e3}"#,
            r#"{"feed_angle_deg":359.123456,"slope_deg":0}"#,
            r#"{"normal":[-0.64,0,0.77],"feed":[1,0,0.84]}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_mm":0.687,"feed_per_tooth_mm":0}"#,
            r#"{"slope_deg":40,"feed_angle_deg":30,"step_over_xy_mm":0.65,"feed_per_tooth_mm":0.3,"surface_radius_mm":-120}"#,
        ] {
            let [short, long] = both(text, ALL);
            assert!(short.is_some(), "{text}");
            assert_eq!(short, long, "{text}");
        }
    }

    #[test]
    fn the_short_way_leaves_every_fault_to_the_long_way() {
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
            ("[40, 30]", ALL),
        ] {
            assert_eq!(both(text, stated), [None, None], "{text}");
        }
    }
}
