//! Numerical tools that any geometry code needs.

pub mod raster;
