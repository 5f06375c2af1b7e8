//! Scallop heights of ball-end, toroidal and flat-end finish milling: what a pass leaves, which feed or step-over keeps a tolerance,
//! and which cutter suits a surface.

pub mod cancellation;
pub mod health;
pub mod http;
pub mod memory_budget;
pub mod milling;
pub mod motion;
pub mod numerics;
pub mod planning;
pub mod quantity;
pub mod server;
pub mod settings;
pub mod surface;
pub mod telemetry;
