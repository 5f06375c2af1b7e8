//! The cutters of a path: one, or several by the T numbers of the program.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, Object};
use crate::http::wire::{CandidateKind, NamedCandidate};
use crate::path::program::{Program, Reached};
use serde_json::value::RawValue;
use std::collections::{BTreeMap, BTreeSet};
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder};
use utoipa::openapi::{RefOr, Schema};

/// The most cutters of a program.
const MOST_CUTTERS: usize = 50;

/// The member `cutter`.
pub(super) const PATH_CUTTER: Member<CandidateKind> =
    Member::new("cutter", "the cutter that runs the path; teeth and spindle_speed_rpm are needed for feeds and tooth marks", CandidateKind);

/// The member `cutters`.
pub(super) const PATH_CUTTERS: Member<CuttersByNumber> =
    Member::new("cutters", "in place of `cutter`: the cutters of a program with several tools, by their T numbers", CuttersByNumber);

/// An object of cutters whose names are T numbers.
pub(super) struct CuttersByNumber;

impl Kind for CuttersByNumber {
    type Value = BTreeMap<u32, NamedCandidate>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        let members = Object::open(raw, path, faults)?.into_members(faults)?;
        if members.is_empty() || members.len() > MOST_CUTTERS {
            let detail = format_args!("expected 1 to {MOST_CUTTERS} cutters, found {}", members.len());
            return Err(faults.add(&path, RequestFault::WrongCount, detail));
        }
        let mut cutters = BTreeMap::new();
        let mut result = Ok(());
        for (name, raw) in members {
            let path = path.member(&name);
            let number = name.parse::<u32>().ok().filter(|number| *number <= 1_000_000);
            let Some(number) = number else {
                result = Err(faults.add(&path, RequestFault::UnknownField, "the name of a cutter is its T number, from 0 to 1000000"));
                continue;
            };
            match CandidateKind.read(raw, path, faults) {
                Ok(cutter) => {
                    if cutters.insert(number, cutter).is_some() {
                        result = Err(faults.add(&path, RequestFault::RepeatedField, "the number is given more than once"));
                    }
                }
                Err(faulted) => result = Err(faulted),
            }
        }
        result.map(|()| cutters)
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let each = CandidateKind.schema("", components);
        let schema = ObjectBuilder::new().description(Some(about)).additional_properties(Some(AdditionalProperties::RefOr(each)));
        schema.into()
    }
}

/// The cutters of a program, and which of them makes each move.
#[derive(Debug, Clone)]
pub(super) struct PathCutters {
    pub(super) cutters: Vec<NamedCandidate>,
    /// The index of each T number; empty for a single cutter without number.
    by_number: BTreeMap<u32, usize>,
}

impl PathCutters {
    /// Those of a program; a T number without a cutter is a fault of the program at `path`.
    pub(super) fn of(
        cutter: Option<NamedCandidate>,
        cutters: Option<BTreeMap<u32, NamedCandidate>>,
        program: &Program,
        object: &JsonPath<'_>,
        path: &JsonPath<'_>,
        faults: &mut Faults,
    ) -> Result<Self, Faulted> {
        let cuts = program.points.iter().filter(|point| point.reached == Reached::Feed);
        let used: BTreeSet<u32> = cuts.map(|point| point.tool).collect();
        match (cutter, cutters) {
            (Some(_), Some(_)) => Err(faults.add(object, RequestFault::ConflictingFields, "give cutter or cutters")),
            (None, None) => {
                let detail = format_args!("{} is missing: {}; or give cutters, by T number", PATH_CUTTER.name, PATH_CUTTER.about);
                Err(faults.add(&object.member(PATH_CUTTER.name), RequestFault::MissingField, detail))
            }
            (Some(cutter), None) if used.len() <= 1 => Ok(Self { cutters: vec![cutter], by_number: BTreeMap::new() }),
            (Some(_), None) => {
                let numbers: Vec<String> = used.iter().map(ToString::to_string).collect();
                let detail = format_args!("the program cuts with tools {}; give cutters by these numbers", numbers.join(", "));
                Err(faults.add(path, RequestFault::FaultyProgram, detail))
            }
            (None, Some(cutters)) => {
                let unknown: Vec<String> = used.iter().filter(|number| !cutters.contains_key(number)).map(ToString::to_string).collect();
                if !unknown.is_empty() {
                    let detail = format_args!("the program cuts with tools without a cutter: {}", unknown.join(", "));
                    return Err(faults.add(path, RequestFault::FaultyProgram, detail));
                }
                let by_number = cutters.keys().enumerate().map(|(index, number)| (*number, index)).collect();
                Ok(Self { cutters: cutters.into_values().collect(), by_number })
            }
        }
    }

    /// The index of the cutter with a T number; that of a rapid before the first tool call is the first.
    pub(super) fn index(&self, tool: u32) -> usize {
        self.by_number.get(&tool).copied().unwrap_or(0)
    }

    /// The cutter with a T number.
    pub(super) fn of_tool(&self, tool: u32) -> &NamedCandidate {
        &self.cutters[self.index(tool)]
    }
}
