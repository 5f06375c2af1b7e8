//! The figures of the calculations' answers. A table has a row for each, with name, description and getter; single
//! answers, columns of batches and their schemas are built from it.

use super::answer;
use crate::http::codes::FaultCode;
use crate::http::reading::{Components, Fault};
use crate::milling::{Contact, EvaluatedPass, ModelWarning, NoAnswer, ScallopHeight, ra_um};
use crate::quantity::Length;
use serde::{Serialize, Serializer};
use serde_json::Value;
use utoipa::openapi::schema::{ArrayBuilder, KnownFormat, ObjectBuilder, OneOfBuilder, SchemaFormat, SchemaType, Type};
use utoipa::openapi::{RefOr, Schema};

/// The most words in a figure that is a list of words.
pub(crate) const MOST_WORDS: usize = 5;

/// The result of a calculation at a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Figures {
    /// h, if a figure of the answer needs it.
    pub(crate) height: Option<Length>,
    /// h in its parts, if a figure of the answer needs them.
    parts: Option<ScallopHeight>,
    largest_turn: f64,
    /// Along the surface.
    pub(crate) step_over: Length,
    /// `None` without tooth marks.
    pub(crate) feed_per_tooth: Option<Length>,
    pub(crate) feed_rate_mm_min: Option<f64>,
    /// The word for the limit of the feed.
    pub(crate) limited_by: Option<&'static str>,
    /// The words for the limits that bind, followed by `None`.
    pub(crate) binding_limits: [Option<&'static str>; MOST_WORDS],
    /// The comparison with the envelope's height, if requested.
    pub(crate) check: Option<Check>,
    effective_radius: Option<Length>,
    transverse_effective_radius: Option<Length>,
    contact: Contact,
}

/// The parts of the scallop height that the figures of an answer need. Model `envelope` searches for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Heights {
    /// None.
    Unused,
    /// The whole height, h.
    Total,
    /// h and the height by the step-over alone, h1.
    Parts,
}

impl Figures {
    /// The figures at a step-over and a feed per tooth, given or found. `step_over_height` is h1, if it is known.
    #[inline]
    pub(crate) fn at(
        pass: &EvaluatedPass,
        step_over: Length,
        feed_per_tooth: Option<Length>,
        heights: Heights,
        step_over_height: Option<Length>,
    ) -> Result<Self, NoAnswer> {
        let parts = match (heights, step_over_height) {
            (Heights::Parts, None) => Some(pass.scallop_height(step_over, feed_per_tooth)?),
            (Heights::Parts, Some(step_over_height)) => Some(pass.height_above(step_over_height, step_over, feed_per_tooth)?),
            (Heights::Unused | Heights::Total, _) => None,
        };
        let height = match (parts, heights) {
            (Some(parts), _) => Some(parts),
            (None, Heights::Unused) if pass.inverses_have_heights() => None,
            (None, _) => Some(pass.total_height(step_over, feed_per_tooth)?),
        };
        Ok(Self {
            height: height.map(ScallopHeight::total),
            parts,
            largest_turn: height.map_or(0.0, ScallopHeight::largest_turn),
            step_over,
            feed_per_tooth,
            feed_rate_mm_min: None,
            limited_by: None,
            binding_limits: [None; MOST_WORDS],
            check: None,
            effective_radius: pass.effective_radius(),
            transverse_effective_radius: pass.transverse_effective_radius(),
            contact: pass.pass().contact,
        })
    }

    /// The warnings about the pass with these figures.
    pub(crate) fn warnings(&self, pass: &EvaluatedPass) -> impl Iterator<Item = ModelWarning> + use<> {
        pass.warnings(self.step_over, self.feed_per_tooth, self.largest_turn)
    }
}

/// A row of the table: one figure of an answer, one column of a batch's.
pub(crate) struct Figure {
    /// The name on the wire, with its unit.
    pub(crate) name: &'static str,
    /// The description for the OpenAPI document.
    about: &'static str,
    /// The bounds of a number.
    minimum: f64,
    maximum: Option<f64>,
    presence: Presence,
    /// The heights from which it is taken.
    pub(crate) heights: Heights,
    pub(crate) get: Get,
}

