//! Laws of the calculations at a pass, tested on random valid passes, and independent calculations of the same figures.

mod continuity;
mod curved_surfaces;
mod cutting_parameters;
mod heights;
mod inverses;
mod outline;
mod passes;
mod path_times;
mod radii;
mod reference;
mod refusals;
mod shapes;
