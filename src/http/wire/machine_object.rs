//! The machine of a request: a preset's name, or an object with a preset, the three limits, or a preset with some limits
//! overridden. Rapid rate, spindle speed and clearance are optional.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, Members, Quantity, members, text};
use crate::motion::{self, MachineLimits, PRESETS, Preset};
use crate::quantity::{Acceleration, Jerk, Length, OutOfRange, Speed, SpindleSpeed, Time};
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The member `machine`.
pub(crate) const MACHINE: Member<MachineKind> =
    Member::new("machine", "the machine: a preset's name, or all three limits; limits beside a preset override its own", MachineKind);

members! {
    /// The members of a machine.
    pub(crate) struct MachineMembers for MachineObject ("Machine", "A machine: a preset's name, or all three limits; limits beside a preset override its own") -> motion::Machine {
        preset: optional PRESET: PresetName = ("preset", PresetName, "the name of a machine that GET /v1/machines lists"),
        feed_rate: optional FEED_RATE: Quantity<Speed> = ("feed_rate_mm_min", Quantity::new(Speed::from_mm_min, 5000.0),
            "V, the programmed feed rate in mm/min"),
        acceleration: optional ACCELERATION: Quantity<Acceleration> = ("acceleration_m_s2", Quantity::new(Acceleration::from_m_s2, 6.0),
            "A, the largest acceleration along the path, in m/s^2"),
        jerk: optional JERK: Quantity<Jerk> = ("jerk_m_s3", Quantity::new(Jerk::from_m_s3, 40.0),
            "J, the largest jerk along the path, in m/s^3"),
        rapid_rate: optional RAPID_RATE: Quantity<Speed> = ("rapid_rate_mm_min", Quantity::new(Speed::from_mm_min, 20_000.0),
            "the rate of moves that do not cut, in mm/min; absent = the feed rate"),
        max_spindle_speed: optional MAX_SPINDLE_SPEED: Quantity<SpindleSpeed> = ("max_spindle_speed_rpm", Quantity::new(SpindleSpeed::from_rpm, 18_000.0),
            "the largest spindle speed; cutters with a higher spindle_speed_rpm run at this one"),
        clearance_height: optional CLEARANCE_HEIGHT: Quantity<Length> = ("clearance_height_mm", Quantity::length(5.0),
            "the height over the highest point of the surface at which rapid moves cross it; absent = 5"),
        path_tolerance: optional PATH_TOLERANCE: Quantity<Length> = ("path_tolerance_mm", Quantity::length(0.01),
            "the tolerance within which the control rounds corners as it looks ahead; absent = it stops at the ends of every run and link"),
        time_factor: optional TIME_FACTOR: Quantity<f64> = ("time_factor", Quantity::new(time_factor, 1.1),
            "what multiplies every time of the answer, those of tool changes too: the measured time of a program over the one stated here; absent = 1"),
        tool_change: optional TOOL_CHANGE: Quantity<Time> = ("tool_change_s", Quantity::new(Time::from_s, 10.0),
            "the time of a tool change, which time_factor multiplies too; absent = 10"),
    }
}

/// A machine: the name of a preset, or an object.
pub(crate) struct MachineKind;

impl Kind for MachineKind {
    type Value = motion::Machine;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<motion::Machine, Faulted> {
        if raw.get().starts_with('"') {
            // Members that stand beside the preset belong in an object.
            faults.object_knows(&path, MachineMembers::names().collect());
            return PresetName.read(raw, path, faults).map(|preset| preset.limits.into());
        }
        MachineObject.read(raw, path, faults)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        components.refer("MachineOrName", about, |components| {
            let forms = OneOfBuilder::new().description(Some(MACHINE.about));
            let forms = forms.item(PresetName.schema("", components));
            forms.item(MachineObject.schema("", components)).into()
        })
    }
}

impl MachineMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<motion::Machine, Faulted> {
        let preset = self.preset.map(|preset| preset.map(|preset| preset.limits));
        let feed_rate = limit(&FEED_RATE, self.feed_rate, preset, |limits| limits.feed_rate, path, faults);
        let acceleration = limit(&ACCELERATION, self.acceleration, preset, |limits| limits.acceleration, path, faults);
        let jerk = limit(&JERK, self.jerk, preset, |limits| limits.jerk, path, faults);
        preset?;
        let (rapid_rate, max_spindle_speed, clearance_height) = (self.rapid_rate, self.max_spindle_speed, self.clearance_height);
        let (path_tolerance, time_factor, tool_change) = (self.path_tolerance, self.time_factor, self.tool_change);
        let machine = motion::Machine::from(MachineLimits { feed_rate: feed_rate?, acceleration: acceleration?, jerk: jerk? });
        Ok(motion::Machine {
            rapid_rate: rapid_rate?.unwrap_or(machine.rapid_rate),
            max_spindle_speed: max_spindle_speed?.or(machine.max_spindle_speed),
            clearance_height: clearance_height?.unwrap_or(machine.clearance_height),
            path_tolerance: path_tolerance?,
            time_factor: time_factor?.unwrap_or(machine.time_factor),
            tool_change: tool_change?.unwrap_or(machine.tool_change),
            limits: machine.limits,
        })
    }
}

fn time_factor(value: f64) -> Result<f64, OutOfRange> {
    OutOfRange::check(value, 0.1, 10.0)
}

/// One limit: the stated one, otherwise the preset's. If the preset has a fault, a missing limit is not another fault.
fn limit<T>(
    member: &Member<Quantity<T>>,
    stated: Result<Option<T>, Faulted>,
    preset: Result<Option<MachineLimits>, Faulted>,
    of_preset: fn(MachineLimits) -> T,
    path: &JsonPath<'_>,
    faults: &mut Faults,
) -> Result<T, Faulted> {
    if let Some(stated) = stated? {
        return Ok(stated);
    }
    preset?.map(of_preset).ok_or_else(|| {
        let detail = format_args!("the field is missing: {}; or name a preset, which has a value for it", member.about);
        faults.add(&path.member(member.name), RequestFault::MissingField, detail)
    })
}

/// The name of a preset.
pub(crate) struct PresetName;

impl Kind for PresetName {
    type Value = &'static Preset;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<&'static Preset, Faulted> {
        let name = text(raw, path, faults)?;
        Preset::named(&name).ok_or_else(|| {
            let known = PRESETS.map(|preset| preset.name).join(", ");
            faults.add(&path, RequestFault::UnknownValue, format_args!("there is no such preset; known are {known}"))
        })
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let names = PRESETS.map(|preset| preset.name);
        components.refer("PresetName", about, |_| ObjectBuilder::new().schema_type(Type::String).enum_values(Some(names)).into())
    }
}
