//! The positions of the planes of passes, as far apart as the worst point of each strip allows.

use super::spacing::CutterSpacing;
use super::sweep::{Covered, Sweep};
use super::workpiece::{Tangent, Workpiece};

/// The most planes that a plan may have; beyond it a direction counts as having no spacing.
pub(super) const MOST_PLANES: usize = 50_000;

/// The number of the tightest facets of a strip that are considered for the share that may be left out.
const TIGHTEST: usize = 8;

/// Facets of one direction with the spacings that they allow one cutter.
#[derive(Debug)]
pub(super) struct Spaced<'a> {
    pub(super) workpiece: &'a Workpiece,
    pub(super) sweep: &'a Sweep,
    pub(super) spacing: &'a CutterSpacing,
    /// The spacings that facets allow, in the order of the sweep; steep facets set none.
    pub(super) allowed: Vec<f32>,
    /// The widest spacing, the cutter's diameter, in mm.
    pub(super) widest: f64,
    /// The share of a strip's area that may allow less than its spacing.
    pub(super) left_out: f64,
}

impl<'a> Spaced<'a> {
    pub(super) fn new(workpiece: &'a Workpiece, sweep: &'a Sweep, spacing: &'a CutterSpacing, widest: f64, left_out: f64) -> Self {
        let allowed = |covered: &Covered| {
            #[expect(clippy::cast_possible_truncation, reason = "single precision errs by 6e-8, far less than the model")]
            let allowed = squared_spacing(&workpiece.tangents[covered.facet as usize], sweep, spacing).sqrt() as f32;
            allowed
        };
        let allowed = sweep.covered.iter().map(allowed).collect();
        Self { workpiece, sweep, spacing, allowed, widest, left_out }
    }

    /// The squared spacing that a facet allows; infinite on a steep one.
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

/// A facet that the planes have reached.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    /// Its position in the order of the sweep.
    pub(super) place: u32,
    pub(super) low: f64,
    pub(super) high: f64,
    /// The spacing that it allows.
    allowed: f64,
    /// Its area over its width across the passes.
    density: f64,
}

/// A plane of passes with the spacings to its neighbours; the first and the last have their one neighbour's on both
/// sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Plane {
    pub(super) at: f64,
    pub(super) before: f64,
    pub(super) after: f64,
    /// The place in the sweep of the facet that binds the spacing after it, if one does.
    pub(super) binding: Option<u32>,
}

impl Plane {
    /// The spacing that determines the scallop height: the wider one.
    pub(super) fn spacing(&self) -> f64 {
        self.before.max(self.after)
    }
}

/// The reason why there are no planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum NoPlanes {
    /// More planes or runs than there is room for.
    NoRoom,
    /// The work was cancelled.
    Cancelled,
    /// No spacing keeps the scallop height.
    NoSpacing,
    /// There would be more than [`MOST_PLANES`].
    TooManyPlanes,
    /// There would be more than [`MOST_RUNS`](super::simulate::MOST_RUNS) runs in them.
    TooManyRuns,
    /// The strips would meet more than [`MOST_MET`] facets.
    TooManyMet,
}

/// The number of planes between two checks for cancellation.
const PLANES_AT_ONCE: usize = 32;

/// The most facets that strips may meet, over all strips: some 0.2 s. A mesh of a million facets meets 5e6; half a
/// million facets that each cover a whole part meet it in every strip.
pub(super) const MOST_MET: usize = 50_000_000;

