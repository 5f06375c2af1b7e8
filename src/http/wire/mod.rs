//! The JSON objects and members that several endpoints share: a file for each, with the objects of which it consists. Other
//! objects of planning answers are in `planning/`. An object of a request declares its members once; its reader and its schema
//! are generated. A figure of a calculation's answer has one row of a table with name, description and getter; a member of another
//! answer has one row of `answer!` with the same.

mod answer_macro;
mod candidate_object;
mod contact_object;
mod contact_parameters;
mod curvature_object;
mod cutter_object;
mod facet_selection;
mod figures;
mod machine_object;
mod not_ranked;
mod roughness_object;
mod source;
mod surface;
mod warning_object;

pub(crate) use answer_macro::answer;
pub(crate) use candidate_object::{CandidateKind, LibraryFilter, LibraryFilterKind, MOST_CUTTERS, NamedCandidate, SPINDLE_SPEED};
pub(crate) use contact_object::{BatchContact, Contacts, OneContact, StatedContact, no_answer};
pub(crate) use contact_parameters::{
    CUTTER, ContactParameters, MODEL, PLAN_MODEL, SharedMembers, SharedParameters, StatedParameters, TOLERANCE,
};
pub(crate) use cutter_object::{AnyCutter, BallEndCutter, TEETH, ToroidalCutter};
pub(crate) use facet_selection::{FACETS_NAME, PIECES_NAME, SelectKind};
pub(crate) use figures::{
    CHECK_FIGURES, COMMON_FIGURES, Check, Extreme, Extremes, Failure, Figure, Figures, Get, Heights, InOrder, Summary,
};
pub(crate) use machine_object::{CLEARANCE_HEIGHT, MACHINE, MAX_SPINDLE_SPEED, MachineKind, PATH_TOLERANCE, RAPID_RATE, TOOL_CHANGE};
pub(crate) use not_ranked::NotRanked;
pub(crate) use roughness_object::{ROUGHNESS, RoughnessKind, SCALLOP_HEIGHT, plan_tolerance, stated_height};
pub(crate) use source::{Source, SurfaceWithSource, UNIT};
pub(crate) use surface::{OnePoint, PathPoints, SURFACE, StatedSurface};
pub(crate) use warning_object::Warning;
