//! Numerical methods that any geometry code needs.

mod root;

pub(crate) use root::bracketed_root;
