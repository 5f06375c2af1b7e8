//! The finish that a path leaves: shares of the area, percentiles, and the worst places, found by climbing from the worst of
//! random ones.

#![allow(clippy::cast_precision_loss, clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts are below 2^52")]

use super::milled::{Left, Milled};
use super::places::{Place, Places};
use super::standing::Reach;
use crate::numerics::vector::mixed;
use crate::surface::Mesh;
use rayon::prelude::*;
use std::collections::HashSet;

/// What is left over the tolerance counts from 2 % over it: paths are laid out to keep it exactly, and their chords and
/// roundings leave as much.
pub const OVER: f64 = 1.02;

/// The least depth of a cut into the part that counts as a gouge in shares: 2 um or a fifth of the tolerance.
const GOUGE: (f64, f64) = (0.002, 0.2);

/// The number of neighbouring places whose highest stands for the ridge between them.
pub(super) const NEIGHBOURS: usize = 16;

/// Places computed by one thread between two looks at `stop`.
const AT_ONCE: usize = 256;

/// What a path leaves, measured at places that stand for equal areas.
#[derive(Debug, Clone)]
pub struct Finish {
    /// For each place what the cuts and links leave; `None` where none of them comes over it.
    pub left: Vec<Option<Left>>,
    /// The places that cuts and links cut by more than 2 um and a fifth of the tolerance, places for cuts and the deepest cut included.
    pub gouges: Vec<Spot>,
    /// The same for rapids.
    pub collisions: Vec<Spot>,
    /// For each place whether it is left over the tolerance.
    pub over: Vec<bool>,
    /// For each place left over the tolerance, whether the cutter could have reached it; false elsewhere.
    pub over_reachable: Vec<bool>,
    /// What is left in mm, over the places which the path comes over.
    pub residual: Option<Residual>,
    /// What is left in mm over those of them that the cutter can reach or that are within the tolerance.
    pub reached: Option<Residual>,
    /// The share of the area that is left over the tolerance, uncut area included.
    pub over_share: Share,
    /// The share of the area that is left over the tolerance and that the cutter could have reached.
    pub over_reachable_share: Share,
    /// The share of the area over which no move comes.
    pub uncut_share: Share,
    /// The greatest height in mm left where the cutter cannot reach. 0 where it reaches everything.
    pub unreachable_height: f64,
    /// The share of the area cut by more than 2 um and a fifth of the tolerance, without places for cuts alone.
    pub gouge_share: Share,
    /// The deepest cut into the part by cuts and links.
    pub gouge: Option<Spot>,
    /// The deepest cut into the part by rapids.
    pub collision: Option<Spot>,
    /// The largest excess over the tolerance where the cutter can reach.
    pub worst: Option<Spot>,
    /// The share of the area with ridges of at least half the tolerance about it.
    pub used_share: Share,
}

/// A share of the area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// From 0 to 1.
    pub value: f64,
    /// Its standard error: that of a share of random places, which is a bound, because the places are one in each of equal
    /// parts of the area. One place more on either side than were found keeps it from being 0.
    pub standard_error: f64,
}

/// Percentiles of what is left, in mm, negative where the part is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// The median.
    pub p50: f64,
    /// 90 % of the area have less.
    pub p90: f64,
    /// 99 % of the area have less.
    pub p99: f64,
    /// The most that was found.
    pub max: f64,
}

impl Share {
    fn new(count: usize, of: usize) -> Self {
        let (count, of) = (count as f64, of as f64);
        let towards_half = (count + 1.0) / (of + 2.0);
        Self { value: if of > 0.0 { count / of } else { 0.0 }, standard_error: (towards_half * (1.0 - towards_half) / (of + 2.0)).sqrt() }
    }
}

impl Residual {
    pub(super) fn new(mut levels: Vec<f64>) -> Option<Self> {
        levels.sort_unstable_by(f64::total_cmp);
        let last = levels.len().checked_sub(1)?;
        let at = |share: f64| levels[(share * last as f64).round() as usize];
        Some(Self { p50: at(0.5), p90: at(0.9), p99: at(0.99), max: levels[last] })
    }
}

