//! The path of a plan: its runs in order, with every link and lift between them as moves.

use super::order::{Leg, in_order};
use super::prepared::Prepared;
use super::runs::{Run, RunTip, STEP_IN_RADII, highest_step};
use super::settings::{Pattern, PlanSettings};
use super::travel::{self, APPROACH_HEIGHT};
use super::workpiece::Workpiece;
use crate::motion::{Machine, TimedMove};
use crate::path::{Move, MoveKind, Sampling, tips_between};
use crate::quantity::Speed;

/// Links longer than this in radii of the cutter go over the clearance height.
const NEAR_IN_RADII: f64 = 6.0;

/// How the tool gets to a point of the path, and what it does there.
#[derive(Debug, Clone, Copy)]
pub(super) struct TourPoint {
    pub(super) tip: [f64; 3],
    pub(super) kind: MoveKind,
    /// The run's tip at this point; `None` on links.
    pub(super) of_run: Option<RunTip>,
    /// The feed rate of the move to this point in mm/s.
    pub(super) rate: f64,
}

/// Times, lengths and counts of a path.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TourFigures {
    /// The time of all runs and links, in s.
    pub seconds: f64,
    /// The number of runs.
    pub runs: usize,
    /// The length of all runs, in mm.
    pub run_length: f64,
    /// The number of links.
    pub links: usize,
    /// The length of all links, the approach to the first run and the retreat from the last, in mm.
    pub link_length: f64,
    /// The number of links over the clearance height.
    pub lifts: usize,
    /// The time that runs and links would take without acceleration, in s.
    pub moving_seconds: f64,
    /// The time that the runs would take without stops, in s.
    pub cutting_seconds: f64,
}

/// A path and its figures.
#[derive(Debug, Clone, Default)]
pub(super) struct Tour {
    pub(super) points: Vec<TourPoint>,
    /// The points at which runs begin.
    pub(super) run_starts: Vec<usize>,
    pub(super) figures: TourFigures,
}

impl Tour {
    /// The path of runs, from the clearance height and back to it. Short links without steps stay on the surface where that is
    /// sooner than over the clearance height.
    pub(super) fn of(workpiece: &Workpiece, prepared: &Prepared, settings: &PlanSettings, runs: &[Run], chord_tolerance: f64) -> Self {
        let near = NEAR_IN_RADII * prepared.profile.outer_radius();
        let mut tour = Self::default();
        for leg in in_order(runs, settings.pattern, near) {
            tour.add_link(workpiece, prepared, settings, runs, leg, chord_tolerance);
            tour.add_run(workpiece, prepared, settings, &leg.tips(runs));
        }
        tour.retract(workpiece, settings);
        if settings.machine.path_tolerance.is_some() {
            tour.figures.seconds = settings.machine.time_of(tour.timed_moves()).seconds();
        }
        tour
    }

    /// The moves with their feed rates, for a control that looks ahead.
    fn timed_moves(&self) -> impl Iterator<Item = TimedMove> {
        self.points.windows(2).map(|pair| TimedMove {
            from: pair[0].tip,
            to: pair[1].tip,
            feed_rate: (pair[1].kind != MoveKind::Rapid).then(|| Speed::computed(pair[1].rate)),
        })
    }

    /// The approach to the first tip, straight down from the clearance height.
    fn approach(&mut self, workpiece: &Workpiece, prepared: &Prepared, settings: &PlanSettings, to: [f64; 3]) {
        let (machine, top) = (&settings.machine, clearance(workpiece, settings));
        let rapid = machine.rapid_rate.mm_s();
        let near = (to[2] + APPROACH_HEIGHT).min(top);
        self.points.extend([top, near].map(|height| link_point([to[0], to[1], height], MoveKind::Rapid, rapid)));
        self.points.push(link_point(to, MoveKind::Link, prepared.link_rate));
        self.figures.link_length += top - to[2];
        self.figures.seconds += travel::straight(top - near, rapid, machine) + travel::straight(near - to[2], prepared.link_rate, machine);
        self.figures.moving_seconds += (top - near) / rapid + (near - to[2]) / prepared.link_rate;
    }

