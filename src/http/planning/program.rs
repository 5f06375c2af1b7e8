//! The recommended plan as a program, and how it is to be written.

use crate::http::codes::RequestFault;
use crate::http::reading::{Choice, Components, Faulted, Faults, Flag, JsonPath, Kind, List, Quantity, Whole, describe, members, text};
use crate::http::wire::{NamedCandidate, OnePoint, answer};
use crate::motion::Machine;
use crate::numerics::vector::difference;
use crate::path::Move;
use crate::path::program::{Operation, WriteSettings, write};
use crate::planning::plan::Passes;
use crate::quantity::SpindleSpeed;
use serde_json::value::RawValue;
use std::collections::HashSet;
use utoipa::openapi::schema::{ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

/// How a program is written.
#[expect(clippy::struct_excessive_bools, reason = "each switches words of its own")]
#[derive(Debug, Clone, Default)]
pub(super) struct ProgramOptions {
    klartext: bool,
    inches: bool,
    number_lines: bool,
    decimals: Option<u32>,
    header: Vec<String>,
    footer: Vec<String>,
    tool: Option<u32>,
    spindle_speed: Option<SpindleSpeed>,
    coolant: bool,
    length_offset: bool,
    origin: [f64; 3],
}

members! {
    /// The members of the options of a program.
    pub(super) struct ProgramOptionMembers for ProgramOptionsKind ("ProgramOptions", "How the program is written; only with `program` in `include`") -> ProgramOptions {
        klartext: optional PROGRAM_DIALECT: Choice<bool> = ("dialect", Choice { name: None, words: &[("iso", false), ("klartext", true)] },
            "the language of the program: iso (default), G-code; klartext, that of Heidenhain's controls"),
        unit: optional PROGRAM_UNIT: Choice<bool> = ("unit", Choice { name: None, words: &[("mm", false), ("inch", true)] },
            "the unit of the program: mm (default) or inch"),
        number_lines: optional NUMBER_LINES: Flag = ("number_lines", Flag, "whether blocks are numbered, those of G-code in steps of 10, from 10 again after 99990; absent = false"),
        decimals: optional DECIMALS: Whole = ("decimals", Whole { minimum: 2, maximum: 6, example: 4 }, "the decimals of coordinates; absent = 4, which in inches rounds by up to 1.3 um"),
        header: optional HEADER: List<Line> = ("header", List { item: Line, about_item: "a block of printable ASCII characters", fewest: 0, most: 50 }, "blocks at the beginning"),
        footer: optional FOOTER: List<Line> = ("footer", List { item: Line, about_item: "a block of printable ASCII characters", fewest: 0, most: 50 }, "blocks before M5 and M30"),
        tool: optional TOOL: Whole = ("tool", Whole { minimum: 0, maximum: 999_999, example: 3 }, "the number of the first tool call; further cutters of a plan of several operations follow; absent = 1"),
        spindle_speed: optional PROGRAM_SPEED: Quantity<SpindleSpeed> = ("spindle_speed_rpm", Quantity::new(SpindleSpeed::from_rpm, 10_000.0),
            "the spindle speed of the program; absent = the cutter's, at most the machine's; if neither is stated, the program has no S and no M3"),
        coolant: optional COOLANT: Flag = ("coolant", Flag, "whether coolant is on, M8; absent = false"),
        origin: optional PROGRAM_ORIGIN: OnePoint = ("origin_mm", OnePoint,
            "where the program's zero point is in the coordinates of the surface, such as a corner of the stock; absent = at the zero point of the surface"),
        length_offset: optional LENGTH_OFFSET: Flag = ("tool_length_offset", Flag,
            "whether the first Z after each tool call of G-code has G43 H with the tool's number; absent = false. Without it, a control whose tool call does not set the length moves the spindle's nose to where the tip should be"),
    }
}

impl ProgramOptionMembers {
    fn build(self, _: &JsonPath<'_>, _: &mut Faults) -> Result<ProgramOptions, Faulted> {
        let Self { klartext, unit, number_lines, decimals, header, footer, tool, spindle_speed, coolant, length_offset, origin } = self;
        Ok(ProgramOptions {
            klartext: klartext?.unwrap_or_default(),
            inches: unit?.unwrap_or_default(),
            number_lines: number_lines?.unwrap_or_default(),
            decimals: decimals?,
            header: header?.unwrap_or_default(),
            footer: footer?.unwrap_or_default(),
            tool: tool?,
            spindle_speed: spindle_speed?,
            coolant: coolant?.unwrap_or_default(),
            length_offset: length_offset?.unwrap_or_default(),
            origin: origin?.unwrap_or_default(),
        })
    }
}

/// A block of a program, as it is written.
pub(super) struct Line;

impl Line {
    const LONGEST: usize = 120;
}

impl Kind for Line {
    type Value = String;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<String, Faulted> {
        let line = text(raw, path, faults)?;
        if line.len() <= Self::LONGEST && line.bytes().all(|byte| (b' '..=b'~').contains(&byte)) {
            return Ok(line);
        }
        let detail = format_args!("a block has at most {} printable ASCII characters, found {}", Self::LONGEST, describe(raw));
        Err(faults.add(&path, RequestFault::OutOfRange, detail))
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let schema = ObjectBuilder::new().schema_type(Type::String).description(Some(about));
        schema.max_length(Some(Self::LONGEST)).examples(["G54"]).into()
    }
}

answer! {
    /// A program.
    #[schema(as = Program)]
    pub(crate) struct ProgramAnswer {
        /// The text. A plan has a tool call for each operation and straight moves alone; in G-code, coordinates and feeds have a decimal
        /// point, and modal words are not repeated; a path's own program is the same, byte for byte, but for its feed words.
        pub(super) text: String,
        /// The dialect of the text: `iso`, `klartext`, `apt` or `columns`.
        pub(super) dialect: &'static str [example = "iso"],
    }
}

impl ProgramAnswer {
    /// The program of a path. Its operations have these cutters, numbered from the first tool's number on, each cutter once.
    pub(super) fn of(passes: &Passes, cutters: &[&NamedCandidate], machine: &Machine, options: &ProgramOptions) -> Option<Self> {
        let tip = |index: usize| difference(passes.points[index].tip, options.origin);
        let moves: Vec<Move> =
            (1..passes.points.len()).map(|to| Move { from: tip(to - 1), to: tip(to), kind: passes.points[to].kind }).collect();
        let feed_rates: Vec<f64> = passes.points.iter().skip(1).map(|point| point.feed_rate.mm_min()).collect();
        let most = machine.max_spindle_speed.map_or(f64::INFINITY, SpindleSpeed::rpm);
        let starts = &passes.operation_starts;
        let operation = |index: usize| {
            let cutter: &NamedCandidate = cutters[index];
            let own = cutter.candidate.drive.map(|drive| drive.spindle_speed.rpm());
            let first_with = cutters.iter().position(|other| std::ptr::eq(*other, cutter)).unwrap_or(index);
            let before: HashSet<_> = cutters[..first_with].iter().map(|cutter| std::ptr::from_ref(*cutter)).collect();
            // The move from the last point of an operation to the next one's first belongs to neither.
            let end = starts.get(index + 1).map_or(moves.len(), |next| next - 1);
            Operation {
                tool: options.tool.unwrap_or(1) + u32::try_from(before.len()).unwrap_or_default(),
                name: cutter.name.as_deref(),
                spindle_speed: options.spindle_speed.map(SpindleSpeed::rpm).or(own.map(|own| own.min(most))),
                moves: &moves[starts[index]..end],
                feed_rates: &feed_rates[starts[index]..end],
            }
        };
        let operations: Vec<Operation> = (0..cutters.len().min(starts.len())).map(operation).collect();
        let settings = WriteSettings {
            inches: options.inches,
            number_lines: options.number_lines,
            decimals: options.decimals.unwrap_or(4) as usize,
            header: &options.header,
            footer: &options.footer,
            coolant: options.coolant,
            length_offset: options.length_offset,
            klartext: options.klartext,
        };
        let text = write(&operations, &settings).ok()?;
        Some(Self { text, dialect: if options.klartext { "klartext" } else { "iso" } })
    }
}
