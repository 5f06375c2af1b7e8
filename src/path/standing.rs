//! Where the tip of a cutter stands when it finishes a place of a part, and whether it can stand there.

use super::body::{Body, Swept};
use super::drop_cutter::DropCutter;
use super::places::{Place, Places, twice_area};
use crate::milling::Profile;
use crate::numerics::vector::{difference, dot, length};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU8, Ordering};

/// The most steps of a walk away from what blocks a flat cutter beside a place, and the most of them at which the cutter is dropped to
/// find what blocks it: the others move away from what was found before.
const MOST_STEPS: usize = 64;
const MOST_DROPS: usize = 16;

/// Where the walk from the place does not clear the cutter, others start around it: at these shares of the flat's radius, so many at each.
const STARTS: [(f64, u8); 2] = [(0.7, 8), (1.0, 12)];

/// Axes closer than this many mm are the same.
const SAME: f64 = 1e-9;

/// A walk ends within this share of the flat's radius of an axis of an earlier one: from there on it would be the same walk.
const JOINED: f64 = 0.03;

/// Off a plane of at least this gradient a flat cutter moves by its lift over the gradient. On gentler ones that step is too long.
const STEEP: f64 = 1.0;

/// A facet whose normal has a vertical part under this is a wall.
const WALL: f64 = 1e-4;

/// The tip that finishes a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    /// Where the axis stands, seen from above, in mm.
    pub axis: [f64; 2],
    /// The height in mm of the tip that touches the place.
    pub tip: f64,
    /// The height in mm by which other facets hold the cutter above its contact with the place; 0 where it can touch the place and
    /// cuts none deeper than the tolerance.
    pub lift: f64,
}

impl Standing {
    /// The tip that finishes a place; `tolerance` is the depth in mm to which it may cut other facets. A cutter that would cut a steep
    /// facet a little is lifted by many times that depth.
    #[must_use]
    pub fn at(drop: &DropCutter, profile: &Profile, place: &Place, tolerance: f64) -> Self {
        let held_up = Self::held_up(drop, profile, place, tolerance);
        let Self { axis: [x, y], tip, lift } = held_up;
        if lift <= tolerance {
            return held_up;
        }
        let body = Body::new(profile);
        let mut is_blocked = false;
        drop.each_over(profile, [x, y, tip + tolerance], |corners| {
            is_blocked = is_cut(&body, [x, y, tip], corners, tolerance);
            !is_blocked
        });
        if is_blocked { held_up } else { Self { lift: 0.0, ..held_up } }
    }

    /// The tip that finishes a place, with the height by which others hold it up. Under the flat of a cutter a level place is
    /// finished from every axis within the flat's radius: one with a lift up to `tolerance` is looked for.
    fn held_up(drop: &DropCutter, profile: &Profile, place: &Place, tolerance: f64) -> Self {
        let Place { point: [x, y, z], normal: [normal_x, normal_y, normal_z], facet } = *place;
        let horizontal = normal_x.hypot(normal_y);
        let slope = horizontal.atan2(normal_z);
        let (offset, height) = profile.arc_at(slope).point(slope);
        let flat = profile.arcs()[0].point(0.0).0;
        // On a slope the flat leaves its radius times the slope.
        if flat * horizontal > 0.1 * tolerance || flat == 0.0 {
            let down_hill = if horizontal > 0.0 { [normal_x / horizontal, normal_y / horizontal] } else { [1.0, 0.0] };
            let axis = [x + offset * down_hill[0], y + offset * down_hill[1]];
            let tip = z - height;
            let lift = drop.drop(profile, axis[0], axis[1], Some(facet)).map_or(0.0, |touch| (touch.height - tip).max(0.0));
            return Self { axis, tip, lift };
        }
        UnderFlat {
            drop,
            profile,
            place,
            flat,
            tolerance,
            best: Self { axis: [x, y], tip: z, lift: f64::INFINITY },
            walked: Vec::new(),
            obstacles: Vec::new(),
        }
        .standing()
    }
}