    /// From the last tip to the clearance height.
    fn retract(&mut self, workpiece: &Workpiece, settings: &PlanSettings) {
        let Some([x, y, z]) = self.points.last().map(|point| point.tip) else { return };
        let (machine, top) = (&settings.machine, clearance(workpiece, settings));
        let rapid = machine.rapid_rate.mm_s();
        self.points.push(link_point([x, y, top], MoveKind::Rapid, rapid));
        self.figures.link_length += top - z;
        self.figures.seconds += travel::straight(top - z, rapid, machine);
        self.figures.moving_seconds += (top - z) / rapid;
    }

    /// The moves of the path.
    pub(super) fn moves(&self) -> Vec<Move> {
        self.points.windows(2).map(|pair| Move { from: pair[0].tip, to: pair[1].tip, kind: pair[1].kind }).collect()
    }

    fn add_run(&mut self, workpiece: &Workpiece, prepared: &Prepared, settings: &PlanSettings, tips: &[&RunTip]) {
        self.run_starts.push(self.points.len());
        let (mut length, mut seconds) = (0.0, 0.0);
        let mut last: Option<&RunTip> = None;
        for &tip in tips {
            let (step, rate) = match last {
                None => (0.0, prepared.link_rate),
                Some(last) => (travel::distance(last.tip, tip.tip), rate_of_move(workpiece, prepared, last, tip)),
            };
            length += step;
            seconds += step / rate;
            match self.points.last_mut() {
                Some(point) if last.is_none() && travel::distance(point.tip, tip.tip) < 1e-12 => point.of_run = Some(*tip),
                _ => self.points.push(TourPoint { tip: tip.tip, kind: MoveKind::Cut, of_run: Some(*tip), rate }),
            }
            last = Some(tip);
        }
        if let Some(start) = self.run_starts.last_mut() {
            *start = (*start).min(self.points.len().saturating_sub(tips.len()));
        }
        self.figures.runs += 1;
        self.figures.run_length += length;
        self.figures.cutting_seconds += seconds;
        self.figures.moving_seconds += seconds;
        self.figures.seconds += travel::run(length, seconds, &settings.machine);
    }

    fn add_link(
        &mut self,
        workpiece: &Workpiece,
        prepared: &Prepared,
        settings: &PlanSettings,
        runs: &[Run],
        leg: Leg,
        chord_tolerance: f64,
    ) {
        let to = leg.begin(runs);
        let Some(from) = self.points.last().map(|point| point.tip) else {
            return self.approach(workpiece, prepared, settings, to);
        };
        let clearance = clearance(workpiece, settings);
        let machine = &settings.machine;
        let over = travel::lift(from, to, clearance, prepared.link_rate, machine);
        let is_near = (to[0] - from[0]).hypot(to[1] - from[1]) <= NEAR_IN_RADII * prepared.profile.outer_radius();
        let on_surface = |corners: &[[f64; 3]]| SurfaceLink::of(workpiece, prepared, machine, corners, chord_tolerance);
        let surface = if is_near && settings.pattern == Pattern::Zigzag {
            on_surface(&[from, to]).or_else(|| {
                // Around the corner of a wall: along the run before until the next one is abeam, or the other way round.
                let before = self.points.iter().rev().map(|point| point.tip).find(|tip| travel::distance(*tip, from) > 0.0);
                let next = leg.tips(runs).get(1).map(|tip| tip.tip);
                let corners = [before.and_then(|before| abeam(from, before, to)), next.and_then(|next| abeam(to, next, from))];
                let links = corners.into_iter().flatten().filter_map(|[x, y]| {
                    let touch = workpiece.drop.drop(&prepared.profile, x, y, None)?;
                    on_surface(&[from, [x, y, touch.height], to])
                });
                links.min_by(|a, b| a.seconds.total_cmp(&b.seconds))
            })
        } else {
            None
        };
        self.figures.links += 1;
        if let Some(SurfaceLink { points, length, seconds }) = surface.filter(|link| link.seconds <= over) {
            self.figures.link_length += length;
            self.figures.seconds += seconds;
            self.figures.moving_seconds += length / prepared.link_rate;
            self.points.extend(points.into_iter().skip(1).map(|tip| link_point(tip, MoveKind::Link, prepared.link_rate)));
            return;
        }
        let rapid = machine.rapid_rate.mm_s();
        let lifted = [[from[0], from[1], clearance], [to[0], to[1], clearance], [to[0], to[1], (to[2] + APPROACH_HEIGHT).min(clearance)]];
        let length = travel::length_of([from].iter().chain(&lifted).chain([to].iter()));
        self.figures.lifts += 1;
        self.figures.link_length += length;
        self.figures.seconds += over;
        self.figures.moving_seconds += (length - APPROACH_HEIGHT) / rapid + APPROACH_HEIGHT / prepared.link_rate;
        self.points.extend(lifted.map(|tip| link_point(tip, MoveKind::Rapid, rapid)));
        self.points.push(link_point(to, MoveKind::Link, prepared.link_rate));
    }
}

