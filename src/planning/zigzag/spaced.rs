//! The facets in the order of one direction, with the spacings that they allow one cutter.

use super::spacing::CutterSpacing;
use super::sweep::{Covered, Sweep};
use super::workpiece::{Tangent, Workpiece};

/// The facets in the order of one direction, with the spacings that they allow one cutter.
#[derive(Debug)]
pub(super) struct Spaced<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) sweep: &'a Sweep,
    pub(super) spacing: &'a CutterSpacing,
    /// The spacings that facets allow, in the order of the sweep; infinite for steep facets.
    pub(super) allowed: Vec<f32>,
    /// The widest spacing, the cutter's diameter, in mm.
    pub(super) widest: f64,
    /// The share of a strip's area that may allow less than its spacing.
    pub(super) left_out: f64,
}

/// The number of facets between two checks for cancellation while their spacings are computed.
const FACETS_AT_ONCE: usize = 8192;

impl<'a> Spaced<'a> {
    /// The facets with the spacings that a cutter allows, whose diameter is `widest`; `left_out` is the share of a strip's
    /// area that may allow less. Once `stop` returns true, it returns early, with fewer spacings.
    pub(super) fn new(
        workpiece: &'a Workpiece,
        sweep: &'a Sweep,
        (spacing, widest): (&'a CutterSpacing, f64),
        left_out: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Self {
        let allowed = |covered: &Covered| {
            #[expect(clippy::cast_possible_truncation, reason = "single precision errs by 6e-8, far less than the model")]
            let allowed = squared_spacing(&workpiece.tangents[covered.facet as usize], sweep, spacing).sqrt() as f32;
            allowed
        };
        let mut spacings = Vec::with_capacity(sweep.covered.len());
        for covered in sweep.covered.chunks(FACETS_AT_ONCE).take_while(|_| !stop()) {
            spacings.extend(covered.iter().map(allowed));
        }
        Self { workpiece, sweep, spacing, allowed: spacings, widest, left_out }
    }

    /// The squared spacing that a facet allows; infinite for a steep facet.
    pub(super) fn squared(&self, facet: usize) -> f64 {
        squared_spacing(&self.workpiece.tangents[facet], self.sweep, self.spacing)
    }

    /// The same for a plane of the facet's slope.
    pub(super) fn squared_on_plane(&self, facet: usize) -> f64 {
        squared_spacing(&Tangent { curvature: [0.0; 3], ..self.workpiece.tangents[facet] }, self.sweep, self.spacing)
    }
}

fn squared_spacing(tangent: &Tangent, sweep: &Sweep, spacing: &CutterSpacing) -> f64 {
    if tangent.is_steep {
        return f64::INFINITY;
    }
    let (cos_alpha, sin_alpha) = tangent.alpha(sweep.heading.e);
    spacing.squared(tangent, cos_alpha, sin_alpha)
}
