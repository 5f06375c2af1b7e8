//! General numerical methods: a bracketed root finder, rasters, and rounding.

pub mod raster;
mod root;
pub(crate) mod rounding;

pub(crate) use root::bracketed_root;
