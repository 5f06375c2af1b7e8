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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::milling::Cutter;
    use crate::motion::{Machine, Preset};
    use crate::planning::zigzag::prepared::{Prepared, rows_of};
    use crate::planning::zigzag::sweep::Sweep;
    use crate::planning::zigzag::workpiece::Workpiece;
    use crate::planning::zigzag::{CandidateCutter, ZigzagSettings};
    use crate::quantity::{Angle, Length};
    use crate::surface::FinishFacet;

    const TOLERANCE: f64 = 0.01;

    /// Facets of 2 mm on z = 0.35 x + 0.1 y + bend (x^2 - y^2/2 + x y), each with the normal and the curvature at its
    /// middle.
    fn facets(bend: f64) -> Vec<FinishFacet> {
        let z = |x: f64, y: f64| 0.35 * x + 0.1 * y + bend * (x * x - 0.5 * y * y + x * y);
        let facet = |corners: [[f64; 2]; 3]| {
            let [x, y] = [0, 1].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 3.0);
            let (zx, zy) = (0.35 + bend * (2.0 * x + y), 0.1 + bend * (x - y));
            let up = zx.hypot(zy).hypot(1.0).recip();
            let corners = corners.map(|[x, y]| [x, y, z(x, y)]);
            // Along tangents t the curvature is -t'Ht n_z, with H the second derivatives of z.
            let curvature = [-2.0 * bend * up, -bend * up, 0.0, bend * up, 0.0, 0.0];
            FinishFacet { corners, normal: [-zx * up, -zy * up, up], area: 2.0 / up, curvature }
        };
        let places = (-5..5).flat_map(|row| (-5..5).map(move |column| [2.0 * f64::from(column), 2.0 * f64::from(row)]));
        let quads = places.map(|[x, y]| [[x, y], [x + 2.0, y], [x + 2.0, y + 2.0], [x, y + 2.0]]);
        quads.flat_map(|[a, b, c, d]| [facet([a, b, c]), facet([a, c, d])]).collect()
    }

    /// The strips that are fitted to facets of a cutter: the inspector, the facets and the place, plane, limit and
    /// fitted width of each strip are handed to `check`. Returns the number of strips and of those that were fitted.
    fn fitted(cutter: Cutter, bend: f64, check: impl Fn(&Inspector, &Spaced, u32, [f64; 3])) -> [u32; 2] {
        let facets = facets(bend);
        let machine = Machine::from(Preset::named("five_axis_vmc").unwrap().limits);
        let settings = ZigzagSettings::new(Length::computed(TOLERANCE), machine);
        let workpiece = Workpiece::new(&facets, settings.max_slope.cos(), &|| false);
        let prepared = Prepared::new(0, &CandidateCutter::new(cutter), &settings, &rows_of(&workpiece), &|| false);
        let inspector = Inspector::new(&facets, &prepared, &settings, &|| false);
        let mut counts = [0; 2];
        for direction in [10.0, 75.0, 140.0] {
            let sweep = Sweep::new(&workpiece, Angle::from_degrees(direction).unwrap(), &|| false);
            let spaced = Spaced::new(&workpiece, &sweep, prepared.allowance(), settings.left_out_share, &|| false);
            for place in (0..200_u32).step_by(7) {
                let covered = sweep.covered[place as usize];
                let width = f64::from(spaced.allowed[place as usize]);
                let limit = (1.3 * width).min(spaced.widest);
                // From a strip that only reaches the facet's beginning to one that holds only its end.
                for part in 0..6 {
                    let at = covered.low - 0.9 * width + f64::from(part) / 5.0 * (covered.high - covered.low + 0.8 * width);
                    counts[0] += 1;
                    if let Some(found) = inspector.fitted(&spaced, place, at, [width, limit]) {
                        counts[1] += 1;
                        check(&inspector, &spaced, place, [at, limit, found]);
                    }
                }
            }
        }
        counts
    }

    /// The largest height by imprints over the tolerance that a strip leaves at many places of its overlap with a facet.
    fn highest(inspector: &Inspector, spaced: &Spaced, place: u32, at: f64, width: f64) -> f64 {
        let (covered, heading) = (spaced.sweep.covered[place as usize], spaced.sweep.heading);
        let corners = spaced.workpiece.corners[covered.facet as usize];
        let [along, across] = [0, 1].map(|axis| {
            let of = |&[x, y, _]: &[f64; 3]| if axis == 0 { heading.along(x, y) } else { heading.across(x, y) };
            corners.iter().map(of).sum::<f64>() / 3.0
        });
        let imprints = Imprints::new(inspector.cutter, &inspector.facets[covered.facet as usize], heading.e);
        let (low, high) = (covered.low.max(at), covered.high.min(at + width));
        if high <= low {
            return 0.0;
        }
        let mut most = 0.0_f64;
        for part in 0..4 {
            let ends = [0.0, 1.0].map(|end| low + (high - low) * (f64::from(part) + end) / 4.0);
            let cut = spaced.sweep.slices[place as usize].cut(f64::midpoint(ends[0], ends[1]));
            for step in 0..5 {
                let at_place = cut[0] + (cut[1] - cut[0]) * f64::from(step) / 4.0 - along;
                let planes = [at - across, at + width - across];
                most = most.max(imprints.height_between(planes, ends.map(|end| end - across), at_place));
            }
        }
        most / inspector.tolerance
    }

    #[test]
    fn a_fitted_strip_keeps_the_tolerance_wherever_it_meets_the_facet() {
        for bend in [0.002, -0.002] {
            let counts = fitted(Cutter::flat_end(Length::computed(6.0)), bend, |inspector, spaced, place, [at, _, width]| {
                let height = highest(inspector, spaced, place, at, width);
                // The fit keeps 0.99 at three places in the middle of the overlap; 3 % is what a plan may exceed.
                assert!(height <= 1.03, "{bend} {place} {at} {width}: {height}");
            });
            assert!(4 * counts[1] > counts[0], "{counts:?}");
        }
    }

    #[test]
    fn a_fitted_strip_is_at_most_the_limit_and_uses_the_tolerance() {
        for bend in [0.002, -0.002] {
            fitted(Cutter::flat_end(Length::computed(6.0)), bend, |inspector, spaced, place, [at, limit, width]| {
                assert!(width <= limit, "{width} {limit}");
                if 1.06 * width < limit {
                    let height = highest(inspector, spaced, place, at, 1.06 * width);
                    assert!(height >= 0.96, "{bend} {place} {at} {width}: {height}");
                }
            });
        }
    }

    #[test]
    fn facets_of_planes_and_of_cutters_without_a_sharp_edge_keep_their_spacing() {
        let mm = Length::computed;
        assert_eq!(fitted(Cutter::flat_end(mm(6.0)), 0.0, |_, _, _, _| ())[1], 0);
        for cutter in [Cutter::ball_end(mm(6.0)), Cutter::toroidal(mm(6.0), mm(0.5)).unwrap()] {
            assert_eq!(fitted(cutter, 0.002, |_, _, _, _| ())[1], 0);
        }
    }
}