impl Finish {
    /// What the path leaves at the places of the mesh, with the tolerance in mm, > 0. `None` once `stop` returns true.
    #[must_use]
    pub fn new(
        milled: &Milled,
        mesh: &Mesh,
        places: &Places,
        reach: &Reach<'_>,
        tolerance: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let over_level = OVER * tolerance;
        let left = looked_at(&places.inside, stop, |_, place| milled.left_at(place.point, place.normal))?;
        let over: Vec<bool> = left.iter().map(|left| left.is_none_or(|left| left.height > over_level)).collect();
        let over_reachable = looked_at(&over, stop, |index, over| *over && reach.includes(index))?;
        let for_cuts = looked_at(&places.for_cuts, stop, |_, place| milled.left_at(place.point, place.normal))?;
        let by_rapids = |places: &[Place]| looked_at(places, stop, |_, place| milled.collision_at(place.point, place.normal));
        let hits = [by_rapids(&places.inside)?, by_rapids(&places.for_cuts)?].concat();

        let count = places.inside.len();
        let share = |matching: usize| Share::new(matching, count);
        let levels = |wanted: &dyn Fn(usize) -> bool| {
            left.iter()
                .enumerate()
                .filter(|(index, _)| wanted(*index))
                .filter_map(|(_, left)| left.map(|left| left.height))
                .collect::<Vec<f64>>()
        };
        let is_reached = |index: usize| !over[index] || over_reachable[index];
        let gouge_level = -GOUGE.0.max(GOUGE.1 * tolerance);

        let corners = |facet: u32| mesh.corners(facet as usize);
        let everywhere = || {
            let inside = places.inside.iter().zip(&left).enumerate().map(|(index, (place, left))| (place, left, is_reached(index)));
            let for_cuts = places.for_cuts.iter().zip(&for_cuts).map(|(place, left)| (place, left, false));
            inside.chain(for_cuts).filter_map(|(place, left, reached)| left.map(|left| (*place, left.height, reached)))
        };
        let gouge = deepest_cut(milled, &corners, everywhere().map(|(place, height, _)| (place, height)));
        let may_climb = |place: &Place, left: &Left| left.height <= over_level || reach.can_touch(place);
        let level_in_reach = |place: &Place| milled.left_at(place.point, place.normal).filter(|left| may_climb(place, left));
        let reached = everywhere().filter(|(.., reached)| *reached).map(|(place, height, _)| (place, height));
        let worst = climbed(&corners, reached, Climbed::Highest, &level_in_reach);
        let all = || places.inside.iter().chain(&places.for_cuts);
        let hit = all().zip(&hits).filter_map(|(place, left)| left.map(|left| (*place, left.height)));
        let collision = climbed(&corners, hit, Climbed::Lowest, &|place| milled.collision_at(place.point, place.normal));
        let is_gouge = |spot: &Spot| spot.left.height < gouge_level;
        let deeper = |(place, left): (&Place, &Option<Left>)| left.map(|left| Spot { place: *place, left }).filter(is_gouge);
        if stop() {
            return None;
        }
        let with_max = |residual: Option<Residual>, spot: Option<Spot>| {
            residual.map(|residual| Residual { max: spot.map_or(residual.max, |spot| spot.left.height.max(residual.max)), ..residual })
        };
        Some(Self {
            residual: with_max(Residual::new(levels(&|_| true)), worst),
            reached: with_max(Residual::new(levels(&is_reached)), worst),
            over_share: share(over.iter().filter(|over| **over).count()),
            over_reachable_share: share(over_reachable.iter().filter(|over| **over).count()),
            uncut_share: share(left.iter().filter(|left| left.is_none()).count()),
            unreachable_height: levels(&|index| !is_reached(index)).into_iter().fold(0.0, f64::max),
            gouge_share: share(left.iter().flatten().filter(|left| left.height < gouge_level).count()),
            used_share: share(used(&left, tolerance)),
            gouge,
            collision,
            worst,
            over_reachable,
            gouges: all().zip(left.iter().chain(&for_cuts)).filter_map(deeper).chain(gouge.filter(is_gouge)).collect(),
            collisions: all().zip(&hits).filter_map(deeper).chain(collision.filter(is_gouge)).collect(),
            over,
            left,
        })
    }
}

/// The number of places in groups of neighbours of which the highest is at least half the tolerance. The highest of m
/// places at random across a parabolic ridge of the height h is at (m/(m+1))^2 h.
fn used(left: &[Option<Left>], tolerance: f64) -> usize {
    let in_group = NEIGHBOURS as f64 / (NEIGHBOURS as f64 + 1.0);
    let level = 0.5 * tolerance * in_group * in_group;
    let is_used = |group: &&[Option<Left>]| group.iter().any(|left| left.is_none_or(|left| left.height >= level));
    left.chunks(NEIGHBOURS).filter(is_used).map(<[_]>::len).sum()
}

/// `each` of all items in their order, on all threads; `None` once `stop` returns true.
pub(super) fn looked_at<T: Sync, U: Send>(
    items: &[T],
    stop: &(dyn Fn() -> bool + Sync),
    each: impl Fn(usize, &T) -> U + Sync,
) -> Option<Vec<U>> {
    let chunks = items.par_chunks(AT_ONCE).enumerate().map(|(chunk, items)| {
        let first = chunk * AT_ONCE;
        (!stop()).then(|| items.iter().enumerate().map(|(at, item)| each(first + at, item)).collect::<Vec<U>>())
    });
    let chunks: Option<Vec<Vec<U>>> = chunks.collect();
    chunks.map(|chunks| chunks.into_iter().flatten().collect())
}

