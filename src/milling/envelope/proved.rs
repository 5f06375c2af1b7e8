//! The ridge by the fast searches together; it has an answer only if the result is proved.

use super::body::Body;
use super::clearing::Clearing;
use super::newton::{End, Lengths, Place, Ridge, Sought};
use super::{local, newton};

/// The ridge on the body, whose sought length is a guess in `lengths`; `None` unless the result is proved.
///
/// If the searches of chords find no height or feed on a convex section, the steps of [`local`] may, from the contact or,
/// near the floor, from under the axis. Convexity proves these results, too: a ridge near the start is the only one.
pub(super) fn solve(body: &Body, sought: Sought, lengths: Lengths, marks: [Clearing; 2]) -> Option<Ridge> {
    let place = Place::start(body, lengths.step_over, marks, lengths.mark_spacing);
    let found = newton::solve_from(body, sought, lengths, place, marks, End::AtRidge);
    if found.is_some() || body.is_concave() || !matches!(sought, Sought::Level) {
        return found;
    }
    let under_axis = || {
        let mut lengths = lengths;
        if matches!(sought, Sought::Level) {
            lengths.level = lengths.level.max(body.height_under_axis(lengths.step_over.hypot(lengths.mark_spacing)));
        }
        local::solve(body, sought, lengths, Place::under_axis(body, lengths, marks), marks)
    };
    local::solve(body, sought, lengths, place, marks).or_else(|| if body.is_nearly_level() { under_axis() } else { None })
}
