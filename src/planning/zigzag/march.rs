//! Where the planes of the passes lie: as far apart as the worst point of each strip allows.

use super::spacing::CutterSpacing;
use super::sweep::{Covered, Sweep};
use super::workpiece::Workpiece;

/// The most planes that a plan may have; beyond it a direction counts as having no spacing.
pub(super) const MOST_PLANES: usize = 50_000;

/// How many of the tightest facets of a strip are looked at for the share that may be left out.
const TIGHTEST: usize = 12;

/// Facets of one direction with the spacings that they allow one cutter.
#[derive(Debug)]
pub(super) struct Spaced<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) sweep: &'a Sweep,
    /// The squared spacings, by facet; steep facets set none.
    pub(super) squared: Vec<f32>,
    /// The widest spacing, the cutter's diameter, in mm.
    pub(super) widest: f64,
    /// The share of a strip's area that may allow less than its spacing.
    pub(super) left_out: f64,
    /// Factors on the spacings, by stretches across the passes, in rising order of where each begins.
    pub(super) factors: Vec<(f64, f64)>,
}

impl<'a> Spaced<'a> {
    pub(super) fn new(workpiece: &'a Workpiece, sweep: &'a Sweep, spacing: &CutterSpacing, widest: f64, left_out: f64) -> Self {
        let squared = workpiece
            .tangents
            .iter()
            .map(|tangent| {
                if tangent.is_steep {
                    return f32::INFINITY;
                }
                let (cos_alpha, sin_alpha) = tangent.alpha(sweep.heading.e);
                #[expect(clippy::cast_possible_truncation, reason = "single precision errs by 6e-8, far less than the model")]
                let squared = spacing.squared(tangent, cos_alpha, sin_alpha) as f32;
                squared
            })
            .collect();
        Self { workpiece, sweep, squared, widest, left_out, factors: Vec::new() }
    }

    pub(super) fn factor(&self, at: f64) -> f64 {
        let next = self.factors.partition_point(|&(start, _)| start <= at);
        if next == 0 { self.factors.first().map_or(1.0, |&(_, factor)| factor) } else { self.factors[next - 1].1 }
    }
}

/// A facet that the planes have reached.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    pub(super) covered: Covered,
    /// The spacing that it allows.
    allowed: f64,
    /// Its area over its width across the passes.
    density: f64,
}

/// A plane of passes with the spacings to its neighbours; the first and the last have their one neighbour's on both sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    pub(super) at: f64,
    pub(super) before: f64,
    pub(super) after: f64,
    /// The facets that bind the spacing after it most, as far as they are known.
    pub(super) binding: [Option<u32>; BINDING],
}

/// How many of the facets that bind a spacing are kept.
pub(super) const BINDING: usize = 4;

impl Plane {
    /// The spacing that decides about the scallop: the wider one.
    pub(super) fn spacing(&self) -> f64 {
        self.before.max(self.after)
    }
}

/// No spacing keeps the scallop height, or so small a one that there would be more than [`MOST_PLANES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TooManyPlanes;

/// Walks across the passes from band to band, and calls `visit` with each plane and the facets that may meet it.
///
/// # Errors
/// [`TooManyPlanes`]
pub(super) fn march(spaced: &Spaced, mut visit: impl FnMut(Plane, &[Reached])) -> Result<(), TooManyPlanes> {
    let mut planes = 0;
    for band in spaced.sweep.bands(spaced.widest) {
        let mut walk = Walk { spaced, next: band.start, end: band.end, reached: Vec::new(), hint: spaced.widest, tightest: Vec::new(), binding: [None; BINDING] };
        let first = walk.widest_from(band.low)?;
        let mut is_last = band.high - band.low < first;
        // As far from the border as from the next plane's half; in a band of less than one spacing in the middle.
        let mut plane = Plane { at: if is_last { f64::midpoint(band.low, band.high) } else { band.low + first / 2.0 }, before: first, after: first, binding: [None; BINDING] };
        loop {
            planes += 1;
            if planes > MOST_PLANES {
                return Err(TooManyPlanes);
            }
            walk.pass_by(plane.at);
            let rest = band.high - plane.at;
            let widest = if is_last { plane.before } else { walk.widest_from(plane.at)? };
            plane.binding = walk.binding;
            if is_last || rest <= widest / 2.0 {
                // The half spacing beyond the last plane leaves as much as a whole one between two planes.
                plane.after = plane.before;
                visit(plane, &walk.reached);
                break;
            }
            // Beyond the border there is nothing to cut: half a spacing before it is enough, and the strip up to the border allows that.
            is_last = widest > rest;
            plane.after = if is_last { rest - widest / 2.0 } else { widest };
            if planes == 1 {
                plane.before = plane.after;
            }
            visit(plane, &walk.reached);
            plane = Plane { at: plane.at + plane.after, before: plane.after, after: plane.after, binding: [None; BINDING] };
        }
    }
    Ok(())
}

