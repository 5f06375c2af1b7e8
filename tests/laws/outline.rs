//! Heights on concave surfaces compared with a brute-force computation of the section visible from the contact, by
//! points of the cutter's solid.

use crate::laws::passes::mm;
use scallopd::milling::{Contact, Cutter, Envelope, EvaluatedPass, Model, Pass, Runout, SurfaceCurvature};
use scallopd::quantity::Angle;

/// A cutter over a quadric surface: the axis in the plane of normal and steepest line.
struct Setup {
    outer: f64,
    corner: f64,
    slope: f64,
    omega: f64,
    /// Along the feed, across it, twist.
    curvature: [f64; 3],
}

impl Setup {
    /// The height of the solid above the surface at x along the feed and y to its side; infinite outside the solid, and
    /// where the surface overhangs uphill of the contact. It is found by Newton's method from below on the distance
    /// along the normal, which is convex.
    fn height(&self, x: f64, y: f64) -> f64 {
        let (r, a) = (self.corner, self.outer - self.corner);
        let ((sin, cos), (sin_omega, cos_omega)) = (self.slope.sin_cos(), self.omega.sin_cos());
        let (steep, level) = (x * cos_omega - y * sin_omega, x * sin_omega + y * cos_omega);
        let from = [steep * cos - r * sin - a, level, -steep * sin - r * cos];
        let mut p = -self.outer;
        for _ in 0..200 {
            let place = [from[0] + p * sin, from[1], from[2] + p * cos];
            let rho = place[0].hypot(place[1]);
            let (outside, below) = ((rho - a).max(0.0), (-place[2]).max(0.0));
            let to_core = outside.hypot(below);
            if to_core - r <= 1e-15 * self.outer {
                break;
            }
            let slope = (outside * place[0] / rho.max(f64::MIN_POSITIVE) * sin - below * cos) / to_core;
            let step = (r - to_core) / slope;
            if slope >= 0.0 || p + step > 10.0 * self.outer {
                return f64::INFINITY;
            }
            p += step;
            if step <= 1e-15 * self.outer {
                break;
            }
        }
        let [along, across, twist] = self.curvature;
        let (by_x, by_y) = (along * x + twist * y, twist * x + across * y);
        let overhangs = cos < sin * (by_x * cos_omega - by_y * sin_omega) - 1e-12;
        if steep < 0.0 && overhangs { f64::INFINITY } else { p + 0.5 * (x * by_x + y * by_y) }
    }

    /// The first point outside the section at the height p, on each of `lines` lines from the contact.
    fn outline(&self, p: f64, lines: u32) -> Vec<[f64; 2]> {
        let corner = |line: u32| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(line) / f64::from(lines)).sin_cos();
            let outside = |length: f64| self.height(length * cos, length * sin) > p;
            let (mut low, mut high) = (0.0, 1e-5 * self.outer);
            while high < 60.0 * self.outer && !outside(high) {
                (low, high) = (high, 1.1 * high);
            }
            while high - low > 1e-5 * high {
                let middle = f64::midpoint(low, high);
                if outside(middle) { high = middle } else { low = middle }
            }
            [low * cos, low * sin]
        };
        (0..lines).map(corner).collect()
    }

    /// The least height, to 0.2 %, at which the rows of the section that contain an interval of the length f fill an
    /// interval as wide as s.
    fn ridge(&self, s: f64, f: f64) -> f64 {
        let (mut low, mut high) = (1e-6 * self.outer, 2.0 * self.outer);
        while high > 1.002 * low {
            let middle = (low * high).sqrt();
            if width(&self.outline(middle, 360), f) < s { low = middle } else { high = middle }
        }
        high
    }
}

/// The width of the widest run of rows that contain an interval of the length f.
fn width(outline: &[[f64; 2]], f: f64) -> f64 {
    let (least, most) = outline.iter().fold((0.0_f64, 0.0_f64), |(least, most), corner| (least.min(corner[1]), most.max(corner[1])));
    if f <= 0.0 {
        return most - least;
    }
    let longest = |t: f64| {
        let sides = outline.iter().zip(outline.iter().cycle().skip(1)).filter(|(a, b)| (a[1] <= t) != (b[1] <= t));
        let mut ends: Vec<f64> = sides.map(|(a, b)| a[0] + (t - a[1]) / (b[1] - a[1]) * (b[0] - a[0])).collect();
        ends.sort_by(f64::total_cmp);
        ends.chunks_exact(2).map(|ends| ends[1] - ends[0]).fold(0.0, f64::max)
    };
    let (mut widest, mut run) = (0.0_f64, 0.0);
    let rows = 400;
    for row in 0..rows {
        let t = least + (most - least) * (f64::from(row) + 0.5) / f64::from(rows);
        run = if longest(t) >= f { run + (most - least) / f64::from(rows) } else { 0.0 };
        widest = widest.max(run);
    }
    widest
}

