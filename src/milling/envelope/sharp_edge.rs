//! Ridges of a flat-end cutter on curved surfaces, without tooth marks: the points at which both sides of its sharp
//! edge are equally high above the surface.
//!
//! Along the edge, the height and the lateral offset are functions of one angle, to which Newton's method is applied
//! directly. The result is only a candidate: the flat or the side of the cutter can clear more, so the caller compares
//! it with the section's outline.

use super::body::{Body, EdgePlace};

/// The largest number of steps; quadratic convergence takes four to six.
const MOST_STEPS: usize = 20;

/// The relative accuracy of the height and the offset at which the iteration ends.
const CLOSE: f64 = 1e-14;

/// The height at which the two sides of the edge are s apart; `None` if the iteration finds none.
pub(super) fn level(body: &Body, s: f64) -> Option<f64> {
    let ahead = body.sharp_edge(0.0).t_by_psi;
    let (mut left, mut right) = (-s / (2.0 * ahead), s / (2.0 * ahead));
    for _ in 0..MOST_STEPS {
        let (a, b) = (body.sharp_edge(left), body.sharp_edge(right));
        // Two equations: equal heights, and offsets s apart.
        let (uneven, apart) = (b.height - a.height, b.t - a.t - s);
        let determinant = b.height_by_psi * a.t_by_psi - a.height_by_psi * b.t_by_psi;
        let right_step = (apart * a.height_by_psi - uneven * a.t_by_psi) / determinant;
        let left_step = (apart * b.height_by_psi - uneven * b.t_by_psi) / determinant;
        if !(right_step.is_finite() && left_step.is_finite()) || right_step.abs().max(left_step.abs()) > 1.0 {
            return None;
        }
        (left, right) = (left + left_step, right + right_step);
        if uneven.abs() <= CLOSE * b.height && apart.abs() <= CLOSE * s {
            return is_held(body, left, right, b.height).then_some(b.height);
        }
    }
    None
}

/// The lateral distance of the two points of the edge at the height p; `None` if the iteration finds none.
pub(super) fn step_over(body: &Body, p: f64, guess: f64) -> Option<f64> {
    let ahead = body.sharp_edge(0.0).t_by_psi;
    let side = |mut psi: f64| {
        for _ in 0..MOST_STEPS {
            let place = body.sharp_edge(psi);
            let excess = place.height - p;
            // The height's square root is nearly linear in the angle.
            let step = -2.0 * place.height * (1.0 - (p / place.height).sqrt()) / place.height_by_psi;
            if !step.is_finite() || step.abs() > 1.0 {
                return None;
            }
            psi += step;
            if excess.abs() <= CLOSE * p {
                return Some(psi);
            }
        }
        None
    };
    let (left, right) = (side(-guess / (2.0 * ahead))?, side(guess / (2.0 * ahead))?);
    is_held(body, left, right, p).then(|| body.sharp_edge(right).t - body.sharp_edge(left).t)
}

/// Whether a result is valid: height and offset rise monotonically along the edge from the contact to both ends, and
/// both ends are visible from the contact.
fn is_held(body: &Body, left: f64, right: f64, p: f64) -> bool {
    let rises = |end: f64| {
        [0.25, 0.5, 0.75, 1.0].into_iter().all(|share| {
            let EdgePlace { t_by_psi, height_by_psi, .. } = body.sharp_edge(share * end);
            t_by_psi > 0.0 && height_by_psi * end > 0.0
        })
    };
    let is_seen = |end: f64| {
        let EdgePlace { x, t, .. } = body.sharp_edge(end);
        body.reaches(x, t, p)
    };
    left < 0.0 && right > 0.0 && rises(left) && rises(right) && is_seen(left) && is_seen(right)
}
