//! Flat regions of a mesh: connected facets in one plane.

use super::fans::{Fans, LARGEST_FAN};
use crate::numerics::vector::dot;

/// The largest angle in rad between normals of one plane. Files in single precision round coordinates of 100 mm by 4e-6
/// mm, which turns the normals of facets of 0.1 mm by 4e-5 rad.
pub(super) const SAME_PLANE: f64 = 1e-4;

/// The number of facets between two checks for cancellation.
const TURN: usize = 1024;

/// For each facet, the area of its flat region in mm^2. A region has all facets that are connected with its first facet
/// by common points and have the same normal. All normals are compared with that of the first facet, so that a gently
/// curved surface does not become one region.
///
/// Points with more than [`LARGEST_FAN`] facets do not extend a region, because the time would grow with the square of
/// their number. The facets of such a fan are also connected at its rim.
///
/// Once `stop` returns true, it returns early, and areas are missing.
pub(super) fn areas_of_flat_regions(
    triangles: &[[u32; 3]],
    fans: &Fans,
    normals: &[[f64; 3]],
    areas: &[f64],
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<f64> {
    // 1 - cos(x) = x^2/2, to 1e-17 for an angle of 1e-4.
    let least_cos = 1.0 - 0.5 * SAME_PLANE * SAME_PLANE;
    let mut of_regions = vec![f64::NAN; triangles.len()];
    let mut members: Vec<u32> = Vec::new();
    let mut examined = 0_usize;
    for (first, normal) in normals.iter().enumerate() {
        if !of_regions[first].is_nan() {
            continue;
        }
        members.clear();
        #[expect(clippy::cast_possible_truncation, reason = "the bound on facets is below 2^32")]
        members.push(first as u32);
        of_regions[first] = 0.0;
        let (mut next, mut area) = (0, 0.0);
        while next < members.len() {
            let facet = members[next] as usize;
            next += 1;
            examined += 1;
            if examined.is_multiple_of(TURN) && stop() {
                return of_regions;
            }
            area += areas[facet];
            for point in triangles[facet] {
                let fan = fans.around(point as usize);
                if fan.len() > LARGEST_FAN {
                    continue;
                }
                for &other in fan {
                    let is_new = of_regions[other as usize].is_nan();
                    if is_new && dot(normals[other as usize], *normal) >= least_cos {
                        of_regions[other as usize] = 0.0;
                        members.push(other);
                    }
                }
            }
        }
        for &member in &members {
            of_regions[member as usize] = area;
        }
    }
    of_regions
}
