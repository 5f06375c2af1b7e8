//! The reader of JSON objects. Callers take the members one by one; all faults are recorded.

use super::{AnyMember, Faulted, Faults, JsonPath, Kind, Member, describe, nearest};
use crate::http::codes::RequestFault;
use crate::json::JsonError;
use serde::Deserialize;
use serde::de::{Deserializer, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// A JSON object whose members are taken one by one. The members left at the end are unknown fields.
pub(crate) struct Object<'a, 'p> {
    path: JsonPath<'p>,
    members: Vec<(Cow<'a, str>, &'a RawValue)>,
    unkept: usize,
    pub(super) known: Vec<&'static str>,
}

impl<'a, 'p> Object<'a, 'p> {
    /// Opens `raw`, which is at `path`, as an object.
    pub(crate) fn open(raw: &'a RawValue, path: JsonPath<'p>, faults: &mut Faults) -> Result<Self, Faulted> {
        match raw.deserialize_map(MembersVisitor) {
            Ok(RawMembers { kept, unkept }) => Ok(Self { unkept, ..Self::of_members(kept, path) }),
            // The syntax has been checked, so a name is not valid text.
            Err(error) if raw.get().starts_with('{') => Err(faults.add(&path, RequestFault::Unreadable, JsonError::from(&error))),
            Err(_) => Err(faults.add(&path, RequestFault::WrongType, format_args!("expected an object, found {}", describe(raw)))),
        }
    }

    /// Opens a whole body as an object. The outer error means that the body is not JSON.
    pub(crate) fn open_body(json: &'a [u8], faults: &mut Faults) -> Result<Result<Self, Faulted>, JsonError> {
        // Reading the members checks the syntax of the whole body.
        if let Ok(RawMembers { kept, unkept }) = serde_json::from_slice(json) {
            return Ok(Ok(Self { unkept, ..Self::of_members(kept, JsonPath::Root) }));
        }
        let raw: &RawValue = serde_json::from_slice(json).map_err(|error| JsonError::from(&error))?;
        Ok(Self::open(raw, JsonPath::Root, faults))
    }

    /// The object of these members.
    pub(super) fn of_members(members: Vec<(Cow<'a, str>, &'a RawValue)>, path: JsonPath<'p>) -> Self {
        Self { path, members, unkept: 0, known: Vec::with_capacity(12) }
    }

    /// The path to the object.
    pub(crate) fn path(&self) -> JsonPath<'p> {
        self.path
    }

    /// Whether a member is present and not taken yet.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.members.iter().any(|(key, _)| key == name)
    }

    /// Takes the member `name` unparsed. A repeated name is a fault.
    pub(crate) fn take(&mut self, name: &'static str, faults: &mut Faults) -> Option<&'a RawValue> {
        self.known.push(name);
        let found = self.members.iter().position(|(key, _)| key == name).map(|index| self.members.remove(index).1);
        while let Some(again) = self.members.iter().position(|(key, _)| key == name) {
            self.members.remove(again);
            faults.add(&self.path.member(name), RequestFault::RepeatedField, "the field is given more than once");
        }
        found
    }

    /// All members, of an object whose names are free.
    pub(crate) fn into_members(self, faults: &mut Faults) -> Result<Vec<(Cow<'a, str>, &'a RawValue)>, Faulted> {
        if self.unkept > 0 {
            let detail = format_args!("at most {MOST_MEMBERS} fields, found {}", self.members.len() + self.unkept);
            return Err(faults.add(&self.path, RequestFault::TooManyFields, detail));
        }
        Ok(self.members)
    }

    /// Takes a required member unparsed.
    pub(crate) fn required_raw<K>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<&'a RawValue, Faulted> {
        self.take(member.name, faults).ok_or_else(|| {
            let detail = format_args!("the field is missing: {}", member.about);
            faults.add(&self.path.member(member.name), RequestFault::MissingField, detail)
        })
    }

    /// Takes a required member.
    pub(crate) fn required<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<K::Value, Faulted> {
        let raw = self.required_raw(member, faults)?;
        member.kind.read(raw, self.path.member(member.name), faults)
    }

    /// Takes a member that may be absent.
    pub(crate) fn optional<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<Option<K::Value>, Faulted> {
        let Some(raw) = self.take(member.name, faults) else {
            return Ok(None);
        };
        member.kind.read(raw, self.path.member(member.name), faults).map(Some)
    }

    /// Takes a member to record its faults.
    pub(crate) fn check(&mut self, member: &dyn AnyMember, faults: &mut Faults) {
        if let Some(raw) = self.take(member.name(), faults) {
            member.check(raw, self.path.member(member.name()), faults);
        }
    }

    /// Reads the whole object with `read`; members that `read` does not take are faults.
    pub(crate) fn read<T>(
        mut self,
        faults: &mut Faults,
        read: impl FnOnce(&mut Self, &mut Faults) -> Result<T, Faulted>,
    ) -> Result<T, Faulted> {
        let result = read(&mut self, faults);
        self.close(faults)?;
        result
    }

    /// Ends the reading: members that were not taken are unknown.
    pub(crate) fn close(self, faults: &mut Faults) -> Result<(), Faulted> {
        let mut result = Ok(());
        if self.unkept > 0 {
            let detail = format!("the object has {} fields more than the {} that are read", self.unkept, MOST_MEMBERS);
            result = Err(faults.add(&self.path, RequestFault::TooManyFields, detail));
        }
        let known = if self.members.is_empty() { String::new() } else { self.known.join(", ") };
        for (index, (name, _)) in self.members.iter().enumerate() {
            let path = self.path.member(name);
            result = Err(match nearest(name, self.known.iter().copied()) {
                Some(meant) => faults.add(&path, RequestFault::UnknownField, format_args!("unknown field; did you mean {meant}?")),
                None if index < MOST_WITH_KNOWN => {
                    faults.add(&path, RequestFault::UnknownField, format_args!("unknown field; known here: {known}"))
                }
                None => faults.add(&path, RequestFault::UnknownField, "unknown field"),
            });
        }
        faults.object_knows(&self.path, self.known);
        result
    }
}

