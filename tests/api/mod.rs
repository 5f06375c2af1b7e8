//! The HTTP contract as a client sees it: the whole service runs in-process on a free port and is called by an HTTP
//! client.

mod batch;
mod columns;
mod curvature;
mod cutters;
mod cutting_parameters;
mod document;
mod examples;
mod faults;
mod floods;
mod hints;
mod max_feed;
pub(crate) mod openapi;
mod pages;
mod query;
mod requests;
mod scallop_height;
mod statuses;
mod step_over;
mod transport;
mod warnings;
mod workbench;
