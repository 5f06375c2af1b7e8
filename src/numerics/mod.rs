//! General numerical methods: a bracketed root finder and rasters.

pub mod raster;
mod root;

pub(crate) use root::bracketed_root;
