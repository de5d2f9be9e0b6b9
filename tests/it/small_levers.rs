//! What stands for what, where a point lies millimetres from an axis: no angle takes the place of a length.

use crate::cli::run;
use crate::plausibility::json;
use crate::support::printed_json;

/// A loader that lifts and reaches, its ball off the last axis by (1, 2) mm: along the last joint an angle moves it as lengths do.
const LOADER: &str = "robot: cylindrical loader
units: {length: mm, angle: deg}
frames:
  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-150, 150]}
  2: {antecedent: 1, joint: prismatic, variable: lift, limits: [0, 800]}
  3: {antecedent: 2, joint: prismatic, variable: reach, alpha: -90, d: 120, theta: 90, r: 500, limits: [0, 700]}
tool: {frame: 3}
markers: {ball: {frame: 3, at: [1, 2, 60]}}
";

/// Sound campaigns of it are calibrated to their noise, whichever errors it has, and nobody doubts them.
#[test]
fn no_angle_with_a_lever_of_millimetres_stands_for_a_length() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    std::fs::write(at.join("loader.yaml"), LOADER).expect("written");
    for seed in ["4", "5", "6", "7"] {
        let made = ["simulate", "loader.yaml", "--poses", "40", "--noise", "0.03", "--into", seed, "--seed", seed];
        assert_eq!(run(at, &made).status, 0);
        let found = json(&run(at, &["identify", seed, "--format", "json"]));
        assert_eq!(found["diagnostics"].as_array().map(Vec::len), Some(0), "{seed}: {:#}", found["diagnostics"]);
        let ratio = found.pointer("/noise_ratio").and_then(serde_json::Value::as_f64).expect("a number");
        assert!((0.7..1.3).contains(&ratio), "{seed}: residuals are {ratio} times the noise");
    }
    // The angle is what is given up.
    let found = printed_json(at, &["identify", "4"]);
    let dropped = found.pointer("/dropped").and_then(serde_json::Value::as_array).expect("a list");
    let names: Vec<&str> = dropped.iter().filter_map(|own| own["name"].as_str()).collect();
    assert!(names.contains(&"3.theta"), "{names:?}");
}
