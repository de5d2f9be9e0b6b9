//! One column among right ones that is in another unit, of another joint, or of other rows; one marker, one sensor or one payload that
//! is not what the campaign says.

use std::fs;
use std::path::Path;

use nalgebra::{Rotation3, Vector3};

use super::cli::run;
use super::plausibility::{Table, doubts, json, of_code, refuses, spoil, starter};
use super::plausible_loads::LOADED;

const DEGREE: f64 = std::f64::consts::PI / 180.0;

fn ok(at: &Path, arguments: &[&str]) {
    let ran = run(at, arguments);
    assert_eq!(ran.status, 0, "{arguments:?}: {}{}", ran.out, ran.err);
}

/// A folder's copy with its table changed.
fn changed(at: &Path, into: &str, change: impl Fn(&mut Table)) {
    let folder = at.join(into);
    fs::create_dir(&folder).expect("a folder");
    for entry in fs::read_dir(at.join("sound")).expect("a folder") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, folder.join(path.file_name().expect("a name"))).expect("a copy");
    }
    spoil(&folder, change);
}

fn number(table: &Table, row: usize, name: &str) -> f64 {
    table.rows[row][table.column(name)].parse().expect("a number")
}

/// The joints of the row two further on at each reading.
fn two_further(table: &mut Table) {
    let old = table.rows.clone();
    let joints: Vec<usize> = (1..=6).map(|k| table.column(&format!("q{k}"))).collect();
    for (row, from) in table.rows.iter_mut().zip(&old[2..]) {
        joints.iter().for_each(|&joint| row[joint].clone_from(&from[joint]));
    }
    table.rows.truncate(old.len() - 2);
}

/// Of an arm that turns: one joint in rad, one axis of the readings in inches, rows shifted by two.
#[test]
fn one_column_in_another_unit_is_named() {
    let folder = starter();
    let at = folder.path();
    fs::rename(at.join("c"), at.join("sound")).expect("renamed");
    changed(at, "rad", |t| t.scale(&["q5"], DEGREE));
    refuses(at, &["check", "rad"], "wrong-units", &["with `q5` alone read as rad", "from 98.8 to 1.7"]);
    changed(at, "inches", |t| t.scale(&["z"], 1.0 / 25.4));
    refuses(at, &["check", "inches"], "wrong-units", &["z of the readings times 25.4"]);
    changed(at, "rows", two_further);
    refuses(at, &["check", "rows"], "misread", &["joints of the row 2 places", "rows shifted by 2?"]);
}

/// Of a SCARA on a rail: the spindle in cm, which readings that are too long would explain as well, the rail in m and in inches, and columns
/// of a joint that slides and one that turns exchanged.
#[test]
fn columns_of_sliding_joints_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let robot = ["simulate", "scara-rail", "--poses", "40", "--seed", "5", "--errors", "1", "--noise", "0.03"];
    ok(at, &[&robot[..], &["--unknown-base", "--unknown-tool", "--into", "sound"]].concat());
    ok(at, &["check", "sound"]);
    changed(at, "cm", |t| t.scale(&["down"], 0.1));
    refuses(at, &["check", "cm"], "wrong-units", &["with `down` alone times 10 ", "is that column in cm"]);
    changed(at, "m", |t| t.scale(&["rail"], 1e-3));
    refuses(at, &["check", "m"], "wrong-units", &["with `rail` alone times 1000 ", "in m, and declared in mm"]);
    changed(at, "inches", |t| t.scale(&["rail"], 1.0 / 25.4));
    refuses(at, &["check", "inches"], "wrong-units", &["with `rail` alone times 25.4 ", "in inches"]);
    changed(at, "exchanged", |t| t.swap("down", "q4"));
    refuses(at, &["check", "exchanged"], "misread", &["with `down` and `q4` exchanged", "columns swapped?"]);
    changed(at, "first", |t| t.swap("rail", "q1"));
    refuses(at, &["check", "first"], "misread", &["with `rail` and `q1` exchanged", "columns swapped?"]);
}

