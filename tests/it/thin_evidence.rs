//! Evidence that is thin in one part: a session of few rows, joints that hardly move, a zero that changes half-way.

use std::fs;
use std::path::Path;

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, refuses, spoil, starter};
use crate::support::{number, printed_json};

fn ok(at: &Path, arguments: &[&str]) -> String {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{}{}", ran.out, ran.err);
    ran.out
}

/// Sixty readings, an encoder that is set anew by 0.3 deg before the thirty-first: the joint and the amount are told.
#[test]
fn a_zero_that_changes_midway_is_told() {
    let folder = starter();
    spoil(&folder.path().join("c"), |table: &mut Table| {
        let q2 = table.column("q2");
        for row in table.rows.iter_mut().skip(30) {
            row[q2] = (0.3 + row[q2].parse::<f64>().expect("a number")).to_string();
        }
    });
    let found = doubts(folder.path(), &["identify", "c"], "moved-midway", &["the zero of `q2` changed by -0."]);
    let message = of_code(&found, "moved-midway")[0]["message"].as_str().expect("words").to_owned();
    let change = message.split("changed by ").nth(1).and_then(|rest| rest.split(' ').next()).expect("an amount");
    assert!((change.parse::<f64>().expect("a number") + 0.3).abs() < 0.02, "{message}");
}

/// Where one joint moves over 5 deg alone, constants that noise decides stay as described: elsewhere the arm is better for the calibration,
/// and not twice as bad.
#[test]
fn narrow_poses_make_the_arm_no_worse_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "40", "--unknown-base", "--unknown-tool", "--noise", "0.03"];
    ok(at, &[&arm[..], &["--range", "q5=40:45", "--seed", "2", "--into", "narrow"]].concat());
    ok(at, &[&arm[..], &["--seed", "2", "--into", "whole"]].concat());
    let left = |description: &str| {
        let found = printed_json(at, &["residuals", description, "whole"]);
        number(&found["all"]["rms"])
    };
    ok(at, &["register", "narrow", "--save", "registered.yaml"]);
    ok(at, &["identify", "narrow", "--save", "calibrated.yaml"]);
    let [before, after] = ["registered.yaml", "calibrated.yaml"].map(left);
    assert!(after < 0.5 * before, "{before} -> {after}");
}

/// Fewer configurations than tell the lags of all joints apart: a diagnosis says what it can.
#[test]
fn few_configurations_are_diagnosed() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    for (robot, poses) in [("universal-ur5", "12"), ("franka-panda", "15")] {
        let unknown = ["--noise", "0.05", "--conditions", "--unknown-base", "--unknown-tool", "--seed", "1"];
        let into = format!("few-{robot}");
        ok(at, &[&["simulate", robot, "--poses", poses, "--into", &into][..], &unknown].concat());
        let found = json(&run(at, &["diagnose", &into, "--format", "json"]));
        assert!(found["verdict"].is_string(), "{robot}: {found}");
    }
}

#[test]
fn a_joint_that_never_moved_is_told_by_every_verb() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "40", "--unknown-base", "--range", "q5=40:40.0001"];
    ok(at, &[&arm[..], &["--into", "s"]].concat());
    for verb in ["check", "identify", "diagnose", "report"] {
        let found = json(&run(at, &[verb, "./s", "--format", "json"]));
        assert!(!of_code(&found, "weak-direction").is_empty(), "{verb}: {}", found["diagnostics"]);
    }
}

/// Five rows of a session with a base of its own are all fitted, and readings of it to check alone are refused.
#[test]
fn a_small_session_is_not_held_out() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    ok(at, &["simulate", "universal-ur5", "--poses", "45", "--unknown-base", "--noise", "0.02", "--into", "s"]);
    let campaign = at.join("s/campaign.yaml");
    let text = fs::read_to_string(&campaign).expect("read");
    fs::write(&campaign, text.replace("base: true", "base: per-session")).expect("written");
    let measurements = at.join("s/measurements.csv");
    let text = fs::read_to_string(&measurements).expect("read");
    // The last cell is that of the column `set`.
    let rows: Vec<&str> = text.lines().map(|line| line.rsplit_once(',').expect("cells").0).collect();
    let session = |k: usize| if k <= 40 { "mon" } else { "tue" };
    let written = |more: &dyn Fn(usize) -> String| {
        let rows: Vec<String> = rows.iter().enumerate().map(|(k, row)| format!("{row},{}", more(k))).collect();
        fs::write(&measurements, rows.join("\n") + "\n").expect("written");
    };
    written(&|k| if k == 0 { "session".into() } else { session(k).into() });
    for seed in ["1", "2", "3", "4", "5"] {
        let found = json(&run(at, &["identify", "./s", "--seed", seed, "--format", "json"]));
        assert!(of_code(&found, "outlying-readings").is_empty(), "{}", found["diagnostics"]);
        assert!(number(&found["residuals"]["check_after"]["max"]) < 0.5, "{}", found["residuals"]);
    }
    written(&|k| match session(k) {
        _ if k == 0 => "session,set".into(),
        "tue" => "tue,check".into(),
        other => format!("{other},fit"),
    });
    let ran = run(at, &["identify", "./s"]);
    assert_eq!(ran.status, 2, "{}", ran.out);
    assert!(ran.err.contains("session `tue` has readings to check alone"), "{}", ran.err);
}

/// A marker near the axis of the last joint hardly shows its sign to registration; calibration does.
#[test]
fn the_sign_of_a_last_joint_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-ir663", "--poses", "60", "--unknown-base", "--noise", "0.03"];
    ok(at, &[&arm[..], &["--seed", "1", "--into", "s"]].concat());
    let sound = json(&run(at, &["identify", "./s", "--format", "json"]));
    assert!(of_code(&sound, "misread").is_empty(), "{}", sound["diagnostics"]);
    spoil(&at.join("s"), |table: &mut Table| {
        let last = table.column("q7");
        for row in &mut table.rows {
            row[last] = (-row[last].parse::<f64>().expect("a number")).to_string();
        }
    });
    refuses(at, &["identify", "./s"], "misread", &["with `q7` negated", "wrong sign?"]);
}

/// That nothing is missing is not concluded from fewer readings than a calibration needs.
#[test]
fn few_configurations_show_no_gap_and_no_absence_of_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let made = ["simulate", "franka-panda", "--observes", "pose", "--noise", "0.05", "--errors", "1", "--seed", "1"];
    ok(at, &[&made[..], &["--unknown-base", "--unknown-tool", "--poses", "9", "--into", "c"]].concat());
    // The commands choose themselves what they hold out.
    spoil(&at.join("c"), |table: &mut Table| table.remove("set"));
    for command in ["identify", "diagnose"] {
        let save = if command == "identify" { "--save" } else { "--apply" };
        let ran = run(at, &[command, "c", save, "a.yaml", "--format", "json"]);
        assert_eq!(ran.status, 1, "{command}: {}{}", ran.out, ran.err);
        assert!(!of_code(&json(&ran), "too-little-data").is_empty(), "{command}: {}", ran.out);
        assert!(!at.join("a.yaml").exists(), "{command}");
    }
    let found = json(&run(at, &["diagnose", "c", "--format", "json"]));
    assert_eq!(found["verdict"], "undecided", "{found}");
}
