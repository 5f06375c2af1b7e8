//! Tests of the model, by subject, and the passes that they share.

mod heights;
mod inverses;
mod refusals;
mod searches;

use super::*;
use crate::milling::{ScallopHeight, SurfaceCurvature};
use crate::quantity::Angle;
use proptest::prelude::*;

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

fn cutter(outer_radius: f64, ratio: f64) -> Cutter {
    if ratio <= 0.0 {
        Cutter::flat_end(mm(2.0 * outer_radius))
    } else if ratio >= 1.0 {
        Cutter::ball_end(mm(2.0 * outer_radius))
    } else {
        Cutter::toroidal(mm(2.0 * outer_radius), mm(ratio * outer_radius)).unwrap()
    }
}

fn pass(cutter: Cutter, slope: f64, alpha: f64) -> Pass {
    let contact = Contact::from_degrees(slope, alpha).unwrap();
    Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }
}

fn on_plane(cutter: Cutter, slope: f64, alpha: f64) -> Envelope {
    Envelope::new(pass(cutter, slope, alpha)).unwrap()
}

fn curved(pass: Pass, radius: f64) -> Pass {
    Pass { surface: SurfaceCurvature::from_radius_mm(radius).unwrap(), ..pass }
}

/// A pass by vectors, which distinguish all feeds on a wall; slope and omega in degrees.
fn by_omega(cutter: Cutter, slope: f64, omega: f64) -> Envelope {
    let (slope, omega) = (Angle::from_degrees(slope).unwrap(), Angle::from_degrees(omega).unwrap());
    let feed = [slope.cos() * omega.cos(), omega.sin(), -slope.sin() * omega.cos()];
    let contact = Contact::from_vectors([slope.sin(), 0.0, slope.cos()], feed, None).unwrap();
    Envelope::new(Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE, teeth: None }).unwrap()
}

/// Any cutter: flat-end, toroidal, ball-end.
fn cutters() -> impl Strategy<Value = Cutter> {
    let ratio = prop_oneof![1 => Just(0.0), 6 => 0.01..0.99_f64, 1 => Just(1.0)];
    (0.5..10.0_f64, ratio).prop_map(|(outer_radius, ratio)| cutter(outer_radius, ratio))
}

/// An angle from 0 to 90 deg, including its ends.
fn quarter_turn() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 8 => 0.0..90.0_f64, 1 => Just(90.0)]
}

/// Heights in mm for lengths in mm.
impl Envelope {
    fn at(&self, s: f64, f: f64) -> Option<f64> {
        self.height(s, f).map(|height| height.level)
    }

    /// The height by the sure search, even where the fast one has an answer.
    fn searched(&self, s: f64, f: f64) -> f64 {
        let guess = Lengths { level: self.guess(s, f), step_over: s, feed: f };
        match self.search(&self.body).solve(Sought::Level, guess, self.body.rounding(), Length::LARGEST, &mut self.places(&guess)) {
            Outcome::At(level) => level,
            Outcome::Below => 0.0,
            Outcome::Above => f64::INFINITY,
        }
    }
}

/// P - sqrt(P^2 - c^2/4) without cancellation: the height between circles of radius P at the distance c <= 2P.
fn circle_height(radius: f64, chord: f64) -> f64 {
    let ratio = chord / (2.0 * radius);
    chord / 2.0 * ratio / (1.0 + ((1.0 - ratio) * (1.0 + ratio)).sqrt())
}
