//! The facets of a workpiece, sorted in the order in which the planes of one direction meet them.

use super::footprint::Outline;
use super::heading::Heading;
use super::workpiece::Workpiece;
use crate::quantity::Angle;

/// A facet and the interval across the passes that it covers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Covered {
    pub(super) low: f64,
    pub(super) high: f64,
    pub(super) facet: u32,
    /// The area of the facet divided by its width across the passes, in mm.
    pub(super) density: f32,
}

/// A facet prepared for intersection with the planes of one direction: an intersection takes a few multiplications.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slice {
    low: f64,
    middle: f64,
    /// The coordinate along the passes of the middle corner in the order across them, and of the first.
    middle_along: f64,
    first: f64,
    height: f64,
    /// The slope of the edge from the first corner to the last: length along the passes per length across them.
    long: f64,
    /// The edges before and after the middle corner: the coordinates of a point on each, across and along the passes,
    /// and its slope.
    short: [[f64; 3]; 2],
    /// The rise of the facet along and across the passes, per length seen from above.
    rise: [f64; 2],
    /// The length in space of a cut per length seen from above.
    stretch: f64,
    /// The number of facets that this one represents.
    pub(super) weight: f64,
}

impl Slice {
    /// Prepares a facet.
    pub(super) fn new(facet: u32, workpiece: &Workpiece, heading: Heading) -> Self {
        let facet = facet as usize;
        let (tangent, weight) = (&workpiece.tangents[facet], workpiece.weights[facet]);
        let mut corners = workpiece.corners[facet].map(|[x, y, z]| [heading.across(x, y), heading.along(x, y), z]);
        for (i, j) in [(0, 1), (1, 2), (0, 1)] {
            if corners[i][0] > corners[j][0] {
                corners.swap(i, j);
            }
        }
        let [low, middle, high] = corners;
        // Infinite for an edge along the passes, which no plane intersects.
        let edge = |a: [f64; 3], b: [f64; 3]| (b[1] - a[1]) / (b[0] - a[0]);
        let ((cos_alpha, sin_alpha), tan) = (tangent.alpha(heading.e), tangent.sin * tangent.per_cos);
        let rise = [-tan * cos_alpha, tan * sin_alpha];
        Self {
            low: low[0],
            middle: middle[0],
            middle_along: middle[1],
            first: low[1],
            height: low[2],
            long: edge(low, high),
            short: [[low[0], low[1], edge(low, middle)], [high[0], high[1], edge(middle, high)]],
            rise,
            stretch: (1.0 + rise[0] * rise[0]).sqrt(),
            weight,
        }
    }

    /// The coordinates along the passes of both ends of the cut at `at`, the smaller one first. `at` must be at or
    /// after the first corner and before the last.
    pub(super) fn cut(&self, at: f64) -> [f64; 2] {
        let long = self.first + self.long * (at - self.low);
        // Indexed, because a branch would be mispredicted half of the time.
        let [across, along, edge] = self.short[usize::from(at >= self.middle)];
        let short = along + edge * (at - across);
        [if long < short { long } else { short }, if long < short { short } else { long }]
    }

    /// The interval across the passes that the facet covers.
    pub(super) fn across(&self) -> [f64; 2] {
        [self.low, self.short[1][0]]
    }

    /// The interval along the passes that the facet covers.
    pub(super) fn along(&self) -> [f64; 2] {
        let others = [self.middle_along, self.short[1][1]];
        others.into_iter().fold([self.first; 2], |[least, most], along| [least.min(along), most.max(along)])
    }

    /// The interval along the passes that the part of the facet from one coordinate across them to another covers; from
    /// infinity to minus infinity if there is no such part.
    pub(super) fn along_between(&self, [from, to]: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.across();
        let corners = [[low, self.first], [self.middle, self.middle_along], [high, self.short[1][1]]];
        let corners = corners.into_iter().filter(|[at, _]| (from..=to).contains(at)).map(|[_, along]| along);
        let cuts = [from, to].into_iter().filter(|&at| low < at && at < high).flat_map(|at| self.cut(at));
        corners.chain(cuts).fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], along| [least.min(along), most.max(along)])
    }

    /// The height of the facet at a place.
    pub(super) fn height(&self, along: f64, at: f64) -> f64 {
        self.height + self.rise[0] * (along - self.first) + self.rise[1] * (at - self.low)
    }

    /// The length in space of a line along the passes per length seen from above.
    pub(super) fn stretch(&self) -> f64 {
        self.stretch
    }
}

/// The facets in rising order of their first coordinate across the passes.
#[derive(Debug)]
pub(super) struct Sweep {
    pub(super) heading: Heading,
    pub(super) covered: Vec<Covered>,
    /// The facets prepared for intersection, in the same order.
    pub(super) slices: Vec<Slice>,
    /// The least and largest coordinate along the passes.
    pub(super) along: [f64; 2],
    /// The intervals across the passes that facets cover without a gap.
    covered_bands: Vec<Band>,
    /// Where passes are on the surface, if the facets are sampled.
    pub(super) outline: Option<Outline>,
}

