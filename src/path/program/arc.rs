//! Arcs of G2 and G3 as chords.

#![allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "bounded before the conversion")]

use std::f64::consts::{PI, TAU};

/// The most chords of an arc: 0.0036 deg each on a circle.
const MOST_CHORDS: f64 = 1e5;

/// An arc in a plane of two axes with a move along the third.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arc {
    /// The plane's first and second axis, and the third one: counter-clockwise turns the first to the second.
    pub(super) axes: [usize; 3],
    pub(super) start: [f64; 3],
    pub(super) end: [f64; 3],
    pub(super) clockwise: bool,
}

/// Where an arc's centre is.
#[derive(Debug, Clone, Copy)]
pub(super) enum Centre {
    /// Along the plane's first and second axis.
    At([f64; 2]),
    /// At this distance, on the side that makes the arc at most a half circle; negative for the other side.
    Radius(f64),
}

impl Arc {
    /// The chords' ends, the last being the arc's end. `None` if the centre does not fit the ends.
    pub(super) fn chords(&self, centre: Centre, sagitta: f64) -> Option<Vec<[f64; 3]>> {
        let [first, second, third] = self.axes;
        let (start, end) = ([self.start[first], self.start[second]], [self.end[first], self.end[second]]);
        let centre = match centre {
            Centre::At(centre) => centre,
            Centre::Radius(radius) => self.centre_by_radius(start, end, radius)?,
        };
        let from = [start[0] - centre[0], start[1] - centre[1]];
        let to = [end[0] - centre[0], end[1] - centre[1]];
        let (radius, end_radius) = (from[0].hypot(from[1]), to[0].hypot(to[1]));
        let difference = (radius - end_radius).abs();
        // LinuxCNC's bounds: 0.5 mm, and 0.1 % where it is over 0.005 mm.
        if radius <= 0.0 || difference > 0.5 || difference > 0.005 && difference > 1e-3 * radius {
            return None;
        }
        let angle = to[1].atan2(to[0]) - from[1].atan2(from[0]);
        let is_full = (start[0] - end[0]).hypot(start[1] - end[1]) < 1e-9;
        let turned = if is_full { 0.0 } else { angle.rem_euclid(TAU) };
        let sweep = match (self.clockwise, turned > 0.0) {
            (false, true) => turned,
            (true, true) => turned - TAU,
            (false, false) => TAU,
            (true, false) => -TAU,
        };
        let step = 2.0 * (1.0 - sagitta / radius).clamp(-1.0, 1.0).acos();
        // At least eight chords a turn: a coarse tolerance leaves a circle round.
        let count = (sweep.abs() / step.min(PI / 4.0)).ceil().clamp(1.0, MOST_CHORDS);
        let start_angle = from[1].atan2(from[0]);
        let point = |number: f64| {
            let share = number / count;
            let (sin, cos) = (start_angle + share * sweep).sin_cos();
            let radius = radius + share * (end_radius - radius);
            let mut point = [0.0; 3];
            point[first] = centre[0] + radius * cos;
            point[second] = centre[1] + radius * sin;
            point[third] = self.start[third] + share * (self.end[third] - self.start[third]);
            point
        };
        let mut points: Vec<[f64; 3]> = (1..count as u32).map(|number| point(f64::from(number))).collect();
        points.push(self.end);
        Some(points)
    }

    fn centre_by_radius(&self, start: [f64; 2], end: [f64; 2], radius: f64) -> Option<[f64; 2]> {
        let chord = [end[0] - start[0], end[1] - start[1]];
        let length = chord[0].hypot(chord[1]);
        let half = 0.5 * length;
        // Rounded radii of half circles may be too small by some units of the last place.
        if length < 1e-9 || half > radius.abs() + 0.005 {
            return None;
        }
        let height = ((radius.abs() - half) * (radius.abs() + half)).max(0.0).sqrt();
        let side = if self.clockwise == (radius < 0.0) { 1.0 } else { -1.0 };
        let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
        Some([middle[0] - side * height * chord[1] / length, middle[1] + side * height * chord[0] / length])
    }
}
