//! Plans judged by an independent simulator of the swept solid: what their paths leave on parts with floors, walls, fillets,
//! edges and holes, for flat-end, toroidal and ball-end cutters.

use super::parts::{
    blade, cavity, cone_on_floor, dome_on_flange, field, fillet_wall, holes, plate, profile, relief, ring_groove, round_pocket,
    sharp_points_on_a_roof, steps,
};
use super::surfaces::{Facet, cross, dot, minus, placed, unit};
use super::{in_direction, mm, ranked_on, settings, workpiece};
use crate::simulation::random::Random;
use crate::simulation::swept::{Solid, Swept};
use scallopd::milling::{Cutter, Model};
use scallopd::path::MoveKind;
use scallopd::planning::plan::{CandidateCutter, FinishFigures, PassPoint, PlanSettings, passes};
use scallopd::quantity::Angle;
use std::fmt;

/// The scallop height of all plans, in mm.
const TOLERANCE: f64 = 0.01;

/// What the tip may stand into another place of the part when it touches a place that counts as reachable, in mm.
const STANDS_INTO: f64 = 0.005;

/// The most places drawn on a part.
const PLACES: usize = 6_000;

/// The spacing of the points that stand for the whole part, in mm. A ball of 3 mm between two of them is 1 um deeper.
const SPACING: f64 = 0.15;

/// The points of a part, in square cells seen from above.
struct Points {
    low: [f64; 2],
    columns: usize,
    starts: Vec<usize>,
    places: Vec<[f64; 3]>,
}

const CELL: f64 = 1.0;

impl Points {
    /// Points on all facets, their edges included, at most `SPACING` apart: corners, and the middles of the longest edges of all
    /// parts until these are that short.
    fn of(facets: &[Facet]) -> Self {
        let mut points: Vec<[f64; 3]> = facets.iter().flatten().copied().collect();
        let mut parts = facets.to_vec();
        while let Some(part) = parts.pop() {
            let squares = [0, 1, 2].map(|corner| {
                let edge = minus(part[(corner + 1) % 3], part[corner]);
                dot(edge, edge)
            });
            let longest = (0..3).max_by(|a, b| squares[*a].total_cmp(&squares[*b])).unwrap_or(0);
            if squares[longest] > SPACING * SPACING {
                let [a, b, c] = [0, 1, 2].map(|corner| part[(longest + corner) % 3]);
                let middle = [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis]));
                points.push(middle);
                parts.extend([[a, middle, c], [middle, b, c]]);
            }
        }
        let least = |axis: usize| points.iter().map(|point: &[f64; 3]| point[axis]).fold(f64::INFINITY, f64::min);
        let low = [least(0), least(1)];
        let most = points.iter().map(|point| point[0]).fold(f64::NEG_INFINITY, f64::max);
        let columns = cell(most - low[0]) + 1;
        let of = |point: &[f64; 3]| cell(point[1] - low[1]) * columns + cell(point[0] - low[0]);
        points.sort_by_key(of);
        let last = points.last().map_or(0, of);
        let starts = (0..=last + 1).map(|cell| points.partition_point(|point| of(point) < cell)).collect();
        Self { low, columns, starts, places: points }
    }

    /// Whether the cutter with this tip stands into none of the points by more than `STANDS_INTO`.
    fn are_clear_of(&self, cutter: &Solid, tip: [f64; 3]) -> bool {
        let range = |centre: f64, low: f64| cell((centre - cutter.outer - low).max(0.0))..cell((centre + cutter.outer - low).max(0.0)) + 1;
        let columns = range(tip[0], self.low[0]);
        let columns = columns.start.min(self.columns)..columns.end.min(self.columns);
        let of_row = |row: usize| columns.clone().map(move |column| row * self.columns + column);
        let mut cells = range(tip[1], self.low[1]).flat_map(of_row).filter(|at| at + 1 < self.starts.len());
        let is_clear = |point: &[f64; 3]| cutter.distance(minus(*point, tip)) >= -STANDS_INTO;
        cells.all(|at| self.places[self.starts[at]..self.starts[at + 1]].iter().all(is_clear))
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "hundreds")]
fn cell(from_low: f64) -> usize {
    (from_low / CELL) as usize
}