/// Walks across the passes from band to band, and calls `visit` with each plane and the facets that may meet it. The
/// visitor keeps those that reach beyond the plane, and may end the walk.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn march(
    spaced: &Spaced,
    stop: &(dyn Fn() -> bool + Sync),
    mut visit: impl FnMut(Plane, &mut Vec<Reached>) -> Result<(), NoPlanes>,
) -> Result<(), NoPlanes> {
    let (mut planes, mut met) = (0_usize, 0_usize);
    for band in spaced.sweep.bands(spaced.widest) {
        let mut walk = Walk {
            spaced,
            next: band.start,
            end: band.end,
            reached: Vec::new(),
            hint: spaced.widest,
            tightest: Vec::new(),
            binding: None,
        };
        let first = walk.widest_from(band.low)?;
        let mut is_last = band.high - band.low < first;
        // As far from the border as from the next plane's half; in a band of less than one spacing in the middle.
        let mut plane = Plane {
            at: if is_last { f64::midpoint(band.low, band.high) } else { band.low + first / 2.0 },
            before: first,
            after: first,
            binding: None,
        };
        loop {
            planes += 1;
            met += walk.reached.len();
            if planes > MOST_PLANES {
                return Err(NoPlanes::TooManyPlanes);
            }
            if met > MOST_MET {
                return Err(NoPlanes::TooManyMet);
            }
            if planes.is_multiple_of(PLANES_AT_ONCE) && stop() {
                return Err(NoPlanes::Cancelled);
            }
            let rest = band.high - plane.at;
            let widest = if is_last { plane.before } else { walk.widest_from(plane.at)? };
            plane.binding = walk.binding;
            if is_last || rest <= widest / 2.0 {
                // The half spacing beyond the last plane leaves as much as a whole one between two planes.
                plane.after = plane.before;
                visit(plane, &mut walk.reached)?;
                break;
            }
            // Beyond the border there is nothing to cut: half a spacing before it is enough, and the strip up to the
            // border allows that.
            is_last = widest > rest;
            plane.after = if is_last { rest - widest / 2.0 } else { widest };
            if planes == 1 {
                plane.before = plane.after;
            }
            visit(plane, &mut walk.reached)?;
            plane = Plane { at: plane.at + plane.after, before: plane.after, after: plane.after, binding: None };
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
    /// The width of the search: somewhat more than the last spacing.
    hint: f64,
    /// The tightest facets of the strip: the width that they allow it, and which of the reached facets they are.
    tightest: Vec<(f64, usize)>,
    /// The place of the facet that binds the last strip; those left out do not.
    binding: Option<u32>,
}

impl Walk<'_> {
    /// The largest d that all facets allow that meet the strip from `at` to `at` + d, but for the share of its area
    /// that may be left out.
    fn widest_from(&mut self, at: f64) -> Result<f64, NoPlanes> {
        let widest = self.spaced.widest;
        loop {
            let width = self.hint.min(widest);
            let found = self.widest_within(at, width);
            if found < width || width >= widest {
                // Under a nanometre there is none: as many planes as are allowed would cover 0.05 mm.
                if found.is_nan() || found <= 1e-6 {
                    return Err(NoPlanes::NoSpacing);
                }
                self.hint = 1.2 * found;
                return Ok(found);
            }
            self.hint = 2.0 * width;
        }
    }

    /// The same, searching at most up to `width`.
    fn widest_within(&mut self, at: f64, width: f64) -> f64 {
        let end = at + width;
        while self.next < self.end {
            let covered = self.spaced.sweep.covered[self.next];
            if covered.low >= end {
                break;
            }
            if covered.high > at && covered.high > covered.low {
                let allowed = f64::from(self.spaced.allowed[self.next]);
                let density = f64::from(covered.density);
                #[expect(clippy::cast_possible_truncation, reason = "as many as facets")]
                let place = self.next as u32;
                self.reached.push(Reached { place, low: covered.low, high: covered.high, allowed, density });
            }
            self.next += 1;
        }
        self.tightest.clear();
        // Only facets with bounds under this one are among the tightest.
        let mut limit = width;
        let mut area = 0.0;
        for (index, reached) in self.reached.iter().enumerate() {
            // Facets that end at the previous plane are still included.
            if reached.high <= at {
                continue;
            }
            // A strip that ends before the facet begins is not bound by it.
            let (own, begins) = (reached.allowed, reached.low - at);
            let bound = if own > begins { own } else { begins };
            let (from, to) = (if reached.low > at { reached.low } else { at }, if reached.high < end { reached.high } else { end });
            area += reached.density * if to > from { to - from } else { 0.0 };
            if bound < limit {
                if self.tightest.len() == TIGHTEST {
                    self.tightest.pop();
                }
                let place = self.tightest.iter().rposition(|&(other, _)| other <= bound).map_or(0, |place| place + 1);
                self.tightest.insert(place, (bound, index));
                if self.tightest.len() == TIGHTEST {
                    limit = self.tightest[TIGHTEST - 1].0;
                }
            }
        }
        // The area of a strip grows in proportion to its width, about. A strip may be as wide as the bound of a facet
        // if a wider one, up to the next bound, would hold more of tighter facets than may be left out.
        let left_out_per_width = self.spaced.left_out * area / width;
        let next_bound = |index: usize| self.tightest.get(index + 1).map_or(width, |&(bound, _)| bound);
        let holds_too_much = |index: &usize| {
            let wider = next_bound(*index);
            let overlap = |&(_, at_index): &(f64, usize)| {
                let reached = &self.reached[at_index];
                reached.density * (reached.high.min(at + wider) - reached.low.max(at)).max(0.0)
            };
            self.tightest[..=*index].iter().map(overlap).sum::<f64>() > left_out_per_width * wider
        };
        // Where all that are kept may be left out, those that were dropped may not: the widest of them binds.
        let first = (0..self.tightest.len()).find(holds_too_much).or((self.tightest.len() == TIGHTEST).then_some(TIGHTEST - 1));
        self.binding = first.map(|first| self.reached[self.tightest[first].1].place);
        first.map_or(width, |first| self.tightest[first].0)
    }
}
