//! Evidence that lacks a part: a contact that is not touched, a noise that is not stated, or for some kinds of reading alone; lengths
//! that count from somewhere else; and results that can hardly be meant, next to a verdict.

use std::path::Path;

use serde_json::Value;

use super::cli::{PLANAR, run};
use super::plausibility::{json, of_code, starter};
use crate::support::{number, printed_json};

fn write(at: &Path, name: &str, text: &str) {
    std::fs::write(at.join(name), text).expect("written");
}

fn simulated(at: &Path, campaign: &str, arguments: &[&str]) {
    write(at, "made.yaml", campaign);
    let ran = run(at, &[&["simulate", "made.yaml", "--seed", "1"], arguments].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
}

/// Two sockets 50 mm apart, of which one is left out: what is known of it tells nothing, and does no harm.
#[test]
fn a_contact_that_is_not_touched_holds_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let sockets = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: contact\ninstrument: {sigma: 0.05}\n\
        estimate: {base: false, tool: true}\ncontacts: {left: {kind: socket}, right: {kind: socket}}\n\
        distances: {left-right: 50}\n";
    simulated(at, sockets, &["--poses", "40", "--errors", "0", "--into", "c"]);
    let table = std::fs::read_to_string(at.join("c/measurements.csv")).expect("read");
    let left: Vec<&str> = table.lines().filter(|line| !line.contains(",right,")).collect();
    assert!(left.len() > 10 && left.len() < table.lines().count());
    write(at, "c/measurements.csv", &(left.join("\n") + "\n"));
    let ran = run(at, &["register", "c"]);
    assert_eq!(ran.status, 0, "{}", ran.err);
    assert!(ran.err.contains("`right` is touched in no row") && ran.err.contains("campaign.yaml:"), "{}", ran.err);
    let found = printed_json(at, &["register", "c"]);
    let left = number(&found["residuals"]["check_after"]["rms"]);
    assert!(left < 0.2, "{left} mm, where the ball's noise is 0.05 mm an axis");
}

/// Positions of 0.02 mm next to inclinations of 0.1 deg and torques of 0.1 N.m, each as its own noise lets it be.
#[test]
fn each_kind_is_judged_in_its_own_noise() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let files = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nestimate: {base: true, tool: true}\n\
        calibrate: [geometry, joint-offset]\nmeasurements:\n- {file: a.csv, observes: position, instrument: {sigma: 0.02}}\n\
        - {file: b.csv, observes: position, instrument: {sigma: 0.02}}\n";
    for (kind, entry) in [
        ("inclination", "- {file: e.csv, observes: inclination, body: \"3\", instrument: {orientation: 0.1}}\n"),
        ("torque", "- {file: e.csv, observes: torque, instrument: {torque: 0.1}}\ntorques: {q2: {}, q3: {}}\n"),
    ] {
        simulated(at, &format!("{files}{entry}"), &["--poses", "40", "--into", kind]);
        let found = printed_json(at, &["identify", kind]);
        assert!(of_code(&found, "outlying-readings").is_empty(), "{kind}: {}", found["diagnostics"]);
        assert!(of_code(&found, "unlike-description").is_empty(), "{kind}: {}", found["diagnostics"]);
        // Each file states its noise: a certificate has all that it needs.
        let certified = printed_json(at, &["report", kind, "--certificate", "--tolerance", "1"]);
        assert_eq!(certified["verdict"], "pass", "{kind}: {}", certified["reason"]);
    }
}

/// A wire that was set to nought 1200 mm out: most of what it shows is below nought.
#[test]
fn a_tared_wire_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let wire = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: distance\ninstrument: {sigma: 0.05}\n\
        estimate: {tool: true}\ncalibrate: [geometry, joint-offset]\nanchors: {outlet: {at: unknown, zero: unknown}}\n";
    simulated(at, wire, &["--poses", "150", "--set", "outlet.zero=-1200", "--into", "c"]);
    let table = std::fs::read_to_string(at.join("c/measurements.csv")).expect("read");
    assert!(table.lines().filter(|line| line.contains(",-")).count() > 20);
    let found = printed_json(at, &["identify", "c"]);
    let zero = found["parameters"].as_array().expect("a list").iter().find(|own| own["name"] == "outlet.zero");
    let zero = number(&zero.expect("an estimate")["value"]);
    assert!((zero + 1200.0).abs() < 1.0, "{zero}");
    // With a zero that is known there is no such length.
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let known: Vec<&str> = text.lines().filter(|line| !line.contains("zero:")).collect();
    assert!(known.len() < text.lines().count());
    std::fs::write(&path, known.join("\n") + "\n").expect("written");
    let ran = run(at, &["check", "c"]);
    assert!(ran.status == 2 && ran.err.contains("a distance must be above 0"), "{}", ran.err);
    assert!(ran.err.contains("write `zero: unknown`"), "{}", ran.err);
}

