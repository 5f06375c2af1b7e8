//! The faults of a request, each with its code and its location: the path to a value of the JSON text.

use super::not_finite;
use crate::cancellation::CancelFlag;
use crate::http::codes::{FaultCode, NoAnswerCode, ProblemFigure, RequestFault};
use crate::milling::NoAnswer;
use serde::Serialize;
use serde_json::value::RawValue;
use std::borrow::Cow;
use std::fmt;
use utoipa::ToSchema;

/// One fault of an invalid request.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub(crate) struct Fault {
    /// The location: a JSON pointer (RFC 6901) into the request; for an uploaded file, `detail` has the line or byte.
    #[schema(example = "/cutter/corner_radius_mm")]
    pub(crate) pointer: String,
    pub(crate) code: FaultCode,
    /// What is wrong and what is expected, for people.
    pub(crate) detail: String,
    /// Figures in mm that help the caller to correct the request. A problem with this fault alone has them as members.
    #[serde(skip)]
    pub(crate) figures: Vec<(ProblemFigure, f64)>,
}

impl Fault {
    pub(crate) fn new(path: &JsonPath<'_>, code: impl Into<FaultCode>, detail: impl fmt::Display) -> Self {
        Self { pointer: path.to_string(), code: code.into(), detail: detail.to_string(), figures: Vec::new() }
    }

    /// The fault that a request has no answer because of `cause`, which `detail` describes.
    pub(crate) fn no_answer(cause: NoAnswer, path: &JsonPath<'_>, detail: impl fmt::Display) -> Self {
        let (code, figures) = NoAnswerCode::of(cause);
        Self { figures, ..Self::new(path, code, detail) }
    }
}

/// The error type of readers: proof that a fault was recorded in place of the value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Faulted;

/// All faults of a request, in the order in which they were found.
#[derive(Debug)]
pub(crate) struct Faults {
    most_listed: usize,
    listed: Vec<Fault>,
    unlisted: usize,
    left_out: usize,
    /// The objects that were read, each with its pointer and the names that it may have. Of the objects in an array, only
    /// the first.
    objects: Vec<(String, Vec<&'static str>)>,
    /// Set when the request is no longer needed. `None` for short requests, which are read to their end.
    cancel: Option<CancelFlag>,
}

impl Default for Faults {
    fn default() -> Self {
        Self::at_most(Self::MOST_LISTED)
    }
}

impl Faults {
    /// The largest number of listed faults; further ones are counted. A request can have a fault every few bytes.
    const MOST_LISTED: usize = 1000;

    /// An empty list that will hold this many faults; further ones are counted.
    pub(crate) fn at_most(most_listed: usize) -> Self {
        Self { most_listed, listed: Vec::new(), unlisted: 0, left_out: 0, objects: Vec::new(), cancel: None }
    }

    /// An empty list for readers that end early once `cancel` is set; what they read and find is then discarded.
    pub(crate) fn until(cancel: &CancelFlag) -> Self {
        Self { cancel: Some(cancel.clone()), ..Self::default() }
    }

    /// The flag that ends reading early, for readers of large values.
    pub(crate) fn cancel_flag(&self) -> CancelFlag {
        self.cancel.clone().unwrap_or_default()
    }

    /// Records a fault and returns the proof of it.
    pub(crate) fn add(&mut self, path: &JsonPath<'_>, code: impl Into<FaultCode>, detail: impl fmt::Display) -> Faulted {
        if self.listed.len() < self.most_listed {
            return self.push(Fault::new(path, code, detail));
        }
        // The text of an unlisted fault is not needed.
        self.unlisted += 1;
        Faulted
    }

    /// Records a complete fault.
    pub(crate) fn push(&mut self, fault: Fault) -> Faulted {
        if self.listed.len() < self.most_listed {
            self.listed.push(fault);
        } else {
            self.unlisted += 1;
        }
        Faulted
    }

    /// Takes all faults out of the list.
    pub(crate) fn take(&mut self) -> Self {
        std::mem::replace(self, Self { cancel: self.cancel.clone(), ..Self::at_most(self.most_listed) })
    }

    /// Counts faults that the caller leaves out of the list. Only the total includes them.
    pub(crate) fn add_left_out(&mut self, count: usize) {
        self.left_out += count;
    }

    /// Records the names that the object at `path` may have, for the faults of misplaced members.
    pub(crate) fn object_knows(&mut self, path: &JsonPath<'_>, names: Vec<&'static str>) {
        if path.is_outer() {
            self.objects.push((path.to_string(), names));
        }
    }

    /// Whether the names of the object at `path` are recorded.
    pub(super) fn knows_object(&self, path: &JsonPath<'_>) -> bool {
        let place = path.to_string();
        self.objects.iter().any(|(known, _)| *known == place)
    }

    /// Takes the names of objects from `others`, and nothing else.
    pub(super) fn take_in_objects(&mut self, others: Self) {
        self.objects.extend(others.objects);
    }

