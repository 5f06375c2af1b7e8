//! The reader of JSON objects. Callers take the members one by one; all faults are recorded.

use super::{Faulted, Faults, Form, JsonPath, Kind, Member, Members, PlainColumn, not_finite};
use crate::http::codes::RequestFault;
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;

/// A JSON object whose members are taken one by one. The members left at the end are unknown fields.
pub(crate) struct Object<'a, 'p> {
    path: JsonPath<'p>,
    members: Vec<(Cow<'a, str>, &'a RawValue)>,
    unkept: usize,
    known: Vec<&'static str>,
}

impl<'a, 'p> Object<'a, 'p> {
    /// Opens `raw`, which is at `path`, as an object.
    pub(crate) fn open(raw: &'a RawValue, path: JsonPath<'p>, faults: &mut Faults) -> Result<Self, Faulted> {
        if !raw.get().starts_with('{') {
            return Err(faults.add(&path, RequestFault::WrongType, format_args!("expected an object, found {}", describe(raw))));
        }
        match serde_json::from_str::<RawMembers<'a>>(raw.get()) {
            Ok(members) => Ok(Self::of(members, path)),
            Err(error) => Err(faults.add(&path, RequestFault::Unreadable, error)),
        }
    }

    /// Opens a whole body as an object. The outer error means that the body is not JSON.
    pub(crate) fn open_body(json: &'a [u8], faults: &mut Faults) -> Result<Result<Self, Faulted>, serde_json::Error> {
        // Reading the members checks the syntax of the whole body; a second pass is needed only if that fails.
        match serde_json::from_slice::<RawMembers<'a>>(json) {
            Ok(members) => Ok(Ok(Self::of(members, JsonPath::Root))),
            Err(_) => Ok(Self::open(serde_json::from_slice(json)?, JsonPath::Root, faults)),
        }
    }

    fn of(members: RawMembers<'a>, path: JsonPath<'p>) -> Self {
        Self { path, members: members.kept, unkept: members.unkept, known: Vec::with_capacity(12) }
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

    /// Takes a required member.
    pub(crate) fn required<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<K::Value, Faulted> {
        match self.optional(member, faults)? {
            Some(value) => Ok(value),
            None => Err(faults.add(
                &self.path.member(member.name),
                RequestFault::MissingField,
                format_args!("the field is missing: {}", member.about),
            )),
        }
    }

    /// Takes a member that may be absent.
    pub(crate) fn optional<K: Kind>(&mut self, member: &Member<K>, faults: &mut Faults) -> Result<Option<K::Value>, Faulted> {
        let Some(raw) = self.take(member.name, faults) else {
            return Ok(None);
        };
        member.kind.read(raw, self.path.member(member.name), faults).map(Some)
    }

    /// Takes a column of at most `most` rows, which may be absent.
    pub(crate) fn column<C: PlainColumn>(&mut self, name: &'static str, most: usize, faults: &mut Faults) -> Option<C> {
        let raw = self.take(name, faults)?;
        C::read(raw, most, self.path.member(name), faults).ok()
    }

    /// Reads the members of one of two forms of an object. `forms` is the text of the fault if none or both are
    /// present.
    pub(crate) fn one_of<A: Members, B: Members>(&mut self, forms: &str, faults: &mut Faults) -> Result<Form<A, B>, Faulted> {
        let [first, second] = [A::NAMES, B::NAMES].map(|names| names.iter().any(|name| self.has(name)));
        match (first, second) {
            (true, false) => Ok(Form::First(A::read(self, faults))),
            (false, true) => Ok(Form::Second(B::read(self, faults))),
            (true, true) => {
                // Both forms are read, so that all their faults are listed.
                A::check(self, faults);
                B::check(self, faults);
                Err(faults.add(&self.path, RequestFault::ConflictingFields, format_args!("{forms}, not both")))
            }
            (false, false) => {
                // Faults of unknown members list both forms.
                self.known.extend(A::NAMES.iter().chain(B::NAMES));
                Err(faults.add(&self.path, RequestFault::MissingField, forms))
            }
        }
    }

    /// Ends the reading: members that were not taken are unknown.
    pub(crate) fn close(self, faults: &mut Faults) -> Result<(), Faulted> {
        let mut result = Ok(());
        if self.unkept > 0 {
            let detail = format!("the object has {} fields more than the {} that are read", self.unkept, RawMembers::MOST);
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

/// The largest number of unknown members of an object whose faults list the known members. The limit keeps an answer
/// from being much longer than its request.
const MOST_WITH_KNOWN: usize = 4;

/// Describes a JSON value for the detail of a fault.
pub(crate) fn describe(raw: &RawValue) -> Cow<'static, str> {
    const SHOWN: usize = 40;
    let text = raw.get();
    if let Some(token) = not_finite::token(text) {
        return token.into();
    }
    match text.as_bytes()[0] {
        b'{' => "an object".into(),
        b'[' => "an array".into(),
        b't' | b'f' => format!("the boolean {text}").into(),
        b'n' => "null".into(),
        first => {
            let what = if first == b'"' { "the string" } else { "the number" };
            let shown: String = text.chars().take(SHOWN).collect();
            let more = if shown.len() < text.len() { "..." } else { "" };
            format!("{what} {shown}{more}").into()
        }
    }
}

/// The members of an object in the order sent, with unparsed values.
struct RawMembers<'a> {
    kept: Vec<(Cow<'a, str>, &'a RawValue)>,
    unkept: usize,
}

impl RawMembers<'_> {
    /// The largest number of members stored, more than ten times that of any object. Further ones are counted, so that
    /// the memory of a body does not exceed its length.
    const MOST: usize = 256;
}

impl<'de> Deserialize<'de> for RawMembers<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Collect;
        impl<'de> Visitor<'de> for Collect {
            type Value = RawMembers<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
                let mut kept = Vec::with_capacity(8);
                while kept.len() < RawMembers::MOST {
                    let Some((Name(name), value)) = map.next_entry()? else { return Ok(RawMembers { kept, unkept: 0 }) };
                    kept.push((name, value));
                }
                let mut unkept = 0;
                while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {
                    unkept += 1;
                }
                Ok(RawMembers { kept, unkept })
            }
        }
        deserializer.deserialize_map(Collect)
    }
}

/// A member's name, borrowed from the body unless it is written with escapes.
struct Name<'a>(Cow<'a, str>);

impl<'de> Deserialize<'de> for Name<'de> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Borrow;
        impl<'de> Visitor<'de> for Borrow {
            type Value = Name<'de>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a field name")
            }
            fn visit_borrowed_str<E>(self, name: &'de str) -> Result<Self::Value, E> {
                Ok(Name(Cow::Borrowed(name)))
            }
            fn visit_str<E>(self, name: &str) -> Result<Self::Value, E> {
                Ok(Name(Cow::Owned(name.to_owned())))
            }
        }
        deserializer.deserialize_str(Borrow)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_beyond_the_limit_are_counted_not_kept() {
        let body = format!("{{{}}}", (0..1000).map(|index| format!("\"m{index}\":{index}")).collect::<Vec<_>>().join(","));
        let raw: &RawValue = serde_json::from_str(&body).unwrap();
        let mut faults = Faults::default();
        let object = Object::open(raw, JsonPath::Root, &mut faults).unwrap();
        assert_eq!(object.members.len(), RawMembers::MOST);
        assert_eq!(object.close(&mut faults), Err(Faulted));
        let listed = faults.into_listed();
        assert_eq!(listed.len(), 1 + RawMembers::MOST);
        assert!(listed[0].detail.contains("744 fields more"), "{}", listed[0].detail);
    }
}
