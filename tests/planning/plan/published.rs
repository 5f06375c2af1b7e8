//! Comparison of times with those of Herraz et al. 2020 and of an independent simulation.

use super::surfaces::{facets, published};
use super::{in_direction, published_cutters, ranked_on, workpiece};
use scallopd::milling::Model;
use scallopd::planning::plan::{Workpiece, estimated_times};
use serde_json::Value;

/// A published surface of 80 x 80 quads.
fn part(surface: usize) -> Workpiece {
    workpiece(&facets(&published(surface), 80, 80))
}

/// The estimated time in s of a published cutter in one direction. Estimates have the paper's rules: the worst point of a strip
/// spaces its lines, and each line is one pass with the length of its contacts. A milled plan moves its lines further apart.
fn estimated(part: &Workpiece, cutter: usize, direction: f64) -> f64 {
    let settings = in_direction(Model::Analytic, direction);
    estimated_times(part, &published_cutters()[cutter..=cutter], &settings, &|| false).unwrap()[0].unwrap().seconds()
}

/// Directions as printed: steepest for the torus, principal for the ball. The paper prints 79.7 s for the ball on surface 1, and
/// does not say how it spaces the passes where the worst point of a strip is at the border; an independent simulation takes
/// 87.0 s.
const PRINTED: [(usize, usize, f64, f64); 4] = [(0, 0, 66.97, 91.3), (0, 1, 170.26, 87.0), (1, 0, 0.0, 71.8), (1, 1, 90.0, 76.8)];

#[test]
fn the_papers_four_simulated_times_are_met() {
    for (surface, cutter, direction, printed) in PRINTED {
        let time = estimated(&part(surface), cutter, direction);
        println!("surface {surface}, cutter {cutter}: {time:.2} s, printed {printed}");
        assert!((time / printed - 1.0).abs() < 0.04, "surface {surface}, cutter {cutter}: {time} s, printed {printed}");
    }
}

/// On a convex surface with a radius of 50 mm, the tips of a cutter of 5 mm go a tenth farther than its contacts.
#[test]
fn a_milled_plan_takes_at_most_a_tenth_longer_than_the_paper_prints() {
    for (surface, cutter, direction, printed) in PRINTED {
        let candidate = published_cutters()[cutter];
        let plan = ranked_on(&part(surface), &[candidate], &in_direction(Model::Analytic, direction)).plans.remove(0);
        let (seconds, left) = (plan.time.seconds(), plan.milled.unwrap().finish);
        println!("surface {surface}, cutter {cutter}: {seconds:.2} s, printed {printed}; {left:?}");
        assert!(seconds <= 1.1 * printed && left.far_over_share <= 0.005, "surface {surface}, cutter {cutter}: {seconds} s; {left:?}");
    }
}

#[test]
fn an_independent_simulation_takes_the_same_time() {
    let text = include_str!("../../data/zigzag_times.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    for (surface, name) in [(0, "surface_1"), (1, "surface_2")] {
        let part = part(surface);
        let mut ratios = Vec::new();
        for (index, direction) in reference["direction_deg"].as_array().unwrap().iter().enumerate() {
            for (cutter, kind) in ["toroidal", "ball_end"].into_iter().enumerate() {
                let expected = reference[name][kind][index].as_f64().unwrap();
                ratios.push(estimated(&part, cutter, direction.as_f64().unwrap()) / expected);
            }
        }
        assert_eq!(ratios.len(), 72);
        let mean = ratios.iter().sum::<f64>() / 72.0;
        println!("{name}: {mean:.4} of the independent times in the mean; {ratios:.4?}");
        // The reference has an error of about 1 %. Where the worst point of a strip is at the border (see `PRINTED`), few of
        // the random places that an estimate is made from are near it.
        assert!(ratios.iter().all(|ratio| (ratio - 1.0).abs() < 0.06), "{name}: {ratios:?}");
        assert!((mean - 1.0).abs() < 0.03, "{name}: {mean}");
    }
}
