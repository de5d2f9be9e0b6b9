//! The noise of a campaign that states none, where its readings show it: against the noise that was drawn.

use std::path::Path;

use serde_json::Value;

use super::cli::run;
use crate::support::{number, printed_json};

/// A simulated campaign in `c` of a folder, its noise of 0.05 mm no longer stated.
fn unstated(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let ran = run(folder.path(), &[&["simulate"], arguments, &["--noise", "0.05", "--into", "c"]].concat());
    assert_eq!(ran.status, 0, "{}", ran.err);
    let path = folder.path().join("c/campaign.yaml");
    let text = std::fs::read_to_string(&path).expect("a campaign");
    let is_kept = |line: &&str| !line.starts_with("instrument") && !line.contains("sigma:");
    let text: Vec<&str> = text.lines().filter(is_kept).collect();
    std::fs::write(path, text.join("\n") + "\n").expect("written");
    folder
}

/// Root mean square of a reading's noise by what `identify` says of where it comes from.
fn identified(folder: &Path) -> (Value, Option<f64>) {
    let found = printed_json(folder, &["identify", "c"]);
    let ratio = &found["noise_ratio"];
    (found["noise_sources"]["position"].clone(), (!ratio.is_null()).then(|| number(ratio)))
}

#[test]
fn repeats_give_the_noise_that_is_not_stated() {
    let folder = unstated(&["universal-ur5", "--poses", "20", "--repeats", "3", "--unknown-base"]);
    let (source, ratio) = identified(folder.path());
    assert_eq!(source, "repeats");
    assert!((ratio.expect("a known noise") - 1.0).abs() < 0.2, "{ratio:?}");
    let taken = |folder: &Path| number(&printed_json(folder, &["check", "c"])["without_robot"]["taken"]);
    assert!((taken(folder.path()) / 0.05 - 1.0).abs() < 0.2);
    // Three of sixty readings are wrong by 5 mm: the median holds.
    let path = folder.path().join("c/measurements.csv");
    let mut reader = csv::Reader::from_path(&path).expect("a table");
    let header = reader.headers().expect("a header").clone();
    let x = header.iter().position(|name| name == "x").expect("a column");
    let mut rows: Vec<Vec<String>> =
        reader.records().map(|row| row.expect("a row").iter().map(String::from).collect()).collect();
    for row in [4, 25, 50] {
        rows[row][x] = (rows[row][x].parse::<f64>().expect("a number") + 5.0).to_string();
    }
    let mut writer = csv::Writer::from_path(&path).expect("a table");
    writer.write_record(&header).expect("written");
    rows.iter().for_each(|row| writer.write_record(row).expect("written"));
    writer.flush().expect("written");
    assert!((taken(folder.path()) / 0.05 - 1.0).abs() < 0.35, "{}", taken(folder.path()));
}

/// What calibration leaves is then compared with it: a spring that the description lacks is no noise.
#[test]
fn rigid_markers_give_the_noise_that_is_not_stated() {
    let softer = "joint2.kar=-25000";
    let text = "units: {length: mm, angle: deg, rotational_stiffness: N.m/rad}\nframes:\n  1: {antecedent: 0, joint: revolute, variable: q1, r: 400, limits: [-170, 170]}\n  \
                2: {antecedent: 1, joint: revolute, variable: q2, alpha: -90, d: 100, limits: [-120, 20]}\n  3: {antecedent: 2, joint: revolute, variable: q3, d: 500, limits: [-60, 90]}\n  \
                E: {antecedent: 3, d: 500}\njoint_stiffness: {1: {kar: {value: 2.0e5}}, 2: {kar: {value: 1.0e5}}, 3: {kar: {value: 1.0e5}}}\n\
                bodies: {3: {mass: 40, com: [250, 0, 0]}}\ntool: {frame: E}\nmarkers: {a: {frame: E, at: [100, 0, 0]}, b: {frame: E, at: [0, 80, 200]}, c: {frame: E, at: [0, -80, 100]}}\n";
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("arm.yaml"), text).expect("written");
    let robot = folder.path().join("arm.yaml");
    let campaign = unstated(&[
        robot.to_str().expect("a path"),
        "--poses",
        "40",
        "--markers",
        "a,b,c",
        "--set",
        softer,
        "--unknown-base",
    ]);
    let (source, ratio) = identified(campaign.path());
    assert_eq!(source, "markers");
    assert!(ratio.expect("a known noise") > 0.8, "{ratio:?}");
    let found = printed_json(campaign.path(), &["diagnose", "c"]);
    // What all markers of a configuration share they do not show.
    assert_eq!(found["noise"]["source"], "leftover", "{}", found["noise"]);
}

/// Computed readings scatter by rounded digits, and single ones not at all.
#[test]
fn where_readings_do_not_show_it_the_noise_stays_unknown() {
    for arguments in [&["--poses", "30"][..], &["--poses", "8", "--repeats", "2"]] {
        let folder = unstated(&[&["universal-ur5", "--unknown-base"], arguments].concat());
        assert_eq!(identified(folder.path()), (Value::from("residuals"), None));
    }
}
