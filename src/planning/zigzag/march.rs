//! Placement of the planes of passes, as far apart as the worst point of each strip allows.

use super::spaced::Spaced;

/// The largest number of planes of a plan. A direction that needs more has no plan.
pub(super) const MOST_PLANES: usize = 50_000;

/// The number of a strip's tightest facets from which the share that may be left out is taken.
const TIGHTEST: usize = 8;

/// The number of a strip's tightest facets that are recorded first: mostly the first one binds.
const FEW: usize = 2;

/// A facet that meets the strip after the current plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reached {
    /// The interval across the passes that it covers.
    low: f64,
    high: f64,
    /// The spacing that it allows.
    allowed: f32,
    /// Its area divided by its width across the passes.
    density: f32,
    /// Its position in the order of the sweep.
    pub(super) place: u32,
}

impl Reached {
    /// Its part of the area between two planes.
    fn area_between(&self, at: f64, end: f64) -> f64 {
        let (from, to) = (if self.low > at { self.low } else { at }, if self.high < end { self.high } else { end });
        f64::from(self.density) * (to - from).max(0.0)
    }
}

/// A plane of passes with the spacings to its neighbours. The first and the last plane have one neighbour, whose
/// spacing counts on both sides.
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
    /// The plan needs more planes or runs than its room has.
    NoRoom,
    /// The work was cancelled.
    Cancelled,
    /// No spacing keeps the scallop height.
    NoSpacing,
    /// There would be more than [`MOST_PLANES`].
    TooManyPlanes,
    /// There would be more than [`MOST_RUNS`](super::room::MOST_RUNS) runs in them.
    TooManyRuns,
    /// The strips would contain facets more than [`MOST_MET`] times, counted once for each strip.
    TooManyMet,
}

/// The number of facets that planes meet between two checks for cancellation, about a millisecond; each plane counts
/// as [`FACETS_OF_A_PLANE`] more.
const MET_AT_ONCE: usize = 65_536;
const FACETS_OF_A_PLANE: usize = 2_048;

/// The largest number of facets in strips, counted once for each strip: about 0.2 s of work. An ordinary mesh of a
/// million facets has 5e6. Half a million facets that each cover the whole part would all be in every strip.
pub(super) const MOST_MET: usize = 50_000_000;

/// The widest strip that a facet allows from a plane. The arguments are the facet's place in the sweep, the coordinate
/// of the plane, the width that the facet's own spacing allows, and the widest one wanted. `None` if the own spacing
/// holds.
pub(super) type Fit<'a> = dyn Fn(u32, f64, f64, f64) -> Option<f64> + 'a;

/// The largest number of facets that are fitted to a strip one after the other.
const MOST_FITTED: usize = 12;

/// The largest factor by which fitting widens a strip: the facets that are not fitted still have their own spacings.
const WIDEST_FITTED: f64 = 1.3;

