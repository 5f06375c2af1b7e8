//! For each place of the surface, the tip at which a cutter finishes it, and whether the cutter can stand there.

use super::drawn_places::DrawnPlace;
use super::workpiece::Workpiece;
use crate::milling::Profile;
use rayon::prelude::*;

/// A place with the tip that finishes it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Station {
    pub(super) place: DrawnPlace,
    /// Where the axis stands, seen from above.
    pub(super) axis: [f64; 2],
    /// The height of the tip that touches the place, in mm.
    pub(super) tip: f64,
    /// The height in mm by which other facets hold the cutter above its contact with the place; 0 where it can touch it.
    pub(super) lift: f64,
}

/// The most steps away from what blocks a flat cutter beside a place.
const MOST_STEPS: usize = 16;

/// The stations of places for a cutter; `tolerance` is the lift in mm that does not count. Once `stop` returns true, the
/// result must be discarded.
pub(super) fn stations(
    workpiece: &Workpiece,
    profile: &Profile,
    places: &[DrawnPlace],
    tolerance: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<Station> {
    let station = |place: &DrawnPlace| if stop() { None } else { Some(station(workpiece, profile, *place, tolerance)) };
    places.par_iter().with_min_len(64).filter_map(station).collect()
}

fn station(workpiece: &Workpiece, profile: &Profile, place: DrawnPlace, tolerance: f64) -> Station {
    let tangent = &workpiece.tangents[place.target];
    let guess = Some(workpiece.facet_of(place.target));
    let [x, y, z] = place.point;
    let (offset, height) = profile.arc_at(tangent.slope).point(tangent.slope);
    let flat = profile.arcs()[0].point(0.0).0;
    let lift_at = |axis: [f64; 2], tip: f64| workpiece.drop.drop(profile, axis[0], axis[1], guess).map(|touch| (touch.height - tip, touch));
    // Under the flat a level place is finished from every axis within the flat's radius; on a slope the flat leaves
    // its radius times the slope.
    if flat * tangent.sin > 0.1 * tolerance || flat == 0.0 {
        let axis = [x + offset * tangent.down_hill[0], y + offset * tangent.down_hill[1]];
        let lift = lift_at(axis, z - height).map_or(0.0, |(lift, _)| lift.max(0.0));
        return Station { place, axis, tip: z - height, lift };
    }
    let mut axis = [x, y];
    let mut best = Station { place, axis, tip: z, lift: f64::INFINITY };
    for _ in 0..MOST_STEPS {
        let Some((lift, touch)) = lift_at(axis, z) else { break };
        if lift < best.lift {
            best = Station { axis, lift: lift.max(0.0), ..best };
        }
        if lift <= tolerance {
            break;
        }
        // The axis moves away from what it touches until the profile clears it, but not farther than the flat reaches.
        let away = [axis[0] - touch.contact.x, axis[1] - touch.contact.y];
        let distance = away[0].hypot(away[1]);
        let needed = clear_distance(profile, touch.contact.z - z) * (1.0 + 1e-9) + 1e-6;
        if distance <= 0.0 || needed <= distance {
            break;
        }
        let step = (needed - distance) / distance;
        axis = [axis[0] + step * away[0], axis[1] + step * away[1]];
        let from_place = [axis[0] - x, axis[1] - y];
        let moved = from_place[0].hypot(from_place[1]);
        if moved > flat {
            axis = [x + from_place[0] * flat / moved, y + from_place[1] * flat / moved];
        }
    }
    best
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
