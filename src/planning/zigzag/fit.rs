//! Strips fitted to the facets that bind them: the height is evaluated where facet and strip overlap, between the
//! strip's own two passes.
//!
//! The spacing of a facet holds for a strip around its middle. A facet wider than the strip meets strips on which it
//! allows more or less than that, and at a border the strip meets only the edge of it. This is so for flat-end cutters,
//! whose strips are narrow; those of other cutters are about as wide as facets.

use super::contacts::FacetContact;
use super::imprint::Imprints;
use super::inspector::{Inspector, NEAR_GOUGING};
use super::spaced::Spaced;
use crate::milling::{CutterKind, Model};

/// Facets narrower than this multiple of a strip's width keep their own spacing.
const NARROW: f64 = 2.0;

/// A strip is fitted once the height is between these shares of the tolerance; `AIM` is between them.
const TIGHT: f64 = 0.96;
const AIM: f64 = 0.98;
const MOST: f64 = 0.99;

/// The largest number of widths that are tried, and the ratio of the narrowest one that is too wide to the widest one
/// that is not, at which the search ends.
const STEPS: usize = 8;
const CLOSE: f64 = 1.01;

/// A strip is not narrowed below this share of the width that the facet's own spacing allows: where imprints leave more
/// than the tolerance at any width, the curvature of the facet is not that of the surface.
const NARROWEST: f64 = 0.1;

impl Inspector<'_> {
    /// The widest strip from the plane at `at` that keeps the tolerance on its overlap with a facet, whose own spacing
    /// allows `width`; at most `limit`. `None` if the facet keeps its own spacing.
    pub(super) fn fitted(&self, spaced: &Spaced, place: u32, at: f64, [width, limit]: [f64; 2]) -> Option<f64> {
        let covered = spaced.sweep.covered[place as usize];
        let is_sharp = self.cutter.kind() == CutterKind::FlatEnd && self.teeth_per_second.is_none();
        if !is_sharp || covered.high - covered.low < NARROW * width || (self.stop)() {
            return None;
        }
        let (index, heading) = (covered.facet as usize, spaced.sweep.heading);
        let tangent = &spaced.workpiece.tangents[index];
        // Where the surface is level the tip jumps from one side of the contact to the other, and with it the height of
        // places beside the facet.
        let [steepest, twist, level] = tangent.curvature;
        let size = spaced.workpiece.areas[index].sqrt() + width;
        if tangent.sin <= size * (steepest.abs().max(level.abs()) + twist.abs()) {
            return None;
        }
        let facet = &self.facets[index];
        let contact = FacetContact::new(facet, heading.e).ok()?;
        if contact.is_plane() || contact.evaluated(self.cutter, Model::Envelope).ok()?.relative_curvature() <= NEAR_GOUGING {
            return None;
        }
        let corners = spaced.workpiece.corners[index];
        let middle = |of: &dyn Fn(f64, f64) -> f64| corners.iter().map(|&[x, y, _]| of(x, y)).sum::<f64>() / 3.0;
        let (along, across) = (middle(&|x, y| heading.along(x, y)), middle(&|x, y| heading.across(x, y)));
        let imprints = Imprints::new(self.cutter, facet, heading.e);
        // The height over the tolerance that a strip of this width has on the facet.
        let height = |width: f64| {
            let part = [covered.low.max(at), covered.high.min(at + width)];
            if part[1] <= part[0] {
                return 0.0;
            }
            let cut = spaced.sweep.slices[place as usize].cut(f64::midpoint(part[0], part[1])).map(|end| end - along);
            let strip = |coordinates: [f64; 2]| coordinates.map(|coordinate| coordinate - across);
            let at_place = |place: f64| imprints.height_between(strip([at, at + width]), strip(part), place) / self.tolerance;
            let level = imprints.level_at(f64::midpoint(part[0], part[1]) - across);
            let size = cut[1] - cut[0];
            if level < cut[0] - size || level > cut[1] + size {
                at_place(f64::midpoint(cut[0], cut[1]))
            } else {
                [cut[0], cut[1], level.clamp(cut[0], cut[1])].into_iter().map(at_place).fold(0.0, f64::max)
            }
        };
        let (mut kept, mut too_wide) = ((covered.low - at).max(0.0), f64::INFINITY);
        let mut tried = width.max(1.02 * kept).min(limit);
        let mut last = None::<(f64, f64)>;
        for _ in 0..STEPS {
            if tried < NARROWEST * width {
                break;
            }
            let found = height(tried).clamp(0.05, 20.0);
            if found > MOST {
                too_wide = tried;
            } else {
                kept = tried;
                if found >= TIGHT || tried >= limit {
                    break;
                }
            }
            if too_wide <= CLOSE * kept {
                break;
            }
            // Beside a sharp edge heights grow with the first power of the width, elsewhere with the second.
            let power = last.map_or(1.0, |(other, at_other)| (at_other / found).ln() / (other / tried).ln());
            let power = if power > 0.5 { power.min(3.0) } else { 1.0 };
            last = Some((tried, found));
            let next = (tried * (AIM / found).powf(power.recip())).min(limit);
            tried = if next > kept && next < too_wide { next } else { f64::midpoint(kept, too_wide) };
        }
        (kept >= NARROWEST * width).then_some(kept)
    }
}
