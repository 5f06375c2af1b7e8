//! The cutters to choose from, each with its drive if stated: teeth, spindle speed and the limit on the feed per tooth; and
//! which cutters of tool libraries join them.

use super::cutter_object::{KINDS, TEETH, kinds_schema, read_geometry};
use crate::http::codes::RequestFault;
use crate::http::reading::{
    Choice, Components, Faulted, Faults, JsonPath, Kind, List, Members, Object, Quantity, Whole, describe, members, text,
};
use crate::milling::CutterKind;
use crate::planning::plan::{CandidateCutter, Drive};
use crate::quantity::{Length, SpindleSpeed};
use crate::tooling::LibraryTool;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The largest number of cutters in a request, including those of its tool libraries.
pub(crate) const MOST_CUTTERS: usize = 200;

/// A cutter to choose from, with its name if it has one.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NamedCandidate {
    pub(crate) name: Option<String>,
    /// The preset of a tool library from which speed and feed were taken.
    pub(crate) preset: Option<String>,
    pub(crate) candidate: CandidateCutter,
    /// The stated members of the drive that have no effect, because the drive is incomplete.
    pub(crate) idle: Vec<&'static str>,
    /// The number of teeth and the limit on the feed per tooth, also of a cutter without spindle speed.
    pub(crate) teeth: Option<u32>,
    pub(crate) max_feed_per_tooth: Option<Length>,
}

impl From<LibraryTool> for NamedCandidate {
    fn from(tool: LibraryTool) -> Self {
        // Spindle speeds of libraries are within the bounds, except speeds under 0.001 rpm.
        let spindle_speed = tool.spindle_speed_rpm.and_then(|rpm| SpindleSpeed::from_rpm(rpm).ok());
        let drive = drive(tool.teeth, spindle_speed, tool.max_feed_per_tooth);
        let candidate = CandidateCutter { drive, flute_length: tool.flute_length, ..CandidateCutter::new(tool.cutter) };
        let LibraryTool { teeth, max_feed_per_tooth, .. } = tool;
        Self { name: Some(tool.name), preset: tool.preset, candidate, teeth, max_feed_per_tooth, idle: Vec::new() }
    }
}

/// The drive of a cutter that states teeth and spindle speed.
fn drive(teeth: Option<u32>, spindle_speed: Option<SpindleSpeed>, max_feed_per_tooth: Option<Length>) -> Option<Drive> {
    teeth.zip(spindle_speed).map(|(teeth, spindle_speed)| Drive { teeth, spindle_speed, max_feed_per_tooth })
}

members! {
    /// The optional members of a candidate, without its geometry.
    pub(crate) struct CandidateMembers {
        name: optional NAME: Name = ("name", Name, "a name for the cutter, which the answer repeats"),
        teeth: optional TEETH: Whole,
        spindle_speed: optional SPINDLE_SPEED: Quantity<SpindleSpeed> = ("spindle_speed_rpm", Quantity::new(SpindleSpeed::from_rpm, 10_000.0),
            "n, the spindle speed; with teeth, the scallop height includes the tooth marks, and step-over and feed are chosen together"),
        max_feed_per_tooth: optional MAX_FEED_PER_TOOTH: Quantity<Length> = ("max_feed_per_tooth_mm", Quantity::length(0.12),
            "the manufacturer's limit on the feed per tooth; used if teeth and spindle_speed_rpm are given"),
        flute_length: optional FLUTE_LENGTH: Quantity<Length> = ("flute_length_mm", Quantity::length(22.0),
            "the length of the flutes; the answer has a warning if the surface is deeper than this"),
    }
}

/// A cutter to choose from, discriminated by `type`.
pub(crate) struct CandidateKind;

