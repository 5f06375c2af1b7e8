//! The mathematics of one finishing pass: which scallop a cutter leaves at a contact, and which feed or step-over keeps a
//! tolerance. Pure functions of checked values; nothing here knows of requests or files.
//!
//! Symbols: R and r the cutter's outer and corner radius, S the slope, alpha the feed's angle to the steepest slope seen from
//! above, theta the same in the tangent plane, s the step-over along the surface, f_z the feed per tooth, h1 the height that the
//! step-over leaves, h the whole height.
//!
//! Sources: Segonds et al. 2017, doi:10.1007/s10845-017-1360-0, with its misprints corrected.

mod analytic;
mod concern;
mod contact;
mod cutter;
mod envelope;
mod model;
mod no_answer;
mod pass;

pub use analytic::{Analytic, EffectiveRadius};
pub use concern::{Concern, circle_concerns, concerns};
pub use contact::{Contact, ContactError};
pub use cutter::{CornerTooLarge, Cutter, CutterKind};
pub use envelope::Envelope;
pub use model::{JudgedPass, Model};
pub use no_answer::NoAnswer;
pub use pass::{Pass, Runout, ScallopHeight, StepOver, SurfaceCurvature};
