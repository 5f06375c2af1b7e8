//! The path of a request: the text of a program, or points of the tip; and its cutters, one, or several by the T numbers of the
//! program.

use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Components, Faulted, Faults, JsonPath, Kind, List, Member, Object, Quantity, Whole, members, text};
use crate::http::wire::{CandidateKind, NamedCandidate, PathPoints};
use crate::path::MoveKind;
use crate::path::program::{Dialect, Program, ProgramPoint, Reached, ReadSettings, read};
use crate::quantity::Speed;
use serde_json::value::RawValue;
use std::collections::{BTreeMap, BTreeSet};
use utoipa::openapi::schema::{AdditionalProperties, ArrayBuilder, ObjectBuilder, OneOfBuilder, RefBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// The most points of a path, arcs in chords.
pub(in crate::http) const MOST_POINTS: usize = 1_100_000;

/// The distance in mm between an arc and its chords: a fiftieth of the smallest usual tolerance, 5 um.
const SAGITTA: f64 = 1e-4;

/// The member `path`.
pub(super) const PATH: Member<PathKind> = Member::new("path", "the path of the cutter: a program, or points", PathKind);

/// A path, with the text of a program.
#[derive(Debug, Clone)]
pub(super) struct StatedPath {
    pub(super) program: Program,
    /// `None` for points.
    pub(super) text: Option<String>,
}

members! {
    /// A path: a program, or points.
    pub(super) struct PathMembers for PathKind ("Path", "A path of the tip: `program`, `passes`, or `tip_mm` with its rapids and its feed rate") -> StatedPath {
        program: optional PROGRAM: ProgramText = ("program", ProgramText, "the text of a program in G-code or Heidenhain's Klartext, of APT statements, or of columns x, y, z and feed rate"),
        passes: optional PASSES: PassesKind = ("passes", PassesKind, "the passes of an answer, as they are"),
        tip: optional TIP: PathPoints = ("tip_mm", PathPoints, "the tip's points [x, y, z] in their order"),
        rapid: optional RAPID: List<Whole> = ("rapid", List { item: Whole { minimum: 0, maximum: 1_100_000, example: 2 },
            about_item: "the index of a point, from 0", fewest: 0, most: MOST_POINTS }, "the points that are reached by a rapid move; no move leads to the first one, with index 0, which may be among them"),
        feed_rates: optional FEED_RATES: FeedRates = ("feed_rate_mm_min", FeedRates,
            "the feed rate of all moves, or one of the move to each point; absent = the machine's"),
    }
}

impl PathMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
        let (program, passes, tip, rapid, feed_rates) = (self.program?, self.passes?, self.tip?, self.rapid?, self.feed_rates?);
        if program.is_some() && passes.is_some() {
            return Err(faults.add(path, RequestFault::ConflictingFields, "give program, passes or tip_mm"));
        }
        match (program.or(passes), tip) {
            (Some(_), _) if rapid.is_some() || feed_rates.is_some() => Err(faults.add(
                path,
                RequestFault::ConflictingFields,
                "rapid and feed_rate_mm_min belong to tip_mm; a program and passes state their own",
            )),
            (Some(stated), None) => Ok(stated),
            (None, Some(tip)) => {
                let mut points = stated_points(tip, &feed_rates.unwrap_or_default(), path, faults)?;
                let at = path.member(RAPID.name);
                for (place, index) in rapid.unwrap_or_default().into_iter().enumerate() {
                    match points.get_mut(index as usize) {
                        Some(point) => point.reached = Reached::Rapid,
                        None => {
                            faults.add(&at.item(place), RequestFault::OutOfRange, format_args!("there is no point {index}"));
                        }
                    }
                }
                Ok(path_of(points))
            }
            (Some(_), Some(_)) => Err(faults.add(path, RequestFault::ConflictingFields, "give program, passes or tip_mm")),
            (None, None) => Err(faults.add(path, RequestFault::MissingField, "give program, passes or tip_mm")),
        }
    }
}

/// The points of the object at `path`, all reached at their feed rates: none, one, or as many as there are points.
fn stated_points(tip: Vec<[f64; 3]>, rates: &[Speed], path: &JsonPath<'_>, faults: &mut Faults) -> Result<Vec<ProgramPoint>, Faulted> {
    if rates.len() > 1 && rates.len() != tip.len() {
        let detail = format_args!("there are {} points and {} feed rates", tip.len(), rates.len());
        return Err(faults.add(&path.member(FEED_RATES.name), RequestFault::WrongCount, detail));
    }
    if tip.len() > MOST_POINTS {
        let detail = format_args!("at most {MOST_POINTS} points, there are {}", tip.len());
        return Err(faults.add(&path.member(TIP.name), RequestFault::TooManyItems, detail));
    }
    let rate = |index: usize| rates.get(index).or(rates.first()).map(|rate| rate.mm_min());
    let stated = |(index, point)| ProgramPoint {
        point,
        reached: Reached::Feed,
        feed_rate: rate(index),
        line: 0,
        tool: 0,
        spindle_speed: None,
        feed_unit: 1.0,
    };
    Ok(tip.into_iter().enumerate().map(stated).collect())
}

/// The path of points without a text; no move leads to the first one.
fn path_of(mut points: Vec<ProgramPoint>) -> StatedPath {
    if let Some(first) = points.first_mut() {
        first.reached = Reached::FromUnknown;
    }
    StatedPath { program: Program { dialect: Dialect::Columns, points }, text: None }
}

/// The passes of an answer. Their operations are the numbers of the tools. Columns that say nothing about the path are not read.
pub(super) struct PassesKind;

