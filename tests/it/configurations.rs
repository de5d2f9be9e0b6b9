//! Error of each configuration held out, observed and predicted (KR-270 paper, Tables X and XII): by simulated campaigns, and through
//! the commands.

use elastogeo::description::campaign::Campaign;
use elastogeo::estimation::{Settings, calibrate, split};
use elastogeo::files::load_robot;
use elastogeo::kinematics::Geometry;
use elastogeo::observation::{DEFLECTION, Observes, POSITION};
use elastogeo::prediction::ConfigurationError;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use rayon::prelude::*;
use serde_json::Value;

use crate::cli::run;
use crate::figures::recorded;
use crate::support::printed_json;

const SEEDS: u64 = 40;

/// Shares of configurations whose error lies in its interval, and of coordinates whose mean error does; each with its standard
/// error (those of one seed share their parameters).
fn coverage(name: &str, count: usize, observes: Observes, repeats: usize) -> [[f64; 2]; 2] {
    let robot = load_robot(name).expect("bundled");
    let model = &robot.model;
    let geometry = Geometry::nominal(model).expect("assembled");
    let is_position = observes == POSITION;
    let trial = |seed: u64| -> [f64; 2] {
        let mut random = generator(seed);
        let plan = Plan {
            configurations: draw_configurations(&geometry, count, 0.8, &mut random).expect("drawn"),
            markers: (0..model.markers.len().min(3)).map(Some).collect(),
            wrenches: if is_position { Vec::new() } else { vec![[0.0, 0.0, -2500.0, 0.0, 0.0, 0.0]] },
            conditions: false,
            repeats,
            observes,
            sigma: 30e-6,
            sigma_orientation: 0.0,
            estimate: [is_position, is_position],
        };
        let plan = Plan { markers: if plan.markers.is_empty() { vec![None] } else { plan.markers }, ..plan };
        let truth =
            draw_errors(model, f64::from(u8::from(is_position)), f64::from(u8::from(!is_position)), &mut random);
        let campaign = simulate(model, &truth, &plan, &mut random).expect("simulated");
        let held_out = split(&campaign, 0.3, seed);
        let found = calibrate(model, &campaign, &held_out, &Settings::default(), &mut |_| {}).expect("calibrated");
        let all = &found.configurations;
        assert_eq!(all.iter().map(|of| of.readings.len()).sum::<usize>(), held_out.iter().filter(|out| **out).count());
        assert!(
            all.iter().all(|of| of.readings.iter().all(|&index| held_out[index] && is_of_one(&campaign, of, index)))
        );
        let within = all.iter().filter(|of| of.is_within()).count() as f64 / all.len() as f64;
        let means = all.iter().flat_map(|of| (0..3).map(|k| of.mean[k].abs() <= of.ci95[k]));
        [within, means.filter(|held| *held).count() as f64 / (3 * all.len()) as f64]
    };
    let shares: Vec<[f64; 2]> = (0..SEEDS).into_par_iter().map(trial).collect();
    std::array::from_fn(|which| {
        let n = SEEDS as f64;
        let mean = shares.iter().map(|of| of[which]).sum::<f64>() / n;
        let variance = shares.iter().map(|of| (of[which] - mean).powi(2)).sum::<f64>() / (n - 1.0);
        [mean, (variance / n).sqrt()]
    })
}

fn is_of_one(campaign: &Campaign, of: &ConfigurationError, index: usize) -> bool {
    campaign.readings[index].pose == campaign.readings[of.readings[0]].pose
}