/// Whether the cutter can stand so that it touches a place and nothing else.
fn can_reach(points: &Points, cutter: &Solid, place: [f64; 3], normal: [f64; 3]) -> bool {
    let horizontal = normal[0].hypot(normal[1]);
    let [offset, height] = cutter.point(horizontal.atan2(normal[2]));
    if horizontal > 1e-9 {
        let aside = [0, 1].map(|axis| place[axis] + offset * normal[axis] / horizontal);
        if points.are_clear_of(cutter, [aside[0], aside[1], place[2] - height]) {
            return true;
        }
    }
    // Under the flat of a cutter a level place is touched from every axis within it.
    let flat = cutter.point(0.0)[0];
    let tip = |aside: [f64; 2]| [place[0] + aside[0], place[1] + aside[1], place[2] - height];
    let around = (0..4).flat_map(|ring| (0..16).map(move |step| (f64::from(ring) / 3.0, std::f64::consts::TAU * f64::from(step) / 16.0)));
    horizontal * flat < 0.02
        && around
            .map(|(share, turn)| tip([share * flat * turn.cos(), share * flat * turn.sin()]))
            .any(|tip| points.are_clear_of(cutter, tip))
}

/// What a path leaves, and what its plan states.
#[derive(Debug, Clone, Copy)]
pub(super) struct Verdict {
    /// The shares of the area left over 1.02 of the tolerance, of what the cutter can reach and of the rest.
    over: f64,
    uncut: f64,
    /// The deepest cut into the part in um: of cuts and of links and lifts.
    gouge: [f64; 2],
    /// The median left in um.
    median: f64,
    stated: [f64; 3],
    seconds: f64,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { over, uncut, gouge, median, stated, seconds } = self;
        write!(
            f,
            "over {:.2} % (stated {:.2}), uncut {:.2} % (stated {:.2}), gouges {:.1} um, links {:.1} um (stated {:.1}), median {median:.1} um, {seconds:.1} s",
            100.0 * over,
            100.0 * stated[0],
            100.0 * uncut,
            100.0 * stated[1],
            gouge[0],
            gouge[1],
            stated[2],
        )
    }
}

impl Verdict {
    /// The promises: half a per cent of what the cutter reaches over 1.02 of the tolerance at most, no cut into the part
    /// deeper than 2 um, or than stated by 0.2 um, and stated shares within a percentage point.
    pub(super) fn is_kept(&self) -> bool {
        self.over <= 0.005
            && self.gouge.iter().all(|depth| *depth <= 2.0 && *depth <= self.stated[2] + 0.2)
            && (self.over - self.stated[0]).abs() <= 0.01
            && (self.uncut - self.stated[1]).abs() <= 0.01
    }
}

