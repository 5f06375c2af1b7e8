//! Reader of cutters in CSV, one on each line after a header:
//! `name,type,diameter_mm,corner_radius_mm,teeth,spindle_speed_rpm,max_feed_per_tooth_mm`, with `_in` for inches in
//! place of `_mm`; also `number`, `flute_length_mm` and `preset`, and the dimensions of other shapes: `taper_deg`,
//! `shank_diameter_mm`, `lens_radius_mm`, `tip_radius_mm`, `side_radius_mm`.
//!
//! Fusion's own table, exported as CSV or copied with tabs, has columns such as `Diameter (tool_diameter)`, and the unit
//! of each tool in a column. Names and units of catalogues are read too: `Dia (mm)`, `Flutes`, `Description`.
//!
//! Columns may be in any order; other columns are not read. The separator of the header is detected: a comma, a
//! semicolon or a tab; a line `sep=;` before the header states it. A decimal comma is accepted if the comma is not the
//! separator, or in quotation marks.

use super::cutter_shape::{Dimension, Dimensions, LibraryShape};
use super::dimension::{LengthUnit, number, spindle_speed, teeth, tool_number, unambiguous_thousands};
use super::library_fault::{Flaws, LibraryFaults};
use super::quoted;
use super::{ReadTool, ToolLibrary, ToolParts, ToolPlace};
use crate::cancellation::CancelFlag;
use crate::file_fault::{FileFaultKind, Flaw};
use crate::milling::Cutter;
use crate::quantity::Length;

/// The quantity in a column.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    Name,
    Kind,
    Number,
    Teeth,
    SpindleSpeed,
    Preset,
    /// The unit of the lengths in the same line.
    Unit,
    Diameter(ColumnUnit),
    CornerRadius(ColumnUnit),
    MaxFeedPerTooth(ColumnUnit),
    FluteLength(ColumnUnit),
    ShankDiameter(ColumnUnit),
    LensRadius(ColumnUnit),
    TipRadius(ColumnUnit),
    SideRadius(ColumnUnit),
    UpperRadius(ColumnUnit),
    /// In degrees.
    Taper,
}

/// The unit of a column of lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ColumnUnit {
    Stated(LengthUnit),
    /// The unit in the column [`Column::Unit`].
    OfLine,
}

/// The largest table in bytes: 400 for each of 10,000 tools. It also limits the number of fields.
const LARGEST: usize = 4 << 20;

