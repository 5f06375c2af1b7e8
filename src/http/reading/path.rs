//! Paths to the values of a JSON text.

use std::fmt;

/// The path to a value, displayed as a JSON pointer (RFC 6901). It lives on the reader's stack and is formatted only
/// for a fault.
#[derive(Debug, Clone, Copy)]
pub(crate) enum JsonPath<'p> {
    /// The whole text.
    Root,
    /// A member of an object.
    Member(&'p JsonPath<'p>, &'p str),
    /// An item of an array.
    Item(&'p JsonPath<'p>, usize),
    /// A row of an object of columns. Its members are items of the columns: `slope_deg` of row 17 is at
    /// `/slope_deg/17`. The row as a whole has no pointer of its own; it has that of its item in the first column,
    /// which is named here.
    Row(&'p JsonPath<'p>, &'static str, usize),
}

impl JsonPath<'_> {
    pub(crate) fn member<'p>(&'p self, name: &'p str) -> JsonPath<'p> {
        JsonPath::Member(self, name)
    }

    pub(crate) fn item(&self, index: usize) -> JsonPath<'_> {
        JsonPath::Item(self, index)
    }

    /// Whether the path leads to the whole text, to one of its members, or to a member or the first item of that.
    pub(crate) fn is_outer(&self) -> bool {
        match self {
            JsonPath::Root | JsonPath::Member(JsonPath::Root | JsonPath::Member(JsonPath::Root, _), _) => true,
            JsonPath::Item(JsonPath::Member(JsonPath::Root, _), index) => *index == 0,
            JsonPath::Member(..) | JsonPath::Item(..) | JsonPath::Row(..) => false,
        }
    }

    /// The name of the innermost member.
    pub(crate) fn name(&self) -> &str {
        match self {
            JsonPath::Root => "",
            JsonPath::Member(_, name) => name,
            JsonPath::Item(parent, _) | JsonPath::Row(parent, ..) => parent.name(),
        }
    }

    /// Writes the pointer up to the innermost column. Returns the row's index if it has not been written yet.
    fn write(&self, f: &mut fmt::Formatter<'_>) -> Result<Option<usize>, fmt::Error> {
        match self {
            JsonPath::Root => Ok(None),
            JsonPath::Row(parent, _, index) => {
                write!(f, "{parent}")?;
                Ok(Some(*index))
            }
            JsonPath::Member(parent, name) => {
                let row = parent.write(f)?;
                write!(f, "/{}", shown(name).replace('~', "~0").replace('/', "~1"))?;
                Ok(row)
            }
            JsonPath::Item(parent, index) => {
                if let Some(row) = parent.write(f)? {
                    write!(f, "/{row}")?;
                }
                write!(f, "/{index}")?;
                Ok(None)
            }
        }
    }
}

impl fmt::Display for JsonPath<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let JsonPath::Row(parent, first_column, index) = self {
            return write!(f, "{parent}/{first_column}/{index}");
        }
        match self.write(f)? {
            Some(row) => write!(f, "/{row}"),
            None => Ok(()),
        }
    }
}

/// The name, shortened if it is longer than any known name, because a message must not repeat megabytes of the text.
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

    #[test]
    fn members_of_a_row_are_items_of_columns() {
        let contacts = JsonPath::Root.member("contacts");
        let row = JsonPath::Row(&contacts, "slope_deg", 17);
        assert_eq!(row.to_string(), "/contacts/slope_deg/17");
        assert_eq!(row.member("feed_angle_deg").to_string(), "/contacts/feed_angle_deg/17");
        assert_eq!(row.member("normal").item(2).to_string(), "/contacts/normal/17/2");
        let curvature = row.member("surface_curvature");
        assert_eq!(curvature.member("twist_per_mm").to_string(), "/contacts/surface_curvature/twist_per_mm/17");
        assert_eq!(curvature.member("principal_per_mm").item(0).to_string(), "/contacts/surface_curvature/principal_per_mm/17/0");
    }
}
