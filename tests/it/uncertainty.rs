//! Standard uncertainty of predicted positions: by simulated campaigns whose truth is known, and through the commands.

use elastogeo::description::raw::RawRobot;
use elastogeo::estimation::{Settings, calibrate, with_uncertainties};
use elastogeo::files::load_robot;
use elastogeo::kinematics::{Geometry, Placements};
use elastogeo::model::{Model, with_values};
use elastogeo::observation::POSITION;
use elastogeo::prediction::FittedUncertainty;
use elastogeo::simulation::{Plan, draw_configurations, draw_errors, generator, simulate};
use rayon::prelude::*;
use serde_json::Value;

use crate::cli::run;
use crate::figures::recorded;
use crate::support::{model_of, printed_json};

const SEEDS: u64 = 40;

/// Share of coordinates of the tool at configurations not measured that lie within 1.96 standard uncertainties of the truth, and
/// its standard error: those of one seed share their parameters.
fn coverage(name: &str, count: usize) -> [f64; 2] {
    let robot = load_robot(name).expect("bundled");
    let model = &robot.model;
    let geometry = Geometry::nominal(model).expect("assembled");
    let configurations = draw_configurations(&geometry, count, 0.8, &mut generator(5)).expect("drawn");
    let fresh = draw_configurations(&geometry, 20, 0.8, &mut generator(6)).expect("drawn");
    let plan = Plan {
        wrenches: Vec::new(),
        conditions: false,
        configurations,
        markers: vec![None],
        repeats: 1,
        observes: POSITION,
        sigma: 20e-6,
        sigma_orientation: 0.0,
        estimate: [false, false],
    };
    let trial = |seed: u64| -> f64 {
        let truth = draw_errors(model, 1.0, 0.0, &mut generator(seed));
        let campaign = simulate(model, &truth, &plan, &mut generator(1_000_000 + seed)).expect("simulated");
        let none = vec![false; campaign.readings.len()];
        let found = calibrate(model, &campaign, &none, &Settings::default(), &mut |_| {}).expect("calibrated");
        let saved = with_uncertainties(&with_values(&robot.raw, model, &found.values), model, &found);
        let calibrated = compiled(&saved);
        let uncertainty = FittedUncertainty::new(&calibrated, saved.calibration.fit.as_ref().expect("written"));
        let all = uncertainty.tool(&calibrated, fresh.iter().map(Vec::as_slice), [0.0; 6]).expect("predicted");
        let at = |model: &Model, values: &[f64], q: &[f64]| {
            let (geometry, mut placements) = (Geometry::new(model, values).expect("assembled"), Placements::default());
            geometry.place(q, &mut placements).expect("placed");
            (placements.frames[model.tool.0] * geometry.tool()).translation.vector
        };
        let held = fresh.iter().zip(&all).flat_map(|(q, own)| {
            let off = at(&calibrated, &calibrated.registry.nominal(), q) - at(model, &truth, q);
            (0..3).map(move |k| off[k].abs() <= 1.96 * own[k])
        });
        held.filter(|held| *held).count() as f64 / (3 * fresh.len()) as f64
    };
    let shares: Vec<f64> = (0..SEEDS).into_par_iter().map(trial).collect();
    let n = SEEDS as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let variance = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, (variance / n).sqrt()]
}

fn compiled(raw: &RawRobot) -> Model {
    model_of(&serde_yaml::to_string(raw).expect("written"))
}

#[test]
fn positions_lie_within_their_uncertainty() {
    let mut lines = Vec::new();
    for (name, count) in [("universal-ur5", 40), ("kuka-ir663", 80), ("kuka-kr270", 50)] {
        let [share, deviation] = coverage(name, count);
        let line = format!(
            "{name}: {share:.3} +- {deviation:.3} of the coordinates within 1.96 standard uncertainties, {SEEDS} seeds"
        );
        assert!((0.93..=0.97).contains(&share) && deviation < 0.02, "{line}");
        lines.push(line);
    }
    recorded("uncertainty", "cargo test positions_lie_within", &lines);
}

