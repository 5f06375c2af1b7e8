//! Numerical methods that any geometry code needs: a bracketed root finder and rasters.

pub mod raster;
mod root;

pub(crate) use root::bracketed_root;
