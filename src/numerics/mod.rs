//! General numerical methods: a bracketed root finder, hypotenuses, small vectors, rasters, random numbers, the Z-order
//! curve, and rounding.

mod hypotenuse;
pub(crate) mod random;
pub mod raster;
mod root;
pub(crate) mod rounding;
pub(crate) mod vector;
pub(crate) mod z_order;

pub(crate) use hypotenuse::hypotenuse;
pub(crate) use root::bracketed_root;