/// Angles of a KUKA controller in rad, which are declared in deg.
#[test]
fn angles_of_orientations_in_rad_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "universal-ur5", "--poses", "40", "--seed", "6", "--observes", "pose", "--noise", "0.03"];
    ok(at, &[&arm[..], &["--errors", "1", "--unknown-base", "--unknown-tool", "--into", "sound"]].concat());
    for (into, unit) in [("deg", DEGREE), ("rad", 1.0)] {
        changed(at, into, |t: &mut Table| {
            for row in 0..t.rows.len() {
                let own = Vector3::from(["rx", "ry", "rz"].map(|name| number(t, row, name) * DEGREE));
                let (x, y, z) = Rotation3::new(own).euler_angles();
                for (name, angle) in [("rx", z), ("ry", y), ("rz", x)] {
                    let column = t.column(name);
                    t.rows[row][column] = (angle / unit).to_string();
                }
            }
            for (old, new) in [("rx", "A"), ("ry", "B"), ("rz", "C")] {
                let column = t.column(old);
                t.names[column] = new.into();
            }
        });
        let campaign = at.join(into).join("campaign.yaml");
        let text = fs::read_to_string(&campaign).expect("text") + "orientation: kuka-abc\n";
        fs::write(campaign, text).expect("written");
    }
    ok(at, &["check", "deg"]);
    refuses(at, &["check", "rad"], "wrong-units", &["the angles of the orientations read as rad"]);
}

/// A sensor that shows the reaction to gravity, upwards.
#[test]
fn an_accelerometer_that_shows_upwards_is_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let level = "robot: universal-ur5\nunits: {length: mm, angle: deg}\nobserves: inclination\ninstrument: {orientation: 0.002}\n\
                 calibrate: [geometry, joint-offset]\nmeasurements: flange.csv\n";
    fs::write(at.join("level.yaml"), level).expect("written");
    ok(at, &["simulate", "level.yaml", "--poses", "40", "--seed", "6", "--errors", "1", "--into", "sound"]);
    ok(at, &["check", "sound"]);
    changed(at, "up", |t| t.scale(&["gx", "gy", "gz"], -1.0));
    refuses(at, &["check", "up"], "misread", &["measured directions reversed", "upwards"]);
}

/// One of three markers slips on its body half-way: what is left steps in its own readings.
#[test]
fn one_marker_of_several_that_slips_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let arm = ["simulate", "kuka-kr270", "--poses", "50", "--markers", "m1,m2,m3", "--seed", "3", "--errors", "1"];
    ok(at, &[&arm[..], &["--noise", "0.03", "--unknown-base", "--unknown-tool", "--into", "sound"]].concat());
    let place = |t: &Table, row: usize| Vector3::from(["x", "y", "z"].map(|name| number(t, row, name)));
    changed(at, "slip", |t: &mut Table| {
        // Rows come in threes; axes of the body by its markers.
        for first in (t.rows.len() / 6 * 3..t.rows.len()).step_by(3) {
            let [a, b, c] = [0, 1, 2].map(|k| place(t, first + k));
            let x = (b - a).normalize();
            let z = x.cross(&(c - a)).normalize();
            let moved = b + 0.18 * x + 0.15 * z.cross(&x) + 0.19 * z;
            for (name, value) in ["x", "y", "z"].into_iter().zip(moved.iter()) {
                let column = t.column(name);
                t.rows[first + 1][column] = value.to_string();
            }
        }
    });
    assert_eq!(of_code(&json(&run(at, &["identify", "sound", "--format", "json"])), "moved-midway").len(), 0);
    doubts(at, &["identify", "slip"], "moved-midway", &["readings of marker `m2` are 0.30 mm away"]);
    let ran = run(at, &["identify", "slip", "--save", "x.yaml"]);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}", ran.out);
}

/// An instrument that creeps by a millimetre is told as drift, and not as a step at one row.
#[test]
fn a_drift_is_not_told_as_a_step() {
    let folder = starter();
    let at = folder.path();
    fs::rename(at.join("c"), at.join("sound")).expect("renamed");
    changed(at, "drift", |t: &mut Table| {
        let (x, last) = (t.column("x"), t.rows.len() as f64);
        for (k, row) in t.rows.iter_mut().enumerate() {
            row[x] = (row[x].parse::<f64>().expect("mm") + k as f64 / last).to_string();
        }
    });
    let found = json(&run(at, &["identify", "drift", "--format", "json"]));
    let told = of_code(&found, "moved-midway");
    let message = told[0]["message"].as_str().expect("words");
    assert!(message.contains("readings drift by") && message.contains("moved slowly"), "{message}");
    let moved = told[0]["figures"]["drift_mm"].as_f64().expect("mm");
    assert!((moved - 1.0).abs() < 0.1, "{moved}");
}