/// A place and what is left there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// The place.
    pub place: Place,
    /// The level and the move that decides.
    pub left: Left,
}

/// The corners of a facet.
pub(super) type Corners<'a> = dyn Fn(u32) -> [[f64; 3]; 3] + Sync + 'a;

/// The number of facets on which a climb begins.
const STARTS: usize = 48;

/// Halvings of the step: from a third of the facet to a millionth.
const HALVINGS: u32 = 18;

/// What is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Climbed {
    Highest,
    Lowest,
}

impl Climbed {
    fn is_worse(self, one: f64, other: f64) -> bool {
        match self {
            Self::Highest => one > other,
            Self::Lowest => one < other,
        }
    }
}

/// The deepest cut into the part that is reached from the given places, with the depths found there as negative heights. `corners`
/// are those of a facet.
#[must_use]
pub fn deepest_cut(milled: &Milled, corners: &Corners<'_>, places: impl Iterator<Item = (Place, f64)>) -> Option<Spot> {
    climbed(corners, places.filter(|(_, height)| *height < 0.0), Climbed::Lowest, &|place| milled.left_at(place.point, place.normal))
}

/// The worst place that is reached from the given ones on their facets, corners and edges included.
fn climbed(
    corners: &Corners<'_>,
    places: impl Iterator<Item = (Place, f64)>,
    towards: Climbed,
    level: &(dyn Fn(&Place) -> Option<Left> + Sync),
) -> Option<Spot> {
    let worst_first = |a: &(Place, f64), b: &(Place, f64)| match towards {
        Climbed::Highest => b.1.total_cmp(&a.1),
        Climbed::Lowest => a.1.total_cmp(&b.1),
    };
    let mut places: Vec<(Place, f64)> = places.collect();
    let most = (64 * STARTS).min(places.len());
    if most < places.len() {
        places.select_nth_unstable_by(most, worst_first);
        places.truncate(most);
    }
    places.sort_by(worst_first);
    let mut seen = HashSet::new();
    places.retain(|(place, _)| seen.insert(place.facet));
    places.truncate(STARTS);
    places
        .par_iter()
        .with_max_len(1)
        .filter_map(|(place, _)| Some(on_facet(corners(place.facet), Spot { place: *place, left: level(place)? }, towards, level)))
        .reduce_with(|a, b| if towards.is_worse(b.left.height, a.left.height) { b } else { a })
}

/// A climb by steps towards the three corners and away from them, halved when none leads on. Steps end at the border.
fn on_facet(corners: [[f64; 3]; 3], start: Spot, towards: Climbed, level: &(dyn Fn(&Place) -> Option<Left> + Sync)) -> Spot {
    let mut best = start;
    let mut weights = barycentric(corners, start.place.point);
    let mut step: f64 = 1.0 / 3.0;
    let mut tried = 0;
    for _ in 0..HALVINGS {
        let mut leads_on = true;
        while leads_on && tried < 400 {
            leads_on = false;
            for (from, to) in [(0, 1), (1, 0), (1, 2), (2, 1), (2, 0), (0, 2)] {
                let by = step.min(weights[from]);
                if by <= 0.0 {
                    continue;
                }
                let mut moved = weights;
                moved[from] -= by;
                moved[to] += by;
                let place = Place { point: at(corners, moved), ..best.place };
                tried += 1;
                if let Some(left) = level(&place)
                    && towards.is_worse(left.height, best.left.height)
                {
                    best = Spot { place, left };
                    weights = moved;
                    leads_on = true;
                }
            }
        }
        step *= 0.5;
    }
    best
}

fn at([a, b, c]: [[f64; 3]; 3], weights: [f64; 3]) -> [f64; 3] {
    let to_c = weights[2];
    let to_b = if weights[0] + weights[1] > 0.0 { weights[1] / (weights[0] + weights[1]) } else { 0.0 };
    mixed(mixed(a, b, to_b), c, to_c)
}

/// The weights of the corners at a point of the facet.
fn barycentric(corners: [[f64; 3]; 3], point: [f64; 3]) -> [f64; 3] {
    use super::places::twice_area;
    use crate::numerics::vector::dot;
    let whole = twice_area(corners);
    let part = |from: [f64; 3], to: [f64; 3]| (dot(twice_area([from, to, point]), whole) / dot(whole, whole)).clamp(0.0, 1.0);
    let (a, b) = (part(corners[1], corners[2]), part(corners[2], corners[0]));
    let b = b.min(1.0 - a);
    [a, b, 1.0 - a - b]
}
