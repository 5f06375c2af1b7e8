//! Faults of a request and the places where they are.

use crate::http::codes::{FaultCode, Figure, RequestFault};
use std::fmt;

/// The place of a value in a request, shown as a JSON pointer (RFC 6901). It lives on the stack of the reader and is spelt out only
/// for a fault.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Place<'p> {
    /// The whole body.
    Root,
    /// A member of an object.
    Member(&'p Place<'p>, &'p str),
    /// An item of an array.
    Item(&'p Place<'p>, usize),
}

impl Place<'_> {
    pub(crate) fn member<'p>(&'p self, name: &'p str) -> Place<'p> {
        Place::Member(self, name)
    }

    pub(crate) fn item(&self, index: usize) -> Place<'_> {
        Place::Item(self, index)
    }
}

impl fmt::Display for Place<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Root => Ok(()),
            Place::Member(parent, name) => write!(f, "{parent}/{}", name.replace('~', "~0").replace('/', "~1")),
            Place::Item(parent, index) => write!(f, "{parent}/{index}"),
        }
    }
}

/// One fault of a request.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fault {
    /// Where: a JSON pointer into the request.
    pub(crate) pointer: String,
    /// Which.
    pub(crate) code: FaultCode,
    /// What is wrong and what would be right, for a person.
    pub(crate) detail: String,
    /// Figures that show a way out, in mm.
    pub(crate) figures: Vec<(Figure, f64)>,
}

impl Fault {
    pub(crate) fn new(place: &Place<'_>, code: impl Into<FaultCode>, detail: impl fmt::Display) -> Self {
        Self { pointer: place.to_string(), code: code.into(), detail: detail.to_string(), figures: Vec::new() }
    }
}

/// Proof that a fault was recorded, in place of the value that could not be had.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Faulted;

/// All faults of a request, in the order in which they were found.
#[derive(Debug)]
pub(crate) struct Faults {
    most_listed: usize,
    listed: Vec<Fault>,
    unlisted: usize,
}

impl Default for Faults {
    fn default() -> Self {
        Self::at_most(Self::MOST_LISTED)
    }
}

impl Faults {
    /// A request can hold a fault every few bytes; beyond this many they are counted, not listed.
    const MOST_LISTED: usize = 1000;

    /// No faults. Beyond `most_listed` they are counted, not listed.
    pub(crate) fn at_most(most_listed: usize) -> Self {
        Self { most_listed, listed: Vec::new(), unlisted: 0 }
    }

    /// Records a fault and returns the proof.
    pub(crate) fn add(&mut self, place: &Place<'_>, code: impl Into<FaultCode>, detail: impl fmt::Display) -> Faulted {
        self.push(Fault::new(place, code, detail))
    }

    /// Records a fault that is put together already.
    pub(crate) fn push(&mut self, fault: Fault) -> Faulted {
        if self.listed.len() < self.most_listed {
            self.listed.push(fault);
        } else {
            self.unlisted += 1;
        }
        Faulted
    }

    /// The faults; where some were only counted, the last one says how many.
    pub(crate) fn into_listed(mut self) -> Vec<Fault> {
        if self.unlisted > 0 {
            let detail = format!("{} further faults are not listed", self.unlisted);
            self.listed.push(Fault::new(&Place::Root, RequestFault::FurtherFaults, detail));
        }
        self.listed
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pointers_escape_slashes_and_tildes() {
        let root = Place::Root;
        let contacts = root.member("contacts");
        let third = contacts.item(2);
        assert_eq!(third.member("a/b~c").to_string(), "/contacts/2/a~1b~0c");
        assert_eq!(root.to_string(), "");
    }

    #[test]
    fn a_flood_of_faults_is_counted_not_kept() {
        let mut faults = Faults::default();
        for _ in 0..Faults::MOST_LISTED + 7 {
            faults.add(&Place::Root, RequestFault::WrongType, "y");
        }
        let listed = faults.into_listed();
        assert_eq!(listed.len(), Faults::MOST_LISTED + 1);
        assert_eq!(listed.last().unwrap().detail, "7 further faults are not listed");
    }
}
