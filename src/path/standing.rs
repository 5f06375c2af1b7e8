//! Where the tip of a cutter stands when it finishes a place of a part, and whether it can stand there.

use super::body::{Body, Swept};
use super::drop_cutter::DropCutter;
use super::places::{Place, Places, twice_area};
use crate::milling::Profile;
use crate::numerics::vector::{difference, dot, length};
use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU8, Ordering};

/// The most steps away from what blocks a flat cutter beside a place, and how many of them may look for what blocks it: the others
/// move away from what is known.
const MOST_STEPS: usize = 64;
const MOST_DROPS: usize = 16;

/// Where that does not clear the cutter, it starts from axes around the place: at these shares of the flat's radius, so many each.
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
        let lift_at = |axis: [f64; 2], tip: f64| drop.drop(profile, axis[0], axis[1], Some(facet)).map(|touch| (touch.height - tip, touch));
        // On a slope the flat leaves its radius times the slope.
        if flat * horizontal > 0.1 * tolerance || flat == 0.0 {
            let down_hill = if horizontal > 0.0 { [normal_x / horizontal, normal_y / horizontal] } else { [1.0, 0.0] };
            let axis = [x + offset * down_hill[0], y + offset * down_hill[1]];
            let lift = lift_at(axis, z - height).map_or(0.0, |(lift, _)| lift.max(0.0));
            return Self { axis, tip: z - height, lift };
        }
        let mut best = Self { axis: [x, y], tip: z, lift: f64::INFINITY };
        let mut walked: Vec<[f64; 2]> = Vec::new();
        let mut obstacles: Vec<Obstacle> = Vec::new();
        let starts =
            STARTS.iter().flat_map(|(share, count)| (0..*count).map(move |part| (*share, TAU * f64::from(part) / f64::from(*count))));
        let around = starts.map(|(share, angle)| [x + share * flat * angle.cos(), y + share * flat * angle.sin()]);
        for mut axis in std::iter::once([x, y]).chain(around) {
            let mut before = axis;
            let of_earlier = walked.len();
            let mut drops = 0;
            for _ in 0..MOST_STEPS {
                let known = obstacles.iter().filter(|known| known.distance(axis) < known.holds_up_within);
                let nearest = known.max_by(|a, b| (a.clear_at - a.distance(axis)).total_cmp(&(b.clear_at - b.distance(axis))));
                let (obstacle, on_plane) = if let Some(known) = nearest {
                    (*known, 0.0)
                } else {
                    let is_joined = |earlier: &[f64; 2]| (axis[0] - earlier[0]).hypot(axis[1] - earlier[1]) <= JOINED * flat;
                    if drops == MOST_DROPS || walked[..of_earlier].iter().any(is_joined) {
                        break;
                    }
                    drops += 1;
                    walked.push(axis);
                    let Some((lift, touch)) = lift_at(axis, z) else { break };
                    // Of two that are as high, the later one is farther from what it touched: in a slot as wide as the cutter, where it fits.
                    if lift <= best.lift {
                        best = Self { axis, lift: lift.max(0.0), ..best };
                    }
                    if lift <= tolerance {
                        return best;
                    }
                    let clear_of = |height: f64| clear_distance(profile, touch.contact.z - z - height);
                    let clear_at = clear_of(0.0) * (1.0 + 1e-9) + 1e-6;
                    let obstacle = Obstacle { at: [touch.contact.x, touch.contact.y], clear_at, holds_up_within: clear_of(tolerance) };
                    obstacles.push(obstacle);
                    let gradient = touch.normal.x.hypot(touch.normal.y) / touch.normal.z;
                    (obstacle, if gradient >= STEEP { lift / gradient } else { 0.0 })
                };
                // The axis moves away from what it touches until the profile clears it, or as far as the steep plane that touches the
                // cutter there holds it up if that is farther, but not farther than the flat reaches.
                let distance = obstacle.distance(axis);
                let farther = (obstacle.clear_at - distance).max(on_plane);
                if distance <= 0.0 || farther <= 0.0 {
                    break;
                }
                let last = std::mem::replace(&mut before, axis);
                axis = [0, 1].map(|part| axis[part] + farther / distance * (axis[part] - obstacle.at[part]));
                let from_place = [axis[0] - x, axis[1] - y];
                let moved = from_place[0].hypot(from_place[1]);
                if moved > flat {
                    axis = [x + from_place[0] * flat / moved, y + from_place[1] * flat / moved];
                }
                // Between two obstacles it would go to and fro.
                if (axis[0] - last[0]).hypot(axis[1] - last[1]) < SAME {
                    break;
                }
            }
        }
        best
    }
}

/// A point of the part that held a cutter up over a place, seen from above.
#[derive(Debug, Clone, Copy)]
struct Obstacle {
    at: [f64; 2],
    /// The distance in mm of an axis from which on the cutter clears it.
    clear_at: f64,
    /// Within this distance in mm it holds the cutter up by more than the tolerance.
    holds_up_within: f64,
}

impl Obstacle {
    fn distance(&self, axis: [f64; 2]) -> f64 {
        (axis[0] - self.at[0]).hypot(axis[1] - self.at[1])
    }
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