/// The search for an axis from which the flat of a cutter finishes a level place: walks away from what holds the cutter up.
struct UnderFlat<'a> {
    drop: &'a DropCutter,
    profile: &'a Profile,
    place: &'a Place,
    /// The radius of the flat in mm.
    flat: f64,
    tolerance: f64,
    /// The axis with the least lift so far.
    best: Standing,
    /// The axes at which the cutter was dropped, and what held it up.
    walked: Vec<[f64; 2]>,
    obstacles: Vec<Obstacle>,
}

/// A point of the part that held the cutter up, seen from above.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    at: [f64; 2],
    /// The distance in mm of an axis from which on the cutter clears it.
    clear_at: f64,
    /// Within this distance in mm it holds the cutter up by more than the tolerance.
    holds_up_within: f64,
}

impl UnderFlat<'_> {
    fn standing(mut self) -> Standing {
        let [x, y, _] = self.place.point;
        let at = |share: f64, angle: f64| [x + share * self.flat * angle.cos(), y + share * self.flat * angle.sin()];
        let around = STARTS.iter().flat_map(|(share, count)| (0..*count).map(|part| (*share, TAU * f64::from(part) / f64::from(*count))));
        let starts: Vec<[f64; 2]> = std::iter::once([x, y]).chain(around.map(|(share, angle)| at(share, angle))).collect();
        for start in starts {
            self.walk(start);
            if self.best.lift <= self.tolerance {
                break;
            }
        }
        self.best
    }

    /// Walks from an axis until nothing holds the cutter up by more than the tolerance, or the walk leads nowhere.
    fn walk(&mut self, mut axis: [f64; 2]) {
        let of_earlier = self.walked.len();
        let mut before = axis;
        for _ in 0..MOST_STEPS {
            let (obstacle, on_plane) = if let Some(known) = self.known_at(axis) {
                (known, 0.0)
            } else {
                let is_joined = self.walked[..of_earlier].iter().any(|earlier| apart(*earlier, axis) <= JOINED * self.flat);
                if is_joined || self.walked.len() - of_earlier == MOST_DROPS {
                    return;
                }
                let Some(found) = self.dropped_at(axis) else { return };
                found
            };
            // The axis moves away from what it touches until the profile clears it, or as far as the steep plane that touches the
            // cutter there holds it up if that is farther.
            let distance = apart(obstacle.at, axis);
            let farther = (obstacle.clear_at - distance).max(on_plane);
            if distance <= 0.0 || farther <= 0.0 {
                return;
            }
            let moved = [0, 1].map(|part| axis[part] + farther / distance * (axis[part] - obstacle.at[part]));
            let last = std::mem::replace(&mut before, axis);
            axis = self.over_the_place(moved);
            // Between two obstacles it would go to and fro.
            if apart(axis, last) < SAME {
                return;
            }
        }
    }

    /// Of the obstacles found before that hold the cutter up at an axis, the one that is farthest to go.
    fn known_at(&self, axis: [f64; 2]) -> Option<Obstacle> {
        let farther = |obstacle: &Obstacle| obstacle.clear_at - apart(obstacle.at, axis);
        let holds_up = |obstacle: &&Obstacle| apart(obstacle.at, axis) < obstacle.holds_up_within;
        self.obstacles.iter().filter(holds_up).max_by(|a, b| farther(a).total_cmp(&farther(b))).copied()
    }

    /// What holds the cutter up where it is dropped at an axis, and the distance in mm to where the steep plane that it touches no longer
    /// does, 0 without one; `None` if nothing holds it up by more than the tolerance.
    fn dropped_at(&mut self, axis: [f64; 2]) -> Option<(Obstacle, f64)> {
        let z = self.place.point[2];
        self.walked.push(axis);
        let touch = self.drop.drop(self.profile, axis[0], axis[1], Some(self.place.facet))?;
        let lift = touch.height - z;
        // Of two that are as high, the later one is farther from what it touched: in a slot as wide as the cutter, where it fits.
        if lift <= self.best.lift {
            self.best = Standing { axis, lift: lift.max(0.0), ..self.best };
        }
        if lift <= self.tolerance {
            return None;
        }
        let clear_of = |height: f64| clear_distance(self.profile, touch.contact.z - z - height);
        let obstacle = Obstacle {
            at: [touch.contact.x, touch.contact.y],
            clear_at: clear_of(0.0) * (1.0 + 1e-9) + 1e-6,
            holds_up_within: clear_of(self.tolerance),
        };
        self.obstacles.push(obstacle);
        let gradient = touch.normal.x.hypot(touch.normal.y) / touch.normal.z;
        Some((obstacle, if gradient >= STEEP { lift / gradient } else { 0.0 }))
    }

    /// The axis, or the nearest one to it from which the flat reaches the place.
    fn over_the_place(&self, axis: [f64; 2]) -> [f64; 2] {
        let [x, y, _] = self.place.point;
        let distance = apart(axis, [x, y]);
        if distance <= self.flat {
            return axis;
        }
        let share = self.flat / distance;
        [x + share * (axis[0] - x), y + share * (axis[1] - y)]
    }
}

fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Whether a cutter with its tip there cuts into a facet deeper than `depth`: to where the ray from a place along the normal enters
/// the cutter. The depth is concave over the facet: it is largest where the cutter's tangent plane has the facet's normal, if that
/// is inside the facet, else on its border.
fn is_cut(body: &Body, tip: [f64; 3], corners: &[[f64; 3]; 3], depth: f64) -> bool {
    let twice = twice_area(*corners);
    let size = length(twice);
    if size <= 0.0 {
        return false;
    }
    // Facets limit a cutter from above, whichever way they are turned. Walls have the outer side that they state.
    let sign = if twice[2] < -WALL * size { -1.0 } else { 1.0 };
    let normal = twice.map(|part| sign * part / size);
    let ray = body.ray(corners[0], normal);
    if Swept::new(tip, tip).tangent_plane(&ray) >= -depth {
        return false;
    }
    let contact = difference(tip, ray.tip);
    let is_inside = (0..3).all(|corner| {
        let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
        sign * dot(twice_area([from, to, contact]), normal) >= 0.0
    });
    is_inside
        || (0..3).any(|corner| {
            let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
            // The cutter at the tip against the edge is the cutter moved back along the edge against its first corner.
            let back = std::array::from_fn(|axis| tip[axis] - (to[axis] - from[axis]));
            body.entry(&Swept::new(tip, back), &body.ray(from, normal), -depth).is_some()
        })
}

/// The distance from the axis at which the profile has risen to `height`: R where that is above its corner.
fn clear_distance(profile: &Profile, height: f64) -> f64 {
    let (mut near, mut far) = (0.0, profile.outer_radius());
    if profile.low(far) <= height {
        return far;
    }
    for _ in 0..40 {
        let middle = f64::midpoint(near, far);
        if profile.low(middle) <= height { near = middle } else { far = middle }
    }
    far
}

/// Which places a cutter could reach, if a path led it there: it can stand where it finishes the place, within a tolerance. It
/// depends on no path, is found where it is asked for, and kept.
#[derive(Debug)]
pub struct Reach<'a> {
    drop: &'a DropCutter,
    places: &'a Places,
    profiles: &'a [Profile],
    tolerance: f64,
    known: Vec<AtomicU8>,
}

const UNKNOWN: u8 = 0;
const CAN: u8 = 1;
const CANNOT: u8 = 2;

impl<'a> Reach<'a> {
    /// What any of the cutters of these profiles can reach among the places of the part; the tolerance in mm, > 0.
    #[must_use]
    pub fn new(profiles: &'a [Profile], drop: &'a DropCutter, places: &'a Places, tolerance: f64) -> Self {
        let known = places.inside.iter().map(|_| AtomicU8::new(UNKNOWN)).collect();
        Self { drop, places, profiles, tolerance, known }
    }

