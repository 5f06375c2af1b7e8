//! Headers of tables of points: which columns are x, y and z, and in which unit.

use super::super::words::length_unit;
use super::layout::Separator;
use crate::file_fault::{FileFaultKind, Flaw, quoted};
use crate::surface::Unit;

/// The columns and the unit that a header states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TableHeader {
    /// Column and axis of the three coordinates, by rising column.
    pub(super) columns: [(usize, usize); 3],
    /// The number of columns.
    pub(super) width: usize,
    pub(super) unit: Option<Unit>,
}

const AXES: [&[u8]; 3] = [b"x", b"y", b"z"];

impl TableHeader {
    /// Reads `line` as a header, split by one of `separators`; `None` if it does not name x, y and z.
    ///
    /// # Errors
    /// Two columns could be the same axis, or the units differ or are not supported.
    pub(super) fn read(line: &[u8], separators: &[Separator]) -> Result<Option<Self>, Flaw> {
        for separator in separators {
            let names = names(line, *separator);
            let candidates = [0, 1, 2].map(|axis| candidates(&names, axis));
            if candidates.iter().all(|columns| !columns.is_empty())
                && let Some(header) = Self::of(&names, &candidates)?
            {
                return Ok(Some(header));
            }
        }
        Ok(None)
    }

    /// The header with these columns; `None` if two axes share a column, as with a separator that the line does not
    /// have.
    fn of(names: &[Name], candidates: &[Vec<usize>; 3]) -> Result<Option<Self>, Flaw> {
        for (axis, columns) in candidates.iter().enumerate() {
            if let [one, other, ..] = columns[..] {
                let expected = format!("one column that is {}", ["x", "y", "z"][axis]);
                let found = format!("{} and {}, which both could be", quoted(names[one].text), quoted(names[other].text));
                return Err(Flaw::new(FileFaultKind::Ambiguous, expected, found));
            }
        }
        let mut columns = [0, 1, 2].map(|axis| (candidates[axis][0], axis));
        columns.sort_unstable();
        if columns[0].0 == columns[1].0 || columns[1].0 == columns[2].0 {
            return Ok(None);
        }
        let [x, y, z] = columns.map(|(column, axis)| names[column].unit(axis));
        let unit = unit_of([x?, y?, z?])?;
        Ok(Some(Self { columns, width: names.len(), unit }))
    }

    /// The unit of x, y and z in the line after the header, if that is a row of units.
    pub(super) fn units_row(&self, line: &[u8], separators: &[Separator]) -> Result<Option<Unit>, Flaw> {
        for separator in separators {
            let fields: Vec<&[u8]> = separator.fields(line).collect();
            let units = self
                .columns
                .map(|(column, _)| fields.get(column).and_then(|field| words(field).next().and_then(|word| length_unit(&word))));
            if let [Some(x), Some(y), Some(z)] = units {
                let unit = unit_of([Some(x?), Some(y?), Some(z?)])?;
                if self.unit.is_some() && unit != self.unit {
                    return Err(Flaw::new(FileFaultKind::Ambiguous, "the unit that the header names", quoted(line)));
                }
                return Ok(unit);
            }
        }
        Ok(None)
    }
}

/// The name of a column.
struct Name<'a> {
    text: &'a [u8],
    words: Vec<Vec<u8>>,
}

impl Name<'_> {
    /// The unit that the name states after the axis.
    fn unit(&self, axis: usize) -> Result<Option<Unit>, Flaw> {
        let after = self.words.iter().position(|word| word == AXES[axis]).map_or(self.words.len(), |at| at + 1);
        self.words[after..].iter().rev().find_map(|word| length_unit(word)).transpose()
    }

    /// How well the name fits an axis: 0 for the axis alone or with a unit, 1 if the name begins with it, 2 if it
    /// contains it.
    fn rank(&self, axis: usize) -> Option<u8> {
        let index = [b"0", b"1", b"2"][axis];
        match &self.words[..] {
            // ParaView numbers the components of a vector.
            [points, number] if points == b"points" && number == index => Some(0),
            [first, rest @ ..] if first == AXES[axis] => {
                Some(u8::from(!rest.iter().all(|word| word == b"in" || length_unit(word).is_some())))
            }
            words => words.iter().any(|word| word == AXES[axis]).then_some(2),
        }
    }
}

/// The columns whose names fit an axis best.
fn candidates(names: &[Name], axis: usize) -> Vec<usize> {
    let ranks = || names.iter().enumerate().filter_map(|(column, name)| Some((column, name.rank(axis)?)));
    let best = ranks().map(|(_, rank)| rank).min();
    ranks().filter(|(_, rank)| Some(*rank) == best).map(|(column, _)| column).collect()
}

/// The names in a header. An empty one after a separator at the end is left out. If blanks separate the names, a unit
/// in brackets belongs to the name before it.
fn names(line: &[u8], separator: Separator) -> Vec<Name<'_>> {
    let mut names: Vec<Name> = Vec::new();
    for text in separator.fields(line) {
        let is_unit = separator == Separator::Blanks && matches!(text.first(), Some(b'[' | b'('));
        match names.last_mut() {
            Some(name) if is_unit => name.words.extend(words(text)),
            _ => names.push(Name { text, words: words(text).collect() }),
        }
    }
    if names.last().is_some_and(|name| name.text.is_empty()) {
        names.pop();
    }
    names
}

/// The words of a column's name in lower case: `X [mm]`, `"pos_x"` and `x(mm)` all have the word x.
fn words(name: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    name.split(|byte| !byte.is_ascii_alphanumeric() && byte.is_ascii()).filter(|word| !word.is_empty()).map(<[u8]>::to_ascii_lowercase)
}

/// The unit of three columns. If only some of them state one, it must be the millimetre, which is assumed for the
/// others.
fn unit_of(units: [Option<Unit>; 3]) -> Result<Option<Unit>, Flaw> {
    let mut stated = units.into_iter().flatten();
    let Some(first) = stated.next() else { return Ok(None) };
    let is_same = stated.all(|unit| unit == first);
    if is_same && (first == Unit::Millimetre || units.iter().all(Option::is_some)) {
        return Ok(Some(first));
    }
    let found = if is_same { "a unit for only some of them: the others may be in it or in mm" } else { "different ones" };
    Err(Flaw::new(FileFaultKind::Ambiguous, "one unit for x, y and z", found))
}
