//! Scallop heights of ball-end, toroidal and flat-end finish milling: the height that a pass leaves, the largest feed
//! or step-over within a tolerance, and the fastest cutter for a surface.
//!
//! The mathematics is in [`milling`], [`motion`], [`surface`] and [`planning`] and can be called without the service.
//! [`http`] and [`server`] offer it over HTTP.
//!
//! # A scallop height
//!
//! A toroidal cutter of 10 mm with a corner radius of 2 mm, on a slope of 40 deg, fed at 30 deg to the steepest line:
//!
//! ```
//! use scallopd::milling::{Contact, Cutter, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
//! use scallopd::quantity::Length;
//!
//! let pass = Pass {
//!     cutter: Cutter::toroidal(Length::from_mm(10.0)?, Length::from_mm(2.0)?)?,
//!     contact: Contact::from_degrees(40.0, 30.0)?,
//!     surface: SurfaceCurvature::PLANE,
//!     runout: Runout::NONE,
//!     teeth: None,
//! };
//! let step_over = Length::from_mm(0.687)?;
//! let feed_per_tooth = Length::from_mm(0.3)?;
//!
//! let analytic = EvaluatedPass::new(Model::Analytic, pass)?.scallop_height(step_over, Some(feed_per_tooth))?;
//! assert_eq!(format!("{:.5}", analytic.total().mm()), "0.01305");
//!
//! // The published formula replaces the cutter by circles. The envelope of the cutter's exact shape leaves more.
//! let envelope = EvaluatedPass::new(Model::Envelope, pass)?.scallop_height(step_over, Some(feed_per_tooth))?;
//! assert_eq!(format!("{:.5}", envelope.total().mm()), "0.01500");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The largest feed per tooth
//!
//! The same pass, with at most 15 um of scallop. If there is no answer, the error has the reason and figures that help
//! to correct the parameters:
//!
//! ```
//! # use scallopd::milling::{Contact, Cutter, Pass, Runout, SurfaceCurvature};
//! use scallopd::milling::{EvaluatedPass, Model, NoAnswer};
//! # use scallopd::quantity::Length;
//! # let pass = Pass {
//! #     cutter: Cutter::toroidal(Length::from_mm(10.0)?, Length::from_mm(2.0)?)?,
//! #     contact: Contact::from_degrees(40.0, 30.0)?,
//! #     surface: SurfaceCurvature::PLANE,
//! #     runout: Runout::NONE,
//! #     teeth: None,
//! # };
//! # let step_over = Length::from_mm(0.687)?;
//!
//! let pass = EvaluatedPass::new(Model::Envelope, pass)?;
//! let feed_per_tooth = pass.max_feed_per_tooth(Length::from_mm(0.015)?, step_over)?;
//! assert_eq!(format!("{:.3}", feed_per_tooth.mm()), "0.300");
//!
//! match pass.max_feed_per_tooth(Length::from_mm(0.005)?, step_over) {
//!     Err(NoAnswer::StepOverUsesUpTolerance { max_step_over, .. }) => assert!(max_step_over < step_over),
//!     other => panic!("the step-over alone leaves 10 um: {other:?}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # A recommendation
//!
//! An inclined rectangle of 80 mm by 40 mm as a mesh, two cutters, 10 um of scallop. The paths of each cutter in
//! its best directions are milled:
//!
//! ```
//! use scallopd::milling::Cutter;
//! use scallopd::motion::{Machine, Preset};
//! use scallopd::planning::SurfaceEvidence;
//! use scallopd::planning::plan::{CandidateCutter, PlanSettings, Workpiece, rank};
//! use scallopd::quantity::{Angle, Length};
//! use scallopd::surface::mesh::Selection;
//! use scallopd::surface::{Facing, MeshBuilder, Unit};
//!
//! let mut mesh = MeshBuilder::new();
//! let points = [[0.0, 0.0, 0.0], [80.0, 0.0, 0.0], [80.0, 32.0, 24.0], [0.0, 32.0, 24.0]];
//! mesh.indexed(&points, &[[0, 1, 2], [0, 2, 3]])?;
//! let mesh = mesh.finish(Unit::Millimetre, Facing::Up, &|| false)?;
//! let selected = mesh.selected(&Selection::all(), &mesh.pieces(&|| false))?;
//! let part = Workpiece::new(&mesh, &mesh.visibility(Angle::from_degrees(85.0)?, &|| false), &selected, None, &|| false);
//!
//! let diameter = Length::from_mm(10.0)?;
//! let candidates = [Cutter::toroidal(diameter, Length::from_mm(2.0)?)?, Cutter::ball_end(diameter)].map(CandidateCutter::new);
//! let machine = Machine::from(Preset::named("five_axis_vmc").ok_or("no such machine")?.limits);
//! let settings = PlanSettings::new(Length::from_mm(0.01)?, machine);
//! let ranking = rank(&part, &candidates, &settings, SurfaceEvidence::default(), &|| false).ok_or("it was cancelled")?;
//!
//! let fastest = &ranking.plans[0];
//! assert_eq!(fastest.candidate, 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod archive;
pub mod budget;
pub mod cancellation;
pub mod file_fault;
pub mod health;
pub mod http;
mod json;
pub mod milling;
pub mod motion;
pub mod numerics;
pub mod path;
pub mod planning;
pub mod quantity;
pub mod server;
pub mod settings;
pub mod surface;
pub mod telemetry;
pub mod tooling;
pub mod worker_pool;