/// The same figure in every command, in text too; nothing of it for a description that was not fitted.
#[test]
fn commands_give_the_uncertainty_of_a_fitted_description() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    assert_eq!(run(at, &["init", "c"]).status, 0);
    assert_eq!(run(at, &["identify", "c", "--save", "fitted.yaml"]).status, 0);
    let joints = "q1=10,q2=-70,q3=80,q4=5,q5=30,q6=0";
    let pose = printed_json(at, &["pose", "fitted.yaml", "--joints", joints]);
    let own: Vec<f64> =
        pose["standard_uncertainty"].as_array().expect("figures").iter().filter_map(Value::as_f64).collect();
    assert!(own.len() == 3 && own.iter().all(|u| (1e-6..1e-3).contains(u)), "{own:?}");
    let text = run(at, &["pose", "fitted.yaml", "--joints", joints]).out;
    assert!(text.contains(&format!("standard uncertainty of the tool's position: {:.4}, ", 1e3 * own[0])), "{text}");
    let found = printed_json(at, &["residuals", "fitted.yaml", "c"]);
    let rms = found["predicted_uncertainty"].as_f64().expect("a figure");
    let squares = found["readings"].as_array().expect("readings").iter().map(|reading| {
        let own = reading["standard_uncertainty"].as_array().expect("figures").iter().filter_map(Value::as_f64);
        own.map(|u| u * u).sum::<f64>()
    });
    let squares: Vec<f64> = squares.collect();
    assert!((rms - (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()).abs() < 1e-12);
    assert_eq!(run(at, &["residuals", "fitted.yaml", "c", "--table", "r.csv"]).status, 0);
    assert!(std::fs::read_to_string(at.join("r.csv")).expect("a table").starts_with("row,pose,marker,set,error.x"));
    let plain = printed_json(at, &["pose", "c/robot.yaml", "--joints", joints]);
    assert!(plain.get("standard_uncertainty").is_none());

    // A covariance that is none is refused with its place.
    let text = std::fs::read_to_string(at.join("fitted.yaml")).expect("text");
    let spoiled = text.replacen("    covariance:\n", "    covariance:\n    - [1.0, 2.0]\n", 1);
    assert_ne!(text, spoiled);
    std::fs::write(at.join("spoiled.yaml"), spoiled).expect("written");
    let refused = run(at, &["pose", "spoiled.yaml", "--joints", joints]);
    assert!(refused.status == 2 && refused.err.contains("the lower triangle for"), "{}", refused.err);
    assert!(refused.err.contains("spoiled.yaml:"), "{}", refused.err);

    // So is one of a parameter that the description does not have: its share would be lost without a word.
    let names = text.find("    parameters:\n").expect("a list");
    let (head, tail) = text.split_at(names);
    std::fs::write(at.join("typo.yaml"), format!("{head}{}", tail.replacen("- 2.alpha\n", "- 2.alhpa\n", 1)))
        .expect("written");
    let refused = run(at, &["pose", "typo.yaml", "--joints", joints]);
    assert!(
        refused.status == 2 && refused.err.contains("2.alhpa") && refused.err.contains("2.alpha"),
        "{}",
        refused.err
    );
}

/// What a campaign leaves out of a fitted description takes its rows and columns with it.
#[test]
fn a_covariance_without_what_is_left_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let fitted = run(at, &["identify", "kr270-simulated", "--what", "elastic", "--save", "fitted.yaml"]);
    assert_eq!(fitted.status, 0, "{}", fitted.err);
    let text = std::fs::read_to_string(at.join("fitted.yaml")).expect("text");
    assert!(text.contains("- joint2.kar\n"), "{text}");
    let reader = elastogeo::files::Reader::default();
    let path = at.join("fitted.yaml");
    let less = reader.robot_leaving_out(path.to_str().expect("a path"), &["joint:2"]).expect("a robot");
    let fit = less.raw.calibration.fit.as_ref().expect("a covariance");
    assert!(fit.parameters.iter().all(|name| !name.starts_with("joint2.")));
    assert!(fit.covariance.iter().enumerate().all(|(row, own)| own.len() == row + 1));
    assert_eq!(fit.covariance.len(), fit.parameters.len());
}
