//! The HTTP contract, as a client meets it: the whole service in-process on a free port, asked with a client of its own.

mod batch;
mod columns;
mod curvature;
mod cutting_parameters;
mod document;
mod faults;
mod floods;
mod max_feed;
mod pages;
mod query;
mod refused_examples;
mod requests;
mod scallop_height;
mod statuses;
mod step_over;
mod transport;
mod warnings;
mod workbench;
