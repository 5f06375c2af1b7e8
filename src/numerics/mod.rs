//! General numerical methods: a bracketed root finder, hypotenuses, rasters, and rounding.

mod hypotenuse;
pub mod raster;
mod root;
pub(crate) mod rounding;

pub(crate) use hypotenuse::hypotenuse;
pub(crate) use root::bracketed_root;