/// The number of facets between two checks for cancellation.
const TURN: usize = 8192;

impl Sweep {
    /// The facets in the order of this direction. Once `stop` returns true, it returns early, with fewer of them.
    pub(super) fn new(workpiece: &Workpiece, direction: Angle, stop: &(dyn Fn() -> bool + Sync)) -> Self {
        let heading = Heading::new(direction);
        let mut along = [f64::INFINITY, f64::NEG_INFINITY];
        let mut across = [f64::INFINITY, f64::NEG_INFINITY];
        let mut unordered: Vec<Covered> = Vec::with_capacity(workpiece.len());
        let facets = (0_u32..).step_by(TURN).zip(workpiece.corners.chunks(TURN).zip(workpiece.areas.chunks(TURN)));
        for (first, (corners, areas)) in facets.take_while(|_| !stop()) {
            unordered.extend((first..).zip(corners).zip(areas).map(|((facet, corners), area)| {
                let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
                for &[x, y, _] in corners {
                    let (p, q) = (heading.along(x, y), heading.across(x, y));
                    along = [along[0].min(p), along[1].max(p)];
                    (low, high) = (low.min(q), high.max(q));
                }
                across = [across[0].min(low), across[1].max(low)];
                #[expect(clippy::cast_possible_truncation, reason = "shares of areas need few digits")]
                let density = (area / (high - low)) as f32;
                Covered { low, high, facet, density }
            }));
        }
        let covered = if stop() { Vec::new() } else { ordered(unordered, across) };
        let slice = |covered: &Covered| Slice::new(covered.facet, workpiece, heading);
        let mut slices = Vec::with_capacity(covered.len());
        for covered in covered.chunks(TURN).take_while(|_| !stop()) {
            slices.extend(covered.iter().map(slice));
        }
        let covered_bands = bands_of(&covered);
        let outline = workpiece.footprint.as_ref().map(|footprint| footprint.outline(heading));
        Self { heading, covered, slices, along, covered_bands, outline }
    }

    /// The intervals across the passes that facets cover without a gap wider than `gap`.
    pub(super) fn bands(&self, gap: f64) -> Vec<Band> {
        let mut bands: Vec<Band> = Vec::new();
        for next in &self.covered_bands {
            match bands.last_mut() {
                Some(band) if next.low <= band.high + gap => {
                    band.high = band.high.max(next.high);
                    band.end = next.end;
                }
                _ => bands.push(*next),
            }
        }
        bands
    }
}

/// An interval across the passes that is covered without wide gaps: its facets and its two ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    /// The first of its facets in the order of the sweep.
    pub(super) start: usize,
    /// One past the last of its facets.
    pub(super) end: usize,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// The intervals that facets in rising order cover without a gap.
fn bands_of(covered: &[Covered]) -> Vec<Band> {
    let mut bands: Vec<Band> = Vec::new();
    for (index, covered) in covered.iter().enumerate() {
        match bands.last_mut() {
            Some(band) if covered.low <= band.high => {
                band.high = band.high.max(covered.high);
                band.end = index + 1;
            }
            _ => bands.push(Band { start: index, end: index + 1, low: covered.low, high: covered.high }),
        }
    }
    bands
}

/// Sorts by `low`, whose smallest and largest value are in `range`. It is a counting sort into as many buckets as there
/// are facets, with an insertion sort within each: a comparison sort takes three times as long.
fn ordered(unordered: Vec<Covered>, range: [f64; 2]) -> Vec<Covered> {
    let count = unordered.len();
    let width = range[1] - range[0];
    if count < 64 || width <= 0.0 {
        let mut sorted = unordered;
        sorted.sort_by(|a, b| a.low.total_cmp(&b.low));
        return sorted;
    }
    #[expect(clippy::cast_precision_loss, reason = "counts far under 2^53")]
    let per_width = (count - 1) as f64 / width;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to count - 1")]
    let bucket = |covered: &Covered| (((covered.low - range[0]) * per_width) as u32 as usize).min(count - 1);
    let mut starts = vec![0_u32; count + 1];
    for covered in &unordered {
        starts[bucket(covered) + 1] += 1;
    }
    for index in 0..count {
        starts[index + 1] += starts[index];
    }
    let mut sorted = vec![Covered { low: 0.0, high: 0.0, facet: 0, density: 0.0 }; count];
    for covered in &unordered {
        let place = &mut starts[bucket(covered)];
        sorted[*place as usize] = *covered;
        *place += 1;
    }
    // In a mesh of rows, hundreds of facets begin at the same coordinate and fall into one bucket. Such a bucket is
    // usually in order already; if not, it is sorted by comparison.
    if sorted.windows(2).any(|pair| pair[0].low > pair[1].low) {
        let mut start = 0;
        for end in 1..=count {
            if end == count || bucket(&sorted[end]) != bucket(&sorted[start]) {
                if end - start > 1 {
                    sorted[start..end].sort_by(|a, b| a.low.total_cmp(&b.low));
                }
                start = end;
            }
        }
    }
    sorted
}
