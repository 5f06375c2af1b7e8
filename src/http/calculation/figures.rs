//! The figures of the answers: for one contact an object of numbers, for many a column each.

use super::warning::Warning;
use crate::http::body::WrittenJson;
use crate::http::codes::FaultCode;
use crate::http::reading::Fault;
use crate::milling::{JudgedPass, Model, NoAnswer, ScallopHeight};
use crate::quantity::Length;
use serde::Serialize;
use utoipa::ToSchema;

/// What every calculation tells of a contact, in mm.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Common {
    pub(crate) height: ScallopHeight,
    pub(crate) step_over: Length,
    pub(crate) feed_per_tooth: Option<Length>,
    effective_radius: Option<Length>,
    transverse_effective_radius: Option<Length>,
    spacing_ratio: f64,
}

impl Common {
    /// At a step-over and a feed per tooth that are given or found.
    pub(crate) fn at(pass: &JudgedPass, step_over: Length, feed_per_tooth: Option<Length>) -> Result<Self, NoAnswer> {
        Ok(Self {
            height: pass.scallop_height(step_over, feed_per_tooth)?,
            step_over,
            feed_per_tooth,
            effective_radius: pass.effective_radius(),
            transverse_effective_radius: pass.transverse_effective_radius(),
            spacing_ratio: pass.pass().contact.spacing_ratio(),
        })
    }

    pub(crate) fn step_over_xy_mm(&self) -> f64 {
        self.step_over.mm() * self.spacing_ratio
    }

    pub(crate) fn effective_radius_mm(&self) -> Option<f64> {
        self.effective_radius.map(Length::mm)
    }

    pub(crate) fn transverse_effective_radius_mm(&self) -> Option<f64> {
        self.transverse_effective_radius.map(Length::mm)
    }
}

/// The analytic height beside the envelope's.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Check {
    /// The height by the cutter's exact shape, model `envelope`.
    #[schema(minimum = 0)]
    pub(crate) envelope_scallop_height_mm: f64,
    /// (height - envelope) / envelope: negative where the model promises less than the cutter leaves. Absent where the envelope's height is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false, minimum = -1)]
    pub(crate) deviation: Option<f64>,
}

/// A contact of a batch that has no answer.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub(crate) struct Failure {
    /// Which contact, counted from 0.
    pub(crate) index: usize,
    /// Where: a JSON pointer (RFC 6901) into the request.
    #[schema(example = "/contacts/17/slope_deg")]
    pub(crate) pointer: String,
    pub(crate) code: FaultCode,
    /// What is wrong and what would be right, for a person; further faults of the contact follow the first, each after its pointer.
    pub(crate) detail: String,
}

impl Failure {
    /// Of the contact's faults, of which there is at least one.
    pub(crate) fn new(index: usize, faults: &[Fault]) -> Option<Self> {
        let (first, further) = faults.split_first()?;
        let further = further.iter().map(|fault| format!("; {}: {}", fault.pointer, fault.detail));
        let detail = std::iter::once(first.detail.clone()).chain(further).collect();
        Some(Self { index, pointer: first.pointer.clone(), code: first.code, detail })
    }
}

/// A contact with an extreme figure.
#[derive(Debug, Clone, Copy, Serialize, ToSchema)]
pub(crate) struct Extreme {
    /// Which contact, counted from 0.
    pub(crate) index: usize,
    /// Its figure, in mm: of the scallop height, the feed per tooth or the step-over, whichever the calculation finds.
    pub(crate) value_mm: f64,
}

/// A batch in short.
#[derive(Debug, Clone, Default, Serialize, ToSchema)]
pub(crate) struct Summary {
    /// How many contacts were sent.
    pub(crate) count: usize,
    /// How many have no answer.
    pub(crate) failures: usize,
    /// The contact with the smallest figure that the calculation finds; absent where none has an answer.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) minimum: Option<Extreme>,
    /// The contact with the largest one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub(crate) maximum: Option<Extreme>,
}

/// The figures that one contact's calculation yields, and the forms in which they are answered.
pub(crate) trait Figures: Send + Sized {
    /// The answer for one contact.
    type Answer: Serialize + ToSchema;
    /// The answer for many.
    type Columns: Columns<Self>;

    fn common(&self) -> &Common;

    /// The figure that the calculation finds, in mm.
    fn found_mm(&self) -> f64;

    fn into_answer(self, model: Model, check: Option<Check>, warnings: Vec<Warning>) -> Self::Answer;
}

