//! The tightest hollows of a part, for requests in which no cutter fits.

use super::workpiece::Workpiece;
use crate::quantity::Length;
use nalgebra::Vector3;

/// Two facets that meet in a hollow at a larger angle than this, in rad, are an edge, not a tessellated fillet: 30 deg.
const EDGE: f64 = 0.52;

/// Facets that meet at less than this, in rad, are one plane with rounded corners.
const FLAT: f64 = 1e-4;

/// The share of the length of hollow edges that may be tighter: scanned and repaired meshes have a few.
const LEFT_OUT: f64 = 0.01;

impl Workpiece {
    /// The radius of the tightest hollow of what is machined, 0 for a sharp inner edge; `None` without hollows. A ball or a corner
    /// of a larger radius leaves material there.
    #[must_use]
    pub fn smallest_concave_radius(&self) -> Option<Length> {
        let mut hollows: Vec<(f64, f64)> = (0..self.targets.len()).flat_map(|target| self.hollows_of(target)).collect();
        hollows.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = hollows.iter().map(|(_, length)| length).sum();
        let mut passed = 0.0;
        let tightest = hollows.iter().find(|(_, length)| {
            passed += length;
            passed > LEFT_OUT * whole
        });
        tightest.map(|(radius, _)| Length::computed(*radius))
    }

    /// Radius and length of each edge of a target beyond which the part rises.
    fn hollows_of(&self, target: usize) -> impl Iterator<Item = (f64, f64)> {
        let facet = self.facet_of(target);
        let corners = self.corners_of(facet);
        let normal_of = |[a, b, c]: [Vector3<f64>; 3]| (b - a).cross(&(c - a));
        let own = normal_of(corners);
        (0..3).filter_map(move |first| {
            let [from, to] = [corners[first], corners[(first + 1) % 3]];
            let other = self.neighbour_of(facet, first)?;
            let beyond = self.corners_of(other);
            let apex = *beyond.iter().max_by(|a, b| off(**a, from, to).total_cmp(&off(**b, from, to)))?;
            let (upwards, beside) = (upright(own), upright(normal_of(beyond)));
            let angle = upwards.cross(&beside).norm().atan2(upwards.dot(&beside));
            if (apex - from).dot(&upwards) <= 0.0 || angle < FLAT {
                return None;
            }
            let length = (to - from).norm();
            // A fillet of the radius r in strips of the width w turns by w/r from strip to strip.
            let width = f64::midpoint(off(corners[(first + 2) % 3], from, to), off(apex, from, to));
            Some((if angle > EDGE { 0.0 } else { width / angle }, length))
        })
    }
}

/// The unit vector that points upwards.
fn upright(normal: Vector3<f64>) -> Vector3<f64> {
    let unit = normal.normalize();
    if unit.z < 0.0 { -unit } else { unit }
}

/// The distance of a point from the line through two others.
fn off(point: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>) -> f64 {
    (point - from).cross(&(to - from)).norm() / (to - from).norm().max(f64::MIN_POSITIVE)
}