    /// Replaces the texts of unknown members by those of `text`, which takes the pointer of the object and its known names.
    pub(crate) fn name_others(&mut self, text: impl Fn(&str, &[&'static str]) -> String) {
        let unknown = FaultCode::from(RequestFault::UnknownField);
        for fault in self.listed.iter_mut().filter(|fault| fault.code == unknown) {
            let object = fault.pointer.rsplit_once('/').map_or("", |(object, _)| object);
            if let Some((_, names)) = self.objects.iter().find(|(place, _)| place == object) {
                fault.detail = text(object, names);
            }
        }
    }

    /// Where a member that is unknown at `pointer` belongs: the pointer of another object that may have its name, and the name
    /// there, which may have another unit.
    fn home_of(&self, pointer: &str) -> Option<(&str, &str)> {
        let (parent, name) = pointer.rsplit_once('/')?;
        let others = || self.objects.iter().filter(|(place, _)| place != parent);
        let other = |is_meant: &dyn Fn(&str) -> bool| {
            others().find_map(|(place, names)| names.iter().find(|known| is_meant(known)).map(|known| (place.as_str(), *known)))
        };
        other(&|known| known == name).or_else(|| {
            let (_, here) = self.objects.iter().find(|(place, _)| place == parent)?;
            let is_near_here = nearest(name, here.iter().copied()).is_some();
            other(&|known| bare(known) == bare(name)).filter(|_| !is_near_here)
        })
    }

    /// The number of all faults, listed or not.
    pub(crate) fn count(&self) -> usize {
        self.listed.len() + self.unlisted + self.left_out
    }

    /// Adds `others` with their pointers mapped by `pointer`; faults whose pointer maps to `None` are left out.
    pub(crate) fn take_in(&mut self, others: Self, pointer: impl Fn(&str) -> Option<String>) {
        self.unlisted += others.unlisted;
        self.left_out += others.left_out;
        for fault in others.listed {
            if let Some(pointer) = pointer(&fault.pointer) {
                self.push(Fault { pointer, ..fault });
            }
        }
    }

    /// The listed faults. If others were only counted, a last entry states their number.
    pub(crate) fn into_listed(mut self) -> Vec<Fault> {
        let unknown = FaultCode::from(RequestFault::UnknownField);
        let mut listed = std::mem::take(&mut self.listed);
        for fault in listed.iter_mut().filter(|fault| fault.code == unknown) {
            if let Some((home, meant)) = self.home_of(&fault.pointer) {
                let place = if home.is_empty() { "at the top of the request".to_owned() } else { format!("in {}", &home[1..]) };
                fault.detail = if fault.pointer.ends_with(&format!("/{meant}")) {
                    format!("{meant} belongs {place}, not here")
                } else {
                    format!("unknown field; did you mean {meant} {place}?")
                };
            }
        }
        self.listed = listed;
        if self.unlisted > 0 {
            let detail = format!("{} further faults are not listed", self.unlisted);
            self.listed.push(Fault::new(&JsonPath::Root, RequestFault::FurtherFaults, detail));
        }
        self.listed
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.listed.is_empty()
    }
}

/// The name that was probably meant by an unknown one: the one with nearly the same letters, or else the one that contains it or is
/// contained in it.
pub(crate) fn meant<'n>(unknown: &str, known: impl Iterator<Item = &'n str> + Clone) -> Option<&'n str> {
    nearest(unknown, known.clone()).or_else(|| containing_or_contained(unknown, known))
}

/// The name that fewest changes of a letter, two at most, turn an unknown one into. Two neighbouring letters in the wrong order are
/// one change; capitals, separators, and a unit at the end count for nothing.
fn nearest<'n>(unknown: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    let most = 2.min(bare(unknown).chars().count() / 3);
    let changes = known.map(|name| {
        let of_bare = strsim::osa_distance(&bare(unknown), &bare(name));
        (of_bare.min(strsim::osa_distance(&letters(unknown), &letters(name))), name)
    });
    changes.filter(|(changes, _)| *changes <= most).min_by_key(|(changes, _)| *changes).map(|(_, name)| name)
}

/// The name that contains an unknown one, or is contained in it, without units and separators: `max_feed_per_tooth_mm` for
/// `feed_per_tooth`, and `diameter_mm` for `ball_diameter_mm`. Of several, the one that differs by fewest letters; `None` if two do.
fn containing_or_contained<'n>(unknown: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
    const LEAST: usize = 3;
    let unknown = bare(unknown);
    let further = known.filter_map(|name| {
        let known = bare(name);
        let [shorter, longer] = if known.len() < unknown.len() { [&known, &unknown] } else { [&unknown, &known] };
        (shorter.len() >= LEAST && longer.contains(shorter.as_str())).then(|| (longer.len() - shorter.len(), name))
    });
    let mut further: Vec<(usize, &str)> = further.collect();
    further.sort_by_key(|(letters, _)| *letters);
    match further[..] {
        [(least, _), (next, _), ..] if least == next => None,
        _ => further.first().map(|(_, name)| *name),
    }
}

/// The letters and digits of a name, in lower case: `stepover` of `stepOver` and of `step-over`.
fn letters(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// The letters of a name without the unit at its end: `feedrate` of `feed_rate_mm_min`. At least one word stays.
fn bare(mut name: &str) -> String {
    const UNITS: [&str; 14] = ["mm", "mm2", "um", "m", "in", "inch", "deg", "rad", "rpm", "per", "min", "s", "s2", "s3"];
    while let Some((rest, _)) = name.rsplit_once('_').filter(|(_, word)| UNITS.contains(word)) {
        name = rest;
    }
    letters(name)
}

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
    fn what_is_left_after_faults_are_taken_can_still_be_cancelled() {
        let cancel = CancelFlag::default();
        let mut faults = Faults::until(&cancel);
        drop(faults.take());
        cancel.cancel();
        assert!(faults.cancel_flag().is_cancelled());
    }

    #[test]
    fn faults_beyond_the_limit_are_counted_not_kept() {
        let mut faults = Faults::default();
        for _ in 0..Faults::MOST_LISTED + 7 {
            faults.add(&JsonPath::Root, RequestFault::WrongType, "y");
        }
        let listed = faults.into_listed();
        assert_eq!(listed.len(), Faults::MOST_LISTED + 1);
        assert_eq!(listed.last().unwrap().detail, "7 further faults are not listed");
    }

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