    /// Whether a cutter could reach the place with this index.
    #[must_use]
    pub fn includes(&self, index: usize) -> bool {
        match self.known[index].load(Ordering::Relaxed) {
            UNKNOWN => {
                let can = self.can_touch(&self.places.inside[index]);
                self.known[index].store(if can { CAN } else { CANNOT }, Ordering::Relaxed);
                can
            }
            known => known == CAN,
        }
    }

    /// Whether a cutter can stand where it finishes the place.
    #[must_use]
    pub fn can_touch(&self, place: &Place) -> bool {
        self.profiles.iter().any(|profile| Standing::at(self.drop, profile, place, self.tolerance).lift <= self.tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Under a flat of 2 mm, with a corner of 1 mm.
    const BULL_NOSE: [f64; 2] = [3.0, 1.0];

    /// A level ledge 1.5 mm wide, whose normal is up, and behind it a convex slope that steepens to 80 deg at its foot; both 40 mm long.
    fn ledge_below_a_hull() -> DropCutter {
        let height = |y: f64| if y <= 1.5 { 0.0 } else { 8.0 * (1.0 - ((12.5 - y) / 11.0).powi(2)).max(0.0).sqrt() };
        let lines: Vec<f64> = (0..=25).map(|line| 0.5 * f64::from(line)).collect();
        let corner = |x: f64, y: f64| [x, y, height(y)];
        let facets: Vec<_> = lines
            .windows(2)
            .flat_map(|y| {
                let [a, b, c, d] = [corner(0.0, y[0]), corner(40.0, y[0]), corner(40.0, y[1]), corner(0.0, y[1])];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        DropCutter::new(&facets, &|| false)
    }

    fn on_the_ledge(y: f64) -> Place {
        Place { point: [20.0, y, 0.0], normal: [0.0, 0.0, 1.0], facet: 0 }
    }

    #[test]
    fn a_ledge_at_the_foot_of_a_steep_hull_is_finished_from_beside_the_part() {
        let drop = ledge_below_a_hull();
        let profile = Profile::torus(BULL_NOSE[0], BULL_NOSE[1]);
        for y in [0.05, 0.2, 0.4] {
            let standing = Standing::at(&drop, &profile, &on_the_ledge(y), 0.01);
            assert!(standing.lift <= 0.01, "{y}: {standing:?}");
            assert!(standing.axis[1] < 0.0 && standing.axis[1] >= y - 2.0, "{y}: {standing:?}");
        }
        // The corner of the cutter, 1 mm wide, stands between the flat and the hull.
        let standing = Standing::at(&drop, &profile, &on_the_ledge(1.2), 0.01);
        assert!(standing.lift > 0.01, "{standing:?}");
    }

    #[test]
    fn a_flat_end_stands_beside_a_wall_as_far_as_it_is_wide() {
        let wall = |x: f64, z: f64| [[x, 0.0, z], [x, 40.0, z]];
        let [[a, b], [c, d], [e, f], [g, h]] = [wall(0.0, 0.0), wall(20.0, 0.0), wall(20.0, 5.0), wall(40.0, 5.0)];
        let drop = DropCutter::new(&[[a, c, b], [b, c, d], [c, e, d], [d, e, f], [e, g, f], [f, g, h]], &|| false);
        let profile = Profile::torus(3.0, 0.0);
        for x in [14.0, 17.5, 19.0, 19.99] {
            let place = Place { point: [x, 20.0, 0.0], normal: [0.0, 0.0, 1.0], facet: 0 };
            let standing = Standing::at(&drop, &profile, &place, 0.01);
            assert!(standing.lift <= 0.01 && standing.axis[0] <= 17.0 && standing.axis[0] >= x - 3.0, "{x}: {standing:?}");
        }
    }
}
