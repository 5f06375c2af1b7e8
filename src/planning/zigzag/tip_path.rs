//! The path of the cutter's tip over the cuts of a run.
//!
//! While the cutter touches one facet, its tip moves along a straight line. Beside a convex edge the lines of two facets end apart, and
//! the cutter turns around the edge. Beside a concave one they cross, and the cutter passes to the next facet at the crossing. The lines
//! are compared seen from the side, so that the highest one counts. Everywhere else, and over gaps, the tip is raised to the height at
//! which the cutter rests on the whole surface.

use super::cuts::Cut;
use super::spaced::Spaced;
use crate::milling::Cutter;
use crate::numerics::vector::{difference, dot, length};
use crate::planning::reach::tip_of;
use crate::surface::FinishFacet;

/// A place of the path.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) facet: u32,
    /// Where the cutter touches the facet, or would if the tip were not raised.
    pub(super) contact: [f64; 3],
    pub(super) tip: [f64; 3],
    /// Whether the cutter touches the facet there.
    pub(super) is_contact: bool,
}

/// The path over the runs of a plan.
pub(super) struct TipPath<'a> {
    pub(super) facets: &'a [FinishFacet],
    pub(super) spaced: &'a Spaced<'a>,
    pub(super) cutter: Cutter,
    /// The lowest height, at least the tip's own, at which the cutter at a tip does not cut into the surface.
    pub(super) raised: &'a (dyn Fn([f64; 3]) -> f64 + Sync),
    /// The largest length seen from above over which the tip is not compared with the surface.
    pub(super) step: f64,
    /// The distance up to which the path may differ from the lines between the middles of facets, and a tip may be too low.
    pub(super) tolerance: f64,
}

/// Cuts that are apart by no more than this share of the cutter's radius have a common edge.
const TOUCHING: f64 = 1e-6;

/// The largest number of places between the ends of the turn around an edge.
const MOST_OF_A_TURN: f64 = 15.0;

/// The line of the tip over the cut of a facet.
#[derive(Debug, Clone, Copy)]
struct Line {
    cut: Cut,
    /// The coordinate of the tip along the pass less that of the contact, and the same of the heights.
    offset: [f64; 2],
    /// The visible part: the coordinates of the tip along the pass.
    ends: [f64; 2],
}

