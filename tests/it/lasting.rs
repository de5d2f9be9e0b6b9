//! What a diagnosis writes into the robot, and what of it holds in the next session; compliances that effects add.

use std::path::Path;

use serde_json::Value;

use super::cli::run;
use super::plausibility::starter;
use super::support::{number, printed_json};

fn ok(at: &Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{arguments:?}: {}{}", ran.out, ran.err);
}

/// The starter's robot with an effect, under another name.
fn with_effect(at: &Path, name: &str, effect: &str) {
    let robot = std::fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    std::fs::write(at.join(name), format!("{robot}effects:\n- {effect}\n")).expect("written");
}

/// Readings with times, of the same errors whatever the effect.
fn simulated(at: &Path, robot: &str, poses: &str, into: &str) {
    let made =
        ["simulate", robot, "--poses", poses, "--seed", "3", "--errors", "0.3", "--conditions", "--noise", "0.02"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--into", into]].concat());
}

/// What the written description leaves of a campaign with base and tool fitted alone, mm.
fn left(at: &Path, campaign: &str, robot: &str) -> f64 {
    let found = printed_json(at, &["register", campaign, "--robot", robot]);
    number(&found["residuals"]["registration"]["rms"])
}

fn causes(found: &Value) -> Vec<String> {
    let named = |cause: &Value| format!("{}@{}", cause["effect"], cause["site"]).replace('"', "");
    found["causes"].as_array().expect("a list").iter().map(named).collect()
}

/// A joint that slipped stays there: the robot is written as it is from then on, and fits a session in which it never was elsewhere.
#[test]
fn a_joint_that_slipped_is_written_where_it_stays() {
    let folder = starter();
    let at = folder.path();
    let slip =
        |at: &str| format!("{{effect: joint-slip, site: 'joint:3', parameters: {{offset: 8e-4, slip_at: {at}}}}}");
    with_effect(at, "slips.yaml", &slip("3000"));
    with_effect(at, "slipped.yaml", &slip("-1"));
    simulated(at, "slips.yaml", "80", "first");
    simulated(at, "slipped.yaml", "80", "next");
    let diagnosed = ["diagnose", "first", "--robot", "c/robot.yaml", "--apply", "applied.yaml", "--format", "json"];
    let ran = run(at, &diagnosed);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(causes(&found).first().map(String::as_str), Some("joint-slip@joint:3"));
    let written = std::fs::read_to_string(at.join("applied.yaml")).expect("written");
    assert!(written.contains("joint-offset") && !written.contains("joint-slip"), "{written}");
    let left = left(at, "next", "applied.yaml");
    assert!(left < 0.06, "{left} mm in the next session, of 0.035 mm of noise; 0.5 mm without the slip");
}

/// A link that warms up does so in every session.
#[test]
fn a_warm_up_comes_again() {
    let folder = starter();
    let at = folder.path();
    with_effect(
        at,
        "warms.yaml",
        "{effect: link-warm-up, site: 'link:2', parameters: {growth: 6e-4, time_constant: 900}}",
    );
    simulated(at, "warms.yaml", "80", "first");
    let diagnosed = ["diagnose", "first", "--robot", "c/robot.yaml", "--apply", "applied.yaml", "--format", "json"];
    let ran = run(at, &diagnosed);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(causes(&found).first().map(String::as_str), Some("link-warm-up@link:2"));
    assert!(std::fs::read_to_string(at.join("applied.yaml")).expect("written").contains("link-warm-up"));
    simulated(at, "warms.yaml", "60", "next");
    let left = left(at, "next", "applied.yaml");
    assert!(left < 0.06, "{left} mm in the next session, of 0.035 mm of noise");
}

/// The compliance of a joint as an effect is that of the joint: `stiffness` deflects as `pose` does. What is no constant is said to be
/// left out.
#[test]
fn stiffness_counts_compliances_that_effects_add() {
    let folder = starter();
    let at = folder.path();
    with_effect(at, "soft.yaml", "{effect: joint-compliance, site: 'joint:2', parameters: {joint2.kar: 5e-6}}");
    let load = ["--joints", "q1=30,q2=20,q3=40,q4=10,q5=20,q6=0", "--wrench", "0,0,-100"];
    let of = |command: &str| printed_json(at, &[&[command, "soft.yaml"], &load[..]].concat());
    let (by_matrix, by_pose) = (of("stiffness"), of("pose"));
    let (z, posed) = (number(&by_matrix["deflection"][2]), number(&by_pose["deflection"]["tool"][2]));
    assert!(z < -1e-4 && (z - posed).abs() < 1e-9 * z.abs(), "{z} {posed}");
    let both = "{effect: joint-compliance, site: 'joint:2', parameters: {joint2.kar: 5e-6}}\n\
        - {effect: joint-stiffening, site: 'joint:3', parameters: {wind_up: 2e-4, wound_up_at: 100}}";
    with_effect(at, "odd.yaml", both);
    let ran = run(at, &[&["stiffness", "odd.yaml"], &load[..]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.err.contains("joint-stiffening@joint:3: not linear in the load, and left out"), "{}", ran.err);
}
