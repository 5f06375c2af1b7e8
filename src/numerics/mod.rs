//! General numerical methods: a bracketed root finder, derivatives, and rasters.

mod dual;
pub mod raster;
mod root;

pub(crate) use dual::Dual;
pub(crate) use root::bracketed_root;
