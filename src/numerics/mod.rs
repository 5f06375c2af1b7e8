//! General numerical methods: a bracketed root finder, derivatives, rasters, and rounding.

mod dual;
pub mod raster;
mod root;
pub(crate) mod rounding;

pub(crate) use dual::Dual;
pub(crate) use root::bracketed_root;
