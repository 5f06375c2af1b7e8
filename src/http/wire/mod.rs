//! The JSON objects and members that several endpoints share: a file for each, with the objects of which it consists. Other
//! objects of planning answers are in `planning/`. An object of a request declares its members once; its reader, its
//! schema and the fast path of batches are generated. A figure of a calculation's answer has one row of a table with
//! name, description and getter; a member of another answer has one row of `answer!` with the same.

mod answer;
mod batch_contact;
mod candidate;
mod check;
mod contact;
mod contacts;
mod curvature;
mod cutter;
mod failure;
mod feed;
mod figures;
mod machine;
mod model;
mod no_answer;
mod not_ranked;
mod parameters;
mod points;
mod runout;
mod selection;
mod source;
mod step_over;
mod summary;
mod surface;
mod unit;
mod warning;

pub(crate) use answer::answer;
pub(crate) use batch_contact::BatchContact;
pub(crate) use candidate::{CandidateKind, MOST_CUTTERS, NamedCandidate};
pub(crate) use check::Check;
pub(crate) use contact::{CONTACT, StatedContact};
pub(crate) use contacts::Contacts;
pub(crate) use cutter::{BallEndCutter, TEETH, ToroidalCutter};
pub(crate) use failure::Failure;
pub(crate) use figures::{CHECK_FIGURES, COMMON_FIGURES, Figure, Figures, Get, Heights};
pub(crate) use machine::{MACHINE, Machine};
pub(crate) use model::{MODEL, PLAN_MODEL};
pub(crate) use no_answer::no_answer;
pub(crate) use not_ranked::NotRanked;
pub(crate) use parameters::{CUTTER, ContactParameters, SharedMembers, SharedParameters, StatedParameters, TOLERANCE};
pub(crate) use selection::{PIECES_NAME, SelectKind};
pub(crate) use source::{Source, SurfaceWithSource};
pub(crate) use summary::{Extreme, Extremes, InOrder, Summary};
pub(crate) use surface::SURFACE;
pub(crate) use unit::UNIT;
pub(crate) use warning::Warning;