impl Kind for CandidateKind {
    type Value = NamedCandidate;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<NamedCandidate, Faulted> {
        let mut object = Object::open(raw, path, faults)?;
        let cutter = read_geometry(&mut object, faults);
        let members = CandidateMembers::read(&mut object, faults);
        object.close(faults)?;
        let CandidateMembers { name, teeth, spindle_speed, max_feed_per_tooth, flute_length } = members;
        let (teeth, spindle_speed, max_feed_per_tooth) = (teeth?, spindle_speed?, max_feed_per_tooth?);
        let drive = drive(teeth, spindle_speed, max_feed_per_tooth);
        let stated = [
            (TEETH.name, teeth.is_some()),
            (SPINDLE_SPEED.name, spindle_speed.is_some()),
            (MAX_FEED_PER_TOOTH.name, max_feed_per_tooth.is_some()),
        ];
        let idle = stated.into_iter().filter(|(_, is_stated)| *is_stated && drive.is_none()).map(|(name, _)| name).collect();
        let candidate = CandidateCutter { drive, flute_length: flute_length?, ..CandidateCutter::new(cutter?) };
        Ok(NamedCandidate { name: name?, preset: None, candidate, teeth, max_feed_per_tooth, idle })
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        const ABOUT: &str = "A cutter to choose from, one of eight kinds, discriminated by type";
        kinds_schema(("CandidateCutter", ABOUT), |shape| shape.names[1], &CandidateMembers::describe, about, components)
    }
}

/// A text of 1 to [`Name::LONGEST`] characters.
pub(crate) struct Name;

impl Name {
    const LONGEST: usize = 100;
}

impl Kind for Name {
    type Value = String;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<String, Faulted> {
        let name = text(raw, path, faults)?;
        if (1..=Self::LONGEST).contains(&name.chars().count()) {
            return Ok(name);
        }
        let detail = format_args!("a name must have 1 to {} characters, found {}", Self::LONGEST, describe(raw));
        Err(faults.add(&path, RequestFault::OutOfRange, detail))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about));
        schema.min_length(Some(1)).max_length(Some(Self::LONGEST)).examples(["T3"]).into()
    }
}

/// Conditions on cutters of libraries; an absent one holds for all.
#[derive(Debug, Default)]
pub(crate) struct LibraryFilter {
    /// The smallest and the largest diameter.
    diameters: Option<[Length; 2]>,
    types: Option<Vec<CutterKind>>,
    numbers: Option<Vec<u32>>,
}

impl LibraryFilter {
    /// Whether a cutter meets all conditions. One without a number meets no list of numbers.
    pub(crate) fn admits(&self, tool: &LibraryTool) -> bool {
        let diameter = 2.0 * tool.cutter.outer_radius().mm();
        // Diameters in inches are converted, so that the bounds may differ by a rounding.
        let is_between = |[least, most]: [Length; 2]| (least.mm() * (1.0 - 1e-9)..=most.mm() * (1.0 + 1e-9)).contains(&diameter);
        self.diameters.is_none_or(is_between)
            && self.types.as_ref().is_none_or(|types| types.contains(&tool.cutter.kind()))
            && self.numbers.as_ref().is_none_or(|numbers| tool.number.is_some_and(|number| numbers.contains(&number)))
    }
}

members! {
    /// The members of a filter.
    pub(crate) struct FilterMembers for LibraryFilterKind ("LibraryFilter", "Conditions that a cutter of a library must meet, all of them, to join") -> LibraryFilter {
        diameters: optional DIAMETERS: List<Quantity<Length>> = ("diameter_mm",
            List { item: Quantity::length(6.0), about_item: "a diameter", fewest: 2, most: 2 },
            "the smallest and the largest diameter"),
        types: optional TYPES: List<Choice<CutterKind>> = ("types",
            List { item: Choice { name: None, words: KINDS }, about_item: "a kind of cutter", fewest: 1, most: KINDS.len() },
            "the kinds of cutters"),
        numbers: optional NUMBERS: List<Whole> = ("numbers",
            List { item: Whole { minimum: 0, maximum: 4_000_000_000, example: 7 }, about_item: "a tool's number", fewest: 1, most: 1000 },
            "the tools' numbers in the library; a tool without a number does not join"),
    }
}

impl FilterMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<LibraryFilter, Faulted> {
        let diameters = self.diameters.and_then(|diameters| {
            let Some(range) = diameters.and_then(|range| <[Length; 2]>::try_from(range).ok()) else { return Ok(None) };
            if range[0].mm() > range[1].mm() {
                let detail = "the smallest diameter must not be over the largest";
                return Err(faults.add(&path.member(DIAMETERS.name), RequestFault::OutOfRange, detail));
            }
            Ok(Some(range))
        });
        Ok(LibraryFilter { diameters: diameters?, types: self.types?, numbers: self.numbers? })
    }
}