/// Whether a facet lies more than 1 um over a place.
fn is_hidden(facets: &[Facet], [x, y, z]: [f64; 3]) -> bool {
    facets.iter().any(|[a, b, c]| {
        let side = |p: &[f64; 3], q: &[f64; 3]| (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
        let [u, v, w] = [side(b, c), side(c, a), side(a, b)];
        let whole = u + v + w;
        let is_inside = whole.abs() > 1e-12 && [u, v, w].iter().all(|part| part / whole >= 0.0);
        is_inside && (u * a[2] + v * b[2] + w * c[2]) / whole > z + 1e-3
    })
}

/// Places of the facets up to 85 deg that are seen from above, drawn evenly over their area, with their normals.
fn drawn(facets: &[Facet]) -> Vec<([f64; 3], [f64; 3])> {
    let with_area = |facet: &Facet| {
        let normal = cross(minus(facet[1], facet[0]), minus(facet[2], facet[0]));
        let area = dot(normal, normal).sqrt() / 2.0;
        (area > 1e-12).then(|| (*facet, unit(normal), area)).filter(|(_, normal, _)| normal[2] >= 85_f64.to_radians().cos())
    };
    let machined: Vec<(Facet, [f64; 3], f64)> = facets.iter().filter_map(with_area).collect();
    let whole: f64 = machined.iter().map(|(.., area)| area).sum();
    let mut random = Random(3);
    let mut places = Vec::new();
    let (mut passed, mut due) = (0.0, 0.0);
    #[expect(clippy::cast_precision_loss, reason = "thousands")]
    let share = whole / PLACES as f64;
    for ([a, b, c], normal, area) in machined {
        passed += area;
        while due < passed {
            due += share;
            let (mut u, mut v) = (random.unit(), random.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            places.push(([0, 1, 2].map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis])), normal));
        }
    }
    places.retain(|(place, _)| !is_hidden(facets, *place));
    places
}

/// The path of a cutter.
pub(super) struct Path<'a> {
    pub(super) cutter: Cutter,
    pub(super) points: &'a [PassPoint],
}

/// Plans a cutter on a part and mills it.
fn verdict(facets: &[Facet], cutter: Cutter, settings: &PlanSettings) -> Option<Verdict> {
    let part = workpiece(facets);
    let settings = PlanSettings { max_uncut_share: 1.0, ..settings.clone() };
    let ranking = ranked_on(&part, &[CandidateCutter::new(cutter)], &settings);
    let plan = ranking.plans.first()?;
    let path = passes(&part, plan, &settings, &|| false)?;
    let verdict = milled(facets, &[Path { cutter, points: &path.points }], &plan.milled?.finish);
    Some(Verdict { seconds: plan.time.seconds(), ..verdict })
}

/// What paths, one after the other, leave on a part, beside the figures that are stated.
pub(super) fn milled(facets: &[Facet], paths: &[Path], stated: &FinishFigures) -> Verdict {
    let swept = |is_wanted: fn(MoveKind) -> bool| -> Vec<Swept> {
        let of = |path: &Path| {
            let pairs = path.points.windows(2).filter(|pair| is_wanted(pair[1].kind));
            Swept::new(Solid::of(path.cutter), pairs.map(|pair| [pair[0].tip, pair[1].tip]))
        };
        paths.iter().map(of).collect()
    };
    let [cuts, others, links] =
        [swept(|kind| kind == MoveKind::Cut), swept(|kind| kind != MoveKind::Cut), swept(|kind| kind == MoveKind::Link)];
    let points = Points::of(facets);
    let places = drawn(facets);
    let cap = 5.0 * TOLERANCE;
    let nearest = |place: [f64; 3]| cuts.iter().chain(&links).map(|swept| swept.distance(place, cap)).fold(cap, f64::min);
    let mut left: Vec<f64> = places.iter().map(|(place, _)| nearest(*place)).collect();
    let over: Vec<_> = places.iter().zip(&left).filter(|(_, left)| **left > 1.02 * TOLERANCE).map(|(place, _)| place).collect();
    // Of many places, some stand for all.
    let every = over.len().div_ceil(400).max(1);
    let looked_at: Vec<_> = over.iter().step_by(every).collect();
    let reaches = |path: &Path, (place, normal): &([f64; 3], [f64; 3])| can_reach(&points, &Solid::of(path.cutter), *place, *normal);
    let reached = looked_at.iter().filter(|place| paths.iter().any(|path| reaches(path, place))).count();
    #[expect(clippy::cast_precision_loss, reason = "thousands")]
    let share = |count: usize, of: usize| count as f64 / of.max(1) as f64;
    let (over, reachable) = (share(over.len(), places.len()), share(reached, looked_at.len()));
    // A point counts where it is cut deeper than those before it.
    let deepest = |swept: &[Swept]| {
        let deeper = |least: f64, point: &[f64; 3]| swept.iter().fold(least, |least, swept| swept.distance(*point, least));
        1e3 * points.places.iter().fold(0.0, deeper).abs()
    };
    let gouge = [deepest(&cuts), deepest(&others)];
    left.sort_by(f64::total_cmp);
    Verdict {
        over: over * reachable,
        uncut: over * (1.0 - reachable),
        gouge,
        median: 1e3 * left[left.len() / 2],
        stated: [stated.far_over_share, stated.uncut_share, 1e3 * stated.gouge.mm()],
        seconds: 0.0,
    }
}

