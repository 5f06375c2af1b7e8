//! The reader of JSON objects. Callers take the members one by one; all faults are recorded.

use super::{Faulted, Faults, Kind, Member, describe};
use crate::http::codes::RequestFault;
use crate::json_text::{JsonError, JsonMembers, JsonPath, JsonText, Unread};
use std::borrow::Cow;

/// A JSON object whose members are taken one by one. The members left at the end are unknown fields.
pub(crate) struct Object<'a, 'p> {
    path: JsonPath<'p>,
    members: Vec<(Cow<'a, str>, JsonText<'a>)>,
    unkept: usize,
    pub(super) known: Vec<&'static str>,
}

impl<'a, 'p> Object<'a, 'p> {
    /// Opens `raw`, which is at `path`, as an object.
    pub(crate) fn open(raw: JsonText<'a>, path: JsonPath<'p>, faults: &mut Faults) -> Result<Self, Faulted> {
        let members = raw.members(MOST_MEMBERS, &|| faults.is_cancelled());
        Self::of(raw, members, path, faults)
    }

    fn of(raw: JsonText<'a>, members: Result<JsonMembers<'a>, Unread>, path: JsonPath<'p>, faults: &mut Faults) -> Result<Self, Faulted> {
        match members {
            Ok(JsonMembers { kept, unkept }) => Ok(Self { path, members: kept, unkept, known: Vec::with_capacity(12) }),
            Err(Unread::Name(error)) => Err(faults.add(&path, RequestFault::Unreadable, error)),
            // The faults of a cancelled reading are discarded.
            Err(Unread::Cancelled) => Err(Faulted),
            Err(Unread::OtherType) => {
                Err(faults.add(&path, RequestFault::WrongType, format_args!("expected an object, found {}", describe(raw))))
            }
        }
    }

    /// Opens a whole body as an object. The outer error means that the body is not JSON.
    pub(crate) fn open_body(json: &'a [u8], faults: &mut Faults) -> Result<Result<Self, Faulted>, JsonError> {
        // Reading the members checks the syntax of the whole body.
        let (body, members) = JsonText::check_object(json, MOST_MEMBERS, &|| faults.is_cancelled())?;
        Ok(Self::of(body, members, JsonPath::Root, faults))
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
    pub(crate) fn take(&mut self, name: &'static str, faults: &mut Faults) -> Option<JsonText<'a>> {
        self.known.push(name);
        let found = self.members.iter().position(|(key, _)| key == name).map(|index| self.members.remove(index).1);
        while let Some(again) = self.members.iter().position(|(key, _)| key == name) {
            self.members.remove(again);
            faults.add(&self.path.member(name), RequestFault::RepeatedField, "the field is given more than once");
        }
        found
    }

    /// Takes a required member unparsed.
    pub(crate) fn required_raw<K>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<JsonText<'a>, Faulted> {
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
            result = Err(if index < MOST_WITH_KNOWN {
                faults.add(&path, RequestFault::UnknownField, format_args!("unknown field; known here: {known}"))
            } else {
                faults.add(&path, RequestFault::UnknownField, "unknown field")
            });
        }
        result
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
        let raw = JsonText::known(&body);
        let mut faults = Faults::default();
        let object = Object::open(raw, JsonPath::Root, &mut faults).unwrap();
        assert_eq!(object.members.len(), MOST_MEMBERS);
        assert_eq!(object.close(&mut faults), Err(Faulted));
        let listed = faults.into_listed();
        assert_eq!(listed.len(), 1 + MOST_MEMBERS);
        assert!(listed[0].detail.contains("744 fields more"), "{}", listed[0].detail);
    }
}
