//! The path of a request: the text of a program, or points of the tip.

use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, List, Member, Quantity, Whole, members, text};
use crate::http::wire::PathPoints;
use crate::path::program::{Dialect, Program, ProgramPoint, Reached, ReadSettings, read};
use crate::quantity::Speed;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};
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
    pub(super) struct PathMembers for PathKind ("Path", "A path of the tip: `program`, or `tip_mm` with its rapids and its feed rate") -> StatedPath {
        program: optional PROGRAM: ProgramText = ("program", ProgramText, "the text of a program in G-code, of APT statements, or of columns x, y, z and feed rate"),
        tip: optional TIP: PathPoints = ("tip_mm", PathPoints, "the tip's points [x, y, z] in their order"),
        rapid: optional RAPID: List<Whole> = ("rapid", List { item: Whole { minimum: 0, maximum: 1_100_000, example: 2 },
            about_item: "the index of a point, from 0", fewest: 0, most: MOST_POINTS }, "the points that are reached by a rapid move; no move leads to the first one, with index 0, which may be among them"),
        feed_rates: optional FEED_RATES: FeedRates = ("feed_rate_mm_min", FeedRates,
            "the feed rate of all moves, or one of the move to each point; absent = the machine's"),
    }
}

impl PathMembers {
    fn build(self, path: &JsonPath<'_>, faults: &mut Faults) -> Result<StatedPath, Faulted> {
        let (program, tip, rapid, feed_rates) = (self.program?, self.tip?, self.rapid?, self.feed_rates?);
        match (program, tip) {
            (Some(_), _) if rapid.is_some() || feed_rates.is_some() => Err(faults.add(
                path,
                RequestFault::ConflictingFields,
                "rapid and feed_rate_mm_min belong to tip_mm; a program states its own",
            )),
            (Some(program), None) => Ok(program),
            (None, Some(tip)) => {
                let rates = feed_rates.unwrap_or_default();
                if rates.len() > 1 && rates.len() != tip.len() {
                    let detail = format_args!("there are {} points and {} feed rates", tip.len(), rates.len());
                    return Err(faults.add(&path.member(FEED_RATES.name), RequestFault::WrongCount, detail));
                }
                if tip.len() > MOST_POINTS {
                    let detail = format_args!("at most {MOST_POINTS} points, there are {}", tip.len());
                    return Err(faults.add(&path.member(TIP.name), RequestFault::TooManyItems, detail));
                }
                let rate = |index: usize| rates.get(index).or(rates.first()).copied();
                let stated = tip.into_iter().enumerate().map(|(index, point)| stated_point(point, rate(index)));
                let mut points: Vec<ProgramPoint> = stated.collect();
                let at = path.member(RAPID.name);
                for (place, index) in rapid.unwrap_or_default().into_iter().enumerate() {
                    match points.get_mut(index as usize) {
                        Some(point) => point.reached = Reached::Rapid,
                        None => {
                            faults.add(&at.item(place), RequestFault::OutOfRange, format_args!("there is no point {index}"));
                        }
                    }
                }
                if let Some(first) = points.first_mut() {
                    first.reached = Reached::FromUnknown;
                }
                Ok(StatedPath { program: Program { dialect: Dialect::Columns, points }, text: None })
            }
            (Some(_), Some(_)) => Err(faults.add(path, RequestFault::ConflictingFields, "give program or tip_mm")),
            (None, None) => Err(faults.add(path, RequestFault::MissingField, "give program or tip_mm")),
        }
    }
}

fn stated_point(point: [f64; 3], feed_rate: Option<Speed>) -> ProgramPoint {
    let feed_rate = feed_rate.map(Speed::mm_min);
    ProgramPoint { point, reached: Reached::Feed, feed_rate, line: 0, tool: 0, spindle_speed: None, feed_unit: 1.0 }
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
