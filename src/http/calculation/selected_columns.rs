//! The request's selection of columns and significant digits for a batch's answer.

use super::Calculation;
use super::column::Column;
use crate::http::codes::RequestFault;
use crate::http::reading::{Components, Faulted, Faults, JsonPath, Kind, Member, Object, ObjectSchema, Whole, items, text};
use crate::http::wire::{CHECK_FIGURES, Figure, Heights};
use crate::numerics::rounding::to_digits;
use serde_json::value::RawValue;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};
use utoipa::openapi::{RefOr, Schema};

const SIGNIFICANT_DIGITS: Member<Whole> = Member::new(
    "significant_digits",
    "the significant digits to which numbers are rounded; absent = all",
    Whole { minimum: 3, maximum: 17, example: 6 },
);

/// The names of figures, each at most once.
struct ColumnNames {
    known: Vec<&'static Figure>,
}

fn columns<C: Calculation>() -> Member<ColumnNames> {
    let known = C::figures().chain(CHECK_FIGURES).collect();
    let about = "the columns of the answer; absent = all except envelope_scallop_height_mm and deviation, which must be named";
    Member::new("columns", about, ColumnNames { known })
}

impl ColumnNames {
    fn names(&self) -> Vec<&'static str> {
        self.known.iter().map(|figure| figure.name).collect()
    }
}

impl Kind for ColumnNames {
    type Value = Vec<&'static Figure>;

    fn read(&self, raw: &RawValue, path: JsonPath<'_>, faults: &mut Faults) -> Result<Self::Value, Faulted> {
        // A list without repetitions has at most as many items as there are names. Further items are read only to
        // report their faults.
        let names = items(raw, "an array", 2 * self.known.len(), path, faults)?;
        if names.is_empty() {
            return Err(faults.add(&path, RequestFault::WrongCount, "name at least one column, or leave the field out"));
        }
        let (mut selected, mut result) = (Vec::<&'static Figure>::new(), Ok(()));
        for (index, raw) in names.into_iter().enumerate() {
            let path = path.item(index);
            let Ok(name) = text(raw, path, faults) else {
                result = Err(Faulted);
                continue;
            };
            match self.known.iter().find(|figure| figure.name == name) {
                None => {
                    let detail = format_args!("expected one of {}, found {name:?}", self.names().join(", "));
                    result = Err(faults.add(&path, RequestFault::UnknownValue, detail));
                }
                Some(figure) if selected.iter().any(|known| known.name == figure.name) => {
                    result = Err(faults.add(&path, RequestFault::RepeatedField, format_args!("the column {name} is named more than once")));
                }
                Some(figure) => selected.push(figure),
            }
        }
        result.map(|()| selected)
    }

    fn schema(&self, about: &str, _: &mut Components) -> RefOr<Schema> {
        let name = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(self.names()));
        let schema = ArrayBuilder::new().items(name).unique_items(true).min_items(Some(1));
        schema.description(Some(about)).examples([serde_json::json!(["step_over_mm"])]).into()
    }
}

/// The columns of an answer.
pub(super) struct ColumnSelection {
    pub(super) figures: Vec<&'static Figure>,
    /// Whether the request names the columns.
    pub(super) is_stated: bool,
    significant_digits: Option<u32>,
    /// The heights that the columns need.
    pub(super) heights: Heights,
    /// Whether a selected column needs the comparison with the cutter's exact shape.
    pub(super) is_compared: bool,
}

impl ColumnSelection {
    /// Reads the selection from `object`.
    pub(super) fn read<C: Calculation>(object: &mut Object<'_, '_>, faults: &mut Faults) -> Result<Self, Faulted> {
        let stated = object.optional(&columns::<C>(), faults);
        let significant_digits = object.optional(&SIGNIFICANT_DIGITS, faults);
        let (stated, significant_digits) = (stated?, significant_digits?);
        let is_stated = stated.is_some();
        let figures = stated.unwrap_or_else(|| C::figures().collect());
        let heights = figures.iter().map(|figure| figure.heights).max().unwrap_or(Heights::Unused);
        let is_compared = figures.iter().any(|figure| CHECK_FIGURES.iter().any(|check| check.name == figure.name));
        Ok(Self { figures, is_stated, significant_digits, heights, is_compared })
    }

    pub(super) fn describe<C: Calculation>(schema: ObjectSchema<'_>) -> ObjectSchema<'_> {
        schema.optional(&columns::<C>()).optional(&SIGNIFICANT_DIGITS)
    }

    /// Whether the answer has the column of a figure.
    pub(super) fn shows(&self, figure: &Figure, column: &Column) -> bool {
        self.is_stated || figure.is_required_column() || column.has_value
    }

    /// The number, rounded to the significant digits.
    pub(super) fn rounded(&self, number: f64) -> f64 {
        self.significant_digits.map_or(number, |digits| to_digits(number, digits))
    }
}