/// Adds the tools of a table of cutters. Once `cancel` is set, it returns early.
///
/// # Errors
/// The file is not a table, or its header has faults, or the library is full.
pub(super) fn read(text: &str, file: &str, library: &mut ToolLibrary, cancel: &CancelFlag) -> Result<(), LibraryFaults> {
    let refused = |flaw: Flaw| LibraryFaults::from(flaw.in_file(file));
    if text.len() > LARGEST {
        return Err(refused(Flaw::too_large(format!("a table of at most {LARGEST} bytes"), format!("{} bytes", text.len()))));
    }
    let (separator, text) = separator(text);
    let mut records = ::csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .has_headers(false)
        .comment(Some(b'#'))
        .trim(::csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut record = ::csv::StringRecord::new();
    let mut table: Option<Table> = None;
    let mut position = 0;
    loop {
        let more = records.read_record(&mut record);
        let has_more = more.map_err(|error| refused(Flaw::malformed("a table in CSV", super::shortened(&error.to_string()))))?;
        if !has_more || cancel.is_cancelled() {
            break;
        }
        if record.iter().all(str::is_empty) {
            continue;
        }
        let Some(table) = &table else {
            table = Some(Table::of(&record, file)?);
            continue;
        };
        position += 1;
        let row = Row { table, record: &record };
        library.add(row.read(position), &ToolPlace { file, position, name: row.text(Column::Name) }).map_err(refused)?;
    }
    if table.is_none() {
        return Err(refused(Flaw::new(FileFaultKind::Empty, "a header and a line for each cutter", "nothing")));
    }
    Ok(())
}

/// The separator, and the text after a line that states it.
fn separator(text: &str) -> (u8, &str) {
    let (first, rest) = text.split_once('\n').unwrap_or((text, ""));
    let stated = first.trim().get(..4).filter(|start| start.eq_ignore_ascii_case("sep="));
    if let (Some(_), &[byte]) = (stated, first.trim_end_matches(['\r', '\n']).as_bytes().get(4..).unwrap_or_default()) {
        return (byte, rest);
    }
    let header = text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    let count = |separator: char| header.matches(separator).count();
    let separator = [';', '\t', ','].into_iter().max_by_key(|separator| count(*separator)).unwrap_or(',');
    (u8::try_from(separator).unwrap_or(b','), text)
}

/// The columns of a table.
struct Table {
    columns: Vec<Option<Column>>,
}

impl Table {
    /// The columns that a header names, or all its faults.
    fn of(header: &::csv::StringRecord, file: &str) -> Result<Self, LibraryFaults> {
        let mut flaws = Vec::new();
        let has_units = header.iter().any(|name| matches!(column(name, false), Ok(Some(Column::Unit))));
        let columns: Vec<Option<Column>> = header
            .iter()
            .map(|name| {
                column(name, has_units).unwrap_or_else(|flaw| {
                    flaws.push(flaw);
                    None
                })
            })
            .collect();
        let has = |wanted: &dyn Fn(&Column) -> bool| columns.iter().flatten().any(wanted);
        if !has(&|column| *column == Column::Kind) || (flaws.is_empty() && !has(&|column| matches!(column, Column::Diameter(_)))) {
            let found = quoted(&header.iter().collect::<Vec<_>>().join(","));
            let expected =
                "a tool library: JSON of Fusion or FreeCAD, a zip of them, or CSV with the columns type and diameter_mm or diameter_in";
            flaws.push(Flaw::new(FileFaultKind::UnknownFormat, expected, found));
        }
        for (index, column) in columns.iter().enumerate() {
            if let Some(column) = column
                && columns[..index].iter().flatten().any(|other| std::mem::discriminant(other) == std::mem::discriminant(column))
            {
                flaws.push(Flaw::malformed("each quantity in one column, in one unit", format!("{} again", quoted(&header[index]))));
            }
        }
        flaws.truncate(super::MOST_FAULTY);
        let faults = flaws.into_iter().map(|flaw| flaw.in_file(file)).collect();
        LibraryFaults::of_files(faults).map_or(Ok(Self { columns }), Err)
    }
}

/// The quantity in a column of this name; `None` for a column that is not read. `has_units` states that another column
/// has the units of lengths.
fn column(name: &str, has_units: bool) -> Result<Option<Column>, Flaw> {
    type OfLength = fn(ColumnUnit) -> Column;
    let (quantity, unit) = quantity_and_unit(name);
    // The first name of each is that of the service, which must state a unit. Other tables may have columns with the names of
    // the last five, of which those without a unit are not read.
    let lengths: [(&[&str], OfLength); 9] = [
        (&["diameter", "dia", "dc", "cutting_diameter", "cutter_diameter"], Column::Diameter),
        (&["corner_radius", "corner_rad", "re"], Column::CornerRadius),
        (&["max_feed_per_tooth", "feed_per_tooth", "fz", "chipload", "chip_load"], Column::MaxFeedPerTooth),
        (&["flute_length", "length_of_cut", "loc", "lcf"], Column::FluteLength),
        (&["shank_diameter", "shaft_diameter", "sfdm"], Column::ShankDiameter),
        (&["lens_radius"], Column::LensRadius),
        (&["tip_radius", "lower_radius"], Column::TipRadius),
        (&["side_radius", "profile_radius"], Column::SideRadius),
        (&["upper_radius"], Column::UpperRadius),
    ];
    for (index, (names, column)) in lengths.into_iter().enumerate() {
        let is_length = names.contains(&quantity.as_str());
        let stated = unit.as_deref().and_then(LengthUnit::named).filter(|unit| [LengthUnit::MILLIMETRE, LengthUnit::INCH].contains(unit));
        match stated {
            Some(unit) if is_length => return Ok(Some(column(ColumnUnit::Stated(unit)))),
            None if is_length && unit.is_none() && has_units => return Ok(Some(column(ColumnUnit::OfLine))),
            None if index < 4 && quantity.starts_with(names[0]) => {
                return Err(Flaw::malformed(format!("{0}_mm or {0}_in", names[0]), quoted(name)));
            }
            _ => {}
        }
    }
    Ok(match quantity.as_str() {
        "name" | "description" | "tool_name" => Some(Column::Name),
        "type" | "tool_type" | "kind" => Some(Column::Kind),
        "number" | "tool_number" | "tool_no" => Some(Column::Number),
        "teeth" | "flutes" | "number_of_flutes" | "number_of_teeth" | "no_of_flutes" => Some(Column::Teeth),
        "spindle_speed_rpm" | "spindle_speed" | "rpm" => Some(Column::SpindleSpeed),
        "preset" | "preset_name" => Some(Column::Preset),
        "unit" | "units" => Some(Column::Unit),
        "taper_deg" | "taper" | "taper_angle" => Some(Column::Taper),
        _ => None,
    })
}

/// The quantity that the name of a column states, in lower case with underscores, and its unit: `diameter` and `mm` for
/// `diameter_mm`, `Diameter (mm)` and `Diameter [mm]`. Fusion repeats a column's name as that of a variable:
/// `Corner Radius (tool_cornerRadius)`.
fn quantity_and_unit(name: &str) -> (String, Option<String>) {
    let plain = |text: &str| text.trim().to_lowercase().replace([' ', '-', '.'], "_").trim_end_matches('_').to_owned();
    let bracketed = name.trim().strip_suffix([')', ']']).and_then(|name| name.rsplit_once(['(', '[']));
    if let Some((_, variable)) = bracketed.filter(|(_, inner)| inner.starts_with("tool_") || inner.starts_with("preset_")) {
        let mut quantity = String::new();
        for c in variable.strip_prefix("tool_").unwrap_or(variable).chars() {
            if c.is_uppercase() {
                quantity.push('_');
            }
            quantity.extend(c.to_lowercase());
        }
        return (quantity, None);
    }
    if let Some((before, unit)) = bracketed {
        return (plain(before), Some(unit.trim().to_lowercase()));
    }
    let bare = plain(name);
    for unit in ["mm", "in", "inch", "inches"] {
        if let Some(quantity) = bare.strip_suffix(unit).and_then(|rest| rest.strip_suffix('_')) {
            return (quantity.to_owned(), Some(unit.to_owned()));
        }
    }
    (bare, None)
}

/// A line of a table.
struct Row<'a> {
    table: &'a Table,
    record: &'a ::csv::StringRecord,
}

