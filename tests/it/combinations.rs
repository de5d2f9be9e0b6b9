//! Results in the parameters of another convention, declared as sums of the description's: those of Table III of the KR-270 paper, on
//! simulated campaigns whose truth is known.

use elastogeo::description::robot::Combination;
use elastogeo::estimation::{Settings, calibrate};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::POSITION;
use elastogeo::results::CombinedParameters;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use rayon::prelude::*;
use serde_json::Value;

use crate::cli::{PLANAR, run};

/// 95 % of the intervals of the 18 parameters hold the truth, whatever the reduction kept of the description's own; base and tool are
/// unknown.
#[test]
fn the_papers_18_parameters_are_reported_with_intervals_that_hold_the_truth() {
    let robot = load_robot("kuka-kr270").expect("bundled");
    let (model, declared) = (&robot.model, &robot.robot.calibration.combinations);
    let geometry = Geometry::nominal(model).expect("assembled");
    let seeds = 40;
    let trials: Vec<Vec<bool>> = (0..seeds)
        .into_par_iter()
        .map(|seed| {
            let mut random = generator(seed);
            let plan = Plan {
                configurations: draw_configurations(&geometry, 40, 0.8, &mut random).expect("drawn"),
                markers: (0..3).map(Some).collect(),
                wrenches: Vec::new(),
                conditions: false,
                repeats: 1,
                observes: POSITION,
                sigma: 30e-6,
                sigma_orientation: 0.0,
                estimate: [true, true],
            };
            let truth = draw_errors(model, 0.3, 0.0, &mut random);
            let campaign = simulate(model, &truth, &plan, &mut random).expect("simulated");
            let none = vec![false; campaign.readings.len()];
            let found = calibrate(model, &campaign, &none, &Settings::default(), &mut |_| {}).expect("calibrated");
            let all = CombinedParameters::all(declared, model, &found);
            let of_truth = |sum: &Combination| -> f64 {
                let change = |(name, factor): &(String, f64)| {
                    let slot = model.registry.slot(name).expect("a parameter");
                    factor * (truth[slot] - model.registry[slot].nominal)
                };
                sum.of.iter().map(change).sum()
            };
            let pairs = declared["table-iii"].values().zip(&all[0].parameters);
            let held = pairs.map(|(sum, found)| {
                let size = if found.unit == "mm" { 1e-3 } else { 1f64.to_radians() };
                (found.value * size - of_truth(sum)).abs() <= found.ci95.expect("estimated") * size
            });
            held.collect()
        })
        .collect();
    let count = |k: usize| trials.iter().filter(|held| held[k]).count();
    let counts: Vec<usize> = (0..18).map(count).collect();
    let share = counts.iter().sum::<usize>() as f64 / (18.0 * seeds as f64);
    println!("{share:.3} of the intervals hold the truth; by parameter, of {seeds}: {counts:?}");
    assert!((0.93..0.975).contains(&share) && counts.iter().all(|held| *held >= 32), "{share} {counts:?}");
}

/// A sum of one parameter has its value and interval; one of several their covariance; what cannot be summed is refused with its place.
#[test]
fn sums_are_reported_and_checked() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let declare = |name: &str, sums: &str| {
        std::fs::write(path.join(name), format!("{PLANAR}combinations: {{mine: {sums}}}\n")).expect("written");
    };
    declare(
        "arm.yaml",
        "{reach: {2.d: 1, E.d: 1}, first: {2.d: 1}, tip: {2.d: 1, 2.theta: 400}, half: {2.theta: 0.5}}",
    );
    assert_eq!(
        run(path, &["simulate", "arm.yaml", "--poses", "40", "--set", "2.d=0.3,2.theta=0.1", "--into", "c"]).status,
        0
    );
    let ran = run(path, &["identify", "c", "--format", "json", "--save", "saved.yaml"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    let own = |name: &str| found["parameters"].as_array().expect("a list").iter().find(|p| p["name"] == name).cloned();
    let [d, theta] = ["2.d", "2.theta"].map(|name| own(name).expect("a parameter"));
    assert!(found["combinations"].is_object(), "what each kept parameter absorbed: {}", found["combinations"]);
    let set = &found["conventions"][0];
    assert_eq!(set["convention"], "mine");
    let sum = |name: &str| {
        let all = set["parameters"].as_array().expect("a list");
        let at = all.iter().position(|p| p["name"] == name).expect("the sum");
        (
            at,
            all[at]["value"].as_f64().expect("a number"),
            all[at]["ci95"].as_f64().expect("a number"),
            &all[at]["unit"],
        )
    };
    let of = |p: &Value, key: &str| p[key].as_f64().expect("a number");
    let change = |p: &Value| of(p, "value") - of(p, "nominal");
    let (first, value, ci95, unit) = sum("first");
    assert!((value - change(&d)).abs() < 1e-9 && (ci95 / of(&d, "ci95") - 1.0).abs() < 1e-9 && unit == "mm");
    let (_, value, ci95, unit) = sum("half");
    assert!(
        (value - 0.5 * change(&theta)).abs() < 1e-9 && (ci95 / of(&theta, "ci95") - 0.5).abs() < 1e-9 && unit == "deg"
    );
    let (tip, value, ci95, unit) = sum("tip");
    let lever = 400.0 * 1f64.to_radians();
    assert!((value - change(&d) - lever * change(&theta)).abs() < 1e-9 && unit == "mm");
    // var(a + b) of the correlation between the two; their degrees of freedom differ a little.
    let names = found["kept_parameters"].as_array().expect("a list");
    let at = |name: &str| names.iter().position(|kept| kept == name).expect("kept");
    let r = found["correlation"][at("2.d")][at("2.theta")].as_f64().expect("a number");
    let (a, b) = (of(&d, "ci95"), lever * of(&theta, "ci95"));
    assert!((ci95 / (a * a + b * b + 2.0 * r * a * b).sqrt() - 1.0).abs() < 1e-2, "{ci95} {a} {b} {r}");
    let with_first = set["correlation"][tip][first].as_f64().expect("a number");
    assert!((with_first - (a + r * b) / (a * a + b * b + 2.0 * r * a * b).sqrt()).abs() < 1e-2, "{with_first}");
    let ran = run(path, &["identify", "c"]);
    assert!(ran.out.contains("changes as mine"), "{}", ran.out);
    assert!(std::fs::read_to_string(path.join("saved.yaml")).expect("a file").contains("combinations:"));
    for (sums, expected) in [
        ("{a: {2.dd: 1}}", "did you mean `2.d`?"),
        ("{a: {2.d: .nan}}", "must be a finite number"),
        ("{a: {}}", "`a` is no sum of parameters"),
    ] {
        declare("wrong.yaml", sums);
        let ran = run(path, &["check", "wrong.yaml"]);
        assert!(
            ran.status == 2 && ran.err.contains(expected) && ran.err.contains("wrong.yaml:"),
            "{sums}: {}",
            ran.err
        );
    }
}
