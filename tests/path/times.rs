//! The time of a path with look-ahead.

use proptest::prelude::*;
use scallopd::motion::{MachineLimits, path_time, travel_time};
use scallopd::quantity::{Acceleration, Jerk, Length, Speed};
use serde_json::Value;

fn limits(feed_rate: f64, acceleration: f64, jerk: f64) -> MachineLimits {
    MachineLimits {
        feed_rate: Speed::from_mm_min(feed_rate).unwrap(),
        acceleration: Acceleration::from_m_s2(acceleration).unwrap(),
        jerk: Jerk::from_m_s3(jerk).unwrap(),
    }
}

fn time(points: &[[f64; 3]], limits: MachineLimits, tolerance: f64) -> f64 {
    path_time(points, &vec![limits.feed_rate; points.len() - 1], limits, Length::from_mm(tolerance).unwrap()).seconds()
}

#[test]
fn times_agree_with_an_independent_program() {
    let document: Value = serde_json::from_str(include_str!("../data/path_times.json")).unwrap();
    for case in document["cases"].as_array().unwrap() {
        let get = |name: &str| case[name].as_f64().unwrap();
        let points: Vec<[f64; 3]> = serde_json::from_value(case["tip_mm"].clone()).unwrap();
        let limits = limits(get("feed_rate_mm_min"), get("acceleration_m_s2"), get("jerk_m_s3"));
        let found = time(&points, limits, get("path_tolerance_mm"));
        // Where full acceleration would reach the feed within the first chord, what counts as the first part between two
        // minima of the speed depends on which of equal speeds is the minimum; it is open by some percent of so short a path.
        let allowed = if limits.acceleration.mm_s2() / limits.jerk.mm_s3() > 2.0 { 0.05 } else { 1e-3 };
        assert!((found / get("time_s") - 1.0).abs() < allowed, "{found} for {}", get("time_s"));
    }
}

proptest! {
    #[test]
    fn a_straight_move_takes_the_time_from_rest_to_rest(
        length in 1e-3..500.0_f64, feed in 100.0..20_000.0_f64, acceleration in 0.2..15.0_f64, jerk in 2.0..200.0_f64,
    ) {
        let limits = limits(feed, acceleration, jerk);
        let expected = travel_time(Length::from_mm(length).unwrap(), limits).seconds();
        let found = time(&[[0.0; 3], [0.6 * length, 0.8 * length, 0.0]], limits, 0.01);
        prop_assert!((found / expected - 1.0).abs() < 1e-9, "{} {}", found, expected);
    }

    #[test]
    fn less_tolerance_takes_more_time_up_to_that_of_a_stop_at_every_point(
        steps in prop::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64, 0.1..1.0_f64), 2..6), feed in 500.0..10_000.0_f64,
    ) {
        let limits = limits(feed, 5.0, 50.0);
        let mut points = vec![[0.0; 3]];
        for (x, y, z) in steps {
            let last = points[points.len() - 1];
            points.push([last[0] + x, last[1] + y, last[2] + z]);
        }
        let turns_everywhere = points.windows(3).all(|three| {
            let [u, v]: [[f64; 3]; 2] = [0, 1].map(|at| std::array::from_fn(|axis| three[at + 1][axis] - three[at][axis]));
            let (dot, lengths) = (0..3).fold((0.0, [0.0; 2]), |(dot, [a, b]), axis| (dot + u[axis] * v[axis], [a + u[axis].powi(2), b + v[axis].powi(2)]));
            dot < 0.9 * (lengths[0] * lengths[1]).sqrt()
        });
        prop_assume!(turns_everywhere);
        let stops: f64 = points
            .windows(2)
            .map(|ends| {
                let length = (0..3).map(|axis| (ends[1][axis] - ends[0][axis]).powi(2)).sum::<f64>().sqrt();
                travel_time(Length::from_mm(length).unwrap(), limits).seconds()
            })
            .sum();
        let [wide, narrow, least] = [0.1, 0.005, 1e-6].map(|tolerance| time(&points, limits, tolerance));
        // The search for the acceleration ends 0.5 % from the best one, where the time is level.
        prop_assert!(wide <= narrow * 1.001 && narrow <= least * 1.001, "{} {} {}", wide, narrow, least);
        prop_assert!((least / stops - 1.0).abs() < 0.01, "{} {}", least, stops);
    }
}
