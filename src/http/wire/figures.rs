//! The figures of the calculations' answers. A row of a table names, describes and fetches a figure; single answers, columns of batches
//! and their schemas follow from it.

use crate::http::reading::Components;
use crate::milling::{JudgedPass, NoAnswer, ScallopHeight};
use crate::quantity::Length;
use serde::{Serialize, Serializer};
use utoipa::openapi::schema::{ArrayBuilder, KnownFormat, ObjectBuilder, OneOfBuilder, SchemaFormat, SchemaType, Type};
use utoipa::openapi::{RefOr, Schema};

/// What a calculation yields at a contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Figures {
    pub(crate) height: ScallopHeight,
    /// Along the surface.
    pub(crate) step_over: Length,
    /// `None` where there are no marks.
    pub(crate) feed_per_tooth: Option<Length>,
    pub(crate) feed_rate_mm_min: Option<f64>,
    /// The word for what limits the feed.
    pub(crate) limited_by: Option<&'static str>,
    effective_radius: Option<Length>,
    transverse_effective_radius: Option<Length>,
    spacing_ratio: f64,
}

impl Figures {
    /// At a step-over and a feed per tooth that are given or found.
    pub(crate) fn at(pass: &JudgedPass, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Self, NoAnswer> {
        Ok(Self {
            height: pass.scallop_height(step_over, feed_per_tooth)?,
            step_over,
            feed_per_tooth,
            feed_rate_mm_min: None,
            limited_by: None,
            effective_radius: pass.effective_radius(),
            transverse_effective_radius: pass.transverse_effective_radius(),
            spacing_ratio: pass.pass().contact.spacing_ratio(),
        })
    }
}

/// A row of the table: one figure of an answer, one column of a batch's.
pub(crate) struct Figure {
    /// The name on the wire, with its unit.
    pub(crate) name: &'static str,
    /// What it is.
    pub(crate) about: &'static str,
    pub(crate) kind: FigureKind,
    pub(crate) presence: Presence,
    /// The figure's value; `None` where it has none.
    pub(crate) get: fn(&Figures) -> Option<FigureValue>,
}

/// What values a figure has.
pub(crate) enum FigureKind {
    /// Numbers of at least 0.
    Number,
    /// Numbers from 0 to 1.
    Share,
    /// Words, with the schema that lists them.
    Word(fn(&str, &mut Components) -> RefOr<Schema>),
}

/// What becomes of a figure without a value. In a batch it is null in its column, as in the row of a contact without an answer.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Presence {
    /// It always has one.
    Always,
    /// A single answer has null. The text says where.
    Null(&'static str),
    /// It is absent from a single answer. The text says where.
    Absent(&'static str),
    /// It is absent from a single answer, and its column from a batch's in which it never has a value. The text says where it has one.
    Only(&'static str),
}

/// A value of a figure.
#[derive(Debug, Clone, Copy)]
pub(crate) enum FigureValue {
    Number(f64),
    Word(&'static str),
}

impl Serialize for FigureValue {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Number(number) => serializer.serialize_f64(*number),
            Self::Word(word) => serializer.serialize_str(word),
        }
    }
}

fn mm(length: Length) -> FigureValue {
    FigureValue::Number(length.mm())
}

/// The figures that all calculations answer with.
pub(crate) const COMMON_FIGURES: &[Figure] = &[
    Figure {
        name: "scallop_height_mm",
        about: "h, the whole scallop height",
        kind: FigureKind::Number,
        presence: Presence::Always,
        get: |figures| Some(mm(figures.height.total())),
    },
    Figure {
        name: "step_over_height_mm",
        about: "h1, what the step-over alone leaves",
        kind: FigureKind::Number,
        presence: Presence::Always,
        get: |figures| Some(mm(figures.height.step_over)),
    },
    Figure {
        name: "feed_height_mm",
        about: "what the tooth marks along the feed add",
        kind: FigureKind::Number,
        presence: Presence::Always,
        get: |figures| Some(mm(figures.height.feed)),
    },
    Figure {
        name: "feed_share",
        about: "the feed's share in the whole height",
        kind: FigureKind::Share,
        presence: Presence::Absent("where there is no height"),
        get: |figures| figures.height.feed_share().map(FigureValue::Number),
    },
    Figure {
        name: "effective_radius_mm",
        about: "R_eff, the groove's radius of curvature across the feed, radial runout included",
        kind: FigureKind::Number,
        presence: Presence::Null("where infinite"),
        get: |figures| figures.effective_radius.map(mm),
    },
    Figure {
        name: "transverse_effective_radius_mm",
        about: "TR_eff, the mark's radius of curvature along the feed",
        kind: FigureKind::Number,
        presence: Presence::Null("where infinite"),
        get: |figures| figures.transverse_effective_radius.map(mm),
    },
    Figure {
        name: "step_over_mm",
        about: "s, the step-over along the surface",
        kind: FigureKind::Number,
        presence: Presence::Always,
        get: |figures| Some(mm(figures.step_over)),
    },
    Figure {
        name: "step_over_xy_mm",
        about: "d, the step-over seen from above",
        kind: FigureKind::Number,
        presence: Presence::Always,
        get: |figures| Some(FigureValue::Number(figures.step_over.mm() * figures.spacing_ratio)),
    },
];

impl Figure {
    /// Whether a single answer always has the figure, be it null.
    pub(crate) fn is_required(&self) -> bool {
        matches!(self.presence, Presence::Always | Presence::Null(_))
    }

    /// Whether a batch's answer always has the column.
    pub(crate) fn is_required_column(&self) -> bool {
        !matches!(self.presence, Presence::Only(_))
    }

    /// The schema of the figure in a single answer.
    pub(crate) fn schema(&self, components: &mut Components) -> RefOr<Schema> {
        let about = match self.presence {
            Presence::Always => self.about.to_owned(),
            Presence::Null(place) => format!("{}; null {place}", self.about),
            Presence::Absent(place) => format!("{}; absent {place}", self.about),
            Presence::Only(place) => format!("{}; only {place}", self.about),
        };
        let is_nullable = matches!(self.presence, Presence::Null(_));
        self.value_schema(&about, is_nullable, components)
    }

    /// The schema of the figure's column.
    pub(crate) fn column_schema(&self, components: &mut Components) -> RefOr<Schema> {
        let about = match self.presence {
            Presence::Always => self.about.to_owned(),
            Presence::Null(place) | Presence::Absent(place) => format!("{}; null also {place}", self.about),
            Presence::Only(place) => format!("{}; only {place}", self.about),
        };
        ArrayBuilder::new().items(self.value_schema("", true, components)).description(Some(about)).into()
    }

    fn value_schema(&self, about: &str, is_nullable: bool, components: &mut Components) -> RefOr<Schema> {
        let about = (!about.is_empty()).then_some(about);
        let number = || {
            let types = if is_nullable { SchemaType::from_iter([Type::Number, Type::Null]) } else { Type::Number.into() };
            let number = ObjectBuilder::new().schema_type(types).description(about).minimum(Some(0.0));
            number.format(Some(SchemaFormat::KnownFormat(KnownFormat::Double)))
        };
        match self.kind {
            FigureKind::Number => number().into(),
            FigureKind::Share => number().maximum(Some(1.0)).into(),
            FigureKind::Word(words) if is_nullable => {
                let null = ObjectBuilder::new().schema_type(Type::Null);
                OneOfBuilder::new().item(words("", components)).item(null).description(about).into()
            }
            FigureKind::Word(words) => words(about.unwrap_or_default(), components),
        }
    }
}
