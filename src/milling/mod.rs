//! The calculations for one finishing pass: the scallop height that a cutter leaves at a contact, and the feed, the
//! step-over or both that keep a tolerance. All are pure functions of checked values.
//!
//! Symbols: R and r the cutter's outer and corner radius, S the slope, alpha the feed's angle to the steepest slope
//! seen from above, omega the same in the tangent plane, K the surface's curvature, s the step-over along the surface,
//! f_z the feed per tooth, h1 the height that the step-over leaves, h the whole height.
//!
//! Sources: Segonds et al. 2017, doi:10.1007/s10845-017-1360-0, with its misprints corrected.

mod analytic;
mod contact;
mod curvature;
mod cutter;
mod cutting_parameters;
mod envelope;
mod gouging;
mod model;
mod pass;
mod profile;
mod roughness;

pub use analytic::{Analytic, EffectiveRadius};
pub use contact::{Contact, ContactError};
pub use curvature::{CurvatureComponent, CurvatureOutOfRange, SurfaceCurvature};
pub use cutter::{Cutter, CutterError, CutterKind};
pub use cutting_parameters::{CuttingLimits, CuttingLimitsError, CuttingParameters, LimitedBy};
pub use envelope::Envelope;
pub use model::{EvaluatedPass, Model, ModelWarning};
pub use pass::{NoAnswer, Pass, Runout, ScallopHeight, StepOver};
pub use profile::{MOST_ARCS, Profile, ProfileArc, ProfileError};
pub use roughness::{Roughness, RoughnessError, ra_um};