impl<'a> Row<'a> {
    fn read(&self, position: usize) -> Result<ReadTool, Flaws> {
        let named = self.table.columns.len();
        let extra = self.record.iter().skip(named).any(|field| !field.is_empty());
        if self.record.len() < named || extra {
            return Err(Flaw::malformed(format!("{named} fields, as the header has"), self.record.len().to_string()).into());
        }
        let kind =
            self.text(Column::Kind).ok_or_else(|| Flaw::missing("ball_end, toroidal, flat_end or another type").of_member("type"))?;
        let Some(shape) = LibraryShape::named(kind) else { return Ok(ReadTool::Other(kind.to_owned())) };
        let mut flaws = Flaws::default();
        let cutter = flaws.take(self.cutter(shape));
        let speed =
            self.text(Column::SpindleSpeed).map_or(Ok(()), unambiguous_thousands).map_err(|flaw| flaw.of_member("spindle_speed_rpm"));
        let speed = speed.and_then(|()| self.number(Column::SpindleSpeed, "spindle_speed_rpm", spindle_speed));
        let parts = ToolParts {
            name: self.text(Column::Name).map(str::to_owned),
            number: flaws.take(self.number(Column::Number, "number", |value| tool_number(value).map(Some))).flatten(),
            teeth: flaws.take(self.number(Column::Teeth, "teeth", teeth)).flatten(),
            spindle_speed_rpm: flaws.take(speed).flatten(),
            max_feed_per_tooth: flaws.take(self.length(|column| matches!(column, Column::MaxFeedPerTooth(_)))).and_then(|feed| feed.0),
            flute_length: flaws.take(self.length(|column| matches!(column, Column::FluteLength(_)))).and_then(|length| length.0),
            preset: self.text(Column::Preset).map(str::to_owned),
        };
        ReadTool::unless_flawed(cutter, parts, position, flaws)
    }

