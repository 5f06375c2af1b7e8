//! Temporary
use super::candidate::*; use super::settings::*; use super::search::*; use super::spacing::*; use super::simulate::*; use super::workpiece::*;
use crate::surface::FinishFacet;
/// x
pub fn times(facets: &[FinishFacet], candidates: &[CandidateCutter], settings: &ZigzagSettings) -> Vec<Vec<(f64, Option<f64>)>> {
    let workpiece = Workpiece::new(facets, settings.max_slope.cos());
    let mut rows = vec![false; super::slopes::sines().len()];
    for tangent in &workpiece.tangents { let row = tangent.place.row as usize; rows[row] = true; rows[row + 1] = true; }
    let feed_rate = settings.machine.limits.feed_rate.mm_s();
    let spacings: Vec<_> = candidates.iter().map(|c| CutterSpacing::new(c.cutter, settings.scallop_height, settings.model, c.drive.map(|d| FeedRange::of(d, &settings.machine)), &rows, feed_rate)).collect();
    let contenders: Vec<_> = spacings.iter().zip(candidates).map(|((spacing, feeds), c)| Contender { spacing, operation: Operation { machine: &settings.machine, pattern: settings.pattern, feeds, link_rate: feed_rate }, diameter: 2.0 * c.cutter.outer_radius().mm() }).collect();
    times_by_direction(&workpiece, &contenders, &settings.directions, settings.left_out_share).into_iter().map(|t| t.into_iter().map(|t| (t.direction.degrees(), t.seconds)).collect()).collect()
}
