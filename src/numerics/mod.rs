//! General numerical methods: a bracketed root finder, hypotenuses, small vectors, rasters, and rounding.

mod hypotenuse;
pub mod raster;
mod root;
pub(crate) mod rounding;
pub(crate) mod vector;

pub(crate) use hypotenuse::hypotenuse;
pub(crate) use root::bracketed_root;
