//! The model against its table, its closed forms and its laws.

use super::*;
use crate::milling::{Analytic, Runout, SurfaceCurvature};

fn mm(value: f64) -> Length {
    Length::from_mm(value).unwrap()
}

fn cutter(outer_radius: f64, corner_radius: f64) -> Cutter {
    if corner_radius == 0.0 {
        Cutter::flat_end(mm(2.0 * outer_radius))
    } else if corner_radius == outer_radius {
        Cutter::ball_end(mm(2.0 * outer_radius))
    } else {
        Cutter::toroidal(mm(2.0 * outer_radius), mm(corner_radius)).unwrap()
    }
}

fn on_plane(cutter: Cutter, slope: f64, alpha: f64) -> Envelope {
    let contact = Contact::from_degrees(slope, alpha).unwrap();
    Envelope::new(Pass { cutter, contact, surface: SurfaceCurvature::PLANE, runout: Runout::NONE }).unwrap()
}

#[test]
fn the_check_values_come_out_to_their_printed_digits() {
    // Slope and alpha in deg, step-over in mm, h1 in um, for R = 5 mm, r = 2 mm.
    for (slope, alpha, step_over, micrometres) in [
        (40.0, 0.0, 0.73, 10.006),
        (40.0, 90.0, 0.4, 10.025),
        (5.0, 0.0, 2.0, 14.065),
        (1.0, 0.0, 3.7, 10.958),
        (0.5, 0.0, 5.27, 13.420),
        (0.2, 0.0, 5.9, 8.295),
        (0.01, 0.0, 6.4, 10.548),
        (85.0, 90.0, 0.4, 9.936),
        (89.0, 90.0, 0.4, 4.371),
    ] {
        let height = on_plane(cutter(5.0, 2.0), slope, alpha).scallop_height(mm(step_over), None).unwrap();
        // Half of the last digit printed.
        approx::assert_abs_diff_eq!(height.step_over.mm() * 1e3, micrometres, epsilon = 5e-4);
    }
}