#[test]
fn errors_of_configurations_lie_within_their_intervals() {
    let cases = [
        ("universal-ur5", 40, POSITION, 1),
        ("kuka-kr270", 30, POSITION, 1),
        ("kuka-kr270", 24, POSITION, 3),
        ("kuka-kr270", 24, DEFLECTION, 1),
    ];
    let mut lines = Vec::new();
    for (name, count, observes, repeats) in cases {
        let [[error, of_error], [mean, of_mean]] = coverage(name, count, observes, repeats);
        let line = format!(
            "{name}, {count} configurations, {}, {repeats} repeats: error {error:.3} +- {of_error:.3}, mean {mean:.3} +- {of_mean:.3}, {SEEDS} seeds",
            observes.name()
        );
        println!("{line}");
        lines.push((line, [error, mean], of_error.max(of_mean)));
    }
    for (line, shares, deviation) in &lines {
        assert!(shares.iter().all(|share| (0.93..=0.975).contains(share)) && *deviation < 0.02, "{line}");
    }
    let lines: Vec<String> = lines.into_iter().map(|(line, ..)| line).collect();
    recorded("configurations", "cargo test errors_of_configurations", &lines);
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// The configurations make up what is said of all; the saved description says nearly the same of them.
#[test]
fn commands_give_the_error_of_each_configuration() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path();
    let made = "simulate kuka-kr270 --observes deflection --poses 16 --markers m1,m2,m3 --wrench 0,0,-2500,0,0,0 \
        --wrench 1000,0,0,0,0,0 --noise 0.03 --errors 0 --elastic-errors 1 --check 0.3 --into c";
    assert_eq!(run(path, &made.split_whitespace().collect::<Vec<_>>()).status, 0);
    let found = printed_json(path, &["identify", "c", "--save", "fitted.yaml", "--configurations", "errors.csv"]);
    let all = found["configurations"].as_array().expect("a list");
    let squares: f64 = all
        .iter()
        .map(|of| of["readings"].as_f64().expect("a number") * of["observed_rms"].as_f64().expect("mm").powi(2))
        .sum();
    let check = &found["residuals"]["check_after"];
    let readings = check["readings"].as_f64().expect("a number");
    assert!(((squares / readings).sqrt() - check["rms"].as_f64().expect("mm")).abs() < 1e-9, "{found:#}");
    // Under each load for itself.
    let loads: Vec<Vec<f64>> = all.iter().map(|of| numbers(&of["wrench"])).collect();
    assert!(all.len() as f64 * 3.0 == readings && loads.iter().any(|wrench| wrench[0] == 1000.0), "{loads:?}");
    for of in all {
        let [measured, predicted, mean, u, ci95] =
            ["measured", "predicted", "mean", "standard_uncertainty", "ci95"].map(|key| numbers(&of[key]));
        for k in 0..3 {
            assert!((measured[k] - predicted[k] - mean[k]).abs() < 1e-12 && ci95[k] > 1.96 * u[k], "{of}");
            let range = numbers(&of["range"][k]);
            assert!(range[0] <= mean[k] && mean[k] <= range[1], "{of}");
        }
        let interval = numbers(&of["predicted_ci95"]);
        let of_rms = |key: &str| of[key].as_f64().expect("mm");
        assert!(interval[0] < of_rms("predicted_rms") && of_rms("predicted_rms") < interval[1], "{of}");
        assert!(of_rms("parameters_rms") < of_rms("predicted_rms"), "{of}");
    }
    let table = std::fs::read_to_string(path.join("errors.csv")).expect("a table");
    assert!(
        table.starts_with("pose,readings,fx,fy,fz,mx,my,mz,measured.x,measured.y,measured.z,predicted.x"),
        "{table}"
    );
    assert_eq!(table.lines().count(), all.len() + 1);

    let again = printed_json(path, &["residuals", "fitted.yaml", "c", "--configurations", "again.csv"]);
    let of_saved = again["configurations"].as_array().expect("a list");
    assert_eq!(of_saved.len(), 32);
    for own in all {
        let same = |of: &&Value| of["pose"] == own["pose"] && of["wrench"] == own["wrench"];
        let saved = of_saved.iter().find(same).expect("the configuration");
        let of = |value: &Value, key: &str| value[key].as_f64().expect("mm");
        assert!((of(saved, "observed_rms") / of(own, "observed_rms") - 1.0).abs() < 1e-6, "{saved} {own}");
        assert!((of(saved, "parameters_rms") / of(own, "parameters_rms") - 1.0).abs() < 1e-3, "{saved} {own}");
        assert!((of(saved, "predicted_rms") / of(own, "predicted_rms") - 1.0).abs() < 0.25, "{saved} {own}");
    }

    assert_eq!(run(path, &["simulate", "universal-ur5", "--poses", "30", "--check", "0", "--into", "bare"]).status, 0);
    for (arguments, expected) in [
        (&["residuals", "kuka-kr270", "c", "--configurations", "x.csv"][..], "how certain its parameters are"),
        (
            &["identify", "bare", "--check", "0", "--configurations", "x.csv"],
            "no configuration with positions is held out",
        ),
        (&["identify", "c", "--configurations", "nowhere/x.csv"], "there is no folder `nowhere`"),
    ] {
        let ran = run(path, arguments);
        assert!(ran.status == 2 && ran.err.contains(expected), "{arguments:?}: {}", ran.err);
    }
}