/// The height in mm at which rapid moves cross the part.
fn clearance(workpiece: &Workpiece, settings: &PlanSettings) -> f64 {
    workpiece.top + settings.machine.clearance_height.mm()
}

fn link_point(tip: [f64; 3], kind: MoveKind, rate: f64) -> TourPoint {
    TourPoint { tip, kind, of_run: None, rate }
}

/// The point on the line from the end of a run through another point of it that is abeam of a third one, seen from above; `None`
/// beyond the end.
fn abeam(end: [f64; 3], through: [f64; 3], of: [f64; 3]) -> Option<[f64; 2]> {
    let along = [through[0] - end[0], through[1] - end[1]];
    let share = (along[0] * (of[0] - end[0]) + along[1] * (of[1] - end[1])) / (along[0] * along[0] + along[1] * along[1]);
    (share > 0.0 && share.is_finite()).then(|| [0, 1].map(|axis| end[axis] + share * along[axis]))
}

/// A link on the surface, straight from corner to corner seen from above.
struct SurfaceLink {
    /// Its points, with both ends.
    points: Vec<[f64; 3]>,
    length: f64,
    /// The time of its straight parts in s, each from rest to rest.
    seconds: f64,
}

impl SurfaceLink {
    /// `None` over a step that is too high for the feed rate.
    fn of(workpiece: &Workpiece, prepared: &Prepared, machine: &Machine, corners: &[[f64; 3]], chord_tolerance: f64) -> Option<Self> {
        let mut link = Self { points: vec![corners[0]], length: 0.0, seconds: 0.0 };
        for ends in corners.windows(2) {
            let points = link_on_surface(workpiece, prepared, ends[0], ends[1], chord_tolerance);
            let length = travel::length_of(points.iter());
            link.length += length;
            link.seconds += travel::straight(length, prepared.link_rate, machine);
            link.points.extend(points.into_iter().skip(1));
        }
        (highest_step(&link.points) <= STEP_IN_RADII * prepared.profile.outer_radius()).then_some(link)
    }
}

/// A straight link seen from above that is nowhere under the tips' surface: straight in space where it can be.
fn link_on_surface(workpiece: &Workpiece, prepared: &Prepared, from: [f64; 3], to: [f64; 3], chord_tolerance: f64) -> Vec<[f64; 3]> {
    let floor = from[2].min(to[2]);
    let sampling = Sampling::fine(&prepared.profile, chord_tolerance);
    let tips = tips_between(&workpiece.drop, &prepared.profile, [from[0], from[1]], [to[0], to[1]], &sampling, Some(floor));
    let across = (to[0] - from[0]).hypot(to[1] - from[1]).max(1e-12);
    let straight = |x: f64, y: f64| from[2] + (to[2] - from[2]) * (x - from[0]).hypot(y - from[1]) / across;
    let mut points = vec![from];
    for tip in tips {
        let [x, y, z] = tip.position;
        let height = straight(x, y);
        if z > height + chord_tolerance {
            points.push([x, y, z]);
        } else if points.len() > 1 {
            points.push([x, y, height.max(z)]);
        }
    }
    points.push(to);
    points
}

/// The feed rate in mm/s of the move between two tips of a run: the lower of both ends'.
fn rate_of_move(workpiece: &Workpiece, prepared: &Prepared, from: &RunTip, to: &RunTip) -> f64 {
    let along = [to.tip[0] - from.tip[0], to.tip[1] - from.tip[1]];
    let length = along[0].hypot(along[1]);
    let rate = |tip: &RunTip| {
        tip.target.filter(|_| length > 0.0).map(|target| {
            let tangent = &workpiece.tangents[target];
            let (cos_alpha, _) = tangent.alpha(along.map(|part| part / length));
            prepared.feeds.rate(tangent, cos_alpha, 1.0)
        })
    };
    match (rate(from), rate(to)) {
        (Some(a), Some(b)) => a.min(b),
        (Some(a), None) | (None, Some(a)) => a,
        (None, None) => prepared.link_rate,
    }
}