/// Floors, walls and slopes between, all kinds of cutters, curvatures of both signs with twist. A polygon of 360
/// corners, and rows of 1/400 of the section's width, have an error of about 2 % of the height; the model's own coarser
/// polygon has 5 %.
#[test]
fn heights_on_concave_surfaces_agree_with_the_section_seen_from_the_contact() {
    for (outer, ratio, slope_deg, omega_deg, principal, turn, s, f) in [
        (5.0, 0.4, 1.5, -116.0, [-0.002, -0.001], 20.0, 0.5, 0.4),
        (5.0, 0.4, 4.0, 90.0, [-0.004, -0.008], 70.0, 0.8, 0.0),
        (7.5, 0.09, 0.755, 90.0, [-0.000_28, -0.000_14], 38.0, 3.75, 2.18),
        (8.0, 0.0, 7.0, 131.0, [-0.013, -0.006], 47.0, 0.97, 1.09),
        (5.0, 0.0, 7.5, 62.0, [-0.004, -0.001], 10.0, 0.88, 0.3),
        (5.0, 0.0, 40.0, 90.0, [-0.01, -0.01], 0.0, 0.5, 0.2),
        (2.4, 0.0, 4.0, 90.0, [-0.001, 0.000_4], 25.0, 0.68, 0.0),
        (5.0, 1.0, 50.0, 30.0, [-0.05, 0.02], 60.0, 0.6, 0.3),
        (8.3, 0.8, 88.5, 90.0, [-0.021, -0.011], 70.0, 4.45, 0.8),
        (0.5, 0.05, 89.73, -94.0, [-0.02, 0.0], 90.0, 0.02, 0.0),
        (5.0, 0.4, 86.0, 35.0, [-0.01, 0.004], 130.0, 0.8, 0.3),
        (8.9, 1.0, 89.7, 10.0, [-0.008, -0.002], 55.0, 2.9, 0.68),
    ] {
        let corner = ratio * outer;
        let cutter = match ratio {
            0.0 => Cutter::flat_end(mm(2.0 * outer)),
            1.0 => Cutter::ball_end(mm(2.0 * outer)),
            _ => Cutter::toroidal(mm(2.0 * outer), mm(corner)).unwrap(),
        };
        let (slope, omega) = (f64::to_radians(slope_deg), f64::to_radians(omega_deg));
        let feed = [slope.cos() * omega.cos(), omega.sin(), -slope.sin() * omega.cos()];
        let contact = Contact::from_vectors([slope.sin(), 0.0, slope.cos()], feed, None).unwrap();
        let surface = SurfaceCurvature::from_principal_per_mm(principal, Angle::from_degrees(turn).unwrap()).unwrap();
        let evaluated = EvaluatedPass::new(Model::Envelope, Pass { cutter, contact, surface, runout: Runout::NONE, teeth: None }).unwrap();
        let envelope = Envelope::new(*evaluated.pass()).unwrap();
        let found = envelope.without_turns().scallop_height(mm(s), (f > 0.0).then(|| mm(f))).unwrap().total().mm();
        let curvature = [surface.along_per_mm(), surface.across_per_mm(), surface.twist_per_mm()];
        let brute = Setup { outer, corner, slope, omega, curvature }.ridge(s, f);
        println!("{found} {brute} at slope {slope_deg}, r/R {ratio}, lambda {}", evaluated.relative_curvature());
        assert!((found / brute - 1.0).abs() <= 0.05, "{found} {brute} at slope {slope_deg}, r/R {ratio}, omega {omega_deg}");
    }
}

/// Marks that do not meet on a strongly convex surface are not gouging, and the stated largest distance has an answer.
#[test]
fn marks_too_far_apart_on_a_strongly_convex_surface_do_not_gouge() {
    let contact = Contact::from_degrees(80.0, 0.0).unwrap();
    let surface = SurfaceCurvature::from_principal_per_mm([1.0, 0.8], Angle::ZERO).unwrap();
    let pass = Pass { cutter: Cutter::toroidal(mm(10.0), mm(2.0)).unwrap(), contact, surface, runout: Runout::NONE, teeth: None };
    let evaluated = EvaluatedPass::new(Model::Envelope, pass).unwrap();
    let mut refused = 0;
    for f in [1.0, 4.0, 6.0, 8.0] {
        match evaluated.scallop_height(mm(1.0), Some(mm(f))) {
            Err(scallopd::milling::NoAnswer::MarksDoNotOverlap { largest_mark_spacing }) => {
                refused += 1;
                assert!(largest_mark_spacing.mm() < f);
                assert!(evaluated.scallop_height(mm(1.0), Some(mm(0.99 * largest_mark_spacing.mm()))).is_ok());
            }
            answer => assert!(answer.is_ok(), "{answer:?}"),
        }
    }
    assert!(refused > 0);
}
