//! Comparison of times with those of Herraz et al. 2020 and of an independent simulation.

use super::surfaces::{facets, published};
use super::{in_direction, published_cutters, ranked};
use scallopd::milling::Model;
use serde_json::Value;

#[test]
fn the_papers_four_simulated_times_are_met() {
    // Directions as printed: steepest for the torus, principal for the ball. The paper does not say how it spaces the passes
    // of the ball on surface 1 where the worst point of a strip is at the border; an independent simulation takes 87.0 s.
    for (surface, cutter, direction, printed, tolerance) in
        [(0, 0, 66.97, 91.3, 0.04), (0, 1, 170.26, 79.7, 0.1), (1, 0, 0.0, 71.8, 0.04), (1, 1, 90.0, 76.8, 0.04)]
    {
        let facets = facets(&published(surface), 80, 80);
        let plan = ranked(&facets, &published_cutters()[cutter..=cutter], &in_direction(Model::Analytic, direction)).plans.remove(0);
        let time = plan.time.seconds();
        println!("surface {surface}, cutter {cutter}: {time:.2} s, printed {printed}; {:?}", plan.milled.unwrap());
        assert!((time / printed - 1.0).abs() < tolerance, "surface {surface}, cutter {cutter}: {time} s, printed {printed}");
    }
}

#[test]
fn an_independent_simulation_takes_the_same_time() {
    let text = include_str!("../../data/zigzag_times.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    let cutters = published_cutters();
    for (surface, name) in [(0, "surface_1"), (1, "surface_2")] {
        let facets = facets(&published(surface), 50, 50);
        let mut ratios = Vec::new();
        // Every third of the directions.
        for (index, direction) in reference["direction_deg"].as_array().unwrap().iter().enumerate().step_by(3) {
            for (cutter, kind) in ["toroidal", "ball_end"].into_iter().enumerate() {
                let settings = in_direction(Model::Analytic, direction.as_f64().unwrap());
                let plan = ranked(&facets, &cutters[cutter..=cutter], &settings).plans.remove(0);
                let expected = reference[name][kind][index].as_f64().unwrap();
                let ratio = plan.time.seconds() / expected;
                println!("{name}, {kind} at {direction} deg: {ratio:.4}, {} lifts", plan.milled.unwrap().tour.lifts);
                ratios.push(ratio);
            }
        }
        let mean = ratios.iter().sum::<f64>() / 24.0;
        assert_eq!(ratios.len(), 24);
        println!("{name}: {mean:.4} of the independent times in the mean");
        // The reference has an error of about 1 %, no lifts, links as long as the spacing, and the length of the contacts.
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.06), "{name}: {ratios:?}");
        assert!((mean - 1.0).abs() < 0.03, "{name}: {mean}");
    }
}