impl Line {
    /// The point of contact of the tip at a coordinate: along the pass, and in height.
    fn contact(&self, tip: f64) -> [f64; 2] {
        let [from, to] = self.cut.ends;
        let share = ((tip - self.offset[0] - from[0]) / (to[0] - from[0])).clamp(0.0, 1.0);
        [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
    }

    /// The height of the tip at a coordinate.
    fn height(&self, tip: f64) -> f64 {
        self.contact(tip)[1] + self.offset[1]
    }

    fn middle(&self) -> f64 {
        f64::midpoint(self.ends[0], self.ends[1])
    }

    /// Whether the whole cut is visible up to its end (1) or from its start (0).
    #[expect(clippy::float_cmp, reason = "the end is the cut's own unless it was changed")]
    fn is_whole(&self, end: usize) -> bool {
        self.ends[end] == self.cut.ends[end][0] + self.offset[0]
    }
}

/// The number of places that are raised and thinned at once, so that they take little memory.
const AT_ONCE: usize = 8192;

/// The memory in bytes of the places of one thread before they are thinned, twice as many as [`AT_ONCE`] because of raised ones.
pub(super) const BYTES_AT_ONCE: usize = 4 * AT_ONCE * size_of::<Place>();

/// The memory in bytes of a cut's line.
pub(super) const BYTES_OF_A_LINE: usize = size_of::<Line>();

impl TipPath<'_> {
    /// The places of a run in the plane with the coordinate `at`, in the direction of the passes, thinned with the chord
    /// tolerance `chord`. Once `stop` returns true, places may be missing.
    pub(super) fn over(&self, at: f64, cuts: &[Cut], chord: f64, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Place> {
        let lines = self.highest(cuts);
        let (mut open, mut kept) = (Vec::new(), Vec::new());
        for (index, line) in lines.iter().enumerate() {
            let middle = self.place(at, line, line.middle());
            match index.checked_sub(1) {
                None => open.push(self.place(at, line, line.ends[0])),
                Some(before) => self.pass_over(at, &lines[before], line, &middle, &mut open),
            }
            open.push(middle);
            if open.len() >= AT_ONCE {
                if stop() {
                    return kept;
                }
                self.keep(&mut open, chord, stop, &mut kept);
            }
        }
        if let Some(line) = lines.last() {
            open.push(self.place(at, line, line.ends[1]));
        }
        self.keep(&mut open, chord, stop, &mut kept);
        kept
    }

    /// Raises and thins the open places, all but the last of which are then closed.
    fn keep(&self, open: &mut Vec<Place>, chord: f64, stop: &(dyn Fn() -> bool + Sync), kept: &mut Vec<Place>) {
        let places = self.thinned(&self.raise(open), chord, stop);
        // The first place is the last one of those before.
        kept.extend(places.into_iter().skip(usize::from(!kept.is_empty())));
        open.drain(..open.len().saturating_sub(1));
    }

    /// The places to keep, so that each omitted one is near the lines between its kept neighbours: its contact, and its tip along the
    /// surface's normal, within `chord`. The algorithm of Douglas and Peucker: it keeps the two ends, then repeatedly the
    /// farthest place. Once `stop` returns true, it ends early.
    ///
    /// Neighbouring facets of a fine mesh differ in their slope across the pass, which moves the tip along the surface from one
    /// to the next. If it is off by t there, the corner's round is lower by t^2 / 2r.
    pub(super) fn thinned(&self, places: &[Place], chord: f64, stop: &(dyn Fn() -> bool + Sync)) -> Vec<Place> {
        let mut keep = vec![false; places.len()];
        let Some(last) = places.len().checked_sub(1) else { return Vec::new() };
        (keep[0], keep[last]) = (true, true);
        let per_slip = (chord / (0.25 * chord * self.cutter.corner_radius().mm()).sqrt()).min(1.0);
        let mut open = vec![(0, last)];
        while let Some((from, to)) = open.pop().filter(|_| !stop()) {
            let far = |index: usize| {
                let (place, [from, to]) = (&places[index], [from, to].map(|index| &places[index]));
                let tip = offset(place.tip, from.tip, to.tip);
                let tip = if place.is_contact {
                    (per_slip * length(tip)).max(dot(tip, self.facets[place.facet as usize].normal).abs())
                } else {
                    length(tip)
                };
                tip.max(distance(place.contact, from.contact, to.contact))
            };
            let farthest = (from + 1..to).map(|index| (index, far(index))).max_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((index, _)) = farthest.filter(|&(_, far)| far > chord) {
                keep[index] = true;
                open.push((from, index));
                open.push((index, to));
            }
        }
        places.iter().zip(keep).filter(|(_, keep)| *keep).map(|(place, _)| *place).collect()
    }

    /// The length of the path of a run seen from above, without turns around edges.
    pub(super) fn length(&self, at: f64, cuts: &[Cut]) -> f64 {
        let ends = self.highest(cuts).into_iter().flat_map(|line| line.ends.map(|end| self.place(at, &line, end).tip));
        let (mut length, mut last) = (0.0, None::<[f64; 3]>);
        for [x, y, z] in ends {
            length += last.map_or(0.0, |last| (x - last[0]).hypot(y - last[1]));
            last = Some([x, y, z]);
        }
        length
    }

    /// The lines over the cuts, each reduced to the part in which it is the highest one, in their order.
    fn highest(&self, cuts: &[Cut]) -> Vec<Line> {
        let mut lines: Vec<Line> = Vec::with_capacity(cuts.len());
        for cut in cuts {
            self.add(self.line(cut), &mut lines);
        }
        lines
    }

    fn line(&self, cut: &Cut) -> Line {
        let [x, y, z] = tip_of(self.cutter, [0.0; 3], self.facets[cut.facet as usize].normal);
        let offset = [self.spaced.sweep.heading.along(x, y), z];
        Line { cut: *cut, offset, ends: cut.ends.map(|[along, _]| along + offset[0]) }
    }

    /// Adds a line whose cut begins behind those of all others.
    #[expect(clippy::unused_self, reason = "a step of the path")]
    fn add(&self, mut line: Line, lines: &mut Vec<Line>) {
        while let Some(last) = lines.last_mut() {
            let (from, to) = (line.ends[0].max(last.ends[0]), line.ends[1].min(last.ends[1]));
            if line.ends[0] >= last.ends[1] {
                break;
            }
            if to < from {
                // The tips of this facet are behind those of an earlier one: the cutter does not reach it.
                return;
            }
            let over = |tip: f64| line.height(tip) - last.height(tip);
            let (at_start, at_end) = (over(from), over(to));
            if at_end <= 0.0 {
                // It is hidden as far as the last one reaches.
                if line.ends[1] <= last.ends[1] {
                    return;
                }
                line.ends[0] = last.ends[1];
                break;
            }
            if at_start < 0.0 {
                let crossing = from + (to - from) * at_start / (at_start - at_end);
                (last.ends[1], line.ends[0]) = (crossing, crossing);
                break;
            }
            if last.ends[0] < line.ends[0] {
                last.ends[1] = line.ends[0];
                break;
            }
            lines.pop();
        }
        lines.push(line);
    }

    fn place(&self, at: f64, line: &Line, tip: f64) -> Place {
        let contact = self.in_space(at, line.contact(tip));
        Place { facet: line.cut.facet, contact, tip: tip_of(self.cutter, contact, self.normal(line)), is_contact: true }
    }

    fn normal(&self, line: &Line) -> [f64; 3] {
        self.facets[line.cut.facet as usize].normal
    }

    fn in_space(&self, at: f64, [along, height]: [f64; 2]) -> [f64; 3] {
        let (e, origin) = (self.spaced.sweep.heading.e, self.spaced.workpiece.origin);
        [origin[0] + e[0] * along - e[1] * at, origin[1] + e[1] * along + e[0] * at, origin[2] + height]
    }

    /// Adds the places between two lines, whose last place and first one are their middles. On a finely meshed smooth surface the
    /// middles are enough, and nearer to the surface than the edges of facets.
    fn pass_over(&self, at: f64, before: &Line, after: &Line, middle: &Place, places: &mut Vec<Place>) {
        let [end, start] = [self.place(at, before, before.ends[1]), self.place(at, after, after.ends[0])];
        let Some(last) = places.last() else { return };
        let touching = TOUCHING * self.cutter.outer_radius().mm();
        let is_edge =
            before.is_whole(1) && after.is_whole(0) && (0..3).all(|axis| (end.contact[axis] - start.contact[axis]).abs() <= touching);
        let normals = [before, after].map(|line| self.normal(line));
        let is_far = |place: &Place| distance(place.tip, last.tip, middle.tip) > self.tolerance;
        if is_far(&end) || is_far(&start) || is_edge && is_far(&self.turned(&end, normals, 0.5)) {
            places.push(end);
            if is_edge {
                self.turn(&end, normals, places);
            }
            places.push(start);
        }
    }

    /// Adds the places between the ends of the turn around an edge.
    fn turn(&self, end: &Place, normals: [[f64; 3]; 2], places: &mut Vec<Place>) {
        let cos = normals[0].iter().zip(normals[1]).map(|(a, b)| a * b).sum::<f64>().clamp(-1.0, 1.0);
        // A chord of a circle of the cutter's radius is at most the tolerance below it.
        let widest = 2.0 * (1.0 - self.tolerance / self.cutter.outer_radius().mm()).max(0.0).acos();
        let parts = (cos.acos() / widest).ceil().min(MOST_OF_A_TURN + 1.0);
        let mut part = 1.0;
        while part < parts {
            places.push(self.turned(end, normals, part / parts));
            part += 1.0;
        }
    }

    /// The place where the cutter touches the edge at `end` with a normal between those of both facets.
    fn turned(&self, end: &Place, [from, to]: [[f64; 3]; 2], share: f64) -> Place {
        let normal = [0, 1, 2].map(|axis| from[axis] + share * (to[axis] - from[axis]));
        let length = normal.iter().map(|component| component * component).sum::<f64>().sqrt();
        Place { tip: tip_of(self.cutter, end.contact, normal.map(|component| component / length)), ..*end }
    }

    /// Raises the tips at places, and between them, where the cutter would cut into the surface.
    pub(super) fn raise(&self, places: &[Place]) -> Vec<Place> {
        let mut path = Climbing { step: self.step, places: Vec::with_capacity(places.len()), was_raised: false, skipped: None };
        for (index, place) in places.iter().enumerate() {
            if let Some(last) = index.checked_sub(1).map(|before| &places[before]) {
                let length = (place.tip[0] - last.tip[0]).hypot(place.tip[1] - last.tip[1]);
                let parts = (length / self.step).ceil();
                let mut part = 1.0;
                while part < parts {
                    let share = part / parts;
                    let between = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis] + share * (b[axis] - a[axis]));
                    let (contact, tip) = (between(last.contact, place.contact), between(last.tip, place.tip));
                    let is_contact = last.is_contact && place.is_contact && last.facet == place.facet;
                    path.add(self.raised_place(Place { contact, tip, is_contact, ..*last }), false);
                    part += 1.0;
                }
            }
            path.add(self.raised_place(*place), true);
        }
        path.places
    }

    /// The place, and whether its tip was raised.
    fn raised_place(&self, place: Place) -> (Place, bool) {
        let resting = (self.raised)(place.tip);
        if resting - place.tip[2] <= 2.0 * self.tolerance {
            return (place, false);
        }
        (Place { tip: [place.tip[0], place.tip[1], resting], is_contact: false, ..place }, true)
    }
}

