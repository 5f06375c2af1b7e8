//! Paths to the values of a request.

use std::fmt;

/// The path to a value, displayed as a JSON pointer (RFC 6901). It lives on the reader's stack; only a fault formats it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum JsonPath<'p> {
    /// The whole body.
    Root,
    /// A member of an object.
    Member(&'p JsonPath<'p>, &'p str),
    /// An item of an array.
    Item(&'p JsonPath<'p>, usize),
}

impl JsonPath<'_> {
    pub(crate) fn member<'p>(&'p self, name: &'p str) -> JsonPath<'p> {
        JsonPath::Member(self, name)
    }

    pub(crate) fn item(&self, index: usize) -> JsonPath<'_> {
        JsonPath::Item(self, index)
    }
}

impl fmt::Display for JsonPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            JsonPath::Root => Ok(()),
            JsonPath::Member(parent, name) => write!(f, "{parent}/{}", shown(name).replace('~', "~0").replace('/', "~1")),
            JsonPath::Item(parent, index) => write!(f, "{parent}/{index}"),
        }
    }
}

/// The name, cut where it is longer than any that is known: an answer must not repeat megabytes of its request.
fn shown(name: &str) -> &str {
    const LONGEST: usize = 200;
    name.char_indices().nth(LONGEST).map_or(name, |(end, _)| &name[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_escape_slashes_and_tildes() {
        let root = JsonPath::Root;
        let contacts = root.member("contacts");
        let third = contacts.item(2);
        assert_eq!(third.member("a/b~c").to_string(), "/contacts/2/a~1b~0c");
        assert_eq!(root.to_string(), "");
    }

    #[test]
    fn long_names_are_cut() {
        let name = "ä".repeat(1000);
        assert_eq!(JsonPath::Root.member(&name).to_string().chars().count(), 201);
    }
}
