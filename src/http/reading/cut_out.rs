//! Cuts the contacts out of the body of a batch, so that the rest of it can be read first, and the contacts in one pass.
//!
//! Finding where the contacts end takes no pass over them: they are divided at places that look like borders between
//! items. Each piece is then read strictly, and the general reader takes over if a piece is not what it looked like.

use crate::json_text::{JsonText, PlainJson, Unusual};
use memchr::{memchr, memchr2_iter, memmem};

/// The bytes of rows that one thread reads and computes at a time: about 1000 contacts, some tenths of a millisecond.
const RUN: usize = 48 * 1024;

/// The longest last run, so that its brackets are counted in less than a millisecond.
const LONGEST_LAST_RUN: usize = 8 * RUN;

/// The largest number of bytes beside the member: the copy of them is not counted in the memory budget.
const MOST_REST: usize = 64 * 1024;

/// The most columns that are cut out; more are left to the general reader.
const MOST_COLUMNS: usize = 16;

/// A body of which a large member is cut out.
#[derive(Debug)]
pub(crate) struct CutOut<'a> {
    /// The body with an empty array or object in place of the member.
    pub(crate) rest: Vec<u8>,
    position: usize,
    large: Large<'a>,
}

/// The member that is cut out. Its syntax is not checked.
#[derive(Debug)]
pub(crate) enum Large<'a> {
    /// An array of objects, divided into runs of objects without the commas between runs.
    Rows(Vec<&'a [u8]>),
    /// An object of arrays.
    Columns(PlainColumns<'a>),
}

/// Columns by their names, as the texts between the brackets of their arrays.
#[derive(Debug, Default)]
pub(crate) struct PlainColumns<'a>(Vec<(&'a str, &'a [u8])>);

impl<'a> PlainColumns<'a> {
    /// Takes the column `name`.
    pub(crate) fn take(&mut self, name: &str) -> Option<&'a [u8]> {
        let index = self.0.iter().position(|(known, _)| *known == name)?;
        Some(self.0.swap_remove(index).1)
    }

    /// Whether all columns have been taken.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<'a> CutOut<'a> {
    /// Cuts the member `name` out of `json`. `None` if it is absent, empty, or no array or object as the fast readers
    /// take it.
    pub(crate) fn of(json: &'a [u8], name: &str) -> Option<Self> {
        let quoted = format!("\"{name}\"");
        let mut reader = PlainJson::new(json);
        reader.seek(memmem::find(json, quoted.as_bytes())? + quoted.len());
        reader.expect(b':').ok()?;
        reader.skip_blank();
        let position = reader.position();
        let (large, end, empty) = if reader.takes(b'[') {
            let (runs, end) = runs(json, reader.position())?;
            (Large::Rows(runs), end, b"[]")
        } else {
            let columns = columns(json, &mut reader).ok()?;
            (Large::Columns(columns), reader.position(), b"{}")
        };
        if position + (json.len() - end) > MOST_REST {
            return None;
        }
        let rest = [&json[..position], empty, &json[end..]].concat();
        Some(Self { rest, position, large })
    }

    /// Whether `value`, a part of the rest, is at the place from which the member was cut out.
    pub(crate) fn is_place(&self, value: JsonText<'_>) -> bool {
        value.get().as_ptr().addr().checked_sub(self.rest.as_ptr().addr()) == Some(self.position)
    }

    pub(crate) fn large(self) -> Large<'a> {
        self.large
    }
}

/// The runs of an array that begins at `first` after its bracket, and the position after its closing bracket.
fn runs(json: &[u8], mut first: usize) -> Option<(Vec<&[u8]>, usize)> {
    let mut runs = Vec::with_capacity((json.len() - first) / RUN + 1);
    while let Some(comma) = border(json, first + RUN) {
        runs.push(&json[first..comma]);
        first = comma + 1;
    }
    // A contact is short; the general reader looks for a border in another array.
    if json.len() - first > MOST_REST + LONGEST_LAST_RUN {
        return None;
    }
    // The other brackets of contacts are those of vectors.
    let mut open = 0_usize;
    for bracket in memchr2_iter(b'[', b']', &json[first..]).map(|at| first + at) {
        if json[bracket] == b'[' {
            open += 1;
        } else if open > 0 {
            open -= 1;
        } else {
            runs.push(&json[first..bracket]);
            return Some((runs, bracket + 1));
        }
    }
    None
}