/// A path whose places are added one after the other.
struct Climbing {
    step: f64,
    places: Vec<Place>,
    /// Whether the last place was raised.
    was_raised: bool,
    /// The last place, if it is on the line between its neighbours unless a raised one follows.
    skipped: Option<Place>,
}

impl Climbing {
    /// Adds a place of which it is known whether its tip was raised, and whether it is needed if it was not.
    fn add(&mut self, (place, is_raised): (Place, bool), is_needed: bool) {
        if !(is_needed || is_raised || self.was_raised) {
            self.skipped = Some(place);
            return;
        }
        if let Some(skipped) = self.skipped.take().filter(|_| is_raised) {
            self.places.push(skipped);
        }
        if let Some(last) = self.places.last().copied()
            && (is_raised || self.was_raised)
            && (place.tip[2] - last.tip[2]).abs() > self.step
        {
            // On a wall the tip moves upwards before the wall, and downwards behind it.
            let [x, y, z] = if place.tip[2] > last.tip[2] {
                [last.tip[0], last.tip[1], place.tip[2]]
            } else {
                [place.tip[0], place.tip[1], last.tip[2]]
            };
            self.places.push(Place { tip: [x, y, z], is_contact: false, ..last });
        }
        self.places.push(place);
        self.was_raised = is_raised;
    }
}

/// The distance of a point from the segment between two others.
fn distance(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    length(offset(point, from, to))
}

/// The vector from the nearest point of a segment to a point.
fn offset(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    let (line, out) = (difference(to, from), difference(point, from));
    let (squared, along) = (dot(line, line), dot(line, out));
    let share = if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 };
    [0, 1, 2].map(|axis| out[axis] - share * line[axis])
}