    fn cutter(&self, shape: LibraryShape) -> Result<Cutter, Flaw> {
        let diameter = self.length(|column| matches!(column, Column::Diameter(_)))?.0;
        let diameter = diameter.ok_or_else(|| Flaw::missing("the diameter of the cutter").of_member("diameter"))?;
        let (corner_radius, is_corner_stated) = self.length(|column| matches!(column, Column::CornerRadius(_)))?;
        let stated = Dimensions {
            corner_radius,
            is_corner_stated,
            taper_deg: self.number(Column::Taper, "taper_deg", |degrees| Ok(Some(degrees)))?,
            shank_diameter: self.length(|column| matches!(column, Column::ShankDiameter(_)))?.0,
            lens_radius: self.length(|column| matches!(column, Column::LensRadius(_)))?.0,
            tip_radius: self.length(|column| matches!(column, Column::TipRadius(_)))?.0,
            side_radius: self.length(|column| matches!(column, Column::SideRadius(_)))?.0,
            upper_radius: self.length(|column| matches!(column, Column::UpperRadius(_)))?.0,
            flute_length: self.length(|column| matches!(column, Column::FluteLength(_)))?.0,
        };
        shape.cutter(diameter, &stated).map_err(|(dimension, flaw)| {
            flaw.of_member(match dimension {
                Dimension::CornerRadius => "corner_radius",
                Dimension::Taper => "taper_deg",
                Dimension::ShankDiameter => "shank_diameter",
                Dimension::LensRadius => "lens_radius",
                Dimension::TipRadius => "tip_radius",
                Dimension::SideRadius => "side_radius",
                Dimension::UpperRadius => "upper_radius",
            })
        })
    }

    /// The first column that `wanted` accepts, and its field; `None` if the field is empty.
    fn field(&self, wanted: impl Fn(&Column) -> bool) -> Option<(Column, &'a str)> {
        let mut columns = self.table.columns.iter().zip(self.record).filter_map(|(column, field)| Some(((*column)?, field)));
        columns.find(|(column, _)| wanted(column)).filter(|(_, field)| !field.is_empty())
    }

    fn text(&self, wanted: Column) -> Option<&'a str> {
        self.field(|column| *column == wanted).map(|(_, field)| field)
    }

    fn number<T>(&self, wanted: Column, name: &'static str, read: impl Fn(f64) -> Result<Option<T>, Flaw>) -> Result<Option<T>, Flaw> {
        self.text(wanted).map_or(Ok(None), |field| number(field).and_then(read)).map_err(|flaw| flaw.of_member(name))
    }

    /// A length, and whether its field is filled; 0 means unknown.
    fn length(&self, wanted: impl Fn(&Column) -> bool) -> Result<(Option<Length>, bool), Flaw> {
        let Some((column, field)) = self.field(wanted) else { return Ok((None, false)) };
        let (name, unit) = match column {
            Column::Diameter(unit) => ("diameter", unit),
            Column::CornerRadius(unit) => ("corner_radius", unit),
            Column::MaxFeedPerTooth(unit) => ("max_feed_per_tooth", unit),
            Column::FluteLength(unit) => ("flute_length", unit),
            Column::ShankDiameter(unit) => ("shank_diameter", unit),
            Column::LensRadius(unit) => ("lens_radius", unit),
            Column::TipRadius(unit) => ("tip_radius", unit),
            Column::SideRadius(unit) => ("side_radius", unit),
            Column::UpperRadius(unit) => ("upper_radius", unit),
            _ => return Ok((None, false)),
        };
        let unit = match unit {
            ColumnUnit::Stated(unit) => unit,
            ColumnUnit::OfLine => self.unit()?,
        };
        let length = number(field).and_then(|value| unit.length_unless_zero(value)).map_err(|flaw| flaw.of_member(name))?;
        Ok((length, true))
    }

    /// The unit of the lengths of this line.
    fn unit(&self) -> Result<LengthUnit, Flaw> {
        let unit = self.text(Column::Unit).ok_or_else(|| Flaw::missing("the unit of the lengths, mm or inches").of_member("unit"))?;
        LengthUnit::named(unit).ok_or_else(|| Flaw::malformed("mm or inches", quoted(unit)).of_member("unit"))
    }
}