/// What the noise hides is judged by what is left where none is stated, not by a noise of 1 mm that nobody stated.
#[test]
fn noise_that_is_not_stated_hides_no_millimetres() {
    let folder = starter();
    let at = folder.path();
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let without: Vec<&str> = text.lines().filter(|line| !line.starts_with("instrument:")).collect();
    assert!(without.len() < text.lines().count());
    std::fs::write(&path, without.join("\n") + "\n").expect("written");
    let ran = run(at, &["diagnose", "c", "--apply", "applied.yaml"]);
    assert!(ran.status == 0 && !ran.out.contains("DOUBTFUL"), "{}", ran.out);
    let left = |description: &str| {
        let found = printed_json(at, &["register", "c", "--robot", description]);
        number(&found["residuals"]["check_after"]["rms"])
    };
    assert!(left("applied.yaml") < 0.1, "{}", left("applied.yaml"));
    // Dropping by noise costs no more than that noise.
    let rms = |more: &[&str]| {
        let found = printed_json(at, &[&["identify", "c"], more].concat());
        number(&found["residuals"]["check_after"]["rms"])
    };
    let [usual, by_noise] = [rms(&[]), rms(&["--tolerance", "noise"])];
    assert!(by_noise < 1.2 * usual, "{usual} {by_noise}");
}

/// Against a noise of 30 mm no gap could show, and a doubtful result passes no tolerance.
#[test]
fn doubts_withdraw_a_verdict() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let poses = ["simulate", "universal-ur5", "--observes", "pose", "--poses", "40", "--unknown-base", "--seed", "1"];
    assert_eq!(run(at, &[&poses[..], &["--noise", "0.03", "--into", "c"]].concat()).status, 0);
    let path = at.join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("read");
    let stated = text.lines().find(|line| line.trim_start().starts_with("sigma:")).expect("a noise").to_owned();
    let certified = |more: &[&str]| -> Value {
        printed_json(at, &[&["report", "c", "--certificate", "--tolerance", "200"], more].concat())
    };
    assert_eq!(certified(&[])["verdict"], "pass");
    std::fs::write(&path, text.replace(&stated, "  sigma: 30")).expect("written");
    let found = json(&run(at, &["diagnose", "c", "--format", "json"]));
    assert_eq!(found["verdict"], "undecided", "{}", found["gap"]);
    let doubted = certified(&[]);
    assert_eq!(doubted["verdict"], "undecided");
    assert!(doubted["reason"].as_str().is_some_and(|why| why.contains("noise-unlike-stated")), "{}", doubted["reason"]);
}

/// A path may say what the tool carries at each point: its weight bends the arm by what the load at that point does.
#[test]
fn payloads_of_a_path_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let springs = "joint_stiffness: {2: {kar: {value: 100000}}}\ngravity: [0, -9.80665, 0]\n";
    write(at, "arm.yaml", &format!("{PLANAR}{springs}payloads: {{block: {{mass: 10, com: [0, 0, 0]}}}}\n"));
    let points = |name: &str, rows: &str| {
        write(at, name, rows);
        let found = printed_json(at, &["compensate", "arm.yaml", name, "--nominal", "arm.yaml"]);
        found["points"].as_array().expect("points").iter().map(|point| point["correction"].clone()).collect::<Vec<_>>()
    };
    let carried = points("carried.csv", "q1,q2,payload\n10,20,block\n10,20,none\n");
    let pushed = points("pushed.csv", "q1,q2,fx,fy,fz,mx,my,mz\n10,20,0,-98.0665,0,0,0,0\n");
    let [own, none, force] = [&carried[0], &carried[1], &pushed[0]].map(|of| number(&of["q2"]));
    assert!(none == 0.0 && own.abs() > 1e-5 && (own / force - 1.0).abs() < 1e-6, "{own} {none} {force}");
    let ran = run(at, &["place", "arm.yaml", "carried.csv"]);
    assert!(ran.status == 2 && ran.err.contains("column `payload`"), "{}", ran.err);
}

/// Orientations in rad, which are read in deg.
#[test]
fn orientations_of_a_path_in_rad_are_doubted() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let path = |turn: &str| format!("x,y,z,rx,ry,rz\n-400,-200,300,{turn},0,0\n-420,-250,320,{turn},0,0\n");
    for (turn, is_doubted) in [("3.1416", true), ("180", false), ("3.5", false)] {
        write(at, "path.csv", &path(turn));
        let found = json(&run(at, &["compensate", "universal-ur5", "path.csv", "--format", "json"]));
        assert_eq!(!of_code(&found, "wrong-units").is_empty(), is_doubted, "{turn}: {}", found["diagnostics"]);
    }
}