/// The members of an object in the order sent, each with its name and its unparsed value.
struct RawMembers<'a> {
    /// The first members.
    kept: Vec<(Cow<'a, str>, &'a RawValue)>,
    /// The number of members beyond those that are kept.
    unkept: usize,
}

impl<'de> Deserialize<'de> for RawMembers<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(MembersVisitor)
    }
}

struct MembersVisitor;

impl<'de> Visitor<'de> for MembersVisitor {
    type Value = RawMembers<'de>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawMembers<'de>, A::Error> {
        /// A name, borrowed unless it is written with escapes.
        #[derive(Deserialize)]
        struct Name<'a>(#[serde(borrow)] Cow<'a, str>);

        let mut members = RawMembers { kept: Vec::with_capacity(8), unkept: 0 };
        while members.kept.len() < MOST_MEMBERS {
            let Some((Name(name), value)) = map.next_entry()? else { return Ok(members) };
            members.kept.push((name, value));
        }
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {
            members.unkept += 1;
        }
        Ok(members)
    }
}

/// The largest number of members stored, more than ten times that of any object. Further ones are counted, so that the
/// memory of a body does not exceed its length.
const MOST_MEMBERS: usize = 256;

/// The largest number of unknown members of an object whose faults list the known members. The limit keeps an answer
/// from being much longer than its request.
const MOST_WITH_KNOWN: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_beyond_the_limit_are_counted_not_kept() {
        let body = format!("{{{}}}", (0..1000).map(|index| format!("\"m{index}\":{index}")).collect::<Vec<_>>().join(","));
        let raw = serde_json::from_str(&body).unwrap();
        let mut faults = Faults::default();
        let object = Object::open(raw, JsonPath::Root, &mut faults).unwrap();
        assert_eq!(object.members.len(), MOST_MEMBERS);
        assert_eq!(object.close(&mut faults), Err(Faulted));
        let listed = faults.into_listed();
        assert_eq!(listed.len(), 1 + MOST_MEMBERS);
        assert!(listed[0].detail.contains("744 fields more"), "{}", listed[0].detail);
    }
}