/// The function that gives a figure's value; `None` if it has none. Words have the schema that lists them.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Get {
    Number(fn(&Figures) -> Option<f64>),
    Word(fn(&Figures) -> Option<&'static str>, WordsSchema),
    Words(fn(&Figures) -> [Option<&'static str>; MOST_WORDS], WordsSchema),
}

type WordsSchema = fn(&str, &mut Components) -> RefOr<Schema>;

/// How a single answer represents a figure without a value. The column of a batch has null, as for a contact without an
/// answer.
#[derive(Debug, Clone, Copy)]
enum Presence {
    /// It always has a value.
    Always,
    /// A single answer has null. The text states when.
    Null(&'static str),
    /// It is absent from a single answer. The text states when.
    Absent(&'static str),
    /// It is absent from a single answer, and its column from a batch's answer if no row has a value. The text states
    /// when it has one.
    Only(&'static str),
}

/// The figures in the answers of all calculations.
pub(crate) const COMMON_FIGURES: &[Figure] = &[
    Figure::number("scallop_height_mm", "h, the scallop height", |figures| figures.height.map(Length::mm)).from(Heights::Total),
    Figure::number("ra_um", "Ra of the geometry across the highest ridge, 0.2566 h, in um; real surfaces are rougher", |figures| {
        figures.height.map(ra_um)
    })
    .from(Heights::Total),
    Figure::number("step_over_height_mm", "h1, the height that the step-over alone leaves", |figures| {
        figures.parts.map(|height| height.step_over.mm())
    })
    .from(Heights::Parts),
    Figure::number("feed_height_mm", "the height that the tooth marks along the feed add", |figures| {
        figures.parts.map(|height| height.feed.mm())
    })
    .from(Heights::Parts),
    Figure {
        maximum: Some(1.0),
        heights: Heights::Parts,
        presence: Presence::Absent("if the height is 0"),
        ..Figure::number("feed_share", "the share of the feed height in the scallop height", |figures| {
            figures.parts.and_then(ScallopHeight::feed_share)
        })
    },
    Figure::number("effective_radius_mm", "R_eff, the groove's radius of curvature across the feed, radial runout included", |figures| {
        figures.effective_radius.map(Length::mm)
    })
    .or_null("if infinite"),
    Figure::number("transverse_effective_radius_mm", "TR_eff, the mark's radius of curvature along the feed", |figures| {
        figures.transverse_effective_radius.map(Length::mm)
    })
    .or_null("if infinite"),
    Figure::number("step_over_mm", "s, the step-over along the surface", |figures| Some(figures.step_over.mm())),
    Figure::number("step_over_xy_mm", "d, the step-over seen from above", |figures| {
        Some(figures.step_over.mm() * figures.contact.spacing_ratio())
    }),
];

/// The figures of a batch that are computed only if the request names their columns.
pub(crate) const CHECK_FIGURES: &[Figure] = &[
    Figure::number("envelope_scallop_height_mm", "the height by the cutter's exact shape (model envelope)", |figures| {
        figures.check.map(|check| check.envelope_scallop_height_mm)
    })
    .from(Heights::Total)
    .only("if columns names it"),
    Figure {
        minimum: -1.0,
        heights: Heights::Total,
        presence: Presence::Only("if columns names it"),
        ..Figure::number(
            "deviation",
            "(height - envelope) / envelope: negative if the model's height is less than the cutter leaves",
            |figures| figures.check.and_then(|check| check.deviation),
        )
    },
];

impl Figure {
    /// A figure that every contact with an answer has.
    pub(crate) const fn new(name: &'static str, about: &'static str, get: Get) -> Self {
        Self { name, about, minimum: 0.0, maximum: None, presence: Presence::Always, heights: Heights::Unused, get }
    }

    /// A number of at least 0 that every contact with an answer has.
    pub(crate) const fn number(name: &'static str, about: &'static str, get: fn(&Figures) -> Option<f64>) -> Self {
        Self::new(name, about, Get::Number(get))
    }

    /// Takes the figure from `heights`.
    const fn from(self, heights: Heights) -> Self {
        Self { heights, ..self }
    }

    /// Lets the figure be null in a single answer.
    const fn or_null(self, place: &'static str) -> Self {
        Self { presence: Presence::Null(place), ..self }
    }

    /// Lets the figure be absent from a single answer, and its column from a batch's.
    pub(crate) const fn only(self, place: &'static str) -> Self {
        Self { presence: Presence::Only(place), ..self }
    }

    /// The figure's value; `None` if it has none.
    pub(crate) fn value(&self, figures: &Figures) -> Option<Value> {
        match self.get {
            Get::Number(get) => get(figures).map(Value::from),
            Get::Word(get, _) => get(figures).map(Value::from),
            Get::Words(get, _) => Some(get(figures).into_iter().flatten().collect()),
        }
    }

    /// Whether a single answer always has the figure, as a value or null.
    pub(crate) fn is_required(&self) -> bool {
        matches!(self.presence, Presence::Always | Presence::Null(_))
    }

    /// Whether a batch's answer always has the column.
    pub(crate) fn is_required_column(&self) -> bool {
        !matches!(self.presence, Presence::Only(_))
    }

    /// The text of the warning that contacts with an answer do not have the figure.
    pub(crate) fn absence(&self) -> String {
        let name = self.name;
        match self.presence {
            Presence::Null(place) | Presence::Absent(place) => format!("{name} is null {place}"),
            Presence::Only(_) if CHECK_FIGURES.iter().any(|check| check.name == name) => {
                format!("{name} is null if the cutter's exact shape leaves no height to compare, or none that is a bound")
            }
            Presence::Only(place) => format!("{name} has values only {place}"),
            Presence::Always => format!("{name} has no finite value"),
        }
    }

    /// The schema of the figure in a single answer.
    pub(crate) fn schema(&self, components: &mut Components) -> RefOr<Schema> {
        let is_nullable = matches!(self.presence, Presence::Null(_));
        self.value_schema(&self.about_with("null", "absent"), is_nullable, components)
    }

    /// The schema of the figure's column.
    pub(crate) fn column_schema(&self, components: &mut Components) -> RefOr<Schema> {
        let about = self.about_with("null also", "null also");
        ArrayBuilder::new().items(self.value_schema("", true, components)).description(Some(about)).into()
    }

    /// The description, with the words for a figure that is null or absent before the text that states when.
    fn about_with(&self, null: &str, absent: &str) -> String {
        match self.presence {
            Presence::Always => self.about.to_owned(),
            Presence::Null(place) => format!("{}; {null} {place}", self.about),
            Presence::Absent(place) => format!("{}; {absent} {place}", self.about),
            Presence::Only(place) => format!("{}; only {place}", self.about),
        }
    }

    fn value_schema(&self, about: &str, is_nullable: bool, components: &mut Components) -> RefOr<Schema> {
        let about = (!about.is_empty()).then_some(about);
        let types = |kind| if is_nullable { SchemaType::from_iter([kind, Type::Null]) } else { kind.into() };
        match self.get {
            Get::Number(_) => {
                let number = ObjectBuilder::new().schema_type(types(Type::Number)).description(about);
                let number = number.format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)));
                number.minimum(Some(self.minimum)).maximum(self.maximum).into()
            }
            Get::Word(_, words) if is_nullable => {
                let null = ObjectBuilder::new().schema_type(Type::Null);
                OneOfBuilder::new().item(words("", components)).item(null).description(about).into()
            }
            Get::Word(_, words) => words(about.unwrap_or_default(), components),
            Get::Words(_, words) => {
                let list = ArrayBuilder::new().schema_type(types(Type::Array)).items(words("", components));
                list.max_items(Some(MOST_WORDS)).description(about).into()
            }
        }
    }
}

answer! {
    /// The comparison of the analytic height with the envelope's.
    #[derive(Clone, Copy)]
    pub(crate) struct Check {
        /// The height by the cutter's exact shape (model `envelope`).
        pub(crate) envelope_scallop_height_mm: f64 [minimum = 0],
        /// (height - envelope) / envelope: negative if the model's height is less than the cutter leaves. Absent if the
        /// envelope's height is 0, or no bound (warning `height-not-a-bound`).
        pub(crate) deviation?: f64 [minimum = -1],
    }
}

answer! {
    /// A contact with an extreme figure.
    #[derive(Clone, Copy)]
    pub(crate) struct Extreme {
        /// The index of the contact, from 0; the first of equals.
        pub(crate) index: usize,
        /// Its figure, as in the column.
        pub(crate) value: f64,
    }

    /// The extremes of a column of numbers.
    #[derive(Clone, Copy)]
    pub(crate) struct Extremes {
        /// The contact with the smallest number.
        pub(crate) minimum: Extreme,
        /// The contact with the largest number.
        pub(crate) maximum: Extreme,
    }
}

/// A JSON object whose members have an order that its type does not determine.
#[derive(Debug, Clone)]
pub(crate) struct InOrder<V>(pub(crate) Vec<(&'static str, V)>);

impl<V: Serialize> Serialize for InOrder<V> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

answer! {
    /// The counts and extremes of a batch.
    #[derive(Clone)]
    pub(crate) struct Summary {
        /// The number of contacts sent.
        pub(crate) count: usize,
        /// The number of contacts without an answer. `failures` beside the summary lists the first thousand of them.
        pub(crate) failures: usize,
        /// The number of contacts whose analytic height is more than 5 % below that of the cutter's exact shape, or whose
        /// exact shape leaves no height to compare. Only if `columns` names `envelope_scallop_height_mm` or `deviation`:
        /// the comparison takes longer than the calculation.
        pub(crate) outside_analytic_range?: usize,
        /// For each column with numbers, the contacts with the smallest and the largest one.
        pub(crate) extremes: InOrder<Extremes> [value_type = std::collections::BTreeMap<String, Extremes>],
    }
}

answer! {
    /// A contact of a batch that has no answer.
    #[derive(Clone)]
    pub(crate) struct Failure {
        /// The index of the contact, from 0.
        pub(crate) index: usize,
        /// The location of the fault: a JSON pointer (RFC 6901) into the request.
        pub(crate) pointer: String [example = "/contacts/17/slope_deg"],
        pub(crate) code: FaultCode,
        /// What is wrong and what is expected, for people; further faults of the contact follow the first, each after its
        /// pointer.
        pub(crate) detail: String,
    }
}

impl Failure {
    /// The failure of a contact with these faults; `None` without faults.
    pub(crate) fn new(index: usize, faults: &[Fault]) -> Option<Self> {
        let (first, further) = faults.split_first()?;
        let further = further.iter().map(|fault| format!("; {}: {}", fault.pointer, fault.detail));
        let detail = std::iter::once(first.detail.clone()).chain(further).collect();
        Some(Self { index, pointer: first.pointer.clone(), code: first.code, detail })
    }
}
