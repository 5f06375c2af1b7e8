//! All integration tests in one binary, a folder for each area.

mod api;
mod app;
mod laws;
mod planning;
mod readers;
mod service;
mod simulation;
mod writers;