/// The answer for many contacts: a column a figure.
pub(crate) trait Columns<F>: Send + Default {
    /// Columns without a row, to which rows can be added one by one, about so many.
    fn open(rows: usize) -> Self;
    /// A row; `None` for a contact without an answer.
    fn push(&mut self, figures: Option<&F>);
    /// The rows of `next` below these.
    fn append(&mut self, next: Self);
    /// The whole answer, with what goes beside the columns.
    fn written(self, model: Model, summary: Summary, failures: Vec<Failure>, warnings: Vec<Warning>) -> WrittenJson;
}

/// The wire name of a model.
pub(crate) fn model_name(model: Model) -> &'static str {
    match model {
        Model::Analytic => "analytic",
        Model::Envelope => "envelope",
    }
}

/// Declares the answers of a calculation: its own figures, and after them those that all have. `optional` ones are absent from a
/// single answer, and null in a column, where there is nothing to say; their column is absent where it has nothing at all.
macro_rules! answers {
    (
        $figures:ident => $answer:ident, $columns:ident;
        $( required { $( $(#[$doc:meta])* $name:ident : $type:ty = $get:expr, )* } )?
        $( optional { $( $(#[$odoc:meta])* $oname:ident : $otype:ty = $oget:expr, )* } )?
    ) => {
        /// The answer for one contact.
        #[derive(Debug, Serialize, ToSchema)]
        pub(crate) struct $answer {
            /// The model that answered: `analytic` or `envelope`.
            #[schema(example = "analytic")]
            model: &'static str,
            $( $( $(#[$doc])* $name: $type, )* )?
            $( $( $(#[$odoc])* #[serde(skip_serializing_if = "Option::is_none")] #[schema(nullable = false)] $oname: Option<$otype>, )* )?
            /// h, the whole scallop height.
            #[schema(minimum = 0)]
            scallop_height_mm: f64,
            /// h1, what the step-over alone leaves.
            #[schema(minimum = 0)]
            step_over_height_mm: f64,
            /// What the tooth marks along the feed add.
            #[schema(minimum = 0)]
            feed_height_mm: f64,
            /// The feed's share in the whole height; absent where there is no height.
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(nullable = false, minimum = 0, maximum = 1)]
            feed_share: Option<f64>,
            /// R_eff, the groove's radius of curvature across the feed, radial runout included; null where infinite.
            #[schema(required, minimum = 0)]
            effective_radius_mm: Option<f64>,
            /// TR_eff, the mark's radius of curvature along the feed; null where infinite.
            #[schema(required, minimum = 0)]
            transverse_effective_radius_mm: Option<f64>,
            /// s, the step-over along the surface.
            #[schema(minimum = 0)]
            step_over_mm: f64,
            /// d, the step-over seen from above.
            #[schema(minimum = 0)]
            step_over_xy_mm: f64,
            /// The height by the cutter's exact shape; only of model `analytic`, and where the envelope has an answer.
            #[serde(skip_serializing_if = "Option::is_none")]
            #[schema(nullable = false)]
            check: Option<Check>,
            /// What must be looked at.
            warnings: Vec<Warning>,
        }

        /// The answer for many contacts: an array a figure, in the order sent; null where a contact has no answer.
        #[derive(Debug, Default, ToSchema)]
        pub(crate) struct $columns {
            /// The model that answered: `analytic` or `envelope`.
            #[schema(example = "analytic")]
            model: &'static str,
            /// The batch in short.
            summary: Summary,
            $( $( $(#[$doc])* #[schema(value_type = Vec<Option<$type>>)] $name: Column, )* )?
            $( $( $(#[$odoc])* #[schema(value_type = Vec<Option<$otype>>, required = false)] $oname: Column, )* )?
            /// h, the whole scallop height of each contact.
            #[schema(value_type = Vec<Option<f64>>)]
            scallop_height_mm: Column,
            /// h1, what the step-over alone leaves.
            #[schema(value_type = Vec<Option<f64>>)]
            step_over_height_mm: Column,
            /// What the tooth marks along the feed add.
            #[schema(value_type = Vec<Option<f64>>)]
            feed_height_mm: Column,
            /// The feed's share in the whole height; null also where there is no height.
            #[schema(value_type = Vec<Option<f64>>)]
            feed_share: Column,
            /// R_eff, the groove's radius of curvature across the feed, radial runout included; null also where infinite.
            #[schema(value_type = Vec<Option<f64>>)]
            effective_radius_mm: Column,
            /// TR_eff, the mark's radius of curvature along the feed; null also where infinite.
            #[schema(value_type = Vec<Option<f64>>)]
            transverse_effective_radius_mm: Column,
            /// s, the step-over along the surface.
            #[schema(value_type = Vec<Option<f64>>)]
            step_over_mm: Column,
            /// d, the step-over seen from above.
            #[schema(value_type = Vec<Option<f64>>)]
            step_over_xy_mm: Column,
            /// The contacts that have no answer.
            failures: Vec<Failure>,
            /// What must be looked at, a line for each kind of warning.
            warnings: Vec<Warning>,
        }

        impl Figures for $figures {
            type Answer = $answer;
            type Columns = $columns;

            fn common(&self) -> &Common {
                &self.common
            }

            fn found_mm(&self) -> f64 {
                self.found_mm()
            }

            fn into_answer(self, model: Model, check: Option<Check>, warnings: Vec<Warning>) -> $answer {
                let common = &self.common;
                $answer {
                    model: model_name(model),
                    $( $( $name: $get(&self), )* )?
                    $( $( $oname: $oget(&self), )* )?
                    scallop_height_mm: common.height.total().mm(),
                    step_over_height_mm: common.height.step_over.mm(),
                    feed_height_mm: common.height.feed.mm(),
                    feed_share: common.height.feed_share(),
                    effective_radius_mm: common.effective_radius_mm(),
                    transverse_effective_radius_mm: common.transverse_effective_radius_mm(),
                    step_over_mm: common.step_over.mm(),
                    step_over_xy_mm: common.step_over_xy_mm(),
                    check,
                    warnings,
                }
            }
        }

        impl Columns<$figures> for $columns {
            fn open(rows: usize) -> Self {
                Self {
                    $( $( $name: Column::open(rows), )* )?
                    $( $( $oname: Column::open(rows), )* )?
                    scallop_height_mm: Column::open(rows),
                    step_over_height_mm: Column::open(rows),
                    feed_height_mm: Column::open(rows),
                    feed_share: Column::open(rows),
                    effective_radius_mm: Column::open(rows),
                    transverse_effective_radius_mm: Column::open(rows),
                    step_over_mm: Column::open(rows),
                    step_over_xy_mm: Column::open(rows),
                    ..Self::default()
                }
            }

            fn push(&mut self, figures: Option<&$figures>) {
                let common = figures.map(|figures| &figures.common);
                $( $( self.$name.push(figures.map($get)); )* )?
                $( $( self.$oname.push(figures.and_then($oget)); )* )?
                self.scallop_height_mm.push(common.map(|common| common.height.total().mm()));
                self.step_over_height_mm.push(common.map(|common| common.height.step_over.mm()));
                self.feed_height_mm.push(common.map(|common| common.height.feed.mm()));
                self.feed_share.push(common.and_then(|common| common.height.feed_share()));
                self.effective_radius_mm.push(common.and_then(Common::effective_radius_mm));
                self.transverse_effective_radius_mm.push(common.and_then(Common::transverse_effective_radius_mm));
                self.step_over_mm.push(common.map(|common| common.step_over.mm()));
                self.step_over_xy_mm.push(common.map(Common::step_over_xy_mm));
            }

            fn append(&mut self, next: Self) {
                $( $( self.$name.append(next.$name); )* )?
                $( $( self.$oname.append(next.$oname); )* )?
                self.scallop_height_mm.append(next.scallop_height_mm);
                self.step_over_height_mm.append(next.step_over_height_mm);
                self.feed_height_mm.append(next.feed_height_mm);
                self.feed_share.append(next.feed_share);
                self.effective_radius_mm.append(next.effective_radius_mm);
                self.transverse_effective_radius_mm.append(next.transverse_effective_radius_mm);
                self.step_over_mm.append(next.step_over_mm);
                self.step_over_xy_mm.append(next.step_over_xy_mm);
            }

            fn written(self, model: Model, summary: Summary, failures: Vec<Failure>, warnings: Vec<Warning>) -> WrittenJson {
                let whole = Self { model: model_name(model), summary, failures, warnings, ..self };
                let mut table = Table::default();
                table.value("model", &whole.model);
                table.value("summary", &whole.summary);
                $( $( table.column(stringify!($name), whole.$name); )* )?
                $( $( table.optional_column(stringify!($oname), whole.$oname); )* )?
                table.column("scallop_height_mm", whole.scallop_height_mm);
                table.column("step_over_height_mm", whole.step_over_height_mm);
                table.column("feed_height_mm", whole.feed_height_mm);
                table.column("feed_share", whole.feed_share);
                table.column("effective_radius_mm", whole.effective_radius_mm);
                table.column("transverse_effective_radius_mm", whole.transverse_effective_radius_mm);
                table.column("step_over_mm", whole.step_over_mm);
                table.column("step_over_xy_mm", whole.step_over_xy_mm);
                table.value("failures", &whole.failures);
                table.value("warnings", &whole.warnings);
                table.written()
            }
        }
    };
}
pub(crate) use answers;
