//! General numerical methods: a bracketed root finder and rounding, small vectors, rasters, and random numbers.

pub(crate) mod random;
pub mod raster;
pub(crate) mod scalar;
pub(crate) mod vector;

pub(crate) use scalar::bracketed_root;
pub(crate) use vector::hypotenuse;