/// A walk across one band.
struct Walk<'a> {
    spaced: &'a Spaced<'a>,
    /// The next facet in the order of the sweep.
    next: usize,
    end: usize,
    reached: Vec<Reached>,
    /// How far to look: somewhat more than the last spacing.
    hint: f64,
    /// The tightest facets of the strip: up to where they let it reach, and what they allow.
    tightest: Vec<(f64, Reached)>,
    /// The facets that bind the last strip most, those left out not among them.
    binding: [Option<u32>; BINDING],
}

impl Walk<'_> {
    /// Drops the facets that end before `at`.
    fn pass_by(&mut self, at: f64) {
        self.reached.retain(|reached| reached.covered.high > at);
    }

    /// The largest d that all facets allow that meet the strip from `at` to `at` + d, but for the share of its area that may be left out.
    fn widest_from(&mut self, at: f64) -> Result<f64, TooManyPlanes> {
        let widest = self.spaced.widest;
        loop {
            let width = self.hint.min(widest);
            let found = self.widest_within(at, width);
            if found < width || width >= widest {
                // More planes than the limit over a kilometre.
                if found.is_nan() || found <= 1e-6 {
                    return Err(TooManyPlanes);
                }
                self.hint = 1.3 * found;
                return Ok(found);
            }
            self.hint = 2.0 * width;
        }
    }

    /// The same, not looking farther than `width`.
    fn widest_within(&mut self, at: f64, width: f64) -> f64 {
        let factor = self.spaced.factor(at);
        let mut area = 0.0;
        self.tightest.clear();
        for index in 0..self.reached.len() {
            let reached = self.reached[index];
            area += consider(&mut self.tightest, reached, at, width, factor);
        }
        while self.next < self.end {
            let covered = self.spaced.sweep.covered[self.next];
            if covered.low >= at + width {
                break;
            }
            self.next += 1;
            let facet = covered.facet as usize;
            let allowed = f64::from(self.spaced.squared[facet]).sqrt();
            let reached = Reached { covered, allowed, density: self.spaced.workpiece.areas[facet] / (covered.high - covered.low) };
            if covered.high > at && covered.high > covered.low {
                self.reached.push(reached);
                area += consider(&mut self.tightest, reached, at, width, factor);
            }
        }
        // The area of a strip grows in proportion to its width, about.
        let left_out_per_width = self.spaced.left_out * area / width;
        let mut tighter = 0.0;
        let is_binding = |&(bound, reached): &(f64, Reached)| {
            tighter += reached.density * overlap(&reached.covered, at, bound);
            tighter > left_out_per_width * bound
        };
        // Where all that are kept may be left out, those that were dropped may not: the widest of them binds.
        let is_full = self.tightest.len() == TIGHTEST;
        let first = self.tightest.iter().position(is_binding).or(is_full.then_some(TIGHTEST - 1));
        let mut binding = self.tightest[first.unwrap_or(self.tightest.len())..].iter().map(|(_, reached)| reached.covered.facet);
        self.binding = std::array::from_fn(|_| binding.next());
        first.map_or(width, |first| self.tightest[first].0.min(width))
    }
}

/// Notes a facet among the tightest of the strip of `width` from `at` if it is one; its area in the strip.
fn consider(tightest: &mut Vec<(f64, Reached)>, reached: Reached, at: f64, width: f64, factor: f64) -> f64 {
    if reached.covered.low >= at + width {
        return 0.0;
    }
    // A strip that ends before the facet begins is not bound by it.
    let bound = (reached.allowed * factor).max(reached.covered.low - at);
    if bound < width && (tightest.len() < TIGHTEST || bound < tightest[TIGHTEST - 1].0) {
        if tightest.len() == TIGHTEST {
            tightest.pop();
        }
        let place = tightest.partition_point(|&(other, _)| other <= bound);
        tightest.insert(place, (bound, reached));
    }
    reached.density * overlap(&reached.covered, at, width)
}

/// The width of what a facet covers of the strip.
fn overlap(covered: &Covered, at: f64, width: f64) -> f64 {
    (covered.high.min(at + width) - covered.low.max(at)).max(0.0)
}