fn degrees(value: f64) -> Angle {
    Angle::from_degrees(value).unwrap()
}

fn ball(diameter: f64) -> Cutter {
    Cutter::ball_end(mm(diameter))
}

fn bull_nose(diameter: f64, corner: f64) -> Cutter {
    Cutter::toroidal(mm(diameter), mm(corner)).unwrap()
}

fn flat(diameter: f64) -> Cutter {
    Cutter::flat_end(mm(diameter))
}

/// Plans each cutter on a part, every second one on the part turned by an odd angle, and prints what it leaves.
///
/// # Panics
///
/// Where a promise is not kept.
fn keeps_the_tolerance(name: &str, facets: &[Facet], cutters: &[Cutter]) {
    let mut broken = Vec::new();
    for (cutter, (turn, direction)) in cutters.iter().zip([(0.0, 0.0), (17.3, 90.0)].into_iter().cycle()) {
        let verdict = verdict(&placed(facets, turn, [0.0; 3]), *cutter, &in_direction(Model::Envelope, direction));
        let said = verdict.map_or_else(|| "no plan".to_owned(), |verdict| verdict.to_string());
        let line = format!(
            "{name}, turned {turn} deg, direction {direction} deg, {:?} of {} mm: {said}",
            cutter.kind(),
            2.0 * cutter.outer_radius().mm()
        );
        println!("{line}");
        if !verdict.is_some_and(|verdict| verdict.is_kept()) {
            broken.push(line);
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Sharp points are cut deepest, where lines pass between two places at which they are computed.
#[test]
fn a_steep_roof_with_sharp_points() {
    keeps_the_tolerance("roof", &sharp_points_on_a_roof(1.2, 60), &[bull_nose(6.0, 0.1), ball(6.0), bull_nose(6.0, 1.0)]);
}

#[test]
fn plates() {
    keeps_the_tolerance("level plate", &plate([30.0, 20.0], 0.0), &[ball(6.0), bull_nose(10.0, 2.0), flat(6.0)]);
    keeps_the_tolerance("tilted plate", &plate([30.0, 20.0], 25.0), &[ball(6.0), bull_nose(10.0, 2.0), flat(6.0)]);
}

/// Most of the two facets of a floor is under a roof.
#[test]
fn a_floor_under_a_roof() {
    let roof = plate([17.5, 20.0], 0.0).into_iter().map(|facet| facet.map(|[x, y, z]| [x + 5.0, y, z + 8.0]));
    let part: Vec<Facet> = plate([30.0, 20.0], 0.0).into_iter().chain(roof).collect();
    keeps_the_tolerance("floor under a roof", &part, &[ball(4.0), bull_nose(4.0, 1.0), flat(4.0)]);
}

#[test]
fn pocket() {
    let part = steps(&[0.0, 6.0, 26.0, 32.0], &[0.0, 6.0, 20.0, 26.0], &[&[5.0; 3], &[5.0, 0.0, 5.0], &[5.0; 3]]);
    keeps_the_tolerance("pocket", &part, &[bull_nose(6.0, 1.0), flat(6.0), ball(4.0)]);
}

/// The axis cannot stand over the ledge around the boss: the edge of the flat finishes it from beside the part.
#[test]
fn a_ledge_narrower_than_the_cutter() {
    let part = steps(&[0.0, 2.0, 28.0, 30.0], &[0.0, 2.0, 18.0, 20.0], &[&[0.0; 3], &[0.0, 8.0, 0.0], &[0.0; 3]]);
    keeps_the_tolerance("narrow ledge", &part, &[flat(6.0), bull_nose(6.0, 1.0), bull_nose(6.0, 0.5), flat(8.0)]);
}

#[test]
fn stairs_narrower_than_the_cutter() {
    let part = steps(&[0.0, 2.0, 4.0, 6.0, 8.0, 10.0], &[0.0, 15.0], &[&[0.0], &[3.0], &[6.0], &[9.0], &[12.0]]);
    keeps_the_tolerance("narrow stairs", &part, &[flat(6.0), bull_nose(6.0, 0.5)]);
}

/// A ledge under a fifth of the cutter's radius, and a post whose top lines miss.
#[test]
fn a_sliver_and_a_post() {
    let sliver = steps(&[0.0, 0.8, 28.0, 28.8], &[0.0, 15.0], &[&[0.0], &[8.0], &[0.0]]);
    keeps_the_tolerance("sliver", &sliver, &[flat(10.0), bull_nose(10.0, 0.5)]);
    let post = steps(&[0.0, 12.0, 12.8, 24.0], &[0.0, 10.0, 14.0, 24.0], &[&[0.0; 3], &[0.0, 6.0, 0.0], &[0.0; 3]]);
    keeps_the_tolerance("post", &post, &[flat(10.0), bull_nose(8.0, 0.5)]);
}

/// The axis can stand only on the middle line of the slot, or in a strip of a few hundredths.
#[test]
fn slots_as_wide_as_the_cutter() {
    for width in [8.0, 8.002, 8.02, 8.1] {
        let part = steps(&[0.0, 20.0, 20.0 + width, 40.0], &[0.0, 30.0], &[&[5.0], &[0.0], &[5.0]]);
        keeps_the_tolerance("slot", &part, &[flat(8.0), bull_nose(8.0, 0.5)]);
    }
}

/// A closed groove, in which no line is straight.
#[test]
fn a_ring_groove_as_wide_as_the_cutter() {
    keeps_the_tolerance("ring groove", &ring_groove(12.0, 6.02), &[flat(6.0), bull_nose(6.0, 1.0)]);
}

/// Over a ledge as wide as the cutter's radius the axis can stand nowhere but on its edge.
#[test]
fn a_ledge_as_wide_as_the_radius() {
    let part = steps(&[0.0, 5.0, 8.0, 12.0], &[0.0, 15.0], &[&[0.0], &[0.5], &[4.0]]);
    keeps_the_tolerance("ledge", &part, &[flat(6.0), flat(6.0), bull_nose(6.0, 1.0), bull_nose(6.0, 0.5)]);
}

/// Beside the edges between its wall's facets a cutter cuts the next facet by a few micrometres, which hold it up by many times as much.
#[test]
fn a_round_pocket_of_few_facets() {
    keeps_the_tolerance("round pocket", &round_pocket(), &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn boss() {
    let part = steps(&[0.0, 14.0, 24.0, 36.0], &[0.0, 12.0, 22.0, 34.0], &[&[0.0; 3], &[0.0, 5.0, 0.0], &[0.0; 3]]);
    keeps_the_tolerance("boss", &part, &[bull_nose(6.0, 1.0), flat(6.0), ball(4.0)]);
}

#[test]
fn two_levels() {
    let part = steps(&[0.0, 15.0, 34.0], &[0.0, 24.0], &[&[4.0], &[0.0]]);
    keeps_the_tolerance("two levels", &part, &[bull_nose(6.0, 1.0), flat(6.0), ball(6.0)]);
}

#[test]
fn ribs() {
    let part = steps(&[0.0, 10.0, 12.0, 22.0, 24.0, 34.0], &[0.0, 20.0], &[&[0.0], &[3.0], &[0.0], &[3.0], &[0.0]]);
    keeps_the_tolerance("ribs", &part, &[bull_nose(6.0, 1.0), flat(6.0), ball(4.0)]);
}

#[test]
fn narrow_slot() {
    let part = steps(&[0.0, 12.0, 15.0, 28.0], &[0.0, 22.0], &[&[0.0], &[-3.0], &[0.0]]);
    keeps_the_tolerance("narrow slot", &part, &[bull_nose(6.0, 1.0), flat(6.0), ball(2.0)]);
}

#[test]
fn relief_of_strokes() {
    keeps_the_tolerance("relief", &relief(), &[bull_nose(2.0, 0.5), flat(2.0), ball(2.0)]);
}

#[test]
fn holes_in_a_plate() {
    keeps_the_tolerance("holes", &holes(), &[bull_nose(10.0, 2.0), flat(6.0), ball(6.0)]);
}

#[test]
fn slanted_walls() {
    let part = profile(&[[0.0, 0.0], [10.0, 0.0], [14.0, 8.0], [24.0, 8.0], [30.0, 0.0], [40.0, 0.0]], 20.0);
    keeps_the_tolerance("slanted walls", &part, &[bull_nose(6.0, 1.0), ball(6.0), flat(6.0)]);
}

#[test]
fn slopes_behind_narrow_ledges() {
    let half = [[0.0, 0.0], [0.01, 0.0], [0.01, 0.08], [2.0, 2.07], [20.0, 2.5]];
    let other = half.iter().rev().skip(1).map(|[x, z]| [40.0 - x, *z]);
    let part = profile(&half.iter().copied().chain(other).collect::<Vec<_>>(), 20.0);
    keeps_the_tolerance("narrow ledges", &part, &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn a_cone_on_a_floor() {
    keeps_the_tolerance("cone on floor", &cone_on_floor(32.0, [12.0, 16.0], [9.0, 6.0, 5.0]), &[ball(6.0), flat(6.0), bull_nose(6.0, 1.0)]);
}

#[test]
fn a_wall_with_fillets() {
    keeps_the_tolerance("fillet wall", &field([34.0, 20.0], 0.25, fillet_wall), &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn a_cavity() {
    keeps_the_tolerance("cavity", &field([40.0, 32.0], 0.5, cavity), &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn waves() {
    let surface = |x: f64, y: f64| 1.5 * (x / 5.0).sin() * (y / 7.0).cos() + 0.1 * x;
    keeps_the_tolerance("waves", &field([32.0, 24.0], 0.4, surface), &[ball(6.0), bull_nose(6.0, 1.0), flat(4.0)]);
}

#[test]
fn a_dome_on_a_flange() {
    keeps_the_tolerance("dome on flange", &field([32.0, 32.0], 0.5, dome_on_flange), &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn a_blade() {
    keeps_the_tolerance("blade", &field([30.0, 20.0], 0.5, blade), &[ball(6.0), bull_nose(6.0, 1.0), flat(6.0)]);
}

/// What is carved with tapered balls: shallow strokes with rounded feet.
#[test]
fn a_relief_by_a_tapered_ball() {
    let relief = |x: f64, y: f64| 0.4 * (1.3 * x).sin() * (1.1 * y).cos();
    let tapered = Cutter::tapered_ball(mm(1.0), degrees(5.0), mm(4.0)).unwrap();
    keeps_the_tolerance("relief", &field([8.0, 6.0], 0.1, relief), &[tapered]);
}

/// A conical barrel beside a ball of its diameter on the side of a blade: its arc of 80 mm takes wide steps where the side has its
/// slope.
#[test]
fn the_side_of_a_blade_by_a_conical_barrel() {
    let side = |x: f64, y: f64| 69_f64.to_radians().tan() * x + 0.01 * (y - 10.0).powi(2);
    let facets = field([5.0, 20.0], 0.25, side);
    let barrel = Cutter::conical_barrel(mm(10.0), mm(2.0), mm(80.0), degrees(20.0)).unwrap();
    keeps_the_tolerance("blade's side", &facets, &[barrel]);
    is_faster_than(&facets, barrel, ball(10.0), 0.5);
}

/// Half a degree and ten steeper than its arc, the sharp end of the barrel cuts.
#[test]
fn sides_steeper_than_the_arc_of_a_conical_barrel() {
    for slope in [70.5_f64, 80.0] {
        let side = |x: f64, y: f64| slope.to_radians().tan() * x + 0.01 * (y - 10.0).powi(2);
        let barrel = Cutter::conical_barrel(mm(10.0), mm(2.0), mm(80.0), degrees(20.0)).unwrap();
        keeps_the_tolerance(&format!("side of {slope} deg"), &field([5.0, 20.0], 0.25, side), &[barrel]);
    }
}

/// A lens beside a bull nose of its diameter and corner in a shallow mould.
#[test]
fn a_nearly_level_mould_by_a_lens() {
    let mould = |x: f64, y: f64| ((x - 16.0).powi(2) + (y - 12.0).powi(2)) / 160.0;
    let facets = field([32.0, 24.0], 0.4, mould);
    let lens = Cutter::lens(mm(10.0), mm(30.0), mm(0.5)).unwrap();
    keeps_the_tolerance("mould", &facets, &[lens]);
    is_faster_than(&facets, lens, bull_nose(10.0, 0.5), 0.8);
}

/// A cutter is ranked before another on a part, and takes at most `share` of its time.
fn is_faster_than(facets: &[Facet], cutter: Cutter, other: Cutter, share: f64) {
    let candidates = [other, cutter].map(CandidateCutter::new);
    let ranking = ranked_on(&workpiece(facets), &candidates, &PlanSettings { max_uncut_share: 1.0, ..settings(Model::Envelope) });
    let times = ranking.plans.iter().map(|plan| (plan.candidate, plan.time.seconds())).collect::<Vec<_>>();
    println!("{times:?}");
    assert_eq!(times[0].0, 1);
    assert!(ranking.plans[0].milled.is_some_and(|milled| milled.finish.over_tolerance_share <= 0.005), "{times:?}");
    assert!(times.len() == 1 || times[0].1 < share * times[1].1, "{times:?}");
}

#[test]
fn a_hull() {
    let hull = |x: f64, y: f64| 8.0 * (1.0 - (x / 30.0 - 1.0).powi(2)) * (1.0 - ((y - 12.5).abs() / 11.0).min(1.0).powi(2)).sqrt();
    keeps_the_tolerance("hull", &field([60.0, 25.0], 0.5, hull), &[bull_nose(6.0, 1.0), flat(6.0)]);
}

#[test]
fn in_all_directions() {
    let part = steps(&[0.0, 6.0, 26.0, 32.0], &[0.0, 6.0, 20.0, 26.0], &[&[5.0; 3], &[5.0, 0.0, 5.0], &[5.0; 3]]);
    let verdict = verdict(&placed(&part, 33.0, [0.0; 3]), flat(6.0), &settings(Model::Envelope)).unwrap();
    println!("pocket, turned 33, all directions, D6 r0: {verdict}");
    assert!(verdict.is_kept(), "{verdict}");
    let cone = placed(&cone_on_floor(32.0, [12.0, 16.0], [9.0, 6.0, 5.0]), 21.0, [0.0; 3]);
    let verdict = self::verdict(&cone, bull_nose(6.0, 1.0), &settings(Model::Envelope)).unwrap();
    println!("cone on floor, turned 21, all directions, D6 r1: {verdict}");
    assert!(verdict.is_kept(), "{verdict}");
}
