//! Laws of the mathematics of a pass, tested on random valid passes, and independent routes to the same numbers.

mod continuity;
mod curved_surfaces;
mod cutting_parameters;
mod heights;
mod inverses;
mod outline;
mod passes;
mod radii;
mod reference;
