//! The tables of docs/papers.md: the printed figures are those of the papers, and the others those of the service.

#![allow(clippy::float_cmp)] // the same printed digits

use crate::app::{TestApp, figure};
use crate::planning::{pair, with};
use serde_json::{Value, json};

const PAGE: &str = include_str!("../../docs/papers.md");

/// The first table below a heading, as texts: its head, then its rows.
fn table(heading: &str) -> Vec<Vec<String>> {
    let (_, below) = PAGE.split_once(&format!("{heading}\n")).unwrap_or_else(|| panic!("no heading {heading}"));
    let lines = below.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect();
    lines.filter(|line| !line.starts_with("|---")).map(cells).collect()
}

/// The rows of the first table below a heading.
fn rows(heading: &str) -> Vec<Vec<String>> {
    table(heading).split_off(1)
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap_or_else(|_| panic!("{cell:?} is a number"))
}

/// Whether a table shows a figure: equal to half a unit of its last digit.
fn shows(cell: &str, value: f64) -> bool {
    let decimals = cell.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    (number(cell) - value).abs() <= 0.500_000_1 * 10.0_f64.powi(-i32::try_from(decimals).unwrap())
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tables_of_segonds_have_the_printed_and_the_computed_figures() {
    let app = TestApp::start().await;
    let published: Value = serde_json::from_str(include_str!("../data/segonds_2017.json")).unwrap();
    let (heights, errors) = (rows("### Tables 4 to 6, figures 10 and 11: measured and computed heights"), rows("### Table 7: errors"));
    let printed = published["heights_um"].as_array().unwrap();
    assert_eq!((heights.len(), errors.len(), printed.len()), (9, 9, 9));
    let (mut off_analytic, mut off_envelope) = (0.0, 0.0);
    for ((printed, heights), errors) in printed.iter().zip(&heights).zip(&errors) {
        let of = |name: &str| printed[name].as_f64().unwrap();
        let request = json!({
            "cutter": {"type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2},
            "contact": {"slope_deg": 40, "feed_angle_deg": of("alpha_deg")},
            "step_over_mm": of("step_over_mm"), "feed_per_tooth_mm": of("feed_per_tooth_mm"),
        });
        let answer = app.answer("/v1/scallop-height", &request).await;
        let um = |pointer: &str| 1000.0 * figure(&answer, pointer);
        let [h1, h2, height, envelope] =
            ["/step_over_height_mm", "/feed_height_mm", "/scallop_height_mm", "/check/envelope_scallop_height_mm"].map(um);
        let exact = ["alpha_deg", "feed_per_tooth_mm", "h1_theory", "h2_theory", "total_theory", "total_measured"].map(of);
        for (column, value) in [0, 1, 2, 4, 6, 8].into_iter().zip(exact) {
            assert_eq!(number(&heights[column]), value, "{heights:?}");
        }
        for (column, value) in [(3, h1), (5, h2), (7, height), (9, envelope)] {
            assert!(shows(&heights[column], value), "{value}: {heights:?}");
        }
        for (column, value) in [(2, of("error_h1_only_percent")), (4, of("error_h1_h2_percent"))] {
            assert_eq!(number(&errors[column]), value, "{errors:?}");
        }
        for (column, measured) in [(3, of("h1_measured")), (5, of("total_measured"))] {
            assert!(shows(&errors[column], 100.0 * (height - measured) / height), "{errors:?}");
        }
        off_analytic += (height - of("total_measured")).abs() / height / 9.0;
        off_envelope += (envelope - of("total_measured")).abs() / envelope / 9.0;
    }
    let stated = format!("{:.1} % from the analytic heights and {:.1} % from the envelope's", 100.0 * off_analytic, 100.0 * off_envelope);
    assert!(PAGE.contains(&stated), "{stated}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_tables_of_herraz_have_the_printed_and_the_computed_figures() {
    let app = TestApp::start().await;
    let published: Value = serde_json::from_str(include_str!("../data/herraz_2020.json")).unwrap();
    // The figures of both test surfaces, as printed and as computed.
    for (number, heading) in
        ["### Tables 2 and 3, figures 8 and 9: test surface 1", "### Tables 4 and 5, figures 10 and 11: test surface 2"]
            .into_iter()
            .enumerate()
    {
        let surface = &published["surfaces"][number];
        let request = json!({
            "surface": {"bezier": {"control_points": surface["control_points_mm"]}, "samples": 80},
            "cutters": [{"name": "toroidal", "type": "toroidal", "diameter_mm": 10, "corner_radius_mm": 2}, {"name": "ball_end", "type": "ball_end", "diameter_mm": 10}],
            "scallop_height_mm": 0.01, "machine": "five_axis_vmc", "method": "rectangle",
        });
        let answer = app.recommend(&request).await.ok();
        let rows = rows(heading);
        let row = |name: &str| rows.iter().find(|row| row[0].starts_with(name)).unwrap_or_else(|| panic!("no row {name}"));
        // The numbers of a cell, with their units left out.
        let numbers = |cell: &str| -> Vec<String> {
            cell.split([',', ';', ' ', '=']).filter(|word| word.parse::<f64>().is_ok()).map(str::to_owned).collect()
        };
        let checks = [
            (
                "lambda_I",
                vec![&surface["eigenvalues_mm2"][0], &surface["eigenvalues_mm2"][1]],
                vec!["/surface/eigenvalues_mm2/0", "/surface/eigenvalues_mm2/1"],
            ),
            (
                "mu, chi",
                vec![&surface["form_factor"], &surface["characteristic_size_mm2"]],
                vec!["/surface/form_factor", "/surface/characteristic_size_mm2"],
            ),
            ("slope", vec![&surface["slope_deg"]], vec!["/surface/slope_deg"]),
            ("s_c", vec![&surface["critical_slope_deg"]], vec!["/critical_slope_deg"]),
        ];
        for (name, printed, computed) in checks {
            let (shown, here) = (numbers(&row(name)[1]), numbers(&row(name)[2]));
            for (shown, printed) in shown.iter().zip(printed) {
                assert_eq!(shown.parse::<f64>().ok(), printed.as_f64(), "{name}: {:?}", row(name));
            }
            for (shown, pointer) in here.iter().zip(computed) {
                assert!(shows(shown, figure(&answer, pointer)), "{pointer}: {} shown as {shown}", figure(&answer, pointer));
            }
        }
        assert_eq!(row("cutter")[1], surface["recommended"].as_str().unwrap().replace('_', "-"));
        assert_eq!(row("cutter")[2], answer["recommended"]["name"].as_str().unwrap().replace('_', "-"));
        for (name, times) in [("toroidal", "torus"), ("ball_end", "ball")] {
            let printed = &surface["simulated"][name];
            let text = format!("{} s, {} mm", printed["time_s"], printed["length_mm"]);
            assert!(PAGE.contains(&text), "{times}: {text}");
        }
    }
}

/// The curves of figures 4, 6 and 12, for chi = 1568 mm^2.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn the_curves_of_herraz_have_the_computed_figures() {
    let app = TestApp::start().await;
    let of = async |members: Value| {
        let rectangle = with(json!({"characteristic_size_mm2": 1568}), members);
        app.answer("/v1/critical-slope", &with(pair(), rectangle)).await
    };
    let times = table("### Figure 4: times over the form factor");
    assert_eq!(times[0][1..], ["T_1, s = 10 deg", "30", "60", "90", "T_2"]);
    for row in &times[1..] {
        for (column, slope) in [10, 30, 60, 90].into_iter().enumerate() {
            let answer = of(json!({"form_factor": number(&row[0]), "slope_deg": slope})).await;
            let [toroidal, ball] = [0, 1].map(|index| figure(&answer, &format!("/candidates/{index}/machining_time_s")));
            assert!(shows(&row[1 + column], toroidal) && shows(&row[5], ball), "{toroidal} s, {ball} s: {row:?}");
        }
    }
    let slopes = table("### Figure 6: s_c(mu), and the error of the times at s_c");
    for (mu, shown) in slopes[0].iter().zip(&slopes[1]).skip(1) {
        let answer = of(json!({"form_factor": number(mu)})).await;
        assert!(shows(shown, figure(&answer, "/critical_slope_deg")), "mu = {mu}: {shown}");
    }
    let factors = table("### Figure 12: mu_c(s), and the error of the times at mu_c");
    for (slope, shown) in factors[0].iter().zip(&factors[1]).skip(1) {
        let answer = of(json!({"form_factor": 2, "slope_deg": number(slope)})).await;
        assert!(shows(shown, figure(&answer, "/critical_form_factor")), "s = {slope}: {shown}");
    }
    assert_eq!([times.len(), slopes[0].len(), factors[0].len()], [6, 9, 9]);
}

/// Figures 5 and 6: plans of tips are within 5 % of the formulas, and at the critical slope within 5 % of each other.
#[test]
fn the_plans_of_the_page_are_within_the_errors_that_it_states() {
    for (heading, is_critical) in
        [("### Figure 5: errors of T_1 and T_2", false), ("### Figure 6: s_c(mu), and the error of the times at s_c", true)]
    {
        let below = PAGE.split_once(&format!("{heading}\n")).unwrap().1.split("\n### ").next().unwrap();
        let answers = below.split("```json\n").skip(1).map(|block| block.split("```").next().unwrap());
        let answers: Vec<Value> = answers.map(|text| serde_json::from_str(text).unwrap()).collect();
        let candidates = answers.iter().find_map(|answer| answer["candidates"].as_array()).unwrap();
        let times: Vec<f64> = candidates.iter().map(|candidate| figure(candidate, "machining_time_s")).collect();
        for (candidate, time) in candidates.iter().zip(&times) {
            let formula = figure(candidate, "/rectangle/machining_time_s");
            assert!((formula - time).abs() <= 0.05 * formula.max(*time), "{heading}: {formula} s, {time} s");
        }
        assert_eq!(times.len(), 2);
        assert!(!is_critical || (times[0] - times[1]).abs() <= 0.05 * times[0].max(times[1]), "{times:?}");
    }
}
