//! Readers of tool libraries, which return finishing cutters: Autodesk Fusion (`.json`, `.tools`), FreeCAD (`.fctb`, and zips
//! of them with their `.fctl`), and CSV.
//!
//! A library may contain tools of any type. Ball-end, bull-nose, flat and tapered cutters, lenses and barrels are read; the
//! others are counted by type. A finishing cutter with a fault is listed with all its faults, and the other tools are still
//! read. Callers must show the faulty cutters, because one of them may be the best. Only a file that cannot be read as a
//! library is refused as a whole. Lengths are in the unit that each tool states.
//!
//! The format is detected from the content. Memory is bounded by [`MOST_TOOLS`], [`MOST_FAULTY`] and the limits in `container`.

mod container;
mod csv;
mod cutter_shape;
mod dimension;
mod freecad;
mod fusion;
mod library_fault;

pub use library_fault::{FaultyTool, LibraryFaults};

use crate::cancellation::CancelFlag;
use crate::file_fault::{self, Flaw};
use crate::milling::Cutter;
use crate::quantity::Length;
use library_fault::Flaws;
use std::collections::BTreeMap;

/// The largest number of tools in a library, of all types together.
pub const MOST_TOOLS: usize = 10_000;

/// The largest number of faulty tools of a library that are listed; further ones are counted.
pub const MOST_FAULTY: usize = 100;

/// The largest number of teeth that a library may state.
pub const MOST_TEETH: u32 = 100;

/// The highest spindle speed that a library may state, in rpm.
pub const HIGHEST_SPINDLE_SPEED: f64 = 1e6;

/// The longest name of a tool, a type or a preset that is kept, in characters.
const LONGEST_NAME: usize = 100;

/// The finishing cutters of a library.
///
/// ```
/// use scallopd::tooling::ToolLibrary;
///
/// let csv = "name,type,diameter_mm,corner_radius_mm,teeth\nB6,ball_end,6,,2\nT10,toroidal,10,2,4\nD8,drill,8,,2\n";
/// let library = ToolLibrary::read(csv.as_bytes(), Some("mills.csv")).unwrap();
/// assert_eq!(library.tools().len(), 2);
/// assert_eq!(library.tools()[0].cutter.corner_radius().mm(), 3.0);
/// assert_eq!(library.others().collect::<Vec<_>>(), [("drill", 1)]);
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ToolLibrary {
    tools: Vec<LibraryTool>,
    faulty: Vec<FaultyTool>,
    unlisted_faulty: u64,
    others: BTreeMap<String, u64>,
    unlisted_files: u64,
    skipped_files: u64,
}

/// A finishing cutter of a library.
#[derive(Debug, Clone, PartialEq)]
pub struct LibraryTool {
    /// The tool's description; if it has none, its product number or its number in the library. At most 100 characters.
    pub name: String,
    /// The tool's number in the machine's program.
    pub number: Option<u32>,
    /// The cutter.
    pub cutter: Cutter,
    /// z, the number of teeth, at least 1.
    pub teeth: Option<u32>,
    /// n, the spindle speed, positive, in rpm.
    pub spindle_speed_rpm: Option<f64>,
    /// f_z, the library's feed per tooth, taken as the largest for this cutter.
    pub max_feed_per_tooth: Option<Length>,
    /// The length of the cutting edges along the axis.
    pub flute_length: Option<Length>,
    /// The name of the preset from which speed and feed are taken, if the library has presets: the one with "finish" in
    /// its name, otherwise the first. At most 100 characters.
    pub preset: Option<String>,
}

impl ToolLibrary {
    /// Reads a library. Faults state `file_name`.
    ///
    /// # Errors
    /// [`LibraryFaults`] if a file cannot be read as a library: its faults, and those of the tools that were read.
    pub fn read(bytes: &[u8], file_name: Option<&str>) -> Result<Self, LibraryFaults> {
        Self::read_until(bytes, file_name, &CancelFlag::default())
    }

    /// Reads a library as [`ToolLibrary::read`] does. Once `cancel` is set, it returns early, and the result must be discarded.
    ///
    /// # Errors
    /// As [`ToolLibrary::read`].
    pub fn read_until(bytes: &[u8], file_name: Option<&str>, cancel: &CancelFlag) -> Result<Self, LibraryFaults> {
        let mut library = Self::default();
        match container::read(bytes, file_name.unwrap_or("the library"), &mut library, cancel) {
            Ok(()) => Ok(library),
            Err(faults) => Err(faults.and(library.faulty)),
        }
    }

    /// The finishing cutters, in the order of the library.
    #[must_use]
    pub fn tools(&self) -> &[LibraryTool] {
        &self.tools
    }