/// What a placement meets in each band: the strip before the first plane, then each plane and the strip after it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Met<'a> {
    /// A plane, and the facets that it cuts.
    Plane(Plane, &'a [Reached]),
    /// The coordinates across the passes between which a strip lies, and the facets that it meets.
    Strip([f64; 2], &'a [Reached]),
}

/// Places the planes band by band, and calls `visit` with each plane and each strip. The visitor may end the placement.
/// Facets that bind a strip are fitted to it by `fit`.
///
/// # Errors
/// [`NoPlanes`]
pub(super) fn march(
    spaced: &Spaced,
    fit: Option<&Fit>,
    stop: &(dyn Fn() -> bool + Sync),
    mut visit: impl FnMut(Met) -> Result<(), NoPlanes>,
) -> Result<(), NoPlanes> {
    let (mut planes, mut met, mut met_at_check) = (0_usize, 0_usize, 0_usize);
    if stop() {
        // After a cancellation, facets and spacings may be missing.
        return Err(NoPlanes::Cancelled);
    }
    for band in spaced.sweep.bands(spaced.widest) {
        let mut walk = Walk {
            spaced,
            next: band.start,
            end: band.end,
            reached: Vec::new(),
            hint: spaced.widest,
            tightest: TightestOfStrip::default(),
            binding: None,
            fitted: Vec::new(),
        };
        let first = walk.widest_from(band.low, FEW)?;
        let mut is_last = band.high - band.low < first;
        // The first plane is half a spacing from the border; in a band narrower than one spacing, in the middle.
        let mut plane = Plane {
            at: if is_last { f64::midpoint(band.low, band.high) } else { band.low + first / 2.0 },
            before: first,
            after: first,
            binding: None,
        };
        visit(Met::Strip([band.low, plane.at], walk.begun(plane.at)))?;
        loop {
            planes += 1;
            met += walk.reached.len();
            if planes > MOST_PLANES {
                return Err(NoPlanes::TooManyPlanes);
            }
            if met > MOST_MET {
                return Err(NoPlanes::TooManyMet);
            }
            if met + planes * FACETS_OF_A_PLANE - met_at_check >= MET_AT_ONCE {
                met_at_check = met + planes * FACETS_OF_A_PLANE;
                if stop() {
                    return Err(NoPlanes::Cancelled);
                }
            }
            walk.pass(plane.at);
            let rest = band.high - plane.at;
            let widest = if is_last { plane.before } else { walk.fitted_from(plane.at, fit)? };
            plane.binding = walk.binding.map(|(place, _)| place);
            if is_last || rest <= widest / 2.0 {
                // Half a spacing beyond the last plane leaves the same height as a whole spacing between two planes.
                plane.after = plane.before;
                visit(Met::Plane(plane, walk.begun(plane.at)))?;
                visit(Met::Strip([plane.at, band.high], &walk.reached))?;
                break;
            }
            // There is no material beyond the border: the last plane may be half a spacing before it, and the strip up
            // to the border allows that spacing.
            is_last = widest > rest;
            plane.after = if is_last { rest - widest / 2.0 } else { widest };
            if planes == 1 {
                plane.before = plane.after;
            }
            let next = plane.at + plane.after;
            visit(Met::Plane(plane, walk.begun(plane.at)))?;
            visit(Met::Strip([plane.at, next], walk.begun(next)))?;
            plane = Plane { at: next, before: plane.after, after: plane.after, binding: None };
        }
    }
    Ok(())
}

/// The placement of planes in one band.
struct Walk<'a> {
    spaced: &'a Spaced<'a>,
    /// The next facet in the order of the sweep.
    next: usize,
    end: usize,
    /// The facets that meet the strip, in rising order of their beginnings.
    reached: Vec<Reached>,
    /// The width to search first: somewhat more than the last spacing.
    hint: f64,
    /// The tightest facets of the strip.
    tightest: TightestOfStrip,
    /// The place of the facet that binds the last strip, and its index among the reached facets; those left out do not.
    binding: Option<(u32, usize)>,
    /// The facets that are fitted to the strip: their indices among the reached ones, and their own spacings.
    fitted: Vec<(usize, f32)>,
}

