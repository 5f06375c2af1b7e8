//! The wire form of a machine: a preset's name, its three limits, or a preset with some of them overridden.

use super::bounded::Bounded;
use crate::http::codes::RequestFault;
use crate::http::reading::member::text;
use crate::http::reading::{Faulted, Faults, Kind, Member, Object, ObjectSchema, Place};
use crate::motion::{MachineLimits, PRESETS, Preset};
use crate::quantity::{Acceleration, Jerk, Speed};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The member `machine`.
pub(super) const MACHINE: Member<Machine> = Member {
    name: "machine",
    about: "the machine: a preset's name, or all three limits; limits beside a preset override its own",
    kind: Machine,
};
const PRESET: Member<PresetName> = Member { name: "preset", about: "the name of a machine that GET /v1/machines lists", kind: PresetName };
const FEED_RATE: Member<Bounded<Speed>> = Member {
    name: "feed_rate_mm_min",
    about: "V, the programmed feed rate in mm/min",
    kind: Bounded { minimum: Speed::SMALLEST, maximum: Speed::LARGEST, example: 5000.0, of: Speed::from_mm_min },
};
const ACCELERATION: Member<Bounded<Acceleration>> = Member {
    name: "acceleration_m_s2",
    about: "A, the largest acceleration along the path, in m/s^2",
    kind: Bounded { minimum: Acceleration::SMALLEST, maximum: Acceleration::LARGEST, example: 6.0, of: Acceleration::from_m_s2 },
};
const JERK: Member<Bounded<Jerk>> = Member {
    name: "jerk_m_s3",
    about: "J, the largest jerk along the path, in m/s^3",
    kind: Bounded { minimum: Jerk::SMALLEST, maximum: Jerk::LARGEST, example: 40.0, of: Jerk::from_m_s3 },
};

/// A preset, limits, or both.
pub(super) struct Machine;

impl Kind for Machine {
    type Value = MachineLimits;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<MachineLimits, Faulted> {
        let mut object = Object::open(raw, place, faults)?;
        let preset = object.optional(&PRESET, faults);
        let of_preset = preset.map(|preset| preset.map(|preset| preset.limits));
        let feed_rate = limit(&mut object, &FEED_RATE, of_preset.map(|limits| limits.map(|limits| limits.feed_rate)), faults);
        let acceleration = limit(&mut object, &ACCELERATION, of_preset.map(|limits| limits.map(|limits| limits.acceleration)), faults);
        let jerk = limit(&mut object, &JERK, of_preset.map(|limits| limits.map(|limits| limits.jerk)), faults);
        object.close(faults)?;
        of_preset?;
        Ok(MachineLimits { feed_rate: feed_rate?, acceleration: acceleration?, jerk: jerk? })
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        ObjectSchema::new(about).optional(&PRESET).optional(&FEED_RATE).optional(&ACCELERATION).optional(&JERK).build()
    }
}

/// One limit: as stated, else the preset's. Where a preset is named that nobody knows, the limit may well be meant to come from it.
fn limit<T>(
    object: &mut Object<'_, '_>,
    member: &Member<Bounded<T>>,
    of_preset: Result<Option<T>, Faulted>,
    faults: &mut Faults,
) -> Result<T, Faulted> {
    if let Some(stated) = object.optional(member, faults)? {
        return Ok(stated);
    }
    of_preset?.ok_or_else(|| {
        let detail = format_args!("the field is missing: {}; or name a preset, which has a value for it", member.about);
        faults.add(&object.place().member(member.name), RequestFault::MissingField, detail)
    })
}

/// The name of a preset.
struct PresetName;

impl Kind for PresetName {
    type Value = &'static Preset;

    fn read(&self, raw: &RawValue, place: Place<'_>, faults: &mut Faults) -> Result<&'static Preset, Faulted> {
        let name = text(raw, place, faults)?;
        Preset::named(&name).ok_or_else(|| {
            let known = PRESETS.map(|preset| preset.name).join(", ");
            faults.add(&place, RequestFault::UnknownValue, format_args!("there is no such preset; known are {known}"))
        })
    }

    fn schema(&self, about: &str) -> RefOr<Schema> {
        let names = PRESETS.map(|preset| preset.name);
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about)).examples(["five_axis_vmc"]);
        schema.enum_values(Some(names)).into()
    }
}