/// A payload ten times too heavy, or with its centre in cm: springs take up a part of it. Where springs are off and held,
/// a length along the last axis, which weight alone tells from the tool, stays as described.
#[test]
fn a_payload_in_another_unit_is_named() {
    let folder = starter();
    let at = folder.path();
    let bare = fs::read_to_string(at.join("c/robot.yaml")).expect("text");
    let bare = bare.split("# Masses and springs").next().expect("a part");
    fs::write(at.join("arm.yaml"), format!("{bare}{LOADED}")).expect("written");
    let plan = "robot: arm.yaml\nunits: {length: mm, angle: deg}\nobserves: position\ninstrument: {sigma: 0.03}\n\
                estimate: {base: true, tool: true}\ncalibrate: [geometry, joint-offset, joint-compliance]\n\
                payloads:\n  block: {mass: 30, com: [120, 60, 100]}\nmeasurements: carried.csv\n";
    fs::write(at.join("plan.yaml"), plan).expect("written");
    let errors = ["--seed", "4", "--errors", "1", "--elastic-errors", "1"];
    ok(at, &[&["simulate", "plan.yaml", "--poses", "60", "--into", "sound"], &errors[..]].concat());
    let with = |into: &str, from: &[&str], to: &[&str]| {
        changed(at, into, |_| {});
        let file = at.join(into).join("campaign.yaml");
        let text = fs::read_to_string(&file).expect("text");
        let text = from.iter().zip(to).fold(text, |text, (from, to)| {
            assert!(text.contains(from), "{from}: {text}");
            text.replace(from, to)
        });
        fs::write(file, text).expect("written");
    };
    assert!(of_code(&json(&run(at, &["identify", "sound", "--format", "json"])), "wrong-units").is_empty());
    with("heavy", &["mass: 30.0"], &["mass: 300.0"]);
    doubts(at, &["identify", "heavy"], "wrong-units", &["the payload's mass times 0.1 ", "decimal sign"]);
    with("centre", &["- 120.0", "- 60.0", "- 100.0"], &["- 12.0", "- 6.0", "- 10.0"]);
    doubts(at, &["identify", "centre"], "wrong-units", &["the payload's centre of mass times 10 ", "in cm?"]);
    let ran = run(at, &["identify", "heavy", "--save", "x.yaml"]);
    assert!(ran.status == 1 && !at.join("x.yaml").exists(), "{}", ran.out);
    with("held", &["- joint-compliance\n"], &[""]);
    let found = json(&run(at, &["diagnose", "held", "--format", "json"]));
    assert!(of_code(&found, "moved-far").is_empty() && found["verdict"] == "explained", "{}", found["diagnostics"]);
    let causes: Vec<&str> =
        found["causes"].as_array().expect("a list").iter().filter_map(|own| own["site"].as_str()).collect();
    assert!(causes.contains(&"joint:2") && causes.contains(&"joint:3"), "{causes:?}");
}

/// Rows that were pasted twice, less than a tenth of them; and a payload where nothing weighs anything.
#[test]
fn pasted_rows_and_weightless_payloads_are_told() {
    let folder = starter();
    let at = folder.path();
    fs::rename(at.join("c"), at.join("sound")).expect("renamed");
    changed(at, "pasted", |t: &mut Table| {
        let some: Vec<Vec<String>> = t.rows[10..15].to_vec();
        t.rows.extend(some);
    });
    doubts(at, &["identify", "pasted"], "suspect-readings", &["5 of 65 readings are copies of others"]);
    changed(at, "light", |t: &mut Table| {
        t.names.push("payload".into());
        t.rows.iter_mut().for_each(|row| row.push("block".into()));
    });
    let robot = at.join("light/robot.yaml");
    let text = fs::read_to_string(&robot).expect("text");
    fs::write(&robot, format!("{text}\ngravity: [0, 0, 0]\n")).expect("written");
    let campaign = at.join("light/campaign.yaml");
    let text = fs::read_to_string(&campaign).expect("text");
    fs::write(&campaign, text + "payloads:\n  block: {mass: 5}\n").expect("written");
    let ran = run(at, &["check", "light"]);
    let told = format!("{}{}", ran.out, ran.err);
    assert!(told.contains("payloads have no weight: gravity of the description is zero"), "{told}");
}