impl Walk<'_> {
    /// Removes the facets that end before a plane.
    fn pass(&mut self, at: f64) {
        let count = self.begun(at).len();
        let begun = &mut self.reached[..count];
        let mut kept = 0;
        // Whether a facet ends is nearly random, so the list is filled without branches.
        for index in 0..count {
            let one = begun[index];
            begun[kept] = one;
            kept += usize::from(one.high > at);
        }
        self.reached.drain(kept..count);
    }

    /// The reached facets that begin before a plane; those that a plane cuts, once the ended ones are removed.
    fn begun(&self, at: f64) -> &[Reached] {
        &self.reached[..self.reached.partition_point(|reached| reached.low <= at)]
    }

    /// The same as [`Self::widest_from`], with the facets that bind the strip fitted to it one after the other. The
    /// others of the tightest are then compared with the result.
    fn fitted_from(&mut self, at: f64, fit: Option<&Fit>) -> Result<f64, NoPlanes> {
        let Some(fit) = fit else { return self.widest_from(at, FEW) };
        let mut found = self.widest_from(at, TIGHTEST)?;
        let limit = (WIDEST_FITTED * found).min(self.spaced.widest);
        while self.fitted.len() < MOST_FITTED && found < limit {
            let is_fitted = |index: usize| self.fitted.iter().any(|&(known, _)| known == index);
            let Some((place, index)) = self.binding.filter(|&(_, index)| !is_fitted(index)) else { break };
            let Some(width) = fit(place, at, found, limit) else { break };
            self.fitted.push((index, self.reached[index].allowed));
            #[expect(clippy::cast_possible_truncation, reason = "single precision errs by 6e-8, far less than the model")]
            let allowed = width as f32;
            self.reached[index].allowed = allowed;
            found = self.widest_from(at, TIGHTEST)?;
        }
        if self.fitted.is_empty() {
            return Ok(found);
        }
        found = found.min(limit);
        for &(_, index) in self.tightest.facets() {
            if self.fitted.iter().all(|&(known, _)| known != index) {
                found = fit(self.reached[index].place, at, found, found).unwrap_or(found);
            }
        }
        for (index, own) in self.fitted.drain(..) {
            self.reached[index].allowed = own;
        }
        Ok(found)
    }

    /// The largest d allowed by all facets in the strip from `at` to `at` + d, except the share of its area that may be
    /// left out. At least `most` of the tightest facets are recorded.
    fn widest_from(&mut self, at: f64, most: usize) -> Result<f64, NoPlanes> {
        let widest = self.spaced.widest;
        loop {
            let width = self.hint.min(widest);
            let found = self.widest_within(at, width, most);
            if found < width || width >= widest {
                // A spacing under a nanometre counts as none: the largest number of planes would cover 0.05 mm.
                if found.is_nan() || found <= 1e-6 {
                    return Err(NoPlanes::NoSpacing);
                }
                self.hint = 1.2 * found;
                return Ok(found);
            }
            self.hint = 2.0 * width;
        }
    }

    /// The same with an upper limit: the result is at most `width`. At least `most` of the tightest facets are recorded.
    fn widest_within(&mut self, at: f64, width: f64, most: usize) -> f64 {
        let end = at + width;
        while self.next < self.end {
            let covered = self.spaced.sweep.covered[self.next];
            if covered.low >= end {
                break;
            }
            if covered.high > at && covered.high > covered.low {
                let (allowed, density) = (self.spaced.allowed[self.next], covered.density);
                #[expect(clippy::cast_possible_truncation, reason = "as many as facets")]
                let place = self.next as u32;
                self.reached.push(Reached { low: covered.low, high: covered.high, allowed, density, place });
            }
            self.next += 1;
        }
        let area = self.find_tightest(at, width, most);
        // The area of a strip is about proportional to its width. The strip may extend to the bound of the first facet
        // that cannot be left out: with it, the tighter facets would exceed the share that may be left out.
        let left_out_per_width = self.spaced.left_out * area / width;
        let tightest = self.tightest.facets();
        let next_bound = |index: usize| tightest.get(index + 1).map_or(width, |&(bound, _)| bound);
        let holds_too_much = |index: &usize| {
            let wider = next_bound(*index);
            let overlap = |&(_, at_index): &(f64, usize)| self.reached[at_index].area_between(at, at + wider);
            tightest[..=*index].iter().map(overlap).sum::<f64>() > left_out_per_width * wider
        };
        // If all recorded facets could be left out, the facets that were not recorded might exceed the share: then the
        // last recorded facet binds.
        let first = (0..tightest.len()).find(holds_too_much).or((tightest.len() == TIGHTEST).then_some(TIGHTEST - 1));
        if most < TIGHTEST && tightest.len() == most && first != Some(0) {
            return self.widest_within(at, width, TIGHTEST);
        }
        self.binding = first.map(|first| tightest[first].1).map(|index| (self.reached[index].place, index));
        first.map_or(width, |first| tightest[first].0)
    }

    /// Records the `most` tightest facets of the strip, and returns the area of its facets.
    fn find_tightest(&mut self, at: f64, width: f64, most: usize) -> f64 {
        let end = at + width;
        let mut tightest = TightestOfStrip { limit: width, most, ..TightestOfStrip::default() };
        let mut area = 0.0;
        let begun = self.begun(at).len();
        for (index, reached) in self.reached[..begun].iter().enumerate() {
            area += f64::from(reached.density) * (if reached.high < end { reached.high } else { end } - at);
            let allowed = f64::from(reached.allowed);
            if allowed < tightest.limit {
                tightest.add(allowed, index);
            }
        }
        for (index, reached) in self.reached.iter().enumerate().skip(begun) {
            area += reached.area_between(at, end);
            // A strip may extend to the facet's beginning in any case.
            let (allowed, begins) = (f64::from(reached.allowed), reached.low - at);
            let bound = if allowed > begins { allowed } else { begins };
            if bound < tightest.limit {
                tightest.add(bound, index);
            }
        }
        self.tightest = tightest;
        area
    }
}

/// The facets of a strip that allow the least.
#[derive(Debug, Clone, Copy, Default)]
struct TightestOfStrip {
    /// The widths that they allow in rising order, each with the facet's index among the reached ones.
    facets: [(f64, usize); TIGHTEST],
    count: usize,
    /// The largest number of them, at most [`TIGHTEST`].
    most: usize,
    /// Only facets that allow less than this belong to them.
    limit: f64,
}

impl TightestOfStrip {
    fn facets(&self) -> &[(f64, usize)] {
        &self.facets[..self.count]
    }

    /// Adds a facet that allows less than the limit.
    fn add(&mut self, width: f64, index: usize) {
        self.count = (self.count + 1).min(self.most);
        let mut place = self.count - 1;
        while place > 0 && self.facets[place - 1].0 > width {
            self.facets[place] = self.facets[place - 1];
            place -= 1;
        }
        self.facets[place] = (width, index);
        if self.count == self.most {
            self.limit = self.facets[self.count - 1].0;
        }
    }
}