    /// The finishing cutters, by value.
    #[must_use]
    pub fn into_tools(self) -> Vec<LibraryTool> {
        self.tools
    }

    /// The finishing cutters with a fault, in the order of the library, at most [`MOST_FAULTY`].
    #[must_use]
    pub fn faulty(&self) -> &[FaultyTool] {
        &self.faulty
    }

    /// The number of faulty tools beyond those that are listed.
    #[must_use]
    pub fn unlisted_faulty(&self) -> u64 {
        self.unlisted_faulty
    }

    /// The number of tool files in a zip that none of its `.fctl` lists names; without such a list all are read.
    #[must_use]
    pub fn unlisted_files(&self) -> u64 {
        self.unlisted_files
    }

    /// The types of the tools that are not finishing cutters, in alphabetical order, each with the number of its tools.
    pub fn others(&self) -> impl Iterator<Item = (&str, u64)> {
        self.others.iter().map(|(kind, count)| (kind.as_str(), *count))
    }

    /// The number of files in a zip without tools: pictures, shapes, texts.
    #[must_use]
    pub fn skipped_files(&self) -> u64 {
        self.skipped_files
    }

    fn count(&self) -> u64 {
        (self.tools.len() + self.faulty.len()) as u64 + self.unlisted_faulty + self.unlisted_files + self.others.values().sum::<u64>()
    }

    /// Adds a tool, or its faults.
    ///
    /// # Errors
    /// The library is full.
    fn add(&mut self, tool: Result<ReadTool, Flaws>, place: &ToolPlace) -> Result<(), Flaw> {
        if self.count() >= MOST_TOOLS as u64 {
            return Err(Flaw::too_large(format!("at most {MOST_TOOLS} tools"), "more"));
        }
        match tool {
            Ok(ReadTool::Finishing(tool)) => self.tools.push(*tool),
            Ok(ReadTool::Other(kind)) => *self.others.entry(shortened(&kind)).or_default() += 1,
            Err(_) if self.faulty.len() == MOST_FAULTY => self.unlisted_faulty += 1,
            Err(flaws) => self.faulty.push(flaws.of_tool(place)),
        }
        Ok(())
    }
}

/// The place of a tool in a file.
#[derive(Debug)]
struct ToolPlace<'a> {
    file: &'a str,
    /// The position among the tools of the file, from 1.
    position: usize,
    name: Option<&'a str>,
}

impl ToolPlace<'_> {
    /// The tool's name, or its position if it has none.
    fn name(&self) -> String {
        match self.name.map(str::trim) {
            Some(name) if !name.is_empty() => shortened(name),
            _ => format!("tool {}", self.position),
        }
    }
}

/// A tool of a library, as the reader of a format returns it.
#[derive(Debug)]
enum ReadTool {
    Finishing(Box<LibraryTool>),
    /// A tool of this type, which is not a finishing cutter.
    Other(String),
}

impl ReadTool {
    /// The cutter with its other values, or the flaws. If `cutter` is `None`, there is at least one flaw.
    fn unless_flawed(cutter: Option<Cutter>, parts: ToolParts, position: usize, flaws: Flaws) -> Result<Self, Flaws> {
        let tool = cutter.map(|cutter| Self::Finishing(Box::new(parts.with(cutter, position))));
        match tool {
            Some(tool) => flaws.or(tool),
            None => Err(flaws),
        }
    }
}

/// The values of a finishing cutter besides its shape, as the reader of a format returns them.
#[derive(Debug, Default)]
struct ToolParts {
    name: Option<String>,
    number: Option<u32>,
    teeth: Option<u32>,
    spindle_speed_rpm: Option<f64>,
    max_feed_per_tooth: Option<Length>,
    flute_length: Option<Length>,
    preset: Option<String>,
}

impl ToolParts {
    /// The tool with these values. `position` counts the tools of the file from 1.
    fn with(self, cutter: Cutter, position: usize) -> LibraryTool {
        LibraryTool {
            name: self.name.map_or_else(|| format!("tool {}", self.number.map_or(position as u64, u64::from)), |name| shortened(&name)),
            number: self.number,
            cutter,
            teeth: self.teeth,
            spindle_speed_rpm: self.spindle_speed_rpm,
            max_feed_per_tooth: self.max_feed_per_tooth,
            flute_length: self.flute_length,
            preset: self.preset.map(|preset| shortened(&preset)),
        }
    }
}

/// `text` without blanks around it, with its control characters escaped, cut to [`LONGEST_NAME`] characters.
fn shortened(text: &str) -> String {
    file_fault::shortened(text, LONGEST_NAME)
}

/// The same in quotation marks: headers and paths are longer than words of a surface file, and names may have inch marks.
fn quoted(text: &str) -> String {
    format!("\"{}\"", shortened(text))
}
