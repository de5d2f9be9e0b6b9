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
    // A session that lasts longer shows a warmth that no reading has shown.
    simulated(at, "warms.yaml", "130", "long");
    for (campaign, is_longer) in [("next", false), ("long", true)] {
        let ran = run(at, &["residuals", "applied.yaml", campaign]);
        let message = "outside the range of the readings by which the description was fitted: time";
        assert_eq!(ran.err.contains(message), is_longer, "{campaign}: {}", ran.err);
    }
}

/// A description of an earlier set-up does not know where the robot stands now.
#[test]
fn residuals_of_another_set_up() {
    let folder = starter();
    let at = folder.path();
    simulated(at, "c/robot.yaml", "40", "first");
    ok(at, &["identify", "first", "--save", "fitted.yaml"]);
    let table = at.join("first/measurements.csv");
    let text = std::fs::read_to_string(&table).expect("text");
    for (by, is_said) in [(0.0, false), (250.0, true)] {
        let mut lines = text.lines().map(String::from).collect::<Vec<_>>();
        for line in lines.iter_mut().skip(1) {
            let mut cells: Vec<String> = line.split(',').map(String::from).collect();
            cells[7] = (cells[7].parse::<f64>().expect("a number") + by).to_string();
            *line = cells.join(",");
        }
        std::fs::write(&table, lines.join("\n") + "\n").expect("written");
        let ran = run(at, &["residuals", "fitted.yaml", "first"]);
        assert_eq!(ran.err.contains("fitted to them, as `estimate:` of the campaign has it"), is_said, "{}", ran.err);
    }
}

/// So does what goes with the time since the start of every session, whatever its law.
#[test]
fn a_curve_over_every_session_comes_again() {
    let folder = starter();
    let at = folder.path();
    with_effect(
        at,
        "bends.yaml",
        "{effect: free-form, site: 'joint:2', parameters: {follows: session-time, at: [0, 900, 1800, 3600], k1: -3e-4, k2: 0, k3: 1.5e-4, k4: 2e-4}}",
    );
    let of_days = |poses: &str, into: &str| {
        let made = ["simulate", "bends.yaml", "--poses", poses, "--seed", "3", "--errors", "0.3", "--conditions"];
        let unknown = ["--noise", "0.02", "--unknown-base", "--unknown-tool", "--sessions", "one,two", "--into", into];
        ok(at, &[&made[..], &unknown].concat());
    };
    of_days("120", "first");
    let ran = run(at, &["diagnose", "first", "--robot", "c/robot.yaml", "--apply", "applied.yaml", "--format", "json"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    let found: Value = serde_json::from_str(&ran.out).expect("JSON");
    assert_eq!(causes(&found), ["free-form@joint:2"], "{}", found["causes"]);
    assert!(found["after_all"].get("rms_of_robot").is_none(), "{}", found["after_all"]);
    assert!(std::fs::read_to_string(at.join("applied.yaml")).expect("written").contains("session-time"));
    of_days("80", "next");
    let left = left(at, "next", "applied.yaml");
    assert!(left < 0.06, "{left} mm in the next sessions, of 0.035 mm of noise");
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