impl PassesKind {
    const MOVES: List<Choice<MoveKind>> = List {
        item: Choice { name: None, words: &[("cut", MoveKind::Cut), ("link", MoveKind::Link), ("rapid", MoveKind::Rapid)] },
        about_item: "how the tip gets to a point",
        fewest: 0,
        most: MOST_POINTS,
    };
    const RUNS: List<Whole> = List {
        item: Whole { minimum: 0, maximum: 1_100_000, example: 0 },
        about_item: "the number of a point or an operation",
        fewest: 0,
        most: MOST_POINTS,
    };
}

impl Kind for PassesKind {
    type Value = StatedPath;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
        let columns = Object::open(raw, path, faults)?.into_members(faults)?;
        let column = |name: &str, faults: &mut Faults| {
            let found = columns.iter().find(|(known, _)| known == name).map(|(_, raw)| *raw);
            found.ok_or_else(|| faults.add(&path.member(name), RequestFault::MissingField, "the passes of an answer have this column"))
        };
        let tip = column(TIP.name, faults).and_then(|raw| PathPoints.read(raw, path.member(TIP.name), faults));
        let moves = column("move", faults).and_then(|raw| Self::MOVES.read(raw, path.member("move"), faults));
        let rates = column(FEED_RATES.name, faults).and_then(|raw| FeedRates.read(raw, path.member(FEED_RATES.name), faults));
        let [starts, operations] =
            ["run_starts", "operation"].map(|name| column(name, faults).and_then(|raw| Self::RUNS.read(raw, path.member(name), faults)));
        let counts = [
            ("move", moves.as_ref().map(Vec::len), tip.as_ref().map(Vec::len)),
            ("operation", operations.as_ref().map(Vec::len), starts.as_ref().map(Vec::len)),
        ];
        let checked = counts.map(|(name, found, expected)| match (found, expected) {
            (Ok(found), Ok(expected)) if found != expected => {
                let detail = format_args!("expected {expected} items, found {found}");
                Err(faults.add(&path.member(name), RequestFault::WrongCount, detail))
            }
            _ => Ok(()),
        });
        checked.into_iter().collect::<Result<(), Faulted>>()?;
        let (tip, moves, rates, starts, operations) = (tip?, moves?, rates?, starts?, operations?);
        let mut points = stated_points(tip, &rates, &path, faults)?;
        for (point, _) in points.iter_mut().zip(&moves).filter(|(_, kind)| **kind == MoveKind::Rapid) {
            point.reached = Reached::Rapid;
        }
        // Passes of which the beginning was removed may have points before the first run: they have its tool.
        let mut runs = starts.iter().zip(&operations).peekable();
        let mut tool = operations.first().copied().unwrap_or_default();
        for (index, point) in points.iter_mut().enumerate() {
            while let Some((_, operation)) = runs.next_if(|(start, _)| **start as usize <= index) {
                tool = *operation;
            }
            point.tool = tool;
        }
        Ok(path_of(points))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        RefBuilder::new().ref_location_from_schema_name("Passes").description(Some(about)).build().into()
    }
}

/// The text of a program. Its arcs become chords later, when the tolerance is known; what is wrong with it is found here.
pub(super) struct ProgramText;

impl Kind for ProgramText {
    type Value = StatedPath;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
        let program = text(raw, path, faults)?;
        read_program(program, &path, faults)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about)).min_length(Some(1));
        schema.examples(["G21 G90\nG0 X0 Y0 Z5\nG1 Z0 F3000\nX40"]).into()
    }
}

/// A path in a file: a program, or the passes of an answer, alone or in the answer. Faults are recorded at `path`.
pub(super) fn read_path_file(text: String, path: &JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
    if !text.trim_start().starts_with('{') {
        return read_program(text, path, faults);
    }
    let raw: &RawValue = serde_json::from_str(&text)
        .map_err(|error| faults.add(path, RequestFault::FaultyProgram, format_args!("the JSON of the passes cannot be read: {error}")))?;
    let members = Object::open(raw, *path, faults)?.into_members(faults)?;
    match members.iter().find(|(name, _)| name == PASSES.name) {
        Some((_, passes)) => PassesKind.read(passes, path.member(PASSES.name), faults),
        None => PassesKind.read(raw, *path, faults),
    }
}

/// A program, with its faults recorded at `path`.
pub(super) fn read_program(text: String, path: &JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
    let program = read(&text, &ReadSettings { sagitta: SAGITTA, most_points: MOST_POINTS }).map_err(|found| {
        let mut faulted = Faulted;
        for fault in found {
            faulted = faults.add(path, RequestFault::FaultyProgram, fault);
        }
        faulted
    })?;
    Ok(StatedPath { program, text: Some(text) })
}

/// One feed rate, or an array of them.
pub(super) struct FeedRates;

impl Kind for FeedRates {
    type Value = Vec<Speed>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Vec<Speed>, Faulted> {
        const ONE: Quantity<Speed> = Quantity::new(Speed::from_mm_min, 3000.0);
        if raw.get().starts_with('[') {
            return List { item: ONE, about_item: "a feed rate", fewest: 1, most: MOST_POINTS }.read(raw, path, faults);
        }
        ONE.read(raw, path, faults).map(|rate| vec![rate])
    }

    fn schema(&self, about: &str, components: &mut Components) -> RefOr<Schema> {
        let one = || Quantity::new(Speed::from_mm_min, 3000.0);
        let each = one().schema("", components);
        let several = ArrayBuilder::new().items(each.clone()).min_items(Some(1));
        OneOfBuilder::new().item(each).item(several).description(Some(about)).into()
    }
}

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