/// The next comma between two objects: in a contact no object follows another.
fn border(json: &[u8], mut from: usize) -> Option<usize> {
    loop {
        let closing = from + memchr(b'}', json.get(from..)?)?;
        let mut reader = PlainJson::new(json);
        reader.seek(closing + 1);
        reader.skip_blank();
        let comma = reader.position();
        if reader.takes(b',') && reader.takes(b'{') {
            return Some(comma);
        }
        from = closing + 1;
    }
}

/// Reads an object of arrays without other brackets in them.
fn columns<'a>(json: &'a [u8], reader: &mut PlainJson<'a>) -> Result<PlainColumns<'a>, Unusual> {
    let mut columns = PlainColumns::default();
    reader.expect(b'{')?;
    loop {
        let name = reader.name()?;
        reader.expect(b':')?;
        reader.expect(b'[')?;
        let first = reader.position();
        let closing = first + memchr(b']', &json[first..]).ok_or(Unusual)?;
        if columns.0.len() == MOST_COLUMNS || columns.0.iter().any(|(known, _)| *known == name) {
            return Err(Unusual);
        }
        columns.0.push((name, &json[first..closing]));
        reader.seek(closing + 1);
        if !reader.takes(b',') {
            reader.expect(b'}')?;
            return Ok(columns);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rest(json: &str) -> Option<String> {
        CutOut::of(json.as_bytes(), "contacts").map(|cut| String::from_utf8(cut.rest).unwrap())
    }

    #[test]
    fn the_rest_has_an_empty_value_in_place_of_the_member() {
        assert_eq!(rest(r#"{"a":1,"contacts" : [{"x":[1,2]}, {}] ,"b":[2]}"#).unwrap(), r#"{"a":1,"contacts" : [] ,"b":[2]}"#);
        assert_eq!(rest(r#"{"contacts":{"x":[1,null],"y" :[ ]},"b":2}"#).unwrap(), r#"{"contacts":{},"b":2}"#);
        for json in
            ["", "{}", r#"{"contacts"}"#, r#"{"contacts":7}"#, r#"{"contacts":[{}"#, r#"{"contacts":{"x":1}}"#, r#"{"contacts":{}}"#]
        {
            assert_eq!(rest(json), None, "{json}");
        }
    }

    #[test]
    fn another_member_of_the_same_name_is_not_the_place() {
        let json = r#"{"cutter":{"contacts":[{"x":1}]},"contacts":[]}"#;
        let cut = CutOut::of(json.as_bytes(), "contacts").unwrap();
        let never = || false;
        let rest = JsonText::check(&cut.rest, &never).unwrap().members(5, &never).unwrap().kept;
        assert_eq!((&*rest[0].0, &*rest[1].0), ("cutter", "contacts"));
        assert!(!cut.is_place(rest[1].1));
        assert!(cut.is_place(rest[0].1.members(5, &never).unwrap().kept[0].1));
    }

    #[test]
    fn runs_join_to_the_whole_array() {
        let contact = r#"{"slope_deg":40.5, "normal":[0,0,1] , "surface_curvature":{"along_per_mm":0.1},"step_over_mm":1}"#;
        for count in [1, 2, 500, 3000] {
            let array = vec![contact; count].join(" , ");
            let json = format!(r#"{{"contacts":[{array}],"columns":["a","b"]}}"#);
            let Large::Rows(runs) = CutOut::of(json.as_bytes(), "contacts").unwrap().large() else { panic!("rows") };
            assert_eq!(runs.len(), array.len().div_ceil(RUN + contact.len()));
            assert_eq!(String::from_utf8(runs.join(&b','.to_owned())).unwrap(), array);
        }
    }
}
